"""The rows of the report's tables, in words: numbers with their units, statuses with their reasons."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from gnomon.harness.adapters.libraries import title
from gnomon.harness.contract.status import Status
from gnomon.harness.reporting.style import MEANINGS
from gnomon.harness.results.analysis import NEVER_RAN, SERIES, records
from gnomon.harness.results.break_even import SOLVES, AtError
from gnomon.harness.results.contenders import ALONE, THIRD
from gnomon.harness.results.equal_error import TARGETS
from gnomon.harness.results.number_text import (
    error_text,
    group_digits,
    order_text,
    power_text,
    problem_name,
    short_text,
    time_text,
)
from gnomon.harness.results.time_ratios import SLOWER

WIDE = 0.5
"""An interval of a power of time that is wider has one decimal."""
LAWS = {"sqrt t": "√t", "t^1.5": "t√t", "t^2": "t²", "faster than t^2": "faster than t²"}


def share_text(share: float) -> str:
    """The share of the null call in the time beside it; empty without a measurement."""
    if not math.isfinite(share):
        return ""
    return (
        f"null call {100 * share:.0f}\N{NO-BREAK SPACE}%" if share >= 0.005 else "null call below 1\N{NO-BREAK SPACE}%"
    )


def first_use_text(seconds: float, case: str) -> str:
    """The time of the first use of an integrator, measured on a case."""
    return f"{time_text(seconds)} at first use (on {case})" if math.isfinite(seconds) else "first use not measured"


def spread_text(row: Mapping[str, Any]) -> str:
    """The range of the error over turned starts, if the error is their median; else empty."""
    if not row.get("turned_starts", 0) > 0:
        return ""
    worst = error_text(row["error_high"]) if math.isfinite(row["error_high"]) else "not finite"
    return f"{error_text(row['error_low'])} to {worst} over {row['turned_starts']:.0f} orientations"


def digits(error: float) -> float:
    """The number of correct decimal digits at this error, with its fraction; 17 if it is zero."""
    return 17.0 if error == 0 else min(max(-math.log10(error), 0.0), 17.0)


def with_problems(table: pd.DataFrame) -> pd.DataFrame:
    columns = zip(table["case"], table["variant"], table["formulation"], strict=True)
    return table.assign(problem=[problem_name(*names) for names in columns])


@dataclass(slots=True)
class Cell:
    """A table cell: its text, a small second line, its class for the style sheet, and text that a narrow page omits."""

    text: str
    note: str = ""
    kind: str = ""
    aside: str = ""


@dataclass(slots=True)
class Row:
    """A table row: its heading and its cells."""

    head: str
    cells: list[Cell]
    group: str = ""
    note: str = ""


def fastest(
    equal: pd.DataFrame,
    problems: Sequence[tuple[str, str]],
    unknown: Mapping[str, str] = {},
    later: pd.DataFrame | None = None,
) -> list[Row]:
    """Per case and formulation, at each error, the fastest third-party integrator, and those not clearly behind it.

    A cell in which one more period has another order says so. Without third parties the rows are of the integrators that
    there are. `equal`: `rankings.divisions`; `unknown`: cases of which nothing is said, and why; `later`:
    `rankings.one_more_period`.
    """
    by_problem, of_later = _cells(equal), {} if later is None else _cells(later)
    rows = []
    for case, formulation in problems:
        cells = []
        for target in TARGETS:
            at = by_problem.get((case, formulation, target))
            if at and case not in unknown:
                cells.append(_first_of(at, of_later.get((case, formulation, target), ())))
            else:
                cells.append(Cell(unknown.get(case, "not reached"), kind="none"))
        rows.append(Row(case, cells, note=formulation))
    return rows


def _cells(equal: pd.DataFrame) -> dict[tuple[str, str, float], list[dict[str, Any]]]:
    """By case, formulation and error the rows of third parties from the default start, the fastest first."""
    default = equal[equal["variant"] == ""].sort_values("seconds")
    third = default[default["division"] == THIRD]
    by_problem: dict[tuple[str, str, float], list[dict[str, Any]]] = {}
    for row in records(third if len(third) else default):
        by_problem.setdefault((row["case"], row["formulation"], row["target"]), []).append(row)
    return by_problem


def _first_of(at: Sequence[Mapping[str, Any]], later: Sequence[Mapping[str, Any]]) -> Cell:
    """The cell for these rows, and those of one more period, the shortest time first."""
    first = at[0]
    bound = "≤ " if first["at_loosest"] else ""
    notes = [f"{bound}{time_text(first['seconds'])}", share_text(first["null_share"])]
    if first["cell"] == ALONE:
        return Cell(str(first["integrator_id"]), " · ".join(filter(None, [*notes, "no other reaches the error"])))
    others = [row for row in at[1:] if row["state"] != SLOWER] or at[1:2]
    more = f" and {len(others) - 2} more" if len(others) > 2 else ""
    notes.append("; ".join(map(_against_first, others[:2])) + more)
    for row in later:
        if row["integrator_id"] == first["integrator_id"] and row["state"] == SLOWER:
            notes.append(f"of one more period {later[0]['integrator_id']} is the fastest; {_against_first(row)}")
    return Cell(str(first["integrator_id"]), " · ".join(filter(None, notes)))


def _against_first(row: Mapping[str, Any]) -> str:
    """An integrator with its state, its factor to the fastest and the interval."""
    interval = f"{short_text(row['ratio'])} ({short_text(row['low'])} – {short_text(row['high'])})"
    return f"{row['state']}: {row['integrator_id']} {interval}"


BREAK_EVEN_HEADS = tuple(f"{group_digits(number)} solve{'s' * (number > 1)}" for number in SOLVES)


def break_even_parts(costs: Iterable[AtError]) -> list[dict[str, Any]]:
    """For each error, in words, the costs of the libraries, the fastest of them, and those that are not compared."""
    return [
        {
            "error": power_text(level.target),
            "systems": level.systems,
            "said": _even_text(level),
            "aside": ", ".join(f"{title(name)} (on {reached})" for name, reached in level.aside),
            "rows": [
                Row(
                    title(of.name),
                    [
                        Cell(time_text(cost, 2), kind="best" if fastest else "")
                        for cost, fastest in zip(of.costs, of.fastest, strict=True)
                    ],
                    note=str(of.reached),
                )
                for of in level.libraries
            ],
        }
        for level in costs
    ]


def _even_text(level: AtError) -> str:
    first, later, many = title(level.first), title(level.later), group_digits(SOLVES[-1])
    if first == later:
        return f"{first} has the least cost for one solve and for {many}"
    even = f", from {group_digits(round(level.even))} on in the median" if math.isfinite(level.even) else ""
    return f"{first} has the least cost for one solve, and {later} for {many}{even}"


def stability_rows(
    matrix: pd.DataFrame, trusted: pd.DataFrame, orders: pd.DataFrame, laws: pd.DataFrame, parts: pd.DataFrame
) -> dict[str, list[Row]]:
    """By case the stability of each integrator on the default variant: status, error, order, parts of it and drift.

    The frames are from `analysis.status_matrix`, `trust`, `orders`, `drift.laws` and `analysis.anatomy`.
    """
    chosen = matrix[(matrix["variant"] == "") & ~matrix["verdict"].isin(NEVER_RAN)]
    trusts, measured, anatomies = (_by_key(frame, *SERIES) for frame in (trusted, orders, parts))
    drifts: dict[tuple[Any, ...], list[dict[str, Any]]] = {}
    for law in laws.to_dict("records"):
        drifts.setdefault(tuple(law[column] for column in SERIES), []).append(law)
    rows: dict[str, list[Row]] = {}
    for key, series in _by_key(chosen, *SERIES).items():
        trial = trusts[key]
        status = Cell(f"{series['settings_ok']} of {series['settings']} ok", _first(series), series["verdict"])
        best = Cell(error_text(trial["best"]), kind="none" if not math.isfinite(trial["best"]) else "")
        if math.isfinite(trial["best"]):
            above = trial["best"] / max(trial["attainable"], 1e-300)
            best.note = f"{short_text(above)} × attainable" if above >= 1 else "at the attainable"
            spread = spread_text(trial)
            best.aside = f" · {spread}" if spread else ""
        knob = _order(measured.get(key))
        if math.isfinite(trial["over_tolerance"]):
            over, worst = (short_text(trial[name]) for name in ("over_tolerance", "worst_over_tolerance"))
            knob = Cell(f"{over} × tolerance", f"worst {worst} ×")
        cells = [status, best, knob, _parts(anatomies.get(key)), *_drift(drifts.get(key))]
        rows.setdefault(key[0], []).append(Row(key[-1], cells, group=key[2]))
    return rows


def _by_key(table: pd.DataFrame, *columns: str) -> dict[tuple[Any, ...], dict[str, Any]]:
    """The rows by the values of these columns; the first of several rows with equal values."""
    by_key: dict[tuple[Any, ...], dict[str, Any]] = {}
    for row in records(table):
        by_key.setdefault(tuple(row[column] for column in columns), row)
    return by_key


def _first(series: dict[str, Any]) -> str:
    if series["failure"] == Status.SKIPPED:
        return f"{series['counts'][Status.SKIPPED]} beyond the time limit"
    return f"{series['failure']}: {series['reason']}" if series["failure"] else ""


def _order(row: dict[str, Any] | None) -> Cell:
    if row is None:
        return Cell("–", kind="none")
    declared = f"declared {row['declared']:.0f}" if math.isfinite(row["declared"]) else ""
    if row["order"] > row["margin"]:
        return Cell(f"order {order_text(row['order'], row['margin'])}", declared)
    if math.isfinite(row["order"]):
        return Cell("no order", "; ".join(filter(None, ("the error does not fall with the step", declared))), "none")
    if row["why"] or not math.isfinite(row["lowest"]):
        return Cell("–", "; ".join(word for word in (row["why"], declared) if word), "none")
    bent = f"slopes from {row['lowest']:.1f} to {row['highest']:.1f}"
    return Cell("no line", "; ".join(word for word in (bent, declared) if word), "none")


def _parts(row: dict[str, Any] | None) -> Cell:
    """The error along the motion and across it, lost turns of angles, and events against the exact ones."""
    if row is None:
        return Cell("–", kind="none")
    words, note = [], ""
    if math.isfinite(row["error_phase"]):
        words.append(f"phase {error_text(row['error_phase'])}")
        note = f"shape {error_text(row['error_shape'])}"
    if math.isfinite(row["events_missing"]):
        missing, extra = int(row["events_missing"]), int(row["events_extra"])
        missed = [f"{n} {word}" for n, word in ((missing, "missing"), (extra, "too many")) if n]
        words.append("events: " + (", ".join(missed) or "all"))
        note = f"times within {error_text(row['events_time_error'])} s"
    if row["turns"] > 0:
        note += f"{'; ' if note else ''}up to {row['turns']:.0f} turns off"
    return Cell("; ".join(words), note) if words or note else Cell("–", kind="none")


def _drift(laws: list[dict[str, Any]] | None) -> list[Cell]:
    """Two cells: the growth law of the error, and the growth laws of the invariants."""
    if laws is None:
        return [Cell("–", kind="none"), Cell("–", kind="none")]
    words = {law["quantity"]: (*_growth(law), error_text(law["size"])) for law in laws}
    law, power, size = words.pop("error", ("–", "", ""))
    note = "; ".join(word for word in (power, f"reaches {size}" if size else "") if word)
    first = Cell(law, note, "" if size else "none")
    if not words:
        return [first, Cell("–", "no constant invariant", "none")]
    text = "; ".join(
        f"{name.replace('_', ' ')}: {', '.join(word for word in (law, power) if word not in ('', '–'))} ({size})"
        for name, (law, power, size) in words.items()
    )
    return [first, Cell("", text)]


def _growth(row: dict[str, Any]) -> tuple[str, str]:
    """The law (– if several are within the interval of the power), and the power with its interval."""
    power = ""
    if math.isfinite(row["power"]):
        digits = 2 if row["high"] - row["low"] < WIDE else 1
        power = f"power {row['power']:.{digits}f} ({row['low']:.{digits}f} to {row['high']:.{digits}f})"
    return LAWS.get(row["law"], row["law"]) or "–", power


def failure_groups(failed: pd.DataFrame) -> list[dict[str, Any]]:
    """Failures by status, then integrator: the number of trials, the problems, and the first two reasons."""
    groups = []
    for status in Status:
        part = failed[failed["status"] == status]
        if part.empty:
            continue
        rows = []
        for name, mine in part.groupby("integrator_id", sort=True):
            where = list(dict.fromkeys(problem for problems in mine["where"] for problem in problems))
            reasons = list(dict.fromkeys(reason for reason in mine["reason"] if reason))
            row = {"integrator": name, "trials": int(mine["trials"].sum()), "where": where}
            rows.append(row | {"reasons": reasons[:2], "more": max(len(reasons) - 2, 0)})
        trials = int(part["trials"].sum())
        groups.append({"status": status, "meaning": MEANINGS[status], "trials": trials, "rows": rows})
    return groups


def status_shares(reduced: pd.DataFrame) -> list[dict[str, Any]]:
    """The number and share of trials in each status, of the trials that could run."""
    counts = reduced["status"].value_counts()
    ran = [name for name in Status if name in counts.index and name not in NEVER_RAN]
    total = float(np.sum([counts[name] for name in ran])) or 1.0
    return [{"status": name, "trials": int(counts[name]), "share": counts[name] / total} for name in ran]
