"""`gnomon.check`: how wrong a trajectory is, from a file or arrays, with a result that a test asserts and a notebook shows."""

from __future__ import annotations

import html
import math
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from gnomon.cases import Case
from gnomon.cases.core.numbers import nearest
from gnomon.harness.registry import selection
from gnomon.harness.results.visible import shorten
from gnomon.harness.system import extras
from gnomon.harness.trajectories import check_report
from gnomon.harness.trajectories.columns import Trajectory, read_columns, states_of
from gnomon.harness.trajectories.comparison import Comparison, NotCheckedError, compare, pick_evenly
from gnomon.harness.trajectories.reading import Table, read_frame, read_table
from gnomon.harness.verification.causes import causes
from gnomon.harness.verification.verification_report import FAILED, NOT_VERIFIED, PASSED

Bound = float | Mapping[str, float]
"""The largest error that is allowed: of the size of the motion, or by coordinate in its unit."""
Span = tuple[float | None, float | None]
"""The times (s) from which and to which a motion must be there; None for the first and the last of the trajectory."""
ACCEPTED = ("unsorted", "sparse", "partial")
"""What is no reason not to compare, where it is named; `gnomon check` has --sort, --sparse and --partial."""

MOST_DIAGNOSED = 256
"""Rows from which causes are found: some are found by solutions of other equations."""


@dataclass(frozen=True)
class Verdict:
    """Whether a trajectory is within a bound; true only if this was checked and is so. `code` is the exit code."""

    code: int
    text: str

    def __bool__(self) -> bool:
        return self.code == PASSED

    def __repr__(self) -> str:
        return f"<{self.text}>"


@dataclass
class TrajectoryCheck:
    """How wrong a trajectory is; `gnomon.check` makes it. `print` shows the report, and a notebook draws it.

    Attributes
    ----------
    case : Case
        The case with its numbers.
    trajectory : Trajectory
        The times and states in the coordinates of the case, and how they were read.
    comparison : Comparison or None
        The trajectory beside the exact motion: errors, phase and shape, period, drifts, events; None if not checked.
    reason : str
        Why the trajectory could not be compared; empty if it was.
    bound : float or mapping or None
        The largest error that is allowed.

    Examples
    --------
    >>> import gnomon
    >>> swing = gnomon.case("pendulum_simple")
    >>> result = gnomon.check(swing, swing.times, swing.sample(swing.times))
    >>> isinstance(result, gnomon.TrajectoryCheck)
    True
    """

    case: Case
    trajectory: Trajectory
    comparison: Comparison | None
    reason: str = ""
    bound: Bound | None = None

    @cached_property
    def causes(self) -> tuple[str, ...]:
        """Likely causes of the error, a line each: what is wrong, and the error that would be left.

        Empty for a trajectory that passed, and for a part of the coordinates.
        """
        comparison = self.comparison
        if comparison is None or not comparison.is_whole or (self.bound is not None and self.within(self.bound)):
            return ()
        places = pick_evenly(len(comparison.times), MOST_DIAGNOSED)
        step = float(np.median(np.diff(comparison.trajectory.times)))
        moves = {"one row": step} if len(places) < len(comparison.times) else {}
        with np.errstate(all="ignore"):
            return tuple(map(str, causes(comparison.case, comparison.times[places], comparison.states[places], moves)))

    @property
    def error(self) -> float:
        """The largest error in the metric of the case, relative to the size of the motion; nan if not checked."""
        return math.nan if self.comparison is None else self.comparison.error

    @property
    def errors(self) -> Any:
        """The error at each time that was compared, shape (n,)."""
        return np.empty(0) if self.comparison is None else self.comparison.errors

    @property
    def times(self) -> Any:
        """The times that were compared, shape (n,)."""
        return np.empty(0) if self.comparison is None else self.comparison.times

    def within(self, bound: Bound) -> Verdict:
        """Whether the trajectory was checked and is within a bound.

        Parameters
        ----------
        bound : float or mapping of str to float
            The largest error, relative to the size of the motion; or by coordinate, in its unit.

        Returns
        -------
        Verdict
            True if it is; its text says why not.
        """
        validate_bound(bound, self.case)
        if self.comparison is None:
            return Verdict(NOT_VERIFIED, f"not checked: {self.reason}")
        failures = _beyond(self.comparison, bound)
        if failures:
            return Verdict(FAILED, "failed: " + "; ".join(failures))
        if self.comparison.doubts:
            return Verdict(NOT_VERIFIED, f"not checked: {'; '.join(self.comparison.doubts)}")
        part = self.comparison.part
        more = "; --from and --to state the part that must be there" if part else ""
        return Verdict(PASSED, f"passed{part}: error {self.error:.3g}, allowed {bound_text(bound)}{more}")

    @property
    def verdict(self) -> Verdict:
        """The verdict on the bound that was given; without one, the error reached, which is no pass."""
        if self.bound is not None:
            return self.within(self.bound)
        if self.comparison is None:
            return Verdict(NOT_VERIFIED, f"not checked: {self.reason}")
        reached = f"error reached{self.comparison.part}: {self.error:.3g} of the size of the motion"
        text = f"{reached}; no bound was given, as --within 1e-6"
        return Verdict(NOT_VERIFIED, "; ".join([text, *(f"not checked: {doubt}" for doubt in self.comparison.doubts)]))

    def plot(self) -> Any:
        """Draw the motion and the error by time.

        Returns
        -------
        altair.Chart
            A chart, which a notebook shows and whose `save` writes .html, .svg or .png.
        """
        extras.require("report", "a chart")
        from gnomon.harness.trajectories.picture import chart  # loads Altair, an optional package

        if self.comparison is None:
            raise ValueError(f"nothing to draw: {self.reason}")
        return chart(self.comparison, self.verdict.text, None if isinstance(self.bound, Mapping) else self.bound)

    def __str__(self) -> str:
        return "\n".join(check_report.lines(self))

    def __repr__(self) -> str:
        return f"<check of {self.trajectory.source} on {self.case.id}: {self.verdict.text}>"

    def _repr_html_(self) -> str:
        text = f"<pre>{html.escape(str(self))}</pre>"
        if self.comparison is None or extras.lacking("report") is not None:
            return text
        import vl_convert  # slow to load: only a drawing needs it

        return text + vl_convert.vegalite_to_svg(self.plot().to_dict(validate=False))


def validate_bound(bound: Bound, case: Case) -> None:
    """Raise ValueError for an error that is not positive, or for a coordinate that the case does not have."""
    names = [coordinate.name for coordinate in case.state]
    for name, value in bound.items() if isinstance(bound, Mapping) else [("", bound)]:
        if name and name not in names:
            raise ValueError(f"within {shorten(name)}: {case.name} has no such coordinate; {nearest(name, names)}")
        if not 0 < value < math.inf:
            raise ValueError(f"within {name}{'=' * bool(name)}{value:g}: give a positive error")


def bound_text(bound: Bound) -> str:
    """A bound as text, as `--within` takes it."""
    return (
        ", ".join(f"{name}={value:g}" for name, value in bound.items()) if isinstance(bound, Mapping) else f"{bound:g}"
    )


def _beyond(comparison: Comparison, bound: Bound) -> list[str]:
    """What is beyond a bound, a sentence each."""
    if not isinstance(bound, Mapping):
        place = comparison.worst
        if comparison.error <= bound:
            return []
        where = comparison.trajectory.row(int(comparison.rows[place]))
        return [f"error {comparison.error:.3g} at t = {comparison.times[place]:.9g} s ({where}), allowed {bound:g}"]
    sentences = []
    units = {coordinate.name: coordinate.unit for coordinate in comparison.case.state}
    for name, value in bound.items():
        if name not in comparison.largest:
            sentences.append(f"{name} has no column")
            continue
        error, place = comparison.largest[name]
        if not abs(error) <= value:
            sentences.append(
                f"{name} is wrong by {error:.3g} {units[name]} at t = {comparison.times[place]:.9g} s, allowed {value:g}"
            )
    return sentences


def check(
    case: Any,
    times: Any,
    states: Any = None,
    *,
    columns: Iterable[str] | Mapping[str, str] | None = None,
    within: Bound | None = None,
    span: Span = (None, None),
    accept: Iterable[str] = (),
) -> TrajectoryCheck:
    """Compare a trajectory with the exact motion of a case.

    Parameters
    ----------
    case : str, Case or ExactCase
        A case or its name; `gnomon.case("pendulum_simple", L=2)` has other numbers.
    times : array_like, path, mapping or frame
        The times in s, shape (n,). Without `states`: a file, or columns by name.
    states : array_like, mapping or frame, optional
        The states in the case's coordinates and units, shape (n, dim); or columns by name.
    columns : str, sequence or mapping, optional
        For columns by name: what each is, as ``"phi=theta:deg,w=omega:deg/s"`` or ``{"phi": "theta:deg"}``.
    within : float or mapping, optional
        The largest error that is allowed, as in `TrajectoryCheck.within`, for the verdict of the report.
    span : tuple of float or None
        The times in s from which and to which the motion must be there, and is compared; None for the first and the last.
    accept : sequence of {"unsorted", "sparse", "partial"}
        What is accepted: rows whose times do not rise, which are sorted; gaps longer than 2 pi times the time scale;
        coordinates without a column, which are not compared.

    Returns
    -------
    TrajectoryCheck
        The errors; `assert result.within(1e-6)` is a test.

    Raises
    ------
    ValueError
        For an unknown case, column, unit, coordinate or word of `accept`, for arrays of other shapes, and for a file that
        is not read.

    Examples
    --------
    >>> import gnomon
    >>> orbit = gnomon.case("kepler_orbit")
    >>> states = orbit.sample(orbit.times)
    >>> assert gnomon.check("kepler_orbit", orbit.times, states).within(1e-12)
    >>> bool(gnomon.check("kepler_orbit", orbit.times, 1.001 * states).within(1e-6))
    False
    """
    chosen, accepted = _find_one_case(case), {accept} if isinstance(accept, str) else {*accept}
    for word in accepted - {*ACCEPTED}:
        raise ValueError(f"accept={shorten(repr(word))}: it is one of {', '.join(ACCEPTED)}")
    if within is not None:
        validate_bound(within, chosen)
    if states is not None and not hasattr(states, "keys") and not hasattr(states, "column_names"):
        if columns is not None:
            raise ValueError("columns: the states have no names; give columns by name, as {'phi': angles}")
        trajectory = states_of(chosen, times, states)
    else:
        trajectory = read_columns(_table(times, states), chosen, columns, "partial" in accepted)
    return check_trajectory(chosen, trajectory, within, span, accepted)


def check_trajectory(
    case: Case,
    trajectory: Trajectory,
    bound: Bound | None = None,
    span: Span = (None, None),
    accepted: Collection[str] = (),
) -> TrajectoryCheck:
    """The result for a trajectory in the coordinates of a case; a trajectory that cannot be compared has its reason."""
    first, last = span
    for name, value in (("--from", first), ("--to", last)):
        if value is not None and not 0 <= value < math.inf:
            raise ValueError(f"{name} {value:g}: give a time from 0 on, in s")
    if first is not None and last is not None and not first < last:
        raise ValueError(f"--from {first:g} --to {last:g}: give a later time with --to")
    try:
        comparison = compare(case, trajectory, first, last, "unsorted" in accepted, "sparse" in accepted)
    except NotCheckedError as reason:
        return TrajectoryCheck(case, trajectory, None, str(reason), bound)
    return TrajectoryCheck(comparison.case, comparison.trajectory, comparison, "", bound)


def _find_one_case(name: Any) -> Case:
    """The case with this name. Raises ValueError for a pattern of several cases."""
    cases = selection.find_cases([name])
    if len(cases) != 1:
        raise ValueError(f"case={shorten(repr(name))}: {len(cases)} cases have this name; give one")
    return cases[0]


def _table(times: Any, states: Any) -> Table:
    if states is not None:
        table = read_frame(states)
        table.add("t", np.asarray(times))
        if len(table.columns["t"]) != table.rows():
            raise ValueError(f"{len(table.columns['t'])} times and {table.rows()} rows; give as many")
        return table
    if isinstance(times, str | Path):
        return read_table(Path(times))
    if hasattr(times, "keys") or hasattr(times, "column_names"):
        return read_frame(times)
    raise ValueError("states: missing; give times and states, a file, or columns by name")
