"""The settings of a run as dicts, for the table that ends it, without pandas: as `analysis.settings(analysis.tidy(...))`."""

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.contract.status import CANNOT_RUN, Status
from gnomon.harness.measuring.outcome import DELAYED
from gnomon.harness.results.convergence_order import line, slopes, why_no_line
from gnomon.harness.results.schema import MEASUREMENT_COLUMNS, TIMES

PROBLEM = ["case", "variant", "formulation"]
SERIES = [*PROBLEM, "library", "integrator_id"]
ON_A_LINE = 0.1
"""A slope counts as an order if the slope between any two neighbouring points differs from it by at most this, the
tolerance between measured and declared order. An error that passes through zero between two steps bends the line by
whole orders."""
ERRORS = [
    *(name for name in MEASUREMENT_COLUMNS if name.startswith("error_") and name != "error_unturned"),
    *("turns", "invariant_drift"),
]
"""Columns to ignore in later launches of a trial if its first launch has the median over turned starts."""
UNDER_LOAD = 0.05
"""Share of delayed measurements above which a machine was under load. A call that waits is repeated up to five times, so
that on a quiet machine only long calls, which the system interrupts now and then, stay delayed: some per cent at most.
Above one in twenty, medians over a few calls and launches contain waits, which no ranking of times survives."""
NOT_RUN = "not_run"
"""The verdict of a hard variant that was not run with an integrator that accepts its case. No trial has this status."""
NEVER_RAN = (*CANNOT_RUN, NOT_RUN)
OWN_NAMES = {"variant": "default", "formulation": "standard"}
"""The names that become empty: of the default variant and of the case's own formulation."""
KINDS = ("error_max", "error_rms", "error_end", "error_start")
"""The errors from which an order is measured, the first on a line."""

Row = Mapping[str, Any]


def series(rows: Iterable[Row]) -> dict[tuple[str, ...], list[dict[str, Any]]]:
    """By SERIES, in sorted order, the settings of each series, loosest first, one dict each.

    A value is the first one over the launches that is not null, but the largest for `error_max`.
    """
    by_series: dict[tuple[str, ...], dict[float | None, dict[str, Any]]] = {}
    for row in sorted(tidy(rows), key=lambda row: int(row["launch"])):
        merged = by_series.setdefault(tuple(row[name] for name in SERIES), {}).setdefault(row["setting"], dict(row))
        for name, value in row.items():
            if merged[name] is None:
                merged[name] = value
        errors = [error for error in (merged["error_max"], row["error_max"]) if error is not None]
        merged["error_max"] = max(errors, default=None)
    return {key: [of[s] for s in sorted(of, key=_loosest_first)] for key, of in sorted(by_series.items())}


def _loosest_first(setting: float | None) -> tuple[bool, float]:
    return setting is None, -(setting or 0.0)


def tidy(rows: Iterable[Row]) -> list[dict[str, Any]]:
    """The rows with the times of one machine (see `_machines`), and without errors of one orientation if others have turned starts."""
    copies = [dict(row) for row in rows]
    for row in copies:
        row |= {name: "" if row[name] in (None, own) else row[name] for name, own in OWN_NAMES.items()}
        row["reason"] = row["reason"] or ""
    machines = _machines(copies)
    turned = {row["trial_key"] for row in copies if row["turned_starts"]}
    for row in copies:
        if row["machine"] != machines.get(_problem(row), row["machine"]):
            row |= dict.fromkeys(TIMES)
        if row["trial_key"] in turned and row["turned_starts"] is None:
            row |= dict.fromkeys(ERRORS)
    return copies


def _machines(rows: Sequence[Row]) -> dict[tuple[str, ...], str]:
    """The machine that timed the most rows of each problem; the first by name of several."""
    counts = Counter((_problem(row), row["machine"]) for row in rows if row["seconds_median"] is not None)
    most = sorted(counts, key=lambda key: (-counts[key], key[1] or ""), reverse=True)
    return dict(most)


def _problem(row: Row) -> tuple[str, ...]:
    return tuple(row[name] for name in PROBLEM)


def count_waits(times: Iterable[tuple[float | None, float | None]]) -> tuple[int, int, int]:
    """The numbers of timed measurements, delayed measurements, and measurements with an unknown delay.

    `times`: the seconds and the delay of each measurement, nan or None for null. A delay is unknown if the system did not
    provide it, or if the file is old.
    """
    timed = [(seconds, delay) for seconds, delay in times if _is_known(seconds)]
    known = [(seconds, delay) for seconds, delay in timed if _is_known(delay)]
    delayed = sum(delay > DELAYED * seconds for seconds, delay in known)  # type: ignore[operator]
    return len(timed), delayed, len(timed) - len(known)


class Load(NamedTuple):
    """The share of timed measurements that waited for a processor, nan if unknown, and whether it is `high`."""

    share: float
    high: bool


def load_of(times: Iterable[tuple[float | None, float | None]]) -> Load:
    """Whether the machine was under load, from the seconds and the delay of each measurement."""
    timed, delayed, unknown = count_waits(times)
    share = delayed / (timed - unknown) if timed > unknown else math.nan
    return Load(share, share > UNDER_LOAD)


def _is_known(value: float | None) -> bool:
    return value is not None and not math.isnan(value)


def nothing_ran(reasons: Iterable[tuple[str, str]]) -> str | None:
    """The most frequent status and reason if no trial with one of these ran; None if one ran."""
    counts = Counter(reasons)
    if any(status not in NEVER_RAN for status, _ in counts):
        return None
    if not counts:
        return "no measurement"
    ((status, reason), _), *_ = counts.most_common(1)
    return " ".join(f"{status.replace('_', ' ')}: {reason}".split())


def order(settings: Sequence[Row]) -> tuple[float, float, float, float, float, str]:
    """(order, margin, lowest, highest, declared, why), as in `analysis.orders`, of settings of fixed steps that are ok."""
    steps, declared = np.array([row["setting"] for row in settings]), _number(settings[0]["order_declared"])
    attainable = float(np.nanmax([[_number(row["conditioning"]), _number(row["floor"]), 0.0] for row in settings]))
    slope, bent, why = None, (math.nan, math.nan), ""
    for name in KINDS:
        errors = np.array([_number(row[name]) for row in settings])
        floor = max(attainable, _plateau(steps, errors, declared))
        slope = line(steps.tolist(), errors.tolist(), floor, ON_A_LINE)
        if name == "error_max":
            bent = (slopes(steps.tolist(), errors.tolist(), floor) or (0.0, *bent))[1:]
            why = why_no_line(errors.tolist(), floor) or ("" if bent[0] < math.inf else "no four settings agree")
        if slope is not None:
            break
    return *(slope or (math.nan, math.nan)), *bent, declared, "" if slope else why


def orders(settings: Mapping[tuple[str, ...], Sequence[Row]]) -> dict[tuple[str, ...], float]:
    """The measured order of each of these `series` that takes fixed steps and has one."""
    by_series = {}
    for key, rows in settings.items():
        fixed = [row for row in rows if row["setting_kind"] == "step" and row["status"] == Status.OK]
        if fixed and math.isfinite(measured := order(fixed)[0]):
            by_series[key] = measured
    return by_series


def _number(value: float | None) -> float:
    return math.nan if value is None else float(value)


def _plateau(steps: Floats, errors: Floats, order: float) -> float:
    """The largest error at which a sweep, loosest first, levels off: its slope falls below half of `order`.

    Only errors below 1e-6 count: above, a slope that low may come from coarse steps, not from round-off. 0 if the sweep
    does not level off.
    """
    if not math.isfinite(order):
        return 0.0
    levelled = errors[1:] > errors[:-1] * (steps[1:] / steps[:-1]) ** (order / 2)
    return float(np.max(errors[1:][levelled & (errors[:-1] < 1e-6)], initial=0.0))
