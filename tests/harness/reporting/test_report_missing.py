"""The words of a report about a run that is not complete."""

import sqlite3
from pathlib import Path

import pytest
from gnomon.harness.reporting import figures_profiles
from gnomon.harness.reporting.report_charts import complete, run_charts, specifications
from gnomon.harness.reporting.report_missing import missing
from gnomon.harness.reporting.report_run import Run
from gnomon.harness.results import schema
from gnomon.harness.results.outstanding import outstanding


def _without(results: Path, condition: str) -> int:
    """Remove the measurements of the trials that meet a condition; returns the number of these trials."""
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
    assert missing(outstanding(synthetic_results)) is None


def test_cases_and_libraries_are_named(synthetic_results: Path) -> None:
    lost = _without(synthetic_results, "\"case\" = 'bouncing_ball'")
    scipy = _without(synthetic_results, "\"case\" = 'kepler_orbit' AND library = 'scipy'")
    found = missing(outstanding(synthetic_results)) or {}
    assert found["trials"] == lost + scipy
    assert found["cases"]["names"] == ["bouncing_ball"]
    assert found["partly"]["names"] == ["kepler_orbit"]
    of_ball = 11  # settings of each integrator on a variant
    assert f"scipy ({scipy + of_ball})" in found["libraries"]["names"]
    with sqlite3.connect(synthetic_results) as db:
        assert found["planned"] == db.execute("SELECT count(*) FROM planned").fetchone()[0]


def test_an_outstanding_trial_is_no_failure_in_a_profile(
    synthetic_results: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Profiles count a missing time as a failure, so cases with outstanding trials of any library are left out of them."""
    monkeypatch.setattr(figures_profiles, "FEWEST", 1)  # the invented run has few cases
    whole = Run.read(synthetic_results)
    assert len(complete(whole, whole.reduced)) == len(whole.reduced)
    _without(synthetic_results, "\"case\" = 'kepler_orbit' AND library = 'scipy'")
    run = Run.read(synthetic_results)
    assert set(complete(run, run.reduced)["case"]) == set(whole.reduced["case"]) - {"kepler_orbit"}
    others = figures_profiles.profile_charts(
        *(rows[rows["case"] != "kepler_orbit"] for rows in (run.equal, run.reduced))
    )
    charts = run_charts(run)
    assert others
    assert {name: charts[name] for name in others} == specifications(others)


def test_a_run_without_a_complete_case_has_no_profile(synthetic_results: Path) -> None:
    _without(synthetic_results, "library = 'scipy'")
    assert not any(name.startswith("profile") for name in run_charts(Run.read(synthetic_results)))


def test_a_run_that_did_not_end_lacks_later_launches(synthetic_results: Path) -> None:
    with sqlite3.connect(synthetic_results) as db:
        db.execute("UPDATE runs SET ended = NULL")
        schema.seal_all(schema.with_checksums(db), "runs")
    assert (missing(outstanding(synthetic_results)) or {})["trials"] == 0
