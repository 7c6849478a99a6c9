"""Validate settings, and the answer of an integrator before it is used: types, shapes, real numbers, counts."""

import math
from numbers import Real
from typing import Any

import numpy as np
from gnomon.harness.contract.integrator import Floats, Refused, Solution

MOST = 2**53
"""Larger counts are refused: a double cannot distinguish them, and no run takes that many steps."""
LEAST_SECONDS = 1e-11
"""Every right-hand side and every step takes more: this is a twentieth of a processor's cycle."""
RESOLUTION_SECONDS = 1e-6
DID_NOT_MOVE = "did not move: every sample equals the initial state"
"""The reason for the refusal of states that rest although the exact motion leaves its start."""
TEXT = 300
"""Reasons are cut to this number of characters."""


class Unusable(Exception):  # noqa: N818 - it names an answer
    """Raised for an answer that is not a valid Solution: the message names the value and the rule."""


def require_positive(setting: float, kind: str) -> None:
    """Raise Refused unless a setting is a positive number: with others libraries hang, or go on.

    `kind` names the setting in the message, such as "tolerance".
    """
    if not (math.isfinite(setting) and setting > 0):
        raise Refused(f"{kind} {setting} is not a positive number")


def check(solution: Any, shape: tuple[int, ...]) -> Solution:
    """The solution with states as float64 of this shape (a copy), counts as ints and events as plain pairs.

    Raises Unusable for any other answer.
    """
    if not isinstance(solution, Solution):
        raise Unusable(f"solve returned {type(solution).__name__}, not a Solution")
    if solution.stopped is not None and not isinstance(solution.stopped, str):
        raise Unusable(f"returned stopped = {short(solution.stopped)}: it is a text, or None")
    return Solution(
        real_states(solution.states, shape),
        None if solution.steps is None else count(solution.steps, "steps"),
        solution.stopped and solution.stopped[:TEXT],
        None if solution.events is None else tuple(_event(event) for event in _as_list(solution.events)),
    )


def real_states(states: Any, shape: tuple[int, ...]) -> Floats:
    """States as a new float64 array of this shape. Complex states are accepted if every imaginary part is zero."""
    numbers = np.asarray(states)
    if numbers.dtype.kind not in "iufc":
        raise Unusable(f"returned states of type {numbers.dtype}, not real numbers")
    if numbers.shape != shape:
        raise Unusable(f"returned states of shape {numbers.shape}, not {shape}")
    if numbers.dtype.kind == "c":
        if np.any(numbers.imag != 0):
            raise Unusable(f"returned complex states (imaginary parts up to {np.nanmax(np.abs(numbers.imag)):.2g})")
        numbers = numbers.real
    with np.errstate(over="ignore"):  # a wider float beyond binary64 becomes infinite: status `diverged`
        return np.array(numbers, dtype=np.float64)


def is_still(states: Floats, starts: Floats) -> bool:
    """Whether, for any start of `starts` (n, dim), its `states` (n, times, dim) equal the start at all samples."""
    return bool(np.any(np.all(states == starts[:, np.newaxis], axis=(1, 2))))


def require_motion(states: Floats, starts: Floats) -> None:
    """Raise Refused if states rest, as `is_still` tells."""
    if is_still(states, starts):
        raise Refused(DID_NOT_MOVE)


def count(value: Any, name: str) -> int:
    """A count as an int. Raises Unusable if it is not a whole number from 0 to 2^53."""
    # Compared before it is rounded: an integer beyond binary64 has no float, and nan is in no interval.
    counted = isinstance(value, Real) and not isinstance(value, bool | np.bool_) and 0 <= value <= MOST  # type: ignore[operator]
    if not counted or value != math.floor(value):
        raise Unusable(f"returned {name} = {short(value)}: a count is a whole number from 0 to 2^53")
    return int(value)


def possible(count: int | None, seconds: float, name: str) -> None:
    """Raise Unusable for more steps or right-hand sides than a processor can do in this time."""
    if count is not None and count * LEAST_SECONDS > seconds + RESOLUTION_SECONDS:
        raise Unusable(f"claims {count} {name} in {seconds:.2g} s: one takes {LEAST_SECONDS:g} s at least")


def _as_list(events: Any) -> list[Any]:
    try:
        return list(events)
    except TypeError:
        raise Unusable(f"returned events = {short(events)}: they are pairs (time, name)") from None


def _event(event: Any) -> tuple[float, str]:
    try:
        time, name = event
    except (TypeError, ValueError):
        raise Unusable(f"returned the event {short(event)}: it is a pair (time, name)") from None
    if not is_finite(time) or not isinstance(name, str):
        raise Unusable(f"returned the event {short(event)}: it is a pair (time, name) with a finite time")
    return float(time), name


def is_finite(value: Any) -> bool:
    """Whether a value is a real number that binary64 can hold."""
    try:
        return isinstance(value, Real) and not isinstance(value, bool) and math.isfinite(value)
    except OverflowError:
        return False


def short(value: object) -> str:
    """The repr of a value, cut to 60 characters, for messages."""
    try:
        text = repr(value)
    except Exception:  # an integer with more digits than Python writes, or a user's own class
        return f"<{type(value).__name__} without a text>"
    return text if len(text) <= 60 else f"{text[:57]}..."
