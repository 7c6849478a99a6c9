"""What is written for the report; rows that a module measures, one for each of its subjects, by a command of its own."""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeVar

from gnomon.harness.system.child_process import interrupts_ignored, process_pool
from gnomon.reference.storage import diskcache

Subject = TypeVar("Subject")


def publish(
    description: str | None, measured: Callable[[Subject], dict[str, Any]], subjects: Sequence[Subject]
) -> None:
    """Measure all of them on all cores, and write them where the command line says: `python -m MODULE --to FILE`."""
    from gnomon.harness.contract import environment  # looks at the processor, which takes a tenth of a second

    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--to", type=Path, required=True)
    arguments = parser.parse_args()
    with process_pool(os.cpu_count() or 1, "spawn") as processes:
        with interrupts_ignored():
            rows = processes.map(measured, subjects)
        found = {"environment": environment.describe(), "rows": list(rows)}
    write(found, arguments.to)


def write(found: Any, path: Path) -> None:
    """As JSON, put in its place whole: where the disk is full the last one stays."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with diskcache.whole(path) as part:
        part.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
