"""Analysis of stored measurements: time at equal error, reliability, failures of each integrator. Runs nothing."""

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from gnomon.harness.contract.status import NOT_BROKEN, SCORED, Status
from gnomon.harness.measuring.outcome import DELAYED
from gnomon.harness.results.equal_error import TARGETS, Reached, find_reached
from gnomon.harness.results.schema import TIMES, TIMING_SPAN
from gnomon.harness.results.summary import ERRORS, KINDS, order
from gnomon.harness.results.summary import NEVER_RAN as NEVER_RAN
from gnomon.harness.results.summary import NOT_RUN as NOT_RUN
from gnomon.harness.results.summary import PROBLEM as PROBLEM
from gnomon.harness.results.summary import SERIES as SERIES

PARTLY = "partly"
"""The verdict of a series in which some settings are ok and others failed."""


def tidy(rows: pd.DataFrame) -> pd.DataFrame:
    """The store's rows with empty strings for missing names, and columns of numbers as floats.

    `null_seconds` is replaced by `null_calls`. If a problem ran on several machines, the times of one machine count
    (see `one_machine`). If one launch of a trial was solved from turned starts, the errors of its other launches become
    nan, because they are from one orientation only.
    """
    columns = {
        column: rows[column].astype(object).where(rows[column].notna(), "")
        for column in ("variant", "formulation", "policy", "reason", "sampling", "setting_kind", "settings_changed")
    }
    columns["variant"] = columns["variant"].replace("default", "")
    columns["formulation"] = columns["formulation"].replace("standard", "")
    for column in (
        *("setting", "error_max", "error_end", "error_rms", "floor", "conditioning", "order_declared"),
        *("error_phase", "error_shape", "turns", "events_missing", "events_extra", "events_time_error"),
        *("rhs_calls", "steps", "seconds_median", "seconds_low", "seconds_high", "prepare_seconds"),
        *("null_seconds", "turned_starts", "error_low", "error_high", "error_unturned", "error_start"),
        *("null_work", "first_seconds", "delay_seconds", "more_seconds"),
    ):
        columns[column] = pd.to_numeric(rows[column], errors="coerce").astype(float)
    frame = one_machine(rows.assign(**columns))
    frame = frame.assign(null_seconds=null_calls(frame), null_work=0.0)
    turned = frame.groupby("trial_key")["turned_starts"].transform("max") > 0
    aside = turned & frame["turned_starts"].isna()
    if aside.any():
        frame.loc[aside, [column for column in ERRORS if column in frame]] = math.nan
    return frame


def own_spans(frame: pd.DataFrame) -> pd.DataFrame:
    """The rows of `tidy` without series over several spans: these give `more_seconds` of the others, and rank nothing."""
    return frame[~frame["variant"].str.contains(TIMING_SPAN, regex=False)]


def one_machine(frame: pd.DataFrame) -> pd.DataFrame:
    """The rows without the times from other machines than the one that timed most rows of the problem.

    Times of different machines are not compared. Errors do not depend on the machine, and stay.
    """
    if frame["machine"].nunique() < 2:
        return frame
    timed = frame[frame["seconds_median"].notna()]
    counts = timed.groupby([*PROBLEM, "machine"]).size().rename("count").reset_index()
    most = counts.sort_values(["count", "machine"], ascending=[False, True]).drop_duplicates(PROBLEM)
    chosen = frame[PROBLEM].merge(most, on=PROBLEM, how="left")["machine"].to_numpy()
    times = [name for name in (*TIMES, "more_seconds") if name in frame]
    return frame.assign(**{name: frame[name].where(frame["machine"] == chosen) for name in times})


def null_calls(frame: pd.DataFrame) -> pd.Series:
    """The times of the null calls without their own work (`null_work`), at the cost of the work in the series.

    With a time a + c w for w right-hand sides (or steps), c is the slope from the null call to the setting with the
    most work in the series, among settings that did not wait for a processor and have at least twice the work of the
    null call. Without such a setting, or if the work of a null call is not known, the time stays whole.
    """
    null, work = frame["null_seconds"], frame["null_work"]
    if not (work > 0).any():
        return null
    counts = frame["rhs_calls"].fillna(frame["steps"])
    counts = counts.groupby(frame["trial_key"]).transform("max")  # later launches do not count right-hand sides
    cost = (frame["seconds_median"] - null) / (counts - work)
    usable = cost.notna() & (counts >= 2 * work) & frame["status"].isin(SCORED) & ~find_delayed(frame)
    series = [frame[column] for column in (*SERIES, "machine")]
    most = counts.where(usable).groupby(series).transform("max")
    slope = cost.where(usable & (counts == most)).groupby(series).transform("median").clip(lower=0.0)
    return (null - slope * work).clip(lower=0.0).fillna(null)


def find_delayed(frame: pd.DataFrame) -> pd.Series:
    """Whether each measurement waited for a processor for more than `DELAYED` of its time."""
    return frame["delay_seconds"] > DELAYED * frame["seconds_median"]


def first_uses(rows: pd.DataFrame) -> pd.DataFrame:
    """By integrator, the seconds of its first use, `first_use`, and the case of this measurement, `first_case`."""
    known = rows[rows["first_seconds"].notna()].drop_duplicates("integrator_id", keep="last")
    known = known.rename(columns={"first_seconds": "first_use", "case": "first_case"})
    return known.set_index("integrator_id")[["first_use", "first_case"]]


def load_seconds(rows: pd.DataFrame) -> pd.Series:
    """By integrator, the seconds that only its first use takes: import of its library, compilation of code that is kept.

    They are the first use without the preparation and the call of its trial, which each further use has.
    """
    known = rows[rows["first_seconds"].notna()].drop_duplicates("integrator_id", keep="last").set_index("integrator_id")
    return (known["first_seconds"] - known["prepare_seconds"] - known["seconds_median"]).clip(lower=0.0)


def own(table: pd.DataFrame) -> pd.DataFrame:
    """The rows of default variants in the case's own formulation."""
    return table[(table["variant"] == "") & (table["formulation"] == "")]


def hard(table: pd.DataFrame) -> pd.DataFrame:
    """The rows of hard variants in the case's own formulation."""
    return table[(table["variant"] != "") & (table["formulation"] == "")]


def settings(frame: pd.DataFrame) -> pd.DataFrame:
    """One row for each setting of a series, loosest first; `seconds` is the median over launches of the whole call.

    `seconds_low` and `seconds_high`, quantiles over the calls of one launch, are from the first launch.
    """
    grouped = frame.sort_values("launch").groupby([*SERIES, "setting"], dropna=False, sort=False)
    reduced = grouped.first().assign(
        error_max=grouped["error_max"].max(),
        seconds=grouped["seconds_median"].median(),
    )
    return reduced.reset_index().sort_values([*SERIES, "setting"], ascending=[True] * len(SERIES) + [False])


def preparations(rows: pd.DataFrame) -> pd.Series:
    """For each series, the median over its settings of the seconds of a preparation in the first launch."""
    ran = rows.loc[~rows["status"].isin(NEVER_RAN), [*SERIES, "setting", "prepare_seconds"]]
    ran = ran.drop_duplicates([*SERIES, "setting"])
    return ran.groupby(list(SERIES))["prepare_seconds"].median()


def equal_error(frame: pd.DataFrame, targets: Sequence[float] = TARGETS) -> pd.DataFrame:
    """Time at equal error: one row for each series and target that it reaches.

    For its columns see `equal_error.Reached`. `prepare_seconds` is the time of `prepare`, which the other times exclude (see
    `preparations`). `machine` is the machine of the times. `more_seconds` are the seconds of one more pass over the case's
    span, at the same settings, and `more_times` these seconds by run and launch; nan and empty where they were not
    measured, or do not differ clearly (see `reading.APART`).

    The error of a setting that diverged counts as infinite. A setting without a solution is ignored.
    """
    rows = []
    columns = (
        *("run", "launch", "setting", "error_max", "seconds_median", "null_seconds", "delay_seconds"),
        *("rhs_calls", "more_seconds"),
    )
    chosen = frame["status"].isin(SCORED) & (frame["seconds_median"] > 0)
    usable = frame.loc[chosen, [*SERIES, "machine", "status", *columns]]
    usable = usable.assign(error_max=usable["error_max"].where(usable["status"] != Status.DIVERGED, math.inf))
    for key, series in _series(usable.sort_values("setting", ascending=False), *columns):
        more = _one_more(series, targets)
        rows += [(*key, *time, *more.get(time.target, (math.nan, {}))) for time in find_reached(series, targets)]
    table = pd.DataFrame(rows, columns=[*SERIES, *Reached._fields, "more_seconds", "more_times"])
    machines = usable.groupby(SERIES)["machine"].first()
    return table.join(machines, on=list(SERIES)).join(preparations(frame), on=list(SERIES))


def _one_more(
    series: Sequence[Mapping[str, Any]], targets: Sequence[float]
) -> dict[float, tuple[float, dict[tuple[int, int], float]]]:
    """By target: the seconds of one more pass over the span, and these seconds by (run, launch), as in `find_reached`."""
    if all(math.isnan(row["more_seconds"]) for row in series):
        return {}
    rows = [{**row, "seconds_median": row["more_seconds"]} for row in series]
    return {time.target: (time.seconds, time.times) for time in find_reached(rows, targets)}


def one_more_period(equal: pd.DataFrame) -> pd.DataFrame:
    """The rows of `equal_error` that have it, with the time of one more pass over the span in place of the whole call.

    It has no null call: both times include one, and the difference has none.
    """
    rows = equal[equal["more_seconds"].notna()]
    times = {
        "low": [min(times.values()) for times in rows["more_times"]],
        "high": [max(times.values()) for times in rows["more_times"]],
        "launches": [len(times) for times in rows["more_times"]],
    }
    return rows.assign(seconds=rows["more_seconds"], times=rows["more_times"], null_share=0.0, **times)


def trust(reduced: pd.DataFrame) -> pd.DataFrame:
    """The reliability of each series: its best error, the attainable error, and achieved error over tolerance.

    The attainable error is the larger of conditioning and floor. Achieved error over tolerance is taken over all
    solutions with an error, also inaccurate and diverged ones, whose tolerance is above the attainable error, because
    smaller ones cannot be met. If the best error is a median over `turned_starts` orientations, `error_low` and
    `error_high` are its range, else nan.
    """
    rows = []
    spread = ("turned_starts", "error_low", "error_high")
    columns = ("status", "setting", "setting_kind", "sampling", "error_max", "conditioning", "floor", *spread)
    for key, series in _series(reduced.loc[~reduced["status"].isin(NEVER_RAN), [*SERIES, *columns]], *columns):
        good = [row for row in series if row["status"] == Status.OK]
        record: dict[str, Any] = dict(zip(SERIES, key, strict=True))
        record |= {"settings": len(series), "settings_ok": len(good), "sampling": series[0]["sampling"]}
        record |= dict.fromkeys(
            ("best", "at", "attainable", "over_tolerance", "worst_over_tolerance", *spread), math.nan
        )
        if good:
            best = min(good, key=lambda row: row["error_max"])
            record |= {"best": best["error_max"], "at": best["setting"]} | {name: best[name] for name in spread}
        limits = [series[0]["conditioning"], series[0]["floor"], 0.0]
        record["attainable"] = float(np.nanmax(limits))
        answered = [row for row in series if row["status"] in SCORED and math.isfinite(row["error_max"])]
        asked = [r for r in answered if r["setting_kind"] == "tolerance" and r["setting"] > record["attainable"]]
        if asked:
            over = [row["error_max"] / row["setting"] for row in asked]
            record |= {"over_tolerance": float(np.median(over)), "worst_over_tolerance": max(over)}
        rows.append(record)
    return pd.DataFrame(rows)


def status_matrix(reduced: pd.DataFrame) -> pd.DataFrame:
    """One row for each series: its statuses over the sweep, the first failure with its reason, and the best error.

    `verdict` is "ok" (every setting that ran), "partly" (some), or the most frequent status if no setting is ok.
    `skipped` (a predicted time above the limit) and `interrupted` (ended from outside) are not failures of the
    integrator, and count only if all settings ended so.
    """
    rows = []
    for key, series in _series(reduced, "status", "reason", "error_max"):
        counts = dict(Counter(row["status"] for row in series).most_common())
        good = [row["error_max"] for row in series if row["status"] == Status.OK]
        broken = [row for row in series if row["status"] not in NOT_BROKEN]
        shown = (broken or [row for row in series if row["status"] != Status.OK])[:1]
        frequent = Counter(row["status"] for row in broken or series).most_common(1)[0][0]
        verdict = Status.OK if good and not broken else PARTLY if good else frequent
        record: dict[str, Any] = dict(zip(SERIES, key, strict=True))
        record |= {"verdict": verdict, "settings_ok": len(good), "settings": len(series), "counts": counts}
        record["best"] = min(good, default=math.nan)
        record["failure"] = "".join(str(row["status"]) for row in shown)
        record["reason"] = "".join(str(row["reason"]) for row in shown)
        rows.append(record)
    return pd.DataFrame(rows)


def not_run(matrix: pd.DataFrame, variants: Mapping[str, Iterable[str]]) -> pd.DataFrame:
    """Rows as in `status_matrix` for hard variants that were not run with an integrator that accepts the case.

    `variants`: the hard variants of each case by name; the variants in `matrix` are added.
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
    """Key and rows of each series, sorted by key. The rows are dicts: a DataFrame for each series takes far longer."""
    places: dict[tuple[str, ...], list[int]] = {}
    for place, key in enumerate(zip(*(frame[name].tolist() for name in SERIES), strict=True)):
        places.setdefault(key, []).append(place)
    values = [frame[name].tolist() for name in columns]
    for key, own in sorted(places.items()):
        rows = zip(*([column[place] for place in own] for column in values), strict=True)
        yield key, [dict(zip(columns, row, strict=True)) for row in rows]


def records(frame: pd.DataFrame, columns: Sequence[str] | None = None) -> Iterator[dict[str, Any]]:
    """The rows as dicts, of these columns or of all: like `to_dict("records")`, in a third of its time."""
    names = [str(name) for name in columns or frame.columns]
    values = [frame[name].tolist() for name in columns or frame.columns]
    return (dict(zip(names, row, strict=True)) for row in zip(*values, strict=True))


def failures(reduced: pd.DataFrame) -> pd.DataFrame:
    """Every setting that is not ok, grouped by status, integrator and reason, with the case variants concerned."""
    bad = reduced[reduced["status"] != Status.OK]
    where = bad["case"] + np.where(bad["variant"] != "", "/" + bad["variant"], "")
    grouped = bad.assign(where=where).groupby(["status", "integrator_id", "reason"], sort=False)["where"]
    table = grouped.agg(trials="count", where=lambda names: list(dict.fromkeys(names))).reset_index()
    rank = {name: place for place, name in enumerate(Status)}
    return table.sort_values(
        ["status", "integrator_id"], key=lambda column: column.map(rank) if column.name == "status" else column
    )


def policies(reduced: pd.DataFrame) -> pd.DataFrame:
    """Errors of engines at equal step under each policy: "as shipped", "configured", "staggered".

    One row for each case variant, engine, policy and step, if at least two policies ran it; `error` is nan if the trial
    failed.
    """
    engines = reduced[(reduced["policy"] != "") & reduced["setting"].notna()]
    table = engines[["case", "variant", "library", "integrator", "policy", "setting", "status", "error_max"]].rename(
        columns={"error_max": "error"}
    )
    several = table.groupby(["case", "variant", "library", "integrator", "setting"])["policy"].transform("nunique") > 1
    return table[several]


def orders(reduced: pd.DataFrame) -> pd.DataFrame:
    """Measured and declared order of every fixed-step series; nan without four points on a line.

    The order is fitted to the largest error over the samples, else to their root mean square, else to the error at the
    end, else to the largest over the first samples: if one of them passes through zero between two steps, another may
    not. If the error has terms such as h^5 t^2 and h^4 t, the early samples show the order. `lowest` and `highest` are
    the smallest and largest slope between neighbouring fine points of the largest error, nan if fewer than 4 settings
    are in the range. `why` is the reason of a missing order. `margin` is half of the order's 95 % interval
    (`convergence_order.mean_slope`).
    """
    fixed = reduced[(reduced["setting_kind"] == "step") & (reduced["status"] == Status.OK)]
    groups = _series(fixed, "setting", "order_declared", "conditioning", "floor", *KINDS)
    rows = [(*key, *order(series)) for key, series in groups]
    return pd.DataFrame(rows, columns=[*SERIES, "order", "margin", "lowest", "highest", "declared", "why"])


def anatomy(frame: pd.DataFrame, near: float = 1e-5) -> pd.DataFrame:
    """The parts of the error of each series, at its ok setting with an error nearest `near`.

    `error_phase` is along the exact motion and `error_shape` across it (nan if undefined). `turns` is the largest number
    of whole turns by which angles are wrong at any ok setting; the error excludes them. The `events_` columns compare
    located events with the exact ones.
    """
    good = frame[(frame["status"] == Status.OK) & (frame["error_max"] > 0)]
    good = good.assign(away=np.abs(np.log10(good["error_max"] / near)))
    chosen = good.sort_values(["launch", "away"]).groupby(SERIES, dropna=False, sort=False).first()
    turns = good.groupby(SERIES, dropna=False, sort=False)["turns"].max()
    events = ["events_missing", "events_extra", "events_time_error"]
    return chosen[["error_max", "error_phase", "error_shape", *events]].assign(turns=turns).reset_index()
