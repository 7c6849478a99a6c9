"""Combines the launches of the paired benchmarks: medians and ranges over processes, for the report.

`make bench` launches tests/benchmarks/test_pairs.py in new processes, each of which writes a pytest-benchmark file, and
then runs `python -m gnomon.harness.studies.benchmarks LAUNCH... --out reports/local/benchmarks.json`. A benchmark's
`extra_info` holds `rows`: dictionaries with the names of the comparison (`group`, `problem`, `level`). A row of a pair
has the seconds of both (`first` and `second`, null if one has no result at the level) and of their null calls and
preparations (`first_null`, `first_prepare` and so on); a row of a single time has its `value` in `unit`.
"""

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import Any

from gnomon.harness.registry import environment
from gnomon.harness.results import study_file

NAMED = ("group", "problem", "level", "first_name", "second_name", "unit")
"""The columns that identify a row, equal in every launch."""


def gather(launches: Sequence[Path]) -> dict[str, Any]:
    """One row for each comparison: the medians of both sides, and the ratio by launch with its median and range."""
    groups: dict[tuple[Any, ...], list[dict[str, Any]]] = {}
    for path in launches:
        for benchmark in json.loads(path.read_text(encoding="utf-8"))["benchmarks"]:
            for row in benchmark["extra_info"].get("rows", []):
                groups.setdefault(tuple(row.get(name) for name in NAMED), []).append(row)
    rows = [dict(zip(NAMED, key, strict=True)) | reduce(members) for key, members in groups.items()]
    return {"launches": len(launches), "environment": environment.record(), "rows": rows}


def reduce(members: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Medians over launches; the time of a side is null unless every launch has it."""
    result: dict[str, Any] = {"launches": len(members)}
    if "value" in members[0]:
        return result | spread([row["value"] for row in members])
    for side in ("first", "second", "first_null", "second_null", "first_prepare", "second_prepare"):
        times = [row[side] for row in members]
        result[side] = None if None in times else median(times)
    if result["first"] is None or result["second"] is None:
        return result | dict.fromkeys(("median", "low", "high"))
    ratios = [row["second"] / row["first"] for row in members]
    return result | spread(ratios) | {"ratios": ratios}


def spread(values: Sequence[float]) -> dict[str, float]:
    return {"median": median(values), "low": min(values), "high": max(values)}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("launches", nargs="+", type=Path)
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    study_file.write(gather(arguments.launches), arguments.out)


if __name__ == "__main__":
    main()
