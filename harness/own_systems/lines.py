"""Lines of Python for a user's equations: the call that runs a method on them, and other forms of them."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from typing import Any

from gnomon.cases.core.forms import Form, Hybrid
from gnomon.harness.running.pieces import Stated

MAIN = "__main__"
FORMS = {
    "SecondOrder": """\
def accelerations(t, q{args}): ...  # q'' of the {half} positions alone
gnomon.solve(accelerations, {span}, (*positions, *velocities), method, accelerations=True)""",
    "Hybrid": """\
impact = gnomon.Transition("impact", "motion", guard, -1, reset, "motion")
gnomon.Hybrid((gnomon.Mode("motion", {name}),), lambda t, y, p: "motion", (impact,))""",
    "Impact": """\
impact = gnomon.Transition("impact", "motion", gap, -1, bounce, "motion")
gnomon.Impact((gnomon.Mode("motion", {name}),), start, (impact,), settle=1e-9,
              free={name}, gap=gap, normal=normal, restitution=restitution)""",
    "Friction": """\
gnomon.Friction((slides, sticks), start, transitions,
                sliding=sliding, bounds=bounds)  # of a state (x, v)""",
    "Charged": """\
def fields(t, place, p): ...  # charge over mass times E, then times B: six numbers
gnomon.Charged({name}, fields=fields)  # of a state (position, velocity)""",
    "Constrained": """\
def constraint(t, q, p): ...  # constant on the motion; gradient: its derivatives by the {half} coordinates
gnomon.Constrained({name}, force=force, constraint=constraint, gradient=gradient)""",
    "RigidBody": """\
def inertia(p): ...  # three principal moments; torque(t, state, p): three components in the body
gnomon.RigidBody(inertia, torque)  # of a state (angular velocity, attitude by rows)""",
    "NBody": """\
def masses(p): ...  # G m of each body; bodies(state): x, y, z, vx, vy, vz of each; state(bodies): back
gnomon.NBody(masses, bodies, state)""",
    "SemiLinear": """\
def linear(p): ...  # the {size} numbers of the matrix L of y' = L y + rest, row by row
gnomon.SemiLinear({name}, linear=linear, rest=rest)""",
    "FirstOrder": """\
def rates(t, y, p): ...  # the derivatives of all components
gnomon.solve(rates, {span}, start, method)""",
}
"""The forms that a function does not state, each in two or three lines for this function."""


def name_of(fun: Any) -> str:
    """The name of a function or a form, for messages and results."""
    inner = getattr(fun, "func", fun)
    name = getattr(inner, "__name__", type(inner).__name__)
    return "equations" if name == "<lambda>" else name


def explain_form(accepted: str, stated: Stated, order: Sequence[int], lacking: str) -> str:
    """The form that a method takes, why these equations do not have it, and its lines for them."""
    name, form = name_of(stated.fun), accepted.partition(" or ")[0]
    if stated.events or isinstance(stated.fun, Hybrid):
        return f"takes {accepted}, equations without events, and {name} has events: take a method with events"
    if form == "SceneForm":
        return "takes a scene of bodies, joints and contacts, not equations; see `gnomon scene`"
    why = f"; {lacking}" if lacking and "SecondOrder" in accepted else ""
    numbers = "".join(f", {each}" for each in _further(stated.fun))
    if form not in FORMS:
        return f"takes {accepted}, which {name} does not state{why}"
    text = FORMS[form].format(name=name, half=len(order) // 2, size=len(order) ** 2, span="span", args=numbers)
    return f"takes {accepted}, which {name} does not state{why}. State it as\n{text}"


def call_lines(
    stated: Stated,
    span: tuple[float, float],
    start: Sequence[float],
    method: str,
    setting: float,
    kind: str,
    place: tuple[str, str] | None = None,
) -> str:
    """The call of `gnomon.solve` with this method, at a tolerance or a step. `place`: module and name of a form."""
    name = "equations" if isinstance(stated.fun, Form) else name_of(stated.fun)
    imported = "".join(map(_import_line, (stated.fun, *stated.events)))
    if isinstance(stated.fun, Form) and place is not None:
        name, imported = place[1], f"from {place[0]} import {place[1]}\n{imported}"
    options = [f"rtol={setting:.4g}" if kind == "tolerance" else f"step={setting!r}"]
    options += [f"args={stated.arguments.args!r}"] if stated.arguments.args else []
    options += ["accelerations=True"] if stated.accelerations else []
    events = [getattr(each, "__name__", "event") for each in stated.events]
    options += [f"events=[{', '.join(events)}]"] if events else []
    numbers = ", ".join(_short(x) for x in start)
    return (
        f"import gnomon\n{imported}\n"
        f'found = gnomon.solve({name}, ({_short(span[0])}, {_short(span[1])}), [{numbers}], "{method}", {", ".join(options)})\n'
    )


def _import_line(fun: Any) -> str:
    """The line that imports a function of a module; "" for a form, and for a function of the script or of another one."""
    inner, module = getattr(fun, "func", fun), getattr(fun, "__module__", MAIN)
    is_found = not isinstance(fun, Form) and getattr(inner, "__qualname__", "<") == name_of(fun) and module != MAIN
    return f"from {module} import {name_of(fun)}\n" if is_found else ""


def _short(x: float) -> str:
    return repr(int(x)) if x == int(x) and abs(x) < 1e15 else repr(x)


def _further(fun: Any) -> list[str]:
    try:
        return [*inspect.signature(fun).parameters][2:]
    except (TypeError, ValueError):
        return []
