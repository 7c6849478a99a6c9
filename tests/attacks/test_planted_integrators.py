"""Harmful integrators: the run ends, results of others keep every bit, the status says what happened, nothing is left."""

import os
import random
import signal
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import planted
import planted_attacks
import pytest
from gnomon.harness.results import store
from planted_attacks import ATTACKS
from waiting import LONG_SECONDS, wait_until, with_variable

FOLDERS = [str(Path(module.__file__).parent) for module in (planted, planted_attacks)]

SCRIPT = """
import sys
sys.path[:0] = {folders!r}
import planted, planted_attacks
from contextlib import nullcontext
from gnomon.harness.registry import selection
from gnomon.harness.running import plan
from gnomon.harness.running.planned_run import run
from turned_clock import turned_clock
if __name__ == "__main__":
    suite = plan.suite("quick").change(block_seconds=0.0, repeats=2).within({limit!r})
    attacks = [one for one in planted_attacks.ATTACKS if one.name in {names!r}]
    chosen = selection.choose(["planted:Short"], False)
    run("alone.sqlite", suite, chosen, [planted.Sound(), planted.NearDuplicate()])
    for hangs, workers, clock in ((False, 2, nullcontext), (True, 1, turned_clock)):
        some = [one for one in attacks if ("timeout" in one.statuses) == hangs]
        with clock():
            integrators = [planted.Sound(), *some, planted.NearDuplicate()]
            run(f"attacked_{{workers}}.sqlite", suite, chosen, integrators, workers=workers)
"""
"""The attacks that hang are ended by a turned clock: by it nothing else takes time, however slow the machine is."""
RUN_SECONDS = 600
"""A guard: a run ends by itself within half a minute on a quiet machine."""
OTHERS = ("sound", "near_duplicate")
SHUFFLED = random.Random(17).sample([one.name for one in ATTACKS], len(ATTACKS))
GROUPS = [SHUFFLED[start::10] for start in range(10)]
"""Attacks that are run together: separate runs would take minutes to start processes."""


def attacked(names: Sequence[str], folder: Path) -> pd.DataFrame:
    """The rows of the attacks in a run whose other trials were compared with a run without attacks."""
    (folder / "tokens").mkdir()
    with tempfile.TemporaryDirectory() as temporary:  # a short name: the path of a socket has at most 107 characters
        _run(names, folder, Path(temporary))
    return _rows(folder)


def _run(names: Sequence[str], folder: Path, temporary: Path) -> None:
    (folder / "job.py").write_text(SCRIPT.format(folders=FOLDERS, names=list(names), limit=LONG_SECONDS))
    own = {"GNOMON_ATTACKS": str(folder / "tokens"), "TMPDIR": str(temporary)}
    process = subprocess.Popen(
        [sys.executable, "job.py"], cwd=folder, env=os.environ | own, stderr=subprocess.PIPE, start_new_session=True
    )
    try:
        _, said = process.communicate(timeout=RUN_SECONDS)
    finally:
        for number in with_variable("GNOMON_ATTACKS", own["GNOMON_ATTACKS"]) if process.poll() is None else []:
            os.kill(number, signal.SIGKILL)
    assert process.returncode == 0, said.decode()
    assert not list(temporary.iterdir()), "a temporary file was left"
    assert all(map(_ending, with_variable("GNOMON_ATTACKS", own["GNOMON_ATTACKS"]))), "a process was left"
    wait_until(
        lambda: not with_variable("GNOMON_ATTACKS", own["GNOMON_ATTACKS"]), "the killed processes of the run have ended"
    )


def _rows(folder: Path) -> pd.DataFrame:
    alone, kept = store.load(folder / "alone.sqlite"), store.states(folder / "alone.sqlite")
    assert list(alone["status"]) == ["ok"] * 16
    attacks = []
    for file in sorted(folder.glob("attacked_*.sqlite")):
        after, found = store.load(file), store.states(file)
        others = after[after["integrator"].isin(OTHERS)]
        assert list(others["status"]) == ["ok"] * 16
        for before, now in zip(alone["measurement"], others["measurement"], strict=True):
            np.testing.assert_array_equal(kept[before], found[now], strict=True)
        attacks.append(after[~after["integrator"].isin(OTHERS)])
    assert len(attacks) == 2
    return pd.concat(attacks)


def _ending(number: int) -> bool:
    """Whether a process has ended or has a SIGKILL pending, as children of a parent that ended have."""
    try:
        status = Path(f"/proc/{number}/status").read_text()
    except OSError:
        return True
    pending = [int(line.split()[1], 16) for line in status.splitlines() if line.startswith(("SigPnd", "ShdPnd"))]
    return "\nState:\tZ" in status or any(mask >> (signal.SIGKILL - 1) & 1 for mask in pending)


def assert_statuses(rows: pd.DataFrame, names: Sequence[str]) -> None:
    expected = {one.name: one.statuses for one in ATTACKS if one.name in names}
    assert rows.groupby("integrator").size().to_dict() == dict.fromkeys(names, 8)
    for name, statuses in expected.items():
        mine = rows[rows["integrator"] == name]
        assert set(mine["status"]) <= statuses, (name, list(mine["reason"].dropna())[:2])


@pytest.mark.parametrize("names", [GROUPS[0], *(pytest.param(group, marks=pytest.mark.slow) for group in GROUPS[1:])])
def test_an_attack_affects_only_its_own_trials(tmp_path: Path, names: list[str]) -> None:
    assert_statuses(attacked(names, tmp_path), names)


def test_there_are_enough_attacks_of_distinct_names() -> None:
    assert len({one.name for one in ATTACKS}) == len(ATTACKS) >= 40
