"""The numbers of a publication that `gnomon history` follows: a few hundred, by name."""

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pandas as pd
from gnomon.harness.contract.status import Status
from gnomon.harness.results import analysis, rankings, store
from gnomon.harness.running.plan import SUITES

ERROR = 1e-6
"""The error at which cases count as reached, and at which times are compared."""
TIMED = SUITES["quick"].scope.cases
"""The cases whose times are followed."""
LARGEST_DIGITS = 16.0


def of_publication(database: Path, files: Mapping[str, Any]) -> dict[str, float]:
    """The numbers of a results file, and of the files beside it by their names."""
    frame = store.load(database)
    of_run = dict(of_results(frame)) if len(frame) else {}
    return {name: value for name, value in (of_run | dict(of_files(files))).items() if math.isfinite(value)}


def of_results(frame: pd.DataFrame) -> Iterator[tuple[str, float]]:
    """Trials by status; by integrator the cases reached, median digits, hard variants solved; times on a few cases."""
    for status, count in frame["status"].value_counts().items():
        yield f"trials/{status}", float(count)
    rows = analysis.own_spans(analysis.tidy(frame))
    reduced = analysis.settings(rows)
    ran = reduced[~reduced["status"].isin(analysis.NEVER_RAN)]
    default = analysis.own(ran)
    best = default["error_max"].where(default["status"] == Status.OK, math.inf)
    least = default.assign(best=best.fillna(math.inf)).groupby(["integrator_id", "case"])["best"].min()
    for name, errors in least.groupby(level=0):
        yield f"cases/{name}", float(len(errors))
        yield f"reached_1e-6/{name}", float((errors <= ERROR).sum())
        finite = [min(LARGEST_DIGITS, -math.log10(error)) if error > 0 else LARGEST_DIGITS for error in errors]
        yield f"digits/{name}", float(pd.Series(finite).clip(lower=0.0).median())
    if len(analysis.hard(ran)):
        for name, right in rankings.find_solved(reduced).items():
            yield f"hard_run/{name}", float(right.notna().sum())
            yield f"hard_solved/{name}", float(right.sum())
    some = rows[rows["case"].isin(TIMED)]
    if len(some):
        equal = analysis.own(analysis.equal_error(some, [ERROR]))
        for (case, name), seconds in equal.groupby(["case", "integrator_id"])["seconds"].min().items():
            yield f"seconds_1e-6/{case}/{name}", float(seconds)


def of_files(files: Mapping[str, Any]) -> Iterator[tuple[str, float]]:
    """Measured orders, certificates, and the shares of faults that `gnomon verify` finds."""
    for row in files.get("orders.json", {}).get("rows", ()):
        yield f"order/gnomon:{row['integrator']}", float(row["order"])
    certificates = files.get("certificates.json", {}).get("rows", ())
    if certificates:
        yield "certificates/confirmed", float(sum(bool(row["passed"]) for row in certificates))
        yield "certificates/all", float(len(certificates))
        yield "certificates/fewest_digits", float(min(row["digits"] for row in certificates))
    verified = files.get("verification.json", {})
    for kind in ("mutants", "defects"):
        if kind in verified:
            yield f"verify/{kind}_share", float(verified[kind]["share"])
    if "false_alarms" in verified:
        yield "verify/false_alarms", float(len(verified["false_alarms"]))
