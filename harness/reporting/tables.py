"""The rows of the report's tables, in words: numbers with their units, statuses with their reasons."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.contract.status import Status
from gnomon.harness.reporting.style import MEANINGS
from gnomon.harness.results.analysis import NEVER_RAN, SERIES, own, preparations, records
from gnomon.harness.results.equal_error import TARGETS
from gnomon.harness.results.number_text import (
    counted,
    error_text,
    problem_name,
    ratio_text,
    short_text,
    time_text,
)
from gnomon.harness.results.profiles import OURS
from gnomon.harness.results.rankings import ALONE, RANKED, TOO_SHORT, drawn, standings

PROBLEM_AND_NAME = ("case", "formulation", "integrator_id")
PREPARING = ["preparation", "first_use", "first_case"]
"""The columns of `analysis.equal_error` on the time before the first timed call."""
LAWS = {"sqrt t": "√t", "t^1.5": "t√t", "t^2": "t²", "faster than t^2": "faster than t²"}


def share_text(share: float) -> str:
    """The share of the null call in the time beside it; empty without a measurement."""
    if not math.isfinite(share):
        return ""
    return (
        f"null call {100 * share:.0f}\N{NO-BREAK SPACE}%" if share >= 0.005 else "null call below 1\N{NO-BREAK SPACE}%"
    )


def preparation_text(seconds: float, first_use: float = math.nan, case: str = "") -> str:
    """The time of preparation, which the time beside it excludes, and of the first use; empty if not measured."""
    if not math.isfinite(seconds):
        return ""
    return f"prepared in {time_text(seconds)} with filled caches, {first_use_text(first_use, case)}"


def first_use_text(seconds: float, case: str) -> str:
    """The time of the first use of an integrator, measured on a case."""
    return f"{time_text(seconds)} at first use (on {case})" if math.isfinite(seconds) else "first use not measured"


def spread_text(row: Mapping[str, Any]) -> str:
    """The range of the error over turned starts, if the error is their median; else empty."""
    if not row.get("turned_starts", 0) > 0:
        return ""
    worst = error_text(row["error_high"]) if math.isfinite(row["error_high"]) else "not finite"
    return f"{error_text(row['error_low'])} to {worst} over {row['turned_starts']:.0f} orientations"


def digits(error: float) -> int:
    """The number of correct decimal digits at this error; 17 if it is zero."""
    return 17 if error == 0 else max(math.floor(-math.log10(error)), 0)


def with_problems(table: pd.DataFrame) -> pd.DataFrame:
    columns = zip(table["case"], table["variant"], table["formulation"], strict=True)
    return table.assign(problem=[problem_name(*names) for names in columns])


@dataclass(slots=True)
class Cell:
    """A table cell: its text, a small second line, its class for the style sheet, and text that a narrow page omits.

    `value` is the number to sort by; nan is sorted last.
    """

    text: str
    note: str = ""
    kind: str = ""
    aside: str = ""
    value: float = math.nan

    @property
    def sorts(self) -> str:
        return f"{self.value:.6g}" if math.isfinite(self.value) else ""


@dataclass(slots=True)
class Row:
    """A table row: its heading and its cells."""

    head: str
    cells: list[Cell]
    group: str = ""
    note: str = ""


def fastest(equal: pd.DataFrame, problems: Sequence[tuple[str, str]]) -> list[Row]:
    """Per case and formulation, at each error, the fastest integrator if it is separated, or the tied ones.

    A cell that is not ranked says why, with the shortest times. Beside a ranked in-house integrator stands the fastest
    third party, and the reverse. `equal`: `rankings.ranked`.
    """
    default = equal[equal["variant"] == ""].sort_values("seconds")
    found: dict[tuple[str, str, float], list[dict[str, Any]]] = {}
    for row in records(default):
        found.setdefault((row["case"], row["formulation"], row["target"]), []).append(row)
    rows = []
    for case, formulation in problems:
        at = [found.get((case, formulation, target)) for target in TARGETS]
        rows.append(
            Row(case, [_first_of(one) if one else Cell("not reached", kind="none") for one in at], note=formulation)
        )
    return rows


def _first_of(at: Sequence[Mapping[str, Any]]) -> Cell:
    """The cell for these rows, the shortest time first."""
    first, tied = at[0], [row for row in at if row["tied"]]
    if first["cell"] not in (RANKED, ALONE):
        most = float(np.max([row["null_share"] for row in tied]))  # nan if one was not measured
        why = (share_text(most) or "null call not measured") if first["cell"] == TOO_SHORT else "one launch"
        return Cell(first["cell"], f"{why}: {_times(tied)}", "none")
    if len(tied) > 1:
        return Cell(f"tie of {len(tied)}", _times(tied), "none")
    bound = "≤ " if first["at_loosest"] else ""
    notes = [f"{bound}{time_text(first['seconds'])}", share_text(first["null_share"])]
    notes += [preparation_text(*(first[name] for name in PREPARING))]
    notes += [_beside(at) if first["cell"] == RANKED else "no other reaches the error"]
    return Cell(str(first["integrator_id"]), " · ".join(filter(None, notes)))


def _times(rows: Sequence[Mapping[str, Any]]) -> str:
    """The three shortest times."""
    words = [f"{row['integrator_id']} {time_text(row['seconds'])}" for row in rows[:3]]
    return ", ".join(words) + (f" and {len(rows) - 3} more" if len(rows) > 3 else "")


def _beside(at: Sequence[Mapping[str, Any]]) -> str:
    """The fastest in-house integrator if the first row is third-party, and the reverse; empty without one.

    An integrator that the run was given has no ratio: a method in Python is interpreted, the others are compiled.
    """
    known = {OURS, *LIBRARIES}
    if at[0]["library"] not in known:
        return ""
    ours = at[0]["library"] == OURS
    found = next((row for row in at if row["library"] in known and (row["library"] == OURS) != ours), None)
    side = "third-party" if ours else "in-house"
    return f"best {side}: {found['integrator_id']} {ratio_text(found['ratio'])}\N{NO-BREAK SPACE}×" if found else ""


def overall(equal: pd.DataFrame, shown: int = 5) -> list[Row]:
    """Over all default variants, the number of ranked cells in which an integrator is the fastest, separated or tied.

    At each error the `shown` best in-house and the `shown` best third-party integrators are chosen. The note gives the
    number of ranked cells that an integrator reaches, and the median ratio of its time to the least, ties being equal.
    The row's note is the median time of a preparation. Empty if no cell is ranked.
    """
    rows_ = own(equal)
    if not (rows_["cell"] == RANKED).any():
        return []
    counts = {target: standings(rows_[rows_["target"] == target]) for target in TARGETS}
    chosen: set[str] = set()
    for at in counts.values():
        for _, side in at.groupby(at["library"] == OURS):
            chosen |= set(side.index[side["leads"] + side["tied"] > 0][:shown])
    by_name = rows_.drop_duplicates(["integrator_id", "case"]).groupby("integrator_id")
    preparing = by_name.agg({"preparation": "median", "first_use": "first", "first_case": "first"})
    rows = []
    for name in sorted(chosen):
        found = [at.loc[name].to_dict() if name in at.index else None for at in counts.values()]
        leads = [row["leads"] if row else 0 for row in found]
        cells = [leads_cell(row) for row in found]
        rows.append((-leads[1], -sum(leads), Row(name, cells, note=preparation_text(*preparing.loc[name, PREPARING]))))
    return [row for *_, row in sorted(rows, key=lambda each: each[:2])]


def leads_cell(row: Mapping[str, Any] | None) -> Cell:
    """The number of ranked cells in which an integrator is the fastest, from its row of `standings`."""
    if row is None:
        return Cell("–", kind="none", value=0)
    if not row["ranked"]:
        return Cell("not ranked", f"reaches {row['reached']}", "none", value=0)
    text = f"alone {row['leads']}, tied {row['tied']}"
    return Cell(text, f"of {row['ranked']} ranked · {ratio_text(row['ratio'])}\N{NO-BREAK SPACE}×", value=row["leads"])


def libraries(equal: pd.DataFrame) -> list[Row]:
    """The time of each library's best integrator over the least, and the number of ranked cases on which it is slower.

    The ratio is the median over the default variants that the library reaches, ties being equal.
    """
    rows_ = own(equal)
    rows_ = rows_.assign(ratio=drawn(rows_), ranked=rows_["cell"] == RANKED)
    rows = []
    for library in rows_["library"].drop_duplicates():
        cells = []
        for target in TARGETS:
            at = rows_[rows_["target"] == target]
            grouped = at[at["library"] == library].groupby("case")
            best = grouped["ratio"].min()
            slower = int((grouped["slower"].min() & grouped["ranked"].any()).sum())
            note = f"{len(best)} of {counted(at['case'].nunique(), 'case')}"
            ranked = int(grouped["ranked"].any().sum())
            note += f", slower on {slower} of {ranked} ranked" if ranked else ""
            ratio = f"{ratio_text(float(best.median()))} ×" if len(best) else "–"
            cells.append(Cell(ratio, note, "" if len(best) else "none"))
        rows.append(Row(str(library), cells))
    return sorted(rows, key=lambda row: row.head != "gnomon")


def equal_error_rows(equal: pd.DataFrame, reduced: pd.DataFrame, uses: pd.DataFrame) -> dict[str, list[Row]]:
    """Times at equal error by case, for every integrator that ran the default variant; the shortest at 1e-6 is first.

    Beside a time stands its ratio to the fastest if the two are separated, else why they are not; then the share of the
    null call and the range over launches. The last cell is the median time of a preparation, which the other cells do
    not include.
    """
    reached = _by_key(equal[equal["variant"] == ""], *PROBLEM_AND_NAME, "target")
    ran = reduced[(reduced["variant"] == "") & ~reduced["status"].isin(NEVER_RAN)]
    preparing = preparations(ran).groupby(list(PROBLEM_AND_NAME)).first().to_dict()
    firsts = uses.to_dict("index")
    found: dict[str, list[tuple[Any, Row]]] = {}
    for case, formulation, name in sorted(set(zip(*(ran[column] for column in PROBLEM_AND_NAME), strict=True))):
        cells, place = [], [math.inf] * len(TARGETS)
        for i, target in enumerate(TARGETS):
            at = reached.get((case, formulation, name, target))
            if at is None:
                cells.append(Cell("–", kind="none"))
                continue
            place[i] = float(at["seconds"])
            spread = f"{time_text(at['low'])} – {time_text(at['high'])}" if at["launches"] > 1 else "one launch"
            text = ("≤ " if at["at_loosest"] else "") + time_text(at["seconds"])
            aside = "".join(f" · {word}" for word in (share_text(at["null_share"]), spread) if word)
            cells.append(Cell(text, _compared(at), "best" if at["cell"] == RANKED and at["tied"] else "", aside))
        preparation = preparing[case, formulation, name]
        known = firsts.get(name, {"first_use": math.nan, "first_case": ""})
        note = first_use_text(known["first_use"], str(known["first_case"]))
        cells.append(Cell(time_text(preparation), note) if math.isfinite(preparation) else Cell("–", kind="none"))
        row = Row(str(name), cells, group=str(formulation))
        found.setdefault(case, []).append(((formulation, place[1], place[0], place[2]), row))
    return {case: [row for _, row in sorted(rows, key=lambda pair: pair[0])] for case, rows in found.items()}


def _compared(at: Mapping[str, Any]) -> str:
    """The comparison of a time with the least of its cell, in words."""
    if at["cell"] != RANKED:
        return str(at["cell"])
    return f"{ratio_text(at['ratio'])} ×" if at["slower"] else "tied" if at["leaders"] > 1 else "fastest"


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
    found: dict[tuple[Any, ...], dict[str, Any]] = {}
    for row in records(table):
        found.setdefault(tuple(row[column] for column in columns), row)
    return found


def _first(series: dict[str, Any]) -> str:
    if series["failure"] == Status.SKIPPED:
        return f"{series['counts'][Status.SKIPPED]} beyond the time limit"
    return f"{series['failure']}: {series['reason']}" if series["failure"] else ""


def _order(found: dict[str, Any] | None) -> Cell:
    if found is None:
        return Cell("–", kind="none")
    declared = f"declared {found['declared']:.0f}" if math.isfinite(found["declared"]) else ""
    if math.isfinite(found["order"]):
        return Cell(f"order {found['order']:.2f} ± {found['margin']:.2f}", declared)
    if found["why"] or not math.isfinite(found["lowest"]):
        return Cell("–", "; ".join(word for word in (found["why"], declared) if word), "none")
    bent = f"slopes from {found['lowest']:.1f} to {found['highest']:.1f}"
    return Cell("no line", "; ".join(word for word in (bent, declared) if word), "none")


def _parts(found: dict[str, Any] | None) -> Cell:
    """The error along the motion and across it, lost turns of angles, and events against the exact ones."""
    if found is None:
        return Cell("–", kind="none")
    words, note = [], ""
    if math.isfinite(found["error_phase"]):
        words.append(f"phase {error_text(found['error_phase'])}")
        note = f"shape {error_text(found['error_shape'])}"
    if math.isfinite(found["events_missing"]):
        missing, extra = int(found["events_missing"]), int(found["events_extra"])
        missed = [f"{n} {word}" for n, word in ((missing, "missing"), (extra, "too many")) if n]
        words.append("events: " + (", ".join(missed) or "all"))
        note = f"times within {error_text(found['events_time_error'])} s"
    if found["turns"] > 0:
        note += f"{'; ' if note else ''}up to {found['turns']:.0f} turns off"
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


def _growth(found: dict[str, Any]) -> tuple[str, str]:
    """The law (– if several are within the interval of the power), and the power with its interval."""
    power = ""
    if math.isfinite(found["power"]):
        power = f"power {found['power']:.2f} ({found['low']:.2f} to {found['high']:.2f})"
    return LAWS.get(found["law"], found["law"]) or "–", power


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
