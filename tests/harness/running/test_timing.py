"""A run without times has the same errors; a run with times into the same file measures the trials without times."""

from pathlib import Path
from typing import Any

import planted
from gnomon.harness.registry import selection
from gnomon.harness.results import store
from gnomon.harness.results.schema import TIMES
from gnomon.harness.running import plan
from gnomon.harness.running.planned_run import run
from waiting import LONG_SECONDS

TIMED = plan.suite("quick").within(LONG_SECONDS).change(launches=1)


def measured(path: Path, suite: plan.Suite) -> Any:
    run(path, suite, selection.choose(["planted:Short"], False), [planted.Sound()])
    return store.load(path, superseded=True)


def test_errors_alone_first_and_times_later(tmp_path: Path) -> None:
    assert TIMED.timing.launches == 1
    alone = measured(tmp_path, TIMED.untimed())
    assert alone[list(TIMES)].isna().all(axis=None)
    assert alone["repeats"].median() == 1, (
        "one call, which is scored; more after a counting run in which the machine paused"
    )
    assert set(alone["status"]) == {"ok"}
    both = measured(tmp_path, TIMED)
    later = both.iloc[1::2]
    assert len(both) == 2 * len(alone), "each trial a second time, and no third"
    assert (later["seconds_median"] > 0).all()
    assert later["error_max"].tolist() == alone["error_max"].tolist()
    assert len(measured(tmp_path, TIMED.untimed())) == len(both), "a trial with a time has an error too"
