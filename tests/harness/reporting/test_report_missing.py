"""What a report says of a run that is not complete."""

import sqlite3
from pathlib import Path

from gnomon.harness.reporting.report_missing import missing
from gnomon.harness.results import schema


def _without(results: Path, condition: str) -> int:
    """Remove the measurements of the trials that meet a condition; returns how many trials these are."""
    with sqlite3.connect(results) as db:
        trials = f"SELECT trial_key FROM trials WHERE {condition}"
        ((count,),) = db.execute(f"SELECT count(*) FROM ({trials})")
        for table in ("sampled_states", "settings_changed"):
            db.execute(
                f"DELETE FROM {table} WHERE measurement IN"
                f" (SELECT measurement FROM measurements WHERE trial_key IN ({trials}))"
            )
        db.execute(f"DELETE FROM measurements WHERE trial_key IN ({trials})")
    return int(count)


def test_a_complete_run_has_nothing_missing(synthetic_results: Path) -> None:
    assert missing(synthetic_results) is None


def test_cases_and_libraries_are_named(synthetic_results: Path) -> None:
    lost = _without(synthetic_results, "\"case\" = 'bouncing_ball'")
    scipy = _without(synthetic_results, "\"case\" = 'kepler_orbit' AND library = 'scipy'")
    found = missing(synthetic_results) or {}
    assert found["trials"] == lost + scipy
    assert found["cases"]["names"] == ["bouncing_ball"]
    assert found["partly"]["names"] == ["kepler_orbit"]
    of_ball = 11  # settings of each integrator on a variant
    assert f"scipy ({scipy + of_ball})" in found["libraries"]["names"]
    with sqlite3.connect(synthetic_results) as db:
        assert found["planned"] == db.execute("SELECT count(*) FROM planned").fetchone()[0]


def test_a_run_that_did_not_end_lacks_later_launches(synthetic_results: Path) -> None:
    with sqlite3.connect(synthetic_results) as db:
        db.execute("UPDATE runs SET ended = NULL")
        schema.seal_all(schema.with_checksums(db), "runs")
    assert (missing(synthetic_results) or {})["trials"] == 0
