"""The report of `gnomon check` as text, JSON, JUnit XML and Markdown, and the order of several files."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol
from xml.etree import ElementTree

import numpy as np
from gnomon.cases import Case
from gnomon.harness.results.visible import markdown, visible
from gnomon.harness.trajectories.columns import Trajectory
from gnomon.harness.trajectories.comparison import LINEAR, Comparison, count_periods, find_period
from gnomon.harness.verification.causes import FEWEST, LEAST
from gnomon.harness.verification.verification_report import FAILED, NOT_VERIFIED, PASSED

SCHEMA = 1
"""Version of the JSON result; it changes when a key disappears or changes its meaning."""
WORDS = {PASSED: "passed", FAILED: "failed", NOT_VERIFIED: "not checked"}
MOST_EVENTS = 3
"""Missed and extra events that a report names."""


class Told(Protocol):
    """A verdict: its exit code and its text."""

    @property
    def code(self) -> int: ...
    @property
    def text(self) -> str: ...


class Result(Protocol):
    """A trajectory that was checked, as `gnomon.TrajectoryCheck`."""

    case: Case
    trajectory: Trajectory
    comparison: Comparison | None
    reason: str
    bound: float | Mapping[str, float] | None

    @property
    def causes(self) -> tuple[str, ...]: ...
    @property
    def verdict(self) -> Told: ...
    @property
    def error(self) -> float: ...


@dataclass(frozen=True)
class Order:
    """The order of convergence of several files: between neighbours (longer step, shorter step, order), and together.

    `left_out`: steps whose errors are limited by digits, or are not small.
    """

    pairs: tuple[tuple[float, float, float], ...]
    order: float
    margin: float
    left_out: tuple[float, ...]


def fit_files(results: Sequence[Result], steps: Sequence[float]) -> Order | None:
    """The order of the errors of files over their steps, up to the end of the shortest; None with less than two."""
    compared = [
        (step, each.comparison) for step, each in zip(steps, results, strict=True) if each.comparison is not None
    ]
    if len(compared) < 2:
        return None
    end = min(float(each.times[-1]) for _, each in compared)
    points, left_out = [], []
    for step, each in sorted(compared, key=lambda pair: -pair[0]):
        error = float(np.max(each.errors[each.times <= end]))
        if 0 < error <= LINEAR and not each.limits:
            points.append((step, error))
        else:
            left_out.append(step)
    if len(points) < 2:
        return None
    pairs = tuple((h, k, math.log(e / f) / math.log(h / k)) for (h, e), (k, f) in itertools.pairwise(points))
    from gnomon.harness.results.convergence_order import mean_slope  # loads scipy.special, slow

    logs = [(math.log(h), math.log(e)) for h, e in points]
    order, margin = mean_slope(logs) if len(points) > 2 else (pairs[0][2], math.nan)
    return Order(pairs, order, margin, tuple(left_out))


def order_lines(results: Sequence[Result], steps: Sequence[float]) -> list[str]:
    """The order of convergence as text."""
    fit = fit_files(results, steps)
    if fit is None:
        return ["order: not told; it takes two files with small errors that their digits do not limit"]
    lines = [f"order from step {h:g} to {k:g}: {order:.3g}" for h, k, order in fit.pairs]
    if len(fit.pairs) > 1:
        margin = f" +- {fit.margin:.2g}" if math.isfinite(fit.margin) else ""
        lines.append(f"order of all: {fit.order:.3g}{margin}")
    else:
        lines.append("two files give no interval for the order; a third one does")
    if fit.left_out:
        steps_left = ", ".join(f"{step:g}" for step in fit.left_out)
        lines.append(f"left out of the order, as errors are large or limited by digits: {steps_left}")
    return lines


def lines(result: Result) -> list[str]:
    """The report as text."""
    trajectory, numbers = result.trajectory, result.case.numbers
    stated = ", ".join(f"{name}={float(value):g}" for name, value in numbers.items())
    report = [f"{trajectory.source} against the exact motion of {result.case.id} ({stated})"]
    report += [f"  {line}" for line in (*trajectory.mapping, *trajectory.notes)]
    if result.comparison is not None:
        report += _describe_compared(result.comparison)
    report += [f"likely cause: {line}" for line in result.causes] or _deny_causes(result)
    return [visible(line) for line in [*report, result.verdict.text]]


def _deny_causes(result: Result) -> list[str]:
    """A line if an error beyond the bound has no known cause, nor is it a limit of the file."""
    whole = result.comparison
    if whole is None or not whole.is_whole or len(whole.times) < FEWEST or not whole.error > LEAST or whole.limits:
        return []
    if result.bound is not None and result.verdict.code != FAILED:
        return []
    return [
        "no common mistake in units, columns, parameters or start explains the error; the step may be too long:"
        " files at two steps, with --step, give the order"
    ]


def _describe_compared(comparison: Comparison) -> list[str]:
    times, units = comparison.times, {c.name: f" {c.unit}" * (c.unit != "1") for c in comparison.case.state}
    covered = f"{times[0]:.9g} s to {times[-1]:.9g} s{count_periods(comparison.case, times[-1] - times[0])}"
    lines = [f"{len(times)} rows from t = {covered}", *_start(comparison)]
    lines.append(f"largest error by time, relative to the size of the motion ({_sizes(comparison)}):")
    lines += [f"  up to t = {end:<10.6g} s {error:.2e}" for end, error in comparison.by_time()]
    worst, place = comparison.case.state[comparison.worst_coordinate].name, comparison.worst
    row = comparison.trajectory.row(int(comparison.rows[place]))
    lines.append(f"largest error: {comparison.error:.3g} at t = {times[place]:.9g} s ({row}), most of it in {worst}")
    for name, (error, place) in comparison.largest.items():
        turned = ""
        if name in comparison.with_turns:
            whole, there = comparison.with_turns[name]
            turned = f", modulo 2 pi; {whole:+.3g} rad at t = {times[there]:.9g} s with whole turns"
        lines.append(f"  {name}: {error:+.3g}{units[name]} at t = {times[place]:.9g} s{turned}")
    if comparison.phase_and_shape is not None:
        phase, shape = comparison.phase_and_shape
        late = ""
        if comparison.latest is not None:
            t, seconds = comparison.latest
            late = f"; {abs(seconds):.3g} s {'late' if seconds > 0 else 'early'} at t = {t:.9g} s"
        lines.append(f"phase (along the motion) {phase:.3g}, shape (across it) {shape:.3g}{late}")
    if comparison.period is not None:
        each = comparison.period
        lines.append(
            f"{each.name}: {each.found:.12g} s +- {each.margin:.1g} s, exact {each.exact:.12g} s, difference"
            f" {each.found - each.exact:+.2g} s"
        )
    for name, (drift, t, end) in comparison.drifts.items():
        lines.append(f"relative drift of {name}: {drift:.2g} at t = {t:.9g} s, {end:.2g} at the end")
    return [*lines, *_events(comparison), *(f"the result is limited by {limit}" for limit in comparison.limits)]


def _sizes(comparison: Comparison) -> str:
    """The largest size of each group of coordinates on the exact motion, by which its errors are divided."""
    state, sizes = comparison.case.state, []
    for group in (each for each in comparison.metric.groups if each.scored):
        names = [state[index].name for index in group.indices]
        unit = state[group.indices[0]].unit
        sizes.append(f"{', '.join(names[:3])}{' ...' * (len(names) > 3)} {group.scale:.3g}{f' {unit}' * (unit != '1')}")
    return "; ".join(sizes)


def _start(comparison: Comparison) -> list[str]:
    """A line if the first row is the start and is not the start of the case."""
    if comparison.times[0] > 0 or not comparison.errors[0] > 1e-6:
        return []
    pairs = zip(comparison.case.state, comparison.states[0].tolist(), comparison.exact[0].tolist(), strict=True)
    far = [f"{c.name} = {got:.9g}, the case at {exact:.9g}" for c, got, exact in pairs if abs(got - exact) > 1e-9]
    return [f"the file starts at {'; '.join(far[:4])} (--set gives a case other numbers)"] if far else []


def _events(comparison: Comparison) -> list[str]:
    events = comparison.events
    if events is None:
        return []
    lines = []
    for word, each in (("missed", events.missed), ("extra", events.extra)):
        if each:
            named = ", ".join(f"{name} at t = {t:.9g} s" for t, name in each[:MOST_EVENTS])
            lines.append(f"events {word}: {len(each)} ({named}{' ...' if len(each) > MOST_EVENTS else ''})")
    text = f"{len(events.late)} events found in the rows as in the exact motion"
    if events.latest is not None:
        t, seconds, name = events.latest
        text += f", most {'late' if seconds > 0 else 'early'}: {name} at t = {t:.9g} s by {abs(seconds):.3g} s"
    lines.append(text)
    if events.until < comparison.times[-1]:
        lines.append(f"events after t = {events.until:.9g} s are not told: they follow faster than the rows")
    return lines


def verdict_word(result: Result) -> str:
    """The verdict in a word: passed, failed, not checked, or no bound."""
    if result.comparison is not None and result.bound is None:
        return "no bound"
    return WORDS[result.verdict.code]


def as_dictionary(result: Result) -> dict[str, Any]:
    """The report for JSON; numbers that are not finite are null."""
    comparison = result.comparison
    whole: dict[str, Any] = {
        "source": result.trajectory.source,
        "case": result.case.id,
        "numbers": {name: float(value) for name, value in result.case.numbers.items()},
        "mapping": result.trajectory.mapping,
        "notes": result.trajectory.notes,
        "within": dict(result.bound) if isinstance(result.bound, Mapping) else result.bound,
        "verdict": verdict_word(result),
        "told": result.verdict.text,
        "causes": list(result.causes),
    }
    if comparison is None:
        return whole | {"reason": result.reason}
    worst, events, times = comparison.worst, comparison.events, comparison.times
    _, period = find_period(comparison.case) or ("", None)
    turned = comparison.with_turns.items()
    return whole | {
        "rows": len(times),
        "from": float(times[0]),
        "to": float(times[-1]),
        "is_part": bool(comparison.part),
        "periods": None if period is None else float(times[-1] - times[0]) / period,
        "error": _number(comparison.error),
        "error_time": float(times[worst]),
        "error_row": int(comparison.trajectory.lines[comparison.rows[worst]]),
        "error_coordinate": comparison.case.state[comparison.worst_coordinate].name,
        "by_time": [[end, _number(error)] for end, error in comparison.by_time()],
        "largest": {
            name: {"error": _number(e), "time": float(times[k])} for name, (e, k) in comparison.largest.items()
        },
        "with_turns": {name: {"error": e, "time": float(times[k])} for name, (e, k) in turned},
        "phase": None if comparison.phase_and_shape is None else _number(comparison.phase_and_shape[0]),
        "shape": None if comparison.phase_and_shape is None else _number(comparison.phase_and_shape[1]),
        "late_seconds": None if comparison.latest is None else comparison.latest[1],
        "period": None if comparison.period is None else comparison.period.__dict__,
        "drifts": {name: {"largest": d, "time": t, "end": end} for name, (d, t, end) in comparison.drifts.items()},
        "events": None if events is None else events.__dict__,
        "limits": comparison.limits,
        "doubts": comparison.doubts,
    }


def _number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def as_json(results: Sequence[Result], steps: Sequence[float]) -> str:
    whole: dict[str, Any] = {"schema": SCHEMA, "checks": [as_dictionary(each) for each in results]}
    if steps:
        order = fit_files(results, steps)
        whole["steps"] = list(steps)
        whole["order"] = None if order is None else {
            "order": order.order, "margin": _number(order.margin), "pairs": order.pairs, "left_out": order.left_out
        }  # fmt: skip
    return json.dumps(whole, indent=1) + "\n"


def as_junit(results: Sequence[Result], steps: Sequence[float]) -> str:
    """A test case for each file: a failure beyond the bound, an error if it was not checked."""
    codes = [each.verdict.code for each in results]
    suite = ElementTree.Element(
        "testsuite", name="gnomon check", tests=str(len(results)), failures=str(codes.count(FAILED)),
        errors=str(codes.count(NOT_VERIFIED)),
    )  # fmt: skip
    for each in results:
        test = ElementTree.SubElement(suite, "testcase", classname=each.case.id, name=visible(each.trajectory.source))
        if each.verdict.code != PASSED:
            kind = "failure" if each.verdict.code == FAILED else "error"
            element = ElementTree.SubElement(test, kind, message=visible(each.verdict.text))
            element.text = "\n".join(lines(each))
    return ElementTree.tostring(suite, encoding="unicode", xml_declaration=True) + "\n"


def as_markdown(results: Sequence[Result], steps: Sequence[float]) -> str:
    """The report for a pull request: a row for each file, then each report."""
    report = ["### gnomon check", "", "| file | case | error | verdict |", "|---|---|---|---|"]
    for each in results:
        cells = [each.trajectory.source, each.case.id, f"{each.error:.3g}", verdict_word(each)]
        report.append(f"| {' | '.join(map(markdown, cells))} |")
    for each in results:
        report += ["", *(f"- {markdown(line.strip())}" for line in lines(each))]
    if steps:
        report += ["", *(f"- {markdown(line)}" for line in order_lines(results, steps))]
    return "\n".join(report) + "\n"


WRITERS: Mapping[str, Callable[[Sequence[Result], Sequence[float]], str]] = {
    "json": as_json, "junit": as_junit, "markdown": as_markdown
}  # fmt: skip
"""The writer of each kind of file, from the results and their steps."""
