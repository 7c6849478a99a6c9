"""The reductions without pandas agree with the analysis of the report, so that both show the same numbers of a run."""

from pathlib import Path

import numpy as np
import pandas as pd
import synthetic
from gnomon.harness.results import analysis, reading, store, summary

COLUMNS = ["setting", "status", "reason", "error_max", "seconds_median", "prepare_seconds", "error_rms", "setting_kind"]


def test_the_settings_and_orders_are_those_of_the_report(tmp_path: Path) -> None:
    """Two machines, several launches, and medians over turned starts: each changes which values count."""
    path = synthetic.write(tmp_path / "results.sqlite")
    rows, frame = reading.rows(path), store.load(path)
    for k in range(0, len(rows), 7):
        rows[k] |= {"machine": "another"}
    for k in range(0, len(rows), 11):
        rows[k] |= {"turned_starts": 9.0}
    for row in rows:
        row["error_max"] = row["error_max"] and row["error_max"] * row["launch"]
    frame["machine"] = [row["machine"] for row in rows]
    frame["turned_starts"] = [row["turned_starts"] for row in rows]
    frame["error_max"] = [row["error_max"] for row in rows]
    reduced = analysis.settings(analysis.tidy(frame))
    found = summary.series(rows)
    table = pd.DataFrame([row for own in found.values() for row in own]).sort_values(
        [*summary.SERIES, "setting"], ascending=[True] * len(summary.SERIES) + [False]
    )
    expected = reduced[[*summary.SERIES, *COLUMNS]].reset_index(drop=True)
    pd.testing.assert_frame_equal(table[expected.columns].reset_index(drop=True), expected, check_dtype=False)
    orders = analysis.orders(reduced).dropna(subset="order")
    assert summary.orders(found) == dict(
        zip(zip(*(orders[n] for n in summary.SERIES), strict=True), orders["order"], strict=True)
    )


def test_rows_have_the_columns_and_values_of_the_frame(tmp_path: Path) -> None:
    path = synthetic.write(tmp_path / "results.sqlite")
    frame = store.load(path)
    rows = reading.rows(path)
    assert list(rows[0]) == list(frame.columns)
    for name in frame:
        values = pd.Series([row[name] for row in rows], dtype=frame[name].dtype)
        pd.testing.assert_series_equal(values, frame[name], check_names=False)
    assert not any(isinstance(value, float) and np.isnan(value) for row in rows for value in row.values())
