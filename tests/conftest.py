"""Settings shared by all tests; makes modules of `helpers/` and `detection/` importable by tests and their processes."""

import gc
import os
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, settings

# Before numpy is imported, here and in all processes of the tests: two threads that share one small matrix take 100 times
# the processor time of one, more on a busy machine.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

for name in ("COLUMNS", "LINES"):  # readline, which pytest imports, sets them for all processes that it starts
    os.environ.pop(name, None)
    os.unsetenv(name)

collect_ignore = ["example_project"]
"""A user's project with tests of its own, which test_example_project.py runs."""
sys.path[:0] = [
    str(Path(__file__).parent / folder)
    for folder in (
        "helpers",
        "helpers/forms",
        "helpers/published",
        "helpers/pages",
        "helpers/plugins",
        "detection",
    )
]

# The default profile draws the same few examples every time, HYPOTHESIS_PROFILE=wide (`make test-all`) twice as many,
# HYPOTHESIS_PROFILE=thorough new ones, and many.
# Health checks for time and rejected draws are off: exact motions are slow, and rules of domains reject draws.
_EXPECTED = [HealthCheck.too_slow, HealthCheck.filter_too_much]
for name, count in (("repeatable", 8), ("wide", 15)):
    settings.register_profile(
        name, max_examples=count, deadline=None, derandomize=True, suppress_health_check=_EXPECTED
    )
settings.register_profile("thorough", max_examples=200, deadline=None, suppress_health_check=_EXPECTED)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))


def pytest_configure(config: pytest.Config) -> None:
    """The last line of a long run names the files that take most processor time; CONTRIBUTING.md has them."""
    from processor_time import ProcessorTime  # after the path is extended

    config.pluginmanager.register(ProcessorTime())


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Iterator[None]:
    """All that is imported and collected lives until the end: the garbage collector visits it neither now nor in a test."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.enable()
        gc.collect()
        gc.freeze()


@pytest.fixture
def singly(monkeypatch: pytest.MonkeyPatch) -> list[float]:
    """Collects the times at which a motion is computed without a table."""
    from gnomon.reference.numerics.motion import Motion  # not at the head: mutations are imported after this file

    asked: list[float] = []
    original = Motion.sample_each

    def counting(self, times):
        asked.extend(times)
        return original(self, times)

    monkeypatch.setattr(Motion, "sample_each", counting)
    return asked


@pytest.fixture
def clock() -> Iterator[Any]:
    """The clock of the supervisor, which turns only while an integrator passes time."""
    from turned_clock import turned_clock

    with turned_clock() as turned:
        yield turned


@pytest.fixture
def unhurried() -> Iterator[None]:
    """The solutions of a verification take no time: a slow machine leaves out no setting, and ends no claim."""
    from gnomon.harness.measuring import trials
    from gnomon.harness.system import supervisor

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(trials, "_clock", lambda: 0.0)
        patch.setattr(supervisor, "processor_time", lambda _process: 0.0)
        yield
