"""A program that misbehaves in the way that its argument names; otherwise it integrates nothing and says so."""

import importlib
import json
import os
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

DESCRIPTION = {"protocol": 1, "name": "odd", "sweep": {"kind": "step"}}
DESCRIPTIONS = {
    "mute": None,
    "other protocol": DESCRIPTION | {"protocol": 2},
    "no sweep": {"protocol": 1, "name": "odd"},
    "odd sweep": DESCRIPTION | {"sweep": {"kind": "guess"}},
    "odd step": DESCRIPTION | {"sweep": {"kind": "step", "coarsest": "large"}},
    "huge step": DESCRIPTION | {"sweep": {"kind": "step", "coarsest": 10**400}},
    "odd form": DESCRIPTION | {"forms": ["Hamiltonian"]},
    "odd order": DESCRIPTION | {"order": -4},
    "huge order": DESCRIPTION | {"order": 10**400},
    "odd name": DESCRIPTION | {"name": "\x1b[2J"},
    "odd counts": DESCRIPTION | {"counts_rhs": "yes"},
    "no counts": DESCRIPTION | {"counts_rhs": True},
    "nan": DESCRIPTION | {"order": float("nan")},
}


def answers(way: str, problem: dict[str, Any]) -> str:
    """The line that it writes for a problem."""
    number, start, count = problem["number"], problem["start"], len(problem["times"])
    right: dict[str, Any] = {"number": number, "status": "ok", "states": [start] * count, "steps": count}
    texts = {
        "garbage": "hello",
        "list": "[1, 2]",
        "deep": "[" * 100_000,
        "plain nan": json.dumps(right | {"states": [[float("nan")] * len(start)] * count}),
        "other number": json.dumps(right | {"number": number + 1}),
        "true number": json.dumps(right | {"number": True}),
        "no status": json.dumps({"number": number, "states": []}),
        "odd status": json.dumps(right | {"status": "fine"}),
        "few states": json.dumps(right | {"states": [start] * (count - 1)}),
        "many states": json.dumps(right | {"states": [start] * (count + 1)}),
        "no states": json.dumps({"number": number, "status": "ok"}),
        "wide state": json.dumps(right | {"states": [[*start, 0.0]] * count}),
        "true state": json.dumps(right | {"states": [[True] * len(start)] * count}),
        "text state": json.dumps(right | {"states": [["much"] * len(start)] * count}),
        "odd hex": json.dumps(right | {"states": [["0xyz"] * len(start)] * count}),
        "odd steps": json.dumps(right | {"steps": -1}),
        "huge steps": json.dumps(right | {"steps": 10**400}),
        "half steps": json.dumps(right | {"steps": 1.5}),
        "no reason": json.dumps({"number": number, "status": "refused"}),
        "lacks nothing": json.dumps({"number": number, "status": "unsupported"}),
        "two lines": json.dumps(right) + "\n" + json.dumps(right),
        "encoded": json.dumps(
            right | {"states": [["nan", "inf"], ["-inf", "0x1.8p+1"], *[[1, 10**400]] * (count - 2)]}
        ),
        "stopped": json.dumps({"number": number, "status": "stopped", "reason": "a pole", "states": [start]}),
        "refused": json.dumps({"number": number, "status": "refused", "reason": "steps this large diverge"}),
        "unsupported": json.dumps({"number": number, "status": "unsupported", "lacks": "elliptic functions"}),
    }
    return texts.get(way, json.dumps(right))


def passing_time() -> Any:
    """The module of this name; as an integrator is a program of its own, it knows no module of the tests."""
    sys.path.insert(0, str(Path(__file__).parents[2] / "helpers"))
    return importlib.import_module("passing_time")


def main(way: str) -> None:
    for line in sys.stdin:
        request = json.loads(line)
        if way == "silent":
            continue
        if request["request"] == "describe":
            found = DESCRIPTIONS.get(way, DESCRIPTION)
            text = "" if found is None else json.dumps(found) + "\n"
        elif way in ("hang", "hang with children"):
            if way == "hang with children":
                waits = "import signal; signal.pause()"
                child = subprocess.Popen([sys.executable, "-c", waits], start_new_session=True)
                Path(os.environ["GNOMON_TEST_PIDS"]).write_text(f"{os.getpid()} {child.pid}")
            passing_time().hang()
        elif way == "slow":
            ends = time.process_time() + 0.1
            while time.process_time() < ends:
                pass
            text = answers(way, request) + "\n"
        elif way == "wait":
            passing_time().pass_time(1)
            text = answers(way, request) + "\n"
        elif way == "exit":
            sys.exit(3)
        elif way == "last words":
            print("step 1\n" * 50 + " corrector convergence failed\n PROGRAM STOP", file=sys.stderr, flush=True)
            sys.exit(0)
        elif way == "talks":
            print("step 1", file=sys.stderr, flush=True)
            text = answers(way, request) + "\n"
        elif way == "signal":
            os.abort()
        elif way == "within a line":
            sys.stdout.write('{"number": ')
            sys.exit(0)
        elif way == "long line":
            text = "x" * 5_000_000 + "\n"
        elif way == "bytes":
            sys.stdout.buffer.write(b"\xff\xfe\n")
            text = ""
        elif way == "who":
            text = (
                json.dumps({"number": request["number"], "status": "refused", "reason": f"process {os.getpid()}"})
                + "\n"
            )
        else:
            text = answers(way, request) + "\n"
        sys.stdout.write(text)
        sys.stdout.flush()
        if way == "mute":
            return


if __name__ == "__main__":
    main(sys.argv[1])
