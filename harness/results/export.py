"""Exports the measurements of a results file as a table for other programs."""

import json
import re
from pathlib import Path
from typing import Any

from gnomon.harness.results.reading import load
from gnomon.reference.storage import diskcache

_FORMULA = re.compile(r"[=+\-@\t\r\n\uff1d\uff0b\uff0d\uff20]")
"""The beginning of a formula in a spreadsheet."""
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)(e[+-]?\d+)?", re.IGNORECASE | re.ASCII)


def export(path: str | Path, target: Path, form: str, raw: bool = False) -> None:
    """Write the rows of `load` as csv, json (a list of rows) or parquet.

    In a csv, an apostrophe is put before a text that a spreadsheet would compute as a formula, unless `raw`.
    """
    writers = {"csv": "to_csv", "json": "to_json", "parquet": "to_parquet"}
    if form not in writers:
        raise ValueError(f"format {form!r} is not one of {', '.join(writers)}")
    frame = load(path)
    if form == "csv" and not raw:
        for name in frame.select_dtypes(exclude="number").columns:
            frame[name] = frame[name].map(_no_formula)
    with diskcache.whole(target) as part:
        if form == "json":
            rows = frame.astype(object).where(frame.notna(), None).to_dict("records")  # to_json drops digits
            part.write_text(json.dumps(rows, indent=1))
        else:
            getattr(frame, writers[form])(part, index=False)


def _no_formula(value: Any) -> Any:
    """The text with an apostrophe if a spreadsheet would compute it; a negative number is not a formula."""
    if not isinstance(value, str) or not _FORMULA.match(value) or _NUMBER.fullmatch(value):
        return value
    return f"'{value}"
