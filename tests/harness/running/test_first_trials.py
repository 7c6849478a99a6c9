"""A run reports faults of a user's own integrator before it starts, and that integrator's results at its end."""

from collections import Counter
from pathlib import Path
from typing import Any

import planted
import pytest
from command_line import gnomon
from gnomon.harness.commands.run_table import MOST_SERIES, run_table, shortcomings
from gnomon.harness.registry import selection
from gnomon.harness.registry.lookup import is_users_own, own
from gnomon.harness.results import reading, store
from gnomon.harness.results.best import find_ways
from gnomon.harness.results.number_text import error_text, time_text
from gnomon.harness.running import first_trials, plan
from rich.console import Console
from turned_clock import Clock
from waiting import LONG_SECONDS

SUITE = plan.suite("quick").within(LONG_SECONDS)
RUN = ("run", "--case", "planted:Short", "--suite", "quick", "--integrator")
ENDS = ("--limit", str(LONG_SECONDS))


def crashes(*kinds: Any) -> list[str]:
    return first_trials.crashes(selection.choose(["planted:Short"], False), [kind() for kind in kinds], SUITE)


def test_only_an_integrator_that_crashes_at_both_settings_is_named_with_its_traceback(clock: Clock) -> None:
    """A correct method may raise at too large a step; a hang, a refusal and a missing library are results of the run."""
    sound = (planted.Sound, planted.RaisesAtLargeSteps, planted.HangsAlways, planted.Declines, planted.MissingLibrary)
    found = crashes(*sound, planted.Raises, planted.NoSolution, planted.Aborts)
    assert clock.hanging is not None
    raised, returned, aborted = found
    assert raised.startswith("planted:raises on short_pendulum: ")
    assert 'planted.py", line ' in raised
    assert raised.endswith("ArithmeticError: planted")
    assert "worker.py" not in raised, "the frames of the harness are left out"
    assert returned == "planted:no solution on short_pendulum: solve returned NoneType, not a Solution"
    assert aborted.endswith("the process died of SIGABRT")


def test_the_integrators_of_gnomon_have_no_first_trial() -> None:
    assert not any(is_users_own(integrator) for integrator in own().values())
    assert is_users_own(planted.Sound())


def test_a_run_of_code_that_raises_stops_with_the_traceback(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "a.sqlite"
    assert gnomon(*RUN, "planted:Raises", *ENDS, "--out", str(out)) == 1
    said = capfd.readouterr().err
    assert "ArithmeticError: planted" in said
    assert said.splitlines()[-1].startswith("nothing was run")
    assert not out.exists()


def test_a_run_in_which_everything_hangs_fails_and_says_so(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "a.sqlite"
    assert gnomon(*RUN, "planted:HangsAlways", "--limit", "0.05", "--out", str(out)) == 1
    captured = capfd.readouterr()
    assert captured.err.splitlines()[-1].startswith("nothing was measured: 5 skipped, 3 timeout")
    assert "no answer within 0.05 s" in captured.out
    assert "gnomon report" not in captured.out


def test_a_run_that_measured_shows_it_and_names_the_next_command(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], clock: Clock
) -> None:
    out = tmp_path / "a file.sqlite"
    assert gnomon(*RUN, "planted:Hangs", "--limit", "2", "--out", str(out)) == 0
    text = capfd.readouterr().out
    (row,) = (line for line in text.splitlines() if line.strip().startswith("planted:hangs"))
    best = store.load(out).query("status == 'ok'")["error_max"].min()
    assert f" {error_text(best)} " in row
    assert "3 ok" in row
    assert "no answer within 2 s" in text
    assert f"gnomon report '{out}'" in text
    assert gnomon(*RUN, "planted:NotANumber", *ENDS, "--out", str(out)) == 1, (
        "results of another integrator in the file do not count"
    )
    assert capfd.readouterr().err.splitlines()[-1].startswith("planted:not a number never succeeded (diverged: ")


def rows(tmp_path: Path) -> list[dict[str, Any]]:
    import synthetic

    return reading.rows(synthetic.write(tmp_path / "results.sqlite"))


def shown(rows: list[dict[str, Any]], error: float | None = None) -> list[str]:
    console = Console(width=250, record=True, file=open("/dev/null", "w"))  # noqa: SIM115
    console.print(run_table(rows, error))
    return console.export_text().splitlines()


def test_for_an_error_the_fastest_is_first_and_a_hidden_error_is_a_bound(tmp_path: Path) -> None:
    """The time is that of the answer below the table, at its setting; an error below the reference's is not measured."""
    many = rows(tmp_path)
    one = [row for row in many if (row["case"], row["variant"]) == (many[0]["case"], many[0]["variant"])]
    ways = find_ways(one, 1e-3)
    assert len(ways) > 1
    lines = shown(one, 1e-3)
    names = [line.strip().partition("  ")[0] for line in lines]
    placed = sorted((names.index(way.timed.integrator_id), way.cost.each) for way in ways)
    times = [seconds for _, seconds in placed]
    assert times == sorted(times)
    assert all(time_text(seconds) in lines[place] for place, seconds in placed)
    hidden = shown([row | {"floor": 0.5} for row in one])
    assert any(" < 5.0e-1 " in line for line in hidden)


def test_the_table_has_a_line_for_each_series_or_for_each_integrator_if_series_are_many(tmp_path: Path) -> None:
    many = rows(tmp_path)
    few = [row for row in many if row["case"] == many[0]["case"]]
    for found in (few, many):
        expected = Counter(identity for _, identity in {(row["series"], row["integrator_id"]) for row in found})
        if found is many:
            assert expected.total() > MOST_SERIES
            expected = Counter(list(expected))
        lines = shown(found)
        for identity, count in expected.items():
            assert sum(line.strip().startswith(f"{identity} ") for line in lines) == count


def test_a_run_in_which_every_integrator_succeeded_has_no_shortcomings(tmp_path: Path) -> None:
    assert shortcomings(rows(tmp_path), []) == []
