"""Results of a small real run, for tests that change them; a time limit for calls that could hang."""

import shutil
import signal
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType

import pytest
from gnomon.harness.registry import lookup, selection
from gnomon.harness.running import plan
from gnomon.harness.running.planned_run import run

sys.path.insert(0, str(Path(__file__).parent))

from changes import changing
from waiting import LONG_SECONDS

HANG_SECONDS = 120
"""A busy machine takes ten times as long as a quiet one, and still less than this."""


class HangError(BaseException):
    """Raised when a call takes longer than HANG_SECONDS; a BaseException, so that no handler under test catches it."""


@pytest.fixture
def no_hang() -> Iterator[None]:
    def stop(_number: int, _frame: FrameType | None) -> None:
        raise HangError

    before = signal.signal(signal.SIGALRM, stop)
    signal.alarm(HANG_SECONDS)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


@pytest.fixture(scope="session")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The results of a small run, all in one file."""
    suite = plan.suite("quick").change(block_seconds=0.001, repeats=3).within(LONG_SECONDS)
    integrators = [found for name in ("gnomon:RK4", "scipy:RK45") for found in lookup.find(name)]
    chosen = selection.choose(["pendulum_simple", "pendulum_simple/rotation", "bouncing_ball"], False)
    path = run(tmp_path_factory.mktemp("measured") / "results.sqlite", suite, chosen, integrators)
    with changing(path) as db:
        db.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    return path


@pytest.fixture
def results(measured: Path, tmp_path: Path) -> Path:
    """A copy of the measured results that a test may change."""
    return Path(shutil.copy(measured, tmp_path / "theirs.sqlite"))


@pytest.fixture
def change(results: Path) -> Callable[..., Path]:
    """Execute statements in the copy and write valid checksums for the tables in `seal`, as its author could."""
    from gnomon.harness.results import schema

    def changed(*statements: str | tuple[str, tuple[object, ...]], seal: tuple[str, ...] = ()) -> Path:
        with changing(results) as db:
            for statement in statements:
                text, values = statement if isinstance(statement, tuple) else (statement, ())
                db.execute(text, values)
            schema.with_checksums(db)
            for table in seal:
                schema.seal_all(db, table)
        return results

    return changed
