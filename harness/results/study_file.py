"""Writes JSON files for the report: a study has its own command, and measures one row for each of its subjects."""

import argparse
import json
import os
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from gnomon.harness.system.supervisor import calls, require
from gnomon.reference.storage import diskcache

Subject = TypeVar("Subject")


def publish(
    description: str | None, measured: Callable[[Subject], dict[str, Any]], subjects: Sequence[Subject]
) -> None:
    """Measure all subjects on all cores, and write the rows to the file of the command `python -m MODULE --out FILE`."""
    from gnomon.harness.registry import environment  # identifies the processor, which takes a tenth of a second

    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--out", type=Path, required=True)
    arguments = parser.parse_args()
    rows = dict(calls(partial(_at, measured, subjects), range(len(subjects)), os.cpu_count() or 1, "spawn"))
    contents = {"environment": environment.record(), "rows": [require(rows[k]) for k in range(len(subjects))]}
    write(contents, arguments.out)


def _at(measured: Callable[[Subject], Any], subjects: Sequence[Subject], k: int) -> Any:
    """The row of subject `k`: a subject need not be hashable."""
    return measured(subjects[k])


def write(contents: Any, path: Path) -> None:
    """Write JSON to a temporary file and then replace `path`: if the disk is full, the former file stays."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with diskcache.whole(path) as part:
        part.write_text(json.dumps(contents, indent=1) + "\n", encoding="utf-8")
