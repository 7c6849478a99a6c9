"""The fastest measured way to an error on one problem, with its setting, its preparation and the lines that run it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from gnomon.harness.contract.status import SCORED, Status
from gnomon.harness.results.contenders import OWN, list_launched, scatters
from gnomon.harness.results.equal_error import credit_errors
from gnomon.harness.results.number_text import error_text, short_text, time_text
from gnomon.harness.results.time_ratios import SLOWER, Launch, Timed, compare, states

ROUNDING = 1e-15
"""Bounds of references below this are rounding to binary64."""


@dataclass(frozen=True)
class Best:
    """The fastest measured method and setting whose error is at most the wanted one; `print` shows it in words.

    Attributes
    ----------
    method : str
        The id of the integrator.
    setting : float
        Its tolerance, or its step size in the unit of the time of the problem.
    kind : str
        "tolerance" or "step".
    error : float
        The measured error at this setting: the largest of 64 samples, relative to the size of the motion.
    seconds : float
        The time of one call (s), without preparation.
    prepare_seconds : float
        The time of the preparation (s), which a further call saves.
    rival : str
        The method that is the fastest for one solve with its preparation; "" if it is this one.
    break_even : int
        The number of solves from which on this method takes less time than the rival, preparations included.
    equally_fast : tuple of str
        The methods whose times do not differ clearly from the time of this method, with the factor and its 95 % interval.
    below_reference : bool
        Whether the error is below the bound of the error of the reference, which is then given as `error`.
    lines : str
        The lines of Python that run it.

    Examples
    --------
    >>> import gnomon
    >>> found = gnomon.compare(lambda t, y: [y[1], -y[0]], (0, 3), [1, 0], ["gnomon:DOP853", "gnomon:RK4"])
    >>> best = found.best(1e-6)
    >>> best.error <= 1e-6, "gnomon.solve" in best.lines
    (True, True)
    """

    method: str
    setting: float
    kind: str
    error: float
    seconds: float
    prepare_seconds: float
    rival: str
    break_even: int
    equally_fast: tuple[str, ...]
    below_reference: bool
    lines: str

    def __str__(self) -> str:
        name = "rtol" if self.kind == "tolerance" else "step"
        bound = "below " if self.below_reference else ""
        text = (
            f"{self.method} at {name}={self.setting:.4g}: error {bound}{error_text(self.error)}, {time_text(self.seconds)} a"
            f" solve after {time_text(self.prepare_seconds)} of preparation; "
        )
        text += (
            f"with its preparation faster than {self.rival} from {self.break_even} solves on"
            if self.rival
            else "the fastest for a single solve too, preparation included"
        )
        text += (
            f"\nnot clearly slower (factor, 95 % interval): {', '.join(self.equally_fast)}" if self.equally_fast else ""
        )
        return f"{text}\n\n{self.lines.strip()}"


class Cost(NamedTuple):
    """The seconds that a method takes once, and for each solve.

    Examples
    --------
    >>> compiled, plain = Cost(once=1.0, each=1e-3), Cost(once=0.0, each=3e-3)
    >>> compiled.total(1), compiled.overtakes(plain), plain.overtakes(compiled)
    (1.001, 501, 1)
    """

    once: float
    each: float

    def total(self, solves: int) -> float:
        """The seconds of this number of solves."""
        return self.once + solves * self.each

    def overtakes(self, rival: Cost) -> float:
        """The number of solves from which on this takes less time than the rival did before; inf if it never does."""
        if self.total(1) < rival.total(1):
            return 1
        return (
            math.floor((self.once - rival.once) / (rival.each - self.each)) + 1 if self.each < rival.each else math.inf
        )


@dataclass(frozen=True)
class Way:
    """A method at the loosest setting that reaches an error, with its cost; `below`: its error is below the reference's."""

    timed: Timed
    setting: float
    kind: str
    error: float
    cost: Cost
    below: bool


def best(rows: Sequence[Mapping[str, Any]], error: float, lines: Callable[[str, float, str], str]) -> Best:
    """The best of the rows of one problem. Raises ValueError, with the least error, if no method reaches the error.

    `lines(method, setting, kind)` are the lines of Python that run a method at a setting.
    """
    ways = find_ways(rows, error)
    if not ways:
        hidden = explain_hidden(rows)
        least = _least(rows)
        nearest = "nothing was solved" if least is None else f"the least error is {error_text(error_of(least))}"
        raise ValueError(f"error={error:g}: {hidden or f'no method that was compared reaches it; {nearest}'}")
    fastest = ways[0]
    rival = min(ways, key=lambda way: way.cost.total(1))
    alone = rival is fastest or rival.cost.each <= fastest.cost.each
    return Best(
        fastest.timed.integrator_id, fastest.setting, fastest.kind, fastest.error, fastest.cost.each, fastest.cost.once,
        "" if alone else rival.timed.integrator_id, 1 if alone else int(fastest.cost.overtakes(rival.cost)),
        tuple(_equally_fast(rows, ways)), fastest.below,
        lines(fastest.timed.integrator_id, fastest.setting, fastest.kind),
    )  # fmt: skip


def find_ways(rows: Sequence[Mapping[str, Any]], error: float) -> list[Way]:
    """The loosest setting of each method that reaches an error on the problem of these rows, the fastest first."""
    series: dict[str, list[Mapping[str, Any]]] = {}
    times: dict[tuple[str, float], dict[Launch, float]] = {}
    for row in rows:
        if _is_timed(row):
            at = times.setdefault((row["integrator_id"], row["setting"]), {})
            at[row.get("run", 1), row["launch"]] = row["seconds_median"]
            if row["launch"] == 1:
                series.setdefault(row["integrator_id"], []).append(row)
    loosest = [_loosest(each, error, times) for each in series.values()]
    return sorted((way for way in loosest if way is not None), key=lambda way: way.cost.each)


def _is_timed(row: Mapping[str, Any]) -> bool:
    return row["status"] in SCORED and bool(row["seconds_median"])


def _least(rows: Sequence[Mapping[str, Any]]) -> Mapping[str, Any] | None:
    """The row with the least error; None if nothing was solved."""
    row = min(filter(_is_timed, rows), key=error_of, default=None)
    return row if row is not None and math.isfinite(error_of(row)) else None


def explain_hidden(rows: Sequence[Mapping[str, Any]]) -> str:
    """Why no smaller error can be measured on a problem, if the reference is the limit; "" if the methods are."""
    row = _least(rows)
    if row is None or not is_below_reference(row):
        return ""
    if row["floor"] >= 1:
        return "no error can be measured, because there is no reference at the end of the span; take a shorter span"
    return (
        f"so small an error cannot be measured, because the reference may itself be wrong by {error_text(row['floor'])}"
    )


def bound_text(floor: float) -> str:
    """An error below the bound of the error of its reference."""
    return f"< {error_text(floor)}" if floor < 1 else "no reference"


def is_below_reference(row: Mapping[str, Any]) -> bool:
    """Whether the error of a row is below the bound of the error of its reference, by more than rounding."""
    floor = row["floor"] or 0.0
    return row["error_max"] is not None and bool(row["error_max"] < floor and floor > ROUNDING)


def _equally_fast(rows: Sequence[Mapping[str, Any]], ways: Sequence[Way]) -> Iterator[str]:
    """The ways that the launches do not separate from the first, which is the fastest, in words."""
    compared = compare([way.timed for way in ways], scatters(list_launched(rows))[OWN])
    for way, row, state in list(zip(ways, compared, *states([compared]), strict=True))[1:]:
        if state != SLOWER:
            yield f"{way.timed.integrator_id} {short_text(row.ratio)} ({short_text(row.low)} – {short_text(row.high)})"


def error_of(row: Mapping[str, Any]) -> float:
    """The error of a row, at least the bound of the error of its reference; inf if it diverged."""
    if row["status"] == Status.DIVERGED or row["error_max"] is None or math.isnan(row["error_max"]):
        return math.inf
    return max(float(row["error_max"]), float(row["floor"] or 0.0))


def _loosest(
    rows: Sequence[Mapping[str, Any]], error: float, times: Mapping[tuple[str, float], dict[Launch, float]]
) -> Way | None:
    """The loosest setting from which on all tighter ones, up to the limit of rounding, have at most this error."""
    ordered = sorted(rows, key=lambda row: -row["setting"])
    for row, held in zip(ordered, credit_errors([error_of(row) for row in ordered]), strict=True):
        if held <= error:
            below = float(row["error_max"]) < float(row["floor"] or 0.0)
            timed = Timed(row["integrator_id"], times[row["integrator_id"], row["setting"]])
            cost = Cost(row["prepare_seconds"] or 0.0, timed.middle)
            return Way(
                timed, row["setting"], row["setting_kind"], error_of(row), cost, below,
            )  # fmt: skip
    return None
