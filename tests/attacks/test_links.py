"""A results file with several names: a run through a symbolic or a hard link is a run into the same file."""

import os
import sqlite3
import subprocess
import sys
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest
from gnomon.harness.reporting import up_to_date
from gnomon.harness.results import store

SYMBOLIC, HARD = "symbolic", "hard"
KINDS = [
    SYMBOLIC,
    pytest.param(HARD, marks=pytest.mark.skipif(sys.platform != "linux", reason="needs locks of Linux")),
]


def linked(file: Path, link: Path, kind: str) -> None:
    if kind == HARD:
        os.link(file, link)
    else:
        link.symlink_to(file)


def in_child(call: Callable[[], None]) -> str:
    """The exception that a forked child raises in a call, as text; "" if the call returns."""
    hears, tells = os.pipe()
    child = os.fork()
    if child == 0:
        try:
            call()
        except BaseException as error:
            os.write(tells, f"{type(error).__name__}: {error}".encode())
        os._exit(0)
    os.close(tells)
    with open(hears) as said:
        text = said.read()
    os.waitpid(child, 0)
    return text


TAKES_THE_LOG = """
import sqlite3, sys
sqlite3.connect(sys.argv[1], timeout=0).execute("PRAGMA journal_mode = DELETE")
"""
"""Another program that needs the file for itself alone. It is started, not forked: SQLite's own record of the locks of a
process would be forked too."""


def without_the_log(file: Path) -> str:
    """The error stream of the other program."""
    command = [sys.executable, "-c", TAKES_THE_LOG, str(file)]
    return subprocess.run(command, capture_output=True, text=True, check=False).stderr


def open_store(path: Path) -> None:
    store.Store(path).close()


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("elsewhere", [False, True], ids=["same folder", "another folder"])
def test_two_names_of_a_file_are_one_lock(kind: str, elsewhere: bool, tmp_path: Path) -> None:
    """Both runs did all trials, and with hard links each wrote a log of its own into one file."""
    file, folder = tmp_path / "results.sqlite", tmp_path / ("other" if elsewhere else ".")
    folder.mkdir(exist_ok=True)
    open_store(file)
    link = folder / "link.sqlite"
    linked(file, link, kind)
    for first, second in ((file, link), (link, file)):
        with store.Store(first):
            assert "in use by another run" in in_child(lambda second=second: open_store(second)), "another process"
            with pytest.raises(ValueError, match="in use by another run"):
                store.Store(second)  # the same process
        assert in_child(lambda second=second: open_store(second)) == "", "the lock ends with the first run"
    assert sorted(path.name for path in tmp_path.rglob("*.sqlite*")) == ["link.sqlite", "results.sqlite"]


def test_a_link_to_a_file_that_is_not_there_yet_is_the_same_lock(tmp_path: Path) -> None:
    link = tmp_path / "link.sqlite"
    link.symlink_to(tmp_path / "results.sqlite")
    with store.Store(link):
        assert "in use by another run" in in_child(lambda: open_store(tmp_path / "results.sqlite"))
    assert link.is_symlink()


def test_a_new_file_can_be_read_by_whoever_could_read_one_of_sqlite(tmp_path: Path) -> None:
    """The lock makes the file: its mode is the one that SQLite gives."""
    open_store(tmp_path / "results.sqlite")
    with closing(sqlite3.connect(tmp_path / "other.sqlite")) as db:
        db.execute("CREATE TABLE a (b)")
    modes = {path.stat().st_mode for path in (tmp_path / "results.sqlite", tmp_path / "other.sqlite")}
    assert len(modes) == 1


@pytest.mark.parametrize("kind", KINDS)
def test_a_run_that_was_refused_leaves_the_locks_of_sqlite_to_the_first(kind: str, tmp_path: Path) -> None:
    """POSIX ends all locks of a process on a file when it closes any descriptor of the file: another program could then
    take the log of a run away, with its last records."""
    file, link = tmp_path / "results.sqlite", tmp_path / "link.sqlite"
    open_store(file)
    linked(file, link, kind)

    with store.Store(file):
        assert "locked" in without_the_log(file), "SQLite's lock is held"
        with pytest.raises(ValueError, match="in use by another run"):
            store.Store(link)
        assert "locked" in without_the_log(file)


def test_a_first_write_that_was_cut_off_is_rolled_back_through_a_symbolic_link(tmp_path: Path) -> None:
    """The journal is beside the file that the link names."""
    file, link = tmp_path / "results.sqlite", tmp_path / "links" / "link.sqlite"
    link.parent.mkdir()
    link.symlink_to(file)

    def cut_off() -> None:
        db = sqlite3.connect(file)
        db.execute("PRAGMA cache_size = 1")
        db.execute("BEGIN")
        db.execute("CREATE TABLE a (b)")
        db.executemany("INSERT INTO a VALUES (?)", [("x" * 1000,)] * 100)  # more than the cache: it is written
        os._exit(0)

    in_child(cut_off)
    assert file.stat().st_size
    assert file.with_name("results.sqlite-journal").stat().st_size
    open_store(link)
    with store.Store(file) as results:
        assert results.history() == {}


def test_the_page_of_a_run_leaves_the_locks_of_sqlite_to_the_run(tmp_path: Path) -> None:
    """It reads the file in the process of the run, to know whether the page is up to date."""
    file, link = tmp_path / "results.sqlite", tmp_path / "link.sqlite"
    link.symlink_to(file)
    with store.Store(file) as results:
        results.begin_run("quick", "gnomon run", {})
        assert "locked" in without_the_log(file)
        for _ in range(2):
            first = up_to_date.key_of(link, ())
        assert "locked" in without_the_log(file)
        results.begin_run("quick", "gnomon run", {})
        assert up_to_date.key_of(link, ()) != first, "later records are in the log beside the file"
