"""Rows that a module measures, one for each of its subjects, written for the report: `python -m MODULE --to FILE`."""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path
from typing import Any, TypeVar

from gnomon.harness import environment
from gnomon.reference import diskcache

Subject = TypeVar("Subject")


def publish(
    description: str | None, measured: Callable[[Subject], dict[str, Any]], subjects: Sequence[Subject]
) -> None:
    """Measure all of them on all cores, and write them as JSON to the file that the command line names."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--to", type=Path, required=True)
    arguments = parser.parse_args()
    with ProcessPoolExecutor(os.cpu_count(), mp_context=get_context("spawn")) as processes:
        found = {"environment": environment.describe(), "rows": list(processes.map(measured, subjects))}
    with diskcache.whole(arguments.to) as part:
        part.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
