"""Invented runs with the scatter of launches, failures and missing counts, for the parts of a page that compare libraries."""

import math
import zlib
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import synthetic

METHODS = (
    # library, name, policy, order, kind of setting, seconds a right-hand side, conserves: the first of each library that
    # gnomon knows stands for it on smooth systems
    ("scipy", "DOP853", "", 8, "tolerance", 3e-8, ""),
    ("scipy", "RK45", "", 5, "tolerance", 3e-8, ""),
    ("rebound", "BS [ODE mode]", "", 8, "tolerance", 3.1e-8, ""),
    ("heyoka", "Taylor", "", 9, "tolerance", 2.9e-8, ""),
    ("sksundae", "CVODE Adams [native]", "", 7, "tolerance", 3e-8, ""),
    ("gnomon", "DOP853", "", 8, "tolerance", 2e-8, ""),
    ("gnomon", "RK4", "", 4, "step", 2e-8, ""),
    ("mine", "stepper", "", 6, "tolerance", 4e-8, ""),
)
LONE_LAUNCH, LONG_CALL, LONE_LIBRARY, NOBODY = "case_01", "case_02", "case_03", "case_04"
"""Cases with one launch, with null calls that take most of the time, that one library brings to 1e-6, and none to 1e-9."""
ROUGH = ("case_05", "case_06", "case_07")
"""Cases whose launches scatter five times as much, so that some of their comparisons stay open."""


def cases(count: int) -> dict[str, tuple[str, str, int, tuple[str, ...]]]:
    """Names that no installed case has."""
    return {f"case_{k:02}": (f"Case {k}", "6.1", 2, ("default",)) for k in range(count)}


@cache
def number(*key: Any) -> float:
    """A normal number that depends on the key alone, so that a method has the same numbers in every run."""
    return float(np.random.default_rng(zlib.crc32(repr(key).encode())).standard_normal())


def write(path: Path, count: int = 16, methods: Any = METHODS, launches: int = 5) -> Path:
    """A run of this many cases, in which libraries are equal, slower or open, fail or are not counted."""

    def change(trial: dict[str, Any], launch: int, found: dict[str, Any]) -> dict[str, Any] | None:
        case, name, setting = trial["case"], trial["integrator_id"], trial["setting"]
        library = trial["library"]
        if launch > (1 if case == LONE_LAUNCH else launches):
            return None
        if found["status"] not in ("ok", "inaccurate", "diverged") or "seconds_median" not in found:
            return found
        broken = number(case, name) > 1.2 or (case == LONE_LIBRARY and library not in ("scipy", "gnomon"))
        if broken:
            return {"status": "crashed", "reason": "planted"}
        bump = math.exp(1.5 * number(case, name, setting)) * (1e5 if case == NOBODY else 1.0)
        error = max(found["error_max"] * bump, 1e-15)
        status = "diverged" if error > 1 else "inaccurate" if error > 0.1 else "ok"
        apart = math.exp((0.4 if number(case) > 0 else 0.02) * number(case, name, "seconds"))
        noise = math.exp((0.15 if case in ROUGH else 0.03) * number(case, name, launch, "seconds"))
        seconds = found["seconds_median"] * apart * noise
        calls = None if library == "heyoka" or launch > 1 else found["rhs_calls"]
        null = 2e-4 if case == LONG_CALL else 2e-7
        return found | {
            "status": status, "error_max": error, "seconds_median": seconds, "rhs_calls": calls, "null_seconds": null,
        }  # fmt: skip

    return synthetic.write(path, cases(count), methods, change)
