"""A program for `gnomon verify --command`: Runge and Kutta's method; `family_faults.py` changes its text."""

import json
import math
import sys


def right_hand_side(question):
    """f(t, state) from the equations of a problem, which are text."""
    known = {name: getattr(math, name) for name in dir(math) if name[0] != "_"} | {"pow": pow}
    known |= question["parameters"]
    common = [line.split(" = ", 1) for line in question["equations"]["where"]]
    lines = [f"    {name} = {text}" for name, text in common]
    lines += [f"    return [{', '.join(question['equations']['derivatives'])}]"]
    exec("\n".join([f"def f(t, state):\n    {', '.join(question['coordinates'])}, = state", *lines]), known)
    return known["f"]


def stepped(f, t, y, h):
    a = f(t, y)
    b = f(t + h / 2, [x + h / 2 * s for x, s in zip(y, a, strict=True)])
    c = f(t + h / 2, [x + h / 2 * s for x, s in zip(y, b, strict=True)])
    d = f(t + h, [x + h * s for x, s in zip(y, c, strict=True)])
    return [x + h / 6 * (k + 2 * m + 2 * n + o) for x, k, m, n, o in zip(y, a, b, c, d, strict=True)]


def solved(question):
    """The states at the times of a problem."""
    f, t, y, found = right_hand_side(question), question["t0"], list(map(float, question["start"])), []
    for end in question["times"]:
        count = max(1, math.ceil(abs(end - t) / question["setting"]["value"] - 1e-9))
        h = (end - t) / count
        for i in range(count):
            y = stepped(f, t + i * h, y, h)
        t = end
        found.append(y)
    return found


def answered(question):
    if question["request"] == "describe":
        return {
            "protocol": 1,
            "name": "RK4 of a program",
            "order": 4,
            "sweep": {"kind": "step", "coarsest": 0.125, "halvings": 7},
        }
    number, value = question["number"], question["setting"]["value"]
    if question["equations"] is None:
        return {"number": number, "status": "unsupported", "lacks": "equations as text"}
    if not isinstance(value, int | float) or not value > 0:
        return {"number": number, "status": "refused", "reason": f"step size {value}"}
    try:
        states = solved(question)
    except (ArithmeticError, ValueError) as error:
        return {"number": number, "status": "stopped", "reason": str(error), "states": []}
    return {
        "number": number,
        "status": "ok",
        "states": [[x if math.isfinite(x) else repr(x) for x in row] for row in states],
    }


def program_rk4():
    for line in sys.stdin:
        print(json.dumps(answered(json.loads(line))), flush=True)


if __name__ == "__main__":
    program_rk4()
