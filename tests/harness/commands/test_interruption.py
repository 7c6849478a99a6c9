"""Ctrl-C during work that would take hours: acknowledged, and every process ended."""

import os
import select
import signal
import subprocess
import sys
import threading
from pathlib import Path

import pytest
from command_line import numbers_in
from gnomon.harness.results import store
from gnomon.harness.results.outstanding import outstanding

ENDED = 300
"""Seconds to an end, against hours of work; on a quiet machine it takes five at most."""
BEGUN = 300
"""Seconds to the beginning of that work."""

MODULE = '''
import os
import numpy as np
from gnomon.cases.pendulums.pendulum_simple import PendulumSimple
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.contract.integrator import Integrator, Solution, Steps


def compute():
    with open("computing", "w") as pipe:
        pipe.write("computing")
    for _ in range(10**12):
        pass


class Long(PendulumSimple):
    name = "long_motion"
    variants = ()

    def exact(self, t, digits):
        compute()


class Longer(Long):
    name = "longer_motion"


class Compiled(Integrator):
    name, library, order = "compiled", "planted", 4
    accepts = (FirstOrder,)
    sweep = Steps(coarsest=0.5, halvings=7)

    def prepare(self, problem, setting):
        compute()


class Later(Compiled):
    """Answers the first process that asks, which measures what a sample costs, and computes in all others."""

    name = "later"

    def prepare(self, problem, setting):
        def solve(starts):
            if not os.path.exists("first"):
                open("first", "w").write(str(os.getpid()))
            if open("first").read() != str(os.getpid()):
                compute()
            return Solution(np.zeros((len(starts), len(problem.times), problem.dimension)))

        return solve
'''
STUCK = (
    MODULE
    + """

from gnomon.harness.integrators.runge_kutta.explicit import RK4


class Stuck(RK4):
    name, library, first = "stuck", "planted", None

    def prepare(self, problem, setting):
        type(self).first = self.first or setting
        if setting != self.first and problem.interval > 1e-3:  # a null call has a shorter one
            compute()
        return super().prepare(problem, setting)
"""
)
"""An integrator that never ends at its second setting."""
SWALLOWED = """
from gnomon.harness.commands.interruption import acknowledge
import signal, sys

with acknowledge(float(sys.argv[1])):
    signal.signal(signal.SIGINT, lambda *_: None)
    with open("computing", "w") as pipe:
        pipe.write("computing")
    for _ in range(10**12):
        pass
"""
"""Work in which no KeyboardInterrupt arrives, as in a compiler or a renderer."""


def heard() -> None:
    """Tests that a shell started in the background inherit that Ctrl-C is ignored, and pass it on."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def started(arguments: list[str], folder: Path) -> subprocess.Popen[str]:
    """A command in a process group of its own, once it computes: terminals send Ctrl-C to a whole group."""
    os.mkfifo(folder / "computing")
    pipe = os.open(folder / "computing", os.O_RDONLY | os.O_NONBLOCK)
    process = subprocess.Popen(
        [sys.executable, *arguments],
        cwd=folder,
        start_new_session=True,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        preexec_fn=heard,
    )
    begun, _, _ = select.select([pipe], [], [], BEGUN)
    os.close(pipe)
    if not begun:
        os.killpg(process.pid, signal.SIGKILL)
        raise AssertionError(f"it did not begin: {process.communicate()[1]}")
    return process


def until(process: subprocess.Popen[str], told: str) -> None:
    assert process.stderr is not None
    limit = threading.Timer(ENDED, os.killpg, (process.pid, signal.SIGKILL))
    limit.start()
    assert any(told in line for line in process.stderr), f"it ended, or was killed after {ENDED} s, without {told!r}"
    limit.cancel()


def ended(process: subprocess.Popen[str]) -> str:
    """The rest of its output. The pipe ends when the last of its processes, which all hold it, has ended."""
    try:
        _, told = process.communicate(timeout=ENDED)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        raise
    return told


@pytest.mark.parametrize(
    "arguments",
    [
        ["run", "--case", "long_motion:Long", "--integrator", "gnomon:RK4", "--out", "results.sqlite"],
        ["certify", "long_motion:Long", "--out", "certificates.json"],
        pytest.param(
            ["run", "--case", "pendulum_simple/default", "--suite", "quick", "--integrator", "long_motion:Compiled"],
            marks=pytest.mark.slow,
        ),
        ["ensemble", "--case", "pendulum_simple", "--integrator", "long_motion:Later", "--samples", "1000"],
        pytest.param(
            ["certify", "long_motion:Long", "long_motion:Longer", "--out", "certificates.json"], marks=pytest.mark.slow
        ),
    ],
    ids=["exact motion", "certify", "compilation", "ensemble", "certify in processes"],
)
def test_an_interruption_ends_long_work(arguments: list[str], tmp_path: Path) -> None:
    (tmp_path / "long_motion.py").write_text(MODULE)
    process = started(["-c", "from gnomon.harness.commands.cli import main; main()", *arguments], tmp_path)
    os.killpg(process.pid, signal.SIGINT)
    told = ended(process)
    assert process.returncode == 130
    assert "stopping ..." in told
    assert "Traceback" not in told


def test_an_interrupted_run_leaves_the_page_of_what_was_measured(tmp_path: Path) -> None:
    (tmp_path / "long_motion.py").write_text(STUCK)
    run = ["run", "--case", "pendulum_simple/default", "--suite", "quick", "--integrator", "long_motion:Stuck"]
    arguments = [*run, "--out", "results.sqlite", "--report", "page"]
    process = started(["-c", "from gnomon.harness.commands.cli import main; main()", *arguments], tmp_path)
    os.killpg(process.pid, signal.SIGINT)
    told = ended(process)
    assert process.returncode == 130
    assert "Traceback" not in told
    assert (tmp_path / "page" / "index.html").is_file(), told
    page = (tmp_path / "page" / "index.html").read_text()
    assert page.rstrip().endswith("</html>")
    measured = len(store.load(tmp_path / "results.sqlite"))
    planned = sum(one.trials for one in outstanding(tmp_path / "results.sqlite").planned)
    assert 0 < measured < planned
    warning = page.partition('<details class="warning"')[2].partition("</details>")[0]
    assert {str(planned - measured), str(planned)} <= set(numbers_in(warning))


def test_work_that_holds_an_interruption_back_is_ended_after_its_time(tmp_path: Path) -> None:
    process = started(["-c", SWALLOWED, "0.5"], tmp_path)
    os.kill(process.pid, signal.SIGINT)
    told = ended(process)
    assert process.returncode == 130
    assert "stopping ..." in told


def test_a_second_interruption_ends_at_once(tmp_path: Path) -> None:
    process = started(["-c", SWALLOWED, "1e6"], tmp_path)
    os.kill(process.pid, signal.SIGINT)
    until(process, "stopping ...")
    os.kill(process.pid, signal.SIGINT)
    ended(process)
    assert process.returncode == 130
