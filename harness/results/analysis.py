"""What a run says: time at equal error, trust, and where each integrator breaks. Reads stored rows, runs nothing."""

from __future__ import annotations

import itertools
import json
import math
import operator
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from gnomon.harness.contract.status import CANNOT_RUN, NOT_BROKEN, SCORED, Status
from gnomon.harness.results.convergence_order import line, slopes, why_no_line
from numpy.typing import NDArray

Floats = NDArray[np.float64]

TARGETS = (1e-3, 1e-6, 1e-9, 1e-12)
SERIES = ["case", "variant", "formulation", "library", "integrator_id"]
ON_A_LINE = 0.1
"""A slope is an order only where each of its pieces is within this of it, the margin that a measured order has about
the declared one. An error that passes through zero between two steps bends the line by whole orders."""

CLAIM = 1.2
"""Ratios of times below this are not claimed as a difference: launches of one program differ by 10 to 13 %."""

LEAST_SHARE = 0.1
"""A time without its null call is at least this share of the time: of less the difference of two times says nothing."""

ERRORS = (
    *(
        "error_max",
        "error_start",
        "error_end",
        "error_rms",
        "error_phase",
        "error_shape",
        "error_over_tolerance",
        "turns",
    ),
    *("invariant_drift", "error_low", "error_high"),
)
"""What later launches of a trial lack, where its first launch has the median over turned starts."""

NOT_RUN = "not_run"
"""The verdict of a hard variant that nobody ran with an integrator that takes its case. No trial has this status."""
PARTLY = "partly"
"""The verdict of a series of which some settings are ok and others failed."""
NEVER_RAN = (*CANNOT_RUN, NOT_RUN)


def tidy(rows: pd.DataFrame) -> pd.DataFrame:
    """The store's rows with empty strings for missing names, and numbers where numbers are meant.

    `seconds_net` is `seconds_median` without the null call (`null_seconds`), and at least a tenth of it: every time that
    is compared is this one. Where the null call was not measured they are the same. The errors of launches without
    turned starts are set aside where another launch of the trial has them: those are of one orientation alone.
    """
    frame = rows.copy()
    for column in ("variant", "formulation", "policy", "reason", "sampling", "setting_kind", "settings_changed"):
        frame[column] = frame[column].astype(object).where(frame[column].notna(), "").astype(str)
    frame["variant"] = frame["variant"].replace("default", "")
    frame["formulation"] = frame["formulation"].replace("standard", "")
    for column in (
        *("setting", "error_max", "error_end", "error_rms", "floor", "conditioning", "order_declared"),
        *("error_phase", "error_shape", "turns", "events_missing", "events_extra", "events_time_error"),
        *("rhs_calls", "steps", "seconds_median", "seconds_low", "seconds_high", "prepare_seconds"),
        *("null_seconds", "turned_starts", "error_low", "error_high", "error_unturned", "error_start"),
    ):
        frame[column] = pd.to_numeric(frame[column], errors="coerce").astype(float)
    frame["seconds_net"] = net(frame["seconds_median"], frame["null_seconds"])
    turned = frame.groupby("trial_key")["turned_starts"].transform("max") > 0
    aside = turned & frame["turned_starts"].isna()
    if aside.any():
        frame.loc[aside, [column for column in ERRORS if column in frame]] = math.nan
    return frame


def net(seconds: pd.Series, null: pd.Series) -> pd.Series:
    """Times without their null call, where that is known; at least `LEAST_SHARE` of each."""
    return np.maximum(seconds - null.fillna(0.0), LEAST_SHARE * seconds)


def nothing_ran(frame: pd.DataFrame) -> str | None:
    """Why nothing in these rows ran, in the words of the most frequent reason; None where something did."""
    if not frame["status"].isin(NEVER_RAN).all():
        return None
    if frame.empty:
        return "no measurement"
    status, reason = frame[["status", "reason"]].value_counts().index[0]
    return " ".join(f"{status.replace('_', ' ')}: {reason}".split())


def settings(frame: pd.DataFrame) -> pd.DataFrame:
    """One row a setting of a series, loosest first: launches reduced to the median of their times without the null call,
    `seconds`, beside the median of their null calls, `overhead`.

    `seconds_low` and `seconds_high`, quantiles over the calls of one launch, are left as the first launch has them.
    """
    grouped = frame.sort_values("launch").groupby([*SERIES, "setting"], dropna=False, sort=False)
    reduced = grouped.first().assign(
        error_max=grouped["error_max"].max(),
        seconds=grouped["seconds_net"].median(),
        overhead=grouped["null_seconds"].median(),
    )
    return reduced.reset_index().sort_values([*SERIES, "setting"], ascending=[True] * len(SERIES) + [False])


def credited(errors: Sequence[float] | Floats) -> Floats:
    """The error that each setting of a sweep, loosest first, is credited with; inf for settings that are left out.

    A loose setting may be right by luck, where its error changes sign. So a setting is credited with the largest error
    of all settings at least as tight: what the method still holds when the knob is turned further. Beyond the best
    setting round-off makes errors grow again, and nobody needs those settings: the sweep ends at the tightest setting
    within 3 times of the second smallest error (of the second, so that one lucky setting cannot cut the sweep).
    """
    values = np.asarray(errors, dtype=float)
    found = np.sort(values[np.isfinite(values)])
    if len(found) == 0:
        return np.full(len(values), math.inf)
    second = found[min(1, len(found) - 1)]
    last = int(np.flatnonzero(values <= 3 * second)[-1])
    kept = np.maximum.accumulate(values[: last + 1][::-1])[::-1]
    return np.concatenate([kept, np.full(len(values) - last - 1, math.inf)])


def time_at(errors: Sequence[float] | Floats, seconds: Sequence[float] | Floats, target: float) -> tuple[float, bool]:
    """The least time in which a sweep, loosest setting first, holds an error; and whether its loosest setting does.

    Linear in the logarithms between the two neighbouring settings of the sweep; nan where no setting reaches it. Where
    the sweep holds any error only from some setting on, an infinite one before, that setting counts as the loosest.

    A tighter setting may take less time than the one that reaches the error: the order of a Taylor series follows its
    tolerance, and a low order takes more steps. It holds the error too, so its time counts, as nobody would wait longer.
    """
    return crossing(credited(errors), seconds, target)


def crossing(held: Floats, seconds: Sequence[float] | Floats, target: float) -> tuple[float, bool]:
    """`time_at` of errors that are `credited` already."""
    reached = np.flatnonzero(held <= target)
    if len(reached) == 0:
        return math.nan, False
    i = int(reached[0])
    loosest = i == 0 or math.isinf(held[i - 1])
    if loosest:
        there = float(seconds[i])
    else:
        upper, lower = math.log(held[i - 1]), math.log(max(held[i], np.finfo(float).tiny))
        share = (upper - math.log(target)) / (upper - lower)
        there = float(np.exp(np.log(seconds[i - 1]) + share * np.log(seconds[i] / seconds[i - 1])))
    # Without a time near the target there is none; tighter settings that were not timed are passed over.
    return (math.nan if math.isnan(there) else min(there, *(float(seconds[k]) for k in reached.tolist()))), loosest


def preparations(rows: pd.DataFrame) -> pd.Series:
    """By series, the median seconds of a preparation over its settings, of the first launch of each."""
    ran = rows[~rows["status"].isin(NEVER_RAN)].drop_duplicates([*SERIES, "setting"])
    return ran.groupby(list(SERIES))["prepare_seconds"].median().rename("preparation")


def equal_error(frame: pd.DataFrame, targets: Sequence[float] = TARGETS) -> pd.DataFrame:
    """Time at equal error: one row a series and target, with the ratio to the fastest of the same case and formulation.

    `seconds` is the median over launches of the time without the null call, `low` and `high` their range, `overhead` the
    median of the null calls, nan where none was measured; `at_loosest` says that the sweep begins below
    the target, so that the time is an upper bound; `tied` marks the fastest and all that are within 1.2 times of it;
    `preparation` is what no time holds (see `preparations`).

    A setting that diverged has answered, and wrongly: its error counts as infinite. One that gave no answer has no say.
    """
    rows = []
    usable = frame[frame["status"].isin(SCORED) & (frame["seconds_median"] > 0)]
    usable = usable.assign(error_max=usable["error_max"].where(usable["status"] != Status.DIVERGED, math.inf))
    columns = ("launch", "setting", "error_max", "seconds_net", "null_seconds")
    for key, series in _series(usable.sort_values("setting", ascending=False), *columns):
        launches: dict[int, dict[float, float]] = {}
        errors: dict[int, dict[float, float]] = {}
        for row in series:
            launches.setdefault(row["launch"], {})[row["setting"]] = row["seconds_net"]
            errors.setdefault(row["launch"], {})[row["setting"]] = row["error_max"]
        # Slow settings are launched once: the errors are those of the fullest launch, a launch without times near the
        # target has no say.
        sweep = errors[max(sorted(errors), key=lambda launch: len(errors[launch]))]
        held = credited(list(sweep.values()))
        nulls = [row["null_seconds"] for row in series if math.isfinite(row["null_seconds"])]
        overhead = float(np.median(nulls)) if nulls else math.nan
        timed = [[seconds.get(setting, math.nan) for setting in sweep] for seconds in launches.values()]
        for target in targets:
            found = [crossing(held, seconds, target) for seconds in timed]
            times = np.array([seconds for seconds, _ in found if math.isfinite(seconds)])
            if len(times):
                bound = any(loosest for _, loosest in found)
                middle = float(np.median(times))
                rows.append((*key, target, middle, times.min(), times.max(), len(times), bound, overhead))
    named = [*SERIES, "target", "seconds", "low", "high", "launches", "at_loosest", "overhead"]
    table = pd.DataFrame(rows, columns=named)
    fastest = table.groupby(["case", "variant", "formulation", "target"])["seconds"].transform("min")
    table = table.assign(ratio=table["seconds"] / fastest, tied=table["seconds"] < CLAIM * fastest)
    return table.join(preparations(frame), on=list(SERIES))


def trust(reduced: pd.DataFrame) -> pd.DataFrame:
    """How far each series can be trusted: best error beside the attainable one, and achieved error over tolerance.

    The attainable error is the conditioning (or the floor where that is larger). Achieved error over tolerance counts
    the settings above the attainable error: below it a tolerance asks for the impossible. `error_low` and `error_high`
    are the range of the best error over `turned_starts` orientations, where it is their median; else nan.
    """
    rows = []
    spread = ("turned_starts", "error_low", "error_high")
    columns = ("status", "setting", "setting_kind", "sampling", "error_max", "conditioning", "floor", *spread)
    for key, series in _series(reduced[~reduced["status"].isin(NEVER_RAN)], *columns):
        good = [row for row in series if row["status"] == Status.OK]
        record: dict[str, Any] = dict(zip(SERIES, key, strict=True))
        record |= {"settings": len(series), "settings_ok": len(good), "sampling": series[0]["sampling"]}
        record |= dict.fromkeys(
            ("best", "at", "attainable", "over_tolerance", "worst_over_tolerance", *spread), math.nan
        )
        if good:
            best = min(good, key=lambda row: row["error_max"])
            record |= {"best": best["error_max"], "at": best["setting"]} | {name: best[name] for name in spread}
            record["attainable"] = float(np.nanmax([best["conditioning"], best["floor"], 0.0]))
        asked = [r for r in good if r["setting_kind"] == "tolerance" and r["setting"] > record["attainable"]]
        if asked:
            over = [row["error_max"] / row["setting"] for row in asked]
            record |= {"over_tolerance": float(np.median(over)), "worst_over_tolerance": max(over)}
        rows.append(record)
    return pd.DataFrame(rows)


def status_matrix(reduced: pd.DataFrame) -> pd.DataFrame:
    """One row a series: its statuses over the sweep, the first failure with its reason, and the best error.

    `verdict` is "ok" (every setting that ran), "partly" (some), or the most frequent status where no setting is ok. A
    sweep that we ended before the time limit (`skipped`), or that the machine ended (`interrupted`), was not broken by
    the integrator, and does not count as such.
    """
    rows = []
    for key, series in _series(reduced, "status", "reason", "error_max"):
        counts = dict(Counter(row["status"] for row in series).most_common())
        good = [row["error_max"] for row in series if row["status"] == Status.OK]
        broken = [row for row in series if row["status"] not in NOT_BROKEN]
        shown = (broken or [row for row in series if row["status"] != Status.OK])[:1]
        verdict = Status.OK if good and not broken else PARTLY if good else next(iter(counts))
        record: dict[str, Any] = dict(zip(SERIES, key, strict=True))
        record |= {"verdict": verdict, "settings_ok": len(good), "settings": len(series), "counts": counts}
        record["best"] = min(good, default=math.nan)
        record["failure"] = "".join(str(row["status"]) for row in shown)
        record["reason"] = "".join(str(row["reason"]) for row in shown)
        rows.append(record)
    return pd.DataFrame(rows)


def not_run(matrix: pd.DataFrame, variants: Mapping[str, Iterable[str]]) -> pd.DataFrame:
    """Rows like those of `status_matrix`, of the hard variants that were not run with an integrator that took the case.

    `variants`: the hard variants of each case by name; those in `matrix` count besides.
    """
    ran = matrix[~matrix["verdict"].isin(NEVER_RAN)]
    takes = ran.drop_duplicates(["case", "library", "integrator_id"])
    own = matrix[matrix["formulation"] == ""]
    there = set(own[["case", "variant", "integrator_id"]].itertuples(index=False, name=None))
    hard = {name: dict.fromkeys(variants.get(name, ())) for name in takes["case"]}
    for name, variant in own.loc[own["variant"] != "", ["case", "variant"]].itertuples(index=False, name=None):
        hard.get(name, {})[variant] = None
    rows: list[tuple[Any, ...]] = [
        (case, variant, "", library, name, NOT_RUN, 0, 0, {}, math.nan, "", "")
        for case, library, name in takes[["case", "library", "integrator_id"]].itertuples(index=False, name=None)
        for variant in hard[case]
        if (case, variant, name) not in there
    ]
    return pd.DataFrame(
        rows, columns=[*SERIES, "verdict", "settings_ok", "settings", "counts", "best", "failure", "reason"]
    )


def _series(frame: pd.DataFrame, *columns: str) -> Iterator[tuple[tuple[str, ...], list[dict[str, Any]]]]:
    """Key and rows of each series, in the order of the keys; plain rows, since a frame a series takes far longer."""
    rows = frame[[*SERIES, *columns]].to_dict("records")
    key = operator.itemgetter(*SERIES)
    for names, members in itertools.groupby(sorted(rows, key=key), key):
        yield names, list(members)


def failures(reduced: pd.DataFrame) -> pd.DataFrame:
    """Every setting that is not ok, grouped by status, integrator and reason, with the scenes where it happened."""
    bad = reduced[reduced["status"] != Status.OK]
    where = bad["case"] + np.where(bad["variant"] != "", "/" + bad["variant"], "")
    grouped = bad.assign(where=where).groupby(["status", "integrator_id", "reason"], sort=False)["where"]
    table = grouped.agg(trials="count", where=lambda names: list(dict.fromkeys(names))).reset_index()
    rank = {name: place for place, name in enumerate(Status)}
    return table.sort_values(
        ["status", "integrator_id"], key=lambda column: column.map(rank) if column.name == "status" else column
    )


def changed_settings(frame: pd.DataFrame) -> pd.DataFrame:
    """Engine settings that differ from the engine's default: one row an integrator, setting and value."""
    rows = []
    for columns in frame.drop_duplicates([*SERIES, "settings_changed"]).itertuples():
        for name, value in json.loads(columns.settings_changed or "{}").items():
            rows.append((columns.library, columns.integrator_id, name, str(value), columns.case))
    table = pd.DataFrame(rows, columns=["library", "integrator_id", "setting", "value", "case"])
    grouped = table.groupby(["library", "integrator_id", "setting", "value"], sort=False)["case"]
    return grouped.agg(lambda names: list(dict.fromkeys(names))).reset_index()


def policies(reduced: pd.DataFrame) -> pd.DataFrame:
    """Engines' error at equal step under each policy: "as shipped" beside "configured" and "staggered".

    One row a scene, engine, policy and step that at least two policies ran, `error` nan where the trial failed.
    """
    engines = reduced[(reduced["policy"] != "") & reduced["setting"].notna()]
    table = engines[["case", "variant", "library", "integrator", "policy", "setting", "status", "error_max"]].rename(
        columns={"error_max": "error"}
    )
    several = table.groupby(["case", "variant", "library", "integrator", "setting"])["policy"].transform("nunique") > 1
    return table[several]


def orders(reduced: pd.DataFrame) -> pd.DataFrame:
    """Measured order beside the declared one of every fixed-step series, nan where no four of its points are on a line.

    Of the largest error over the samples, else of their root mean square, else of that at the end, else of the largest
    over the first samples: where one passes through zero between two steps, another need not, and errors that grow
    with time in two ways, such as h^5 t^2 and h^4 t, show the order early. `lowest` and `highest` are the slopes of the largest error from one
    of its finest points to the next, nan where fewer than 4 settings lie in the range. `why` says what an order lacks.
    `margin` is half of the order's interval (`order.mean_slope`).
    """
    rows = []
    fixed = reduced[(reduced["setting_kind"] == "step") & (reduced["status"] == Status.OK)]
    for key, series in fixed.groupby(SERIES, dropna=False):
        steps, declared = series["setting"].to_numpy(float), float(series["order_declared"].iloc[0])
        attainable = float(np.nanmax([series["conditioning"].max(), series["floor"].max(), 0.0]))
        order, margin, bent, why = math.nan, math.nan, (math.nan, math.nan), ""
        for name in ("error_max", "error_rms", "error_end", "error_start"):
            errors = series[name].to_numpy(float)
            floor = max(attainable, _plateau(steps, errors, declared))
            found = line(steps.tolist(), errors.tolist(), floor, ON_A_LINE)
            if name == "error_max":
                bent = (slopes(steps.tolist(), errors.tolist(), floor) or (0.0, *bent))[1:]
                why = why_no_line(errors.tolist(), floor) or ("" if bent[0] < math.inf else "no four settings agree")
            if found is not None:
                (order, margin), why = found, ""
                break
        rows.append((*key, order, margin, *bent, declared, why))
    return pd.DataFrame(rows, columns=[*SERIES, "order", "margin", "lowest", "highest", "declared", "why"])


def _plateau(steps: Floats, errors: Floats, order: float) -> float:
    """The largest error at which a sweep, loosest first, levels off: where its slope falls below half of the order.

    Only errors below 1e-6 count, where a slope that low is round-off and not yet a coarse step. 0 where none does.
    """
    if not math.isfinite(order):
        return 0.0
    levelled = errors[1:] > errors[:-1] * (steps[1:] / steps[:-1]) ** (order / 2)
    return float(np.max(errors[1:][levelled & (errors[:-1] < 1e-6)], initial=0.0))


def anatomy(frame: pd.DataFrame, near: float = 1e-5) -> pd.DataFrame:
    """What the error of each series consists of, at its ok setting with an error nearest `near`.

    `error_phase` is along the exact motion and `error_shape` across it (nan where that has no meaning), `turns` the
    most whole turns that angles were off at any ok setting, which the error itself does not count; the `events_`
    columns compare located events with the exact ones.
    """
    good = frame[(frame["status"] == Status.OK) & (frame["error_max"] > 0)]
    good = good.assign(away=np.abs(np.log10(good["error_max"] / near)))
    chosen = good.sort_values(["launch", "away"]).groupby(SERIES, dropna=False, sort=False).first()
    turns = good.groupby(SERIES, dropna=False, sort=False)["turns"].max()
    events = ["events_missing", "events_extra", "events_time_error"]
    return chosen[["error_max", "error_phase", "error_shape", *events]].assign(turns=turns).reset_index()
