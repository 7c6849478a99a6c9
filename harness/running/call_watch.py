"""Watch the calls of a user's function, and announce a right-hand side that makes the steps collapse."""

import sys
import warnings
from functools import partial
from typing import Any

import numpy as np
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.running.clock import Clock

MANY = 100_000
"""Calls after which the rest of the span is compared with the part that they took."""
LONG = 10
"""The rest is announced if it takes this many times MANY calls or more."""
RECENT = 64
"""Calls that are compared to find the coordinate."""
GAP, JUMP, FEW = 0.5, 1e-6, 4
"""A derivative jumps if its values leave out a part GAP of their range, with at least FEW values on either side of this part,
and if the range is larger than JUMP times the size of the derivative."""


SHOWN_BY = "showwarning", "_showwarnmsg_impl"
"""The functions that `warnings.catch_warnings` replaces to record warnings, and restores."""


class CallWatch:
    """Counts the calls of a function called `name`, and warns once if its steps collapse.

    The warning is filtered and shown as at the time of the construction: a run ignores or records the warnings of libraries.
    """

    def __init__(self, name: str, clock: Clock) -> None:
        self.name, self.clock = name, clock
        self.filters, self.line = list(warnings.filters), user_line()
        self.shown_by = {name: getattr(warnings, name) for name in SHOWN_BY if hasattr(warnings, name)}
        self.calls, self.reached = 0, 0.0
        self.recent: list[tuple[float, Floats, Floats]] = []

    def __call__(self, t: float, state: Floats, values: Floats) -> None:
        self.calls += 1
        since = self.calls % MANY
        if since >= RECENT or self.calls < MANY:
            return
        self.recent.append((t, state.copy(), values))
        if since == RECENT - 1:
            self._compare()

    def _compare(self) -> None:
        recent, self.recent = self.recent, []
        t = max(time for time, _, _ in recent)
        end = max(map(self.clock.elapsed, (self.clock.first, self.clock.last)))
        passed, self.reached = t - self.reached, t
        if not end < np.inf or end - t < LONG * passed:
            return
        text = f"{self.name}: after {MANY} calls from t={self.clock.time(t - passed):.9g} on, a method is only at"
        text = f"{text} t={self.clock.time(t):.9g}: {reason(recent)}"
        self.calls = -sys.maxsize  # once is enough
        with warnings.catch_warnings():
            warnings.filters[:] = self.filters  # type: ignore[index]
            for name, function in self.shown_by.items():
                setattr(warnings, name, function)
            warnings.warn_explicit(text, UserWarning, *self.line)


def reason(recent: list[tuple[float, Floats, Floats]]) -> str:
    """Why steps collapse, with the coordinate, and the way out.

    Where a derivative jumps, its values lie in two groups with a wide gap in between, however short the steps are.
    """
    _, states, values = (np.array(each) for each in zip(*recent, strict=True))
    ordered = np.sort(values, axis=0)
    spread = np.ptp(values, axis=0)
    inner = np.diff(ordered[FEW - 1 : 1 - FEW], axis=0).max(axis=0)  # no gap beside a few values counts
    jumps = (inner > GAP * spread) & (spread > JUMP * np.abs(values).max(axis=0))
    if not jumps.any():
        fastest = int(np.argmax(spread / (np.abs(values).max(axis=0) + np.finfo(float).tiny)))
        return (
            f"its steps are short, and no derivative jumps; that of y[{fastest}] changes fastest. If the equations are"
            " stiff, take gnomon:Radau IIA 5 or scipy:Radau"
        )
    which = int(np.argmax(jumps))
    low, high = values[:, which].min(), values[:, which].max()
    signs = [k for k in range(states.shape[1]) if states[:, k].min() < 0 < states[:, k].max()]
    where = f" where y[{signs[0]}] changes its sign" if signs else ""
    return (
        f"the derivative of y[{which}] jumps between {low:.6g} and {high:.6g}{where}, and steps collapse there. State dry"
        " friction by gnomon.sliding_friction, other changes of equations as the modes of a gnomon.Hybrid, with a method"
        " with events, and inputs that change at known times by jumps=[...]"
    )


def user_line() -> tuple[str, int]:
    """The file and the line of the code that called gnomon, for warnings."""
    frame = sys._getframe(1)
    while frame.f_back is not None and frame.f_globals.get("__name__", "").startswith("gnomon."):
        frame = frame.f_back
    return frame.f_code.co_filename, frame.f_lineno


def place(function: Any) -> str:
    """The name of a function with the file and the line where it is written, for messages."""
    inner = function.func if isinstance(function, partial) else function
    name = getattr(inner, "__qualname__", type(inner).__qualname__).replace("<locals>.", "")
    code = getattr(inner, "__code__", None)
    return name if code is None else f"{name} ({code.co_filename}, line {code.co_firstlineno})"
