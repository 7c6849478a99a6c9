"""Results files made to harm a user who opens them: each gives one line and exit code 2, or is shown as plain text."""

import json
import os
import re
import shutil
import struct
import subprocess
import sys
import zlib
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pandas
import pytest
from changes import changing
from command_line import gnomon
from gnomon.harness.reporting.report import write_report
from gnomon.harness.results import export, reading, regression, schema, store
from page_parts import read_page

pytestmark = pytest.mark.usefixtures("no_hang")

Change = Callable[..., Path]
ESCAPE = "\x1b]0;owned\x07\x1b[31m"
DEEP = "[" * 100_000 + "]" * 100_000


ENDLESS = "WITH RECURSIVE n(run) AS (SELECT 1 UNION ALL SELECT run + 1 FROM n) SELECT run, 'cpu' AS name, 'x' AS value, 0 AS checksum"
STRUCTURES = {  # the words that name it, and the statements that make it
    "a view that refers to itself": (
        "the view trials", "DROP TABLE trials", "CREATE VIEW trials AS SELECT * FROM trials"
    ),
    "a view in place of a table": ("the view runs", "DROP TABLE runs", "CREATE VIEW runs AS SELECT * FROM planned"),
    "an endless view": (
        "the view environment", "DROP TABLE environment", f"CREATE VIEW environment AS {ENDLESS} FROM n"
    ),
    "a trigger": ("the trigger t", "CREATE TRIGGER t AFTER INSERT ON runs BEGIN DELETE FROM measurements; END"),
    "a generated column": (
        "table trials is not made",
        "ALTER TABLE trials ADD COLUMN more TEXT GENERATED ALWAYS AS (hex(zeroblob(100000000)))",
    ),
    "an index on an expression": ("the index slow", "CREATE INDEX slow ON trials (lower(title))"),
    "a virtual table": ("found", "CREATE VIRTUAL TABLE found USING fts5(text)"),
    "statistics that mislead the planner": ("sqlite_stat1", "ANALYZE"),
    "a missing table": ("settings_changed", "DROP TABLE settings_changed"),
    "a missing index": ("measured", "DROP INDEX measured"),
    "a name that steers a terminal": (r"\x1b]0;owned", f'CREATE TABLE "{ESCAPE}" (a)'),
    "an older schema's number": ("run it again", f"PRAGMA user_version = {schema.SCHEMA_VERSION - 1}"),
    "a newer schema's number": ("upgrade gnomon", f"PRAGMA user_version = {schema.SCHEMA_VERSION + 1}"),
    "a table of others": ("the table t, which gnomon does not make", "CREATE TABLE t (x)"),
    "another program's number": ("not one of gnomon's", "PRAGMA application_id = 0"),
}  # fmt: skip


@pytest.mark.parametrize("name", STRUCTURES)
def test_a_file_that_holds_more_or_less_than_ours_is_refused(
    change: Change, name: str, capfd: pytest.CaptureFixture[str]
) -> None:
    place, *statements = STRUCTURES[name]
    path = change(*statements)
    before = path.read_bytes()
    for arguments in (["export", path, "--out", path.with_suffix(".csv")], ["compare", path, path], ["report", path]):
        assert gnomon(*map(str, arguments)) == 2
        _one_line(capfd, str(path), place)
    with pytest.raises(ValueError, match=re.escape(place)):
        store.Store(path)
    assert path.read_bytes() == before
    assert not path.with_suffix(".csv").exists()


def _one_line(capfd: pytest.CaptureFixture[str], *parts: str) -> None:
    found = capfd.readouterr()
    (line,) = found.err.strip().splitlines()
    assert line.startswith("error: ")
    assert line.isprintable()
    assert all(part in line for part in parts), line
    assert found.out == ""


LONG = "long " * 200_000
SCHEMAS = {
    "a name": [f'CREATE TABLE "{LONG}" (a)'],
    "a name in an error of SQLite": [
        "PRAGMA writable_schema = ON",
        f"UPDATE sqlite_master SET name = '{LONG}', sql = 'nonsense' WHERE name = 'runs'",
    ],
}


@pytest.mark.parametrize("name", SCHEMAS)
def test_a_schema_of_any_length_makes_a_message_of_a_few_lines(
    change: Change, name: str, capfd: pytest.CaptureFixture[str]
) -> None:
    """A name of a million letters would fill the terminal, and hide the file and the way out."""
    path = change(*SCHEMAS[name])
    for arguments in (
        ["export", path],
        ["compare", path, path],
        ["merge", path, path, "--out", path.with_name("all.sqlite")],
    ):
        assert gnomon(*map(str, arguments)) == 2
        line = capfd.readouterr().err
        assert str(path) in line
        assert len(line) < 2000
    with pytest.raises(ValueError, match="damaged") as caught:
        store.load(path)
    assert len(str(caught.value)) < 1000


VALUES: dict[str, tuple[str, str, object]] = {
    "text for a number": ("measurements", "error_max", "far"),
    "null for a status": ("measurements", "status", b""),
    "an unknown status": ("measurements", "status", "passed"),
    "a number below zero": ("measurements", "seconds_median", -1.0),
    "a launch of no bound": ("measurements", "launch", 2**62),
    "a number that hangs": ("trials", "numbers", '{"theta": "1e100000000"}'),
    "a number with a point": ("trials", "numbers", '{"theta": "1_000"}'),
    "a fraction over zero": ("trials", "numbers", '{"theta": "1/0"}'),
    "too many digits": ("trials", "numbers", json.dumps({"theta": "9" * 100_000})),
    "numbers that are none": ("trials", "numbers", '{"theta": 1}'),
    "a list of numbers": ("trials", "numbers", "[]"),
    "deep numbers": ("trials", "numbers", DEEP),
    "broken numbers": ("trials", "numbers", "{"),
    "an infinite span": ("trials", "span", float("inf")),
    "a step of which no number of steps is finite": ("trials", "setting", 5e-324),
    "a time of which no ratio is finite": ("measurements", "seconds_median", 5e-324),
    "an error of no solution": ("measurements", "error_max", 1.7e308),
    "a text that is no text": ("trials", "title", b"\xff\xfe\x00"),
    "a dimension of no bound": ("sampled_states", "dimension", 2**40),
    "another integrator's library": ("trials", "library", "other"),
    "a row of no trial": ("measurements", "trial_key", "none"),
}


@pytest.mark.parametrize("name", VALUES)
def test_a_value_that_its_column_does_not_hold_is_named(change: Change, name: str) -> None:
    table, column, value = VALUES[name]
    row = f"(SELECT max(rowid) FROM {table} WHERE {column} IS NOT NULL)"
    path = change((f"UPDATE {table} SET {column} = ? WHERE rowid = {row}", (value,)), seal=tuple(schema.TABLES))
    with pytest.raises(ValueError, match=rf"{path}: damaged \(table {table}, row \d+: ") as caught:
        store.states(path) if table == "sampled_states" else store.load(path)
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 500
    with pytest.raises(ValueError, match=f"table {table}, row"):
        store.Store(path)


QUICK = ("setting", "error_max", "seconds_median")
"""Columns that `make test` fills; the others are slow together."""
REALS = [
    pytest.param(table, name, marks=() if name in QUICK else pytest.mark.slow)
    for table in ("trials", "measurements")
    for name, kind in schema.TABLES[table].items()
    if kind.startswith("REAL")
]


@pytest.mark.parametrize(
    "value", [1.7e308, 5e-324, *(pytest.param(x, marks=pytest.mark.slow) for x in (1e149, 1e-149))]
)
@pytest.mark.parametrize(("table", "column"), REALS)
def test_a_number_of_any_size_is_shown_or_named(
    change: Change, results: Path, tmp_path: Path, table: str, column: str, value: float
) -> None:
    """Never an error of arithmetic, which would name no file: such sizes overflow in a ratio or a square."""
    base = Path(shutil.copy(results, tmp_path / "base.sqlite"))
    path = change(f"UPDATE {table} SET {column} = {value!r} WHERE {column} IS NOT NULL", seal=tuple(schema.TABLES))
    try:
        store.load(path)
    except ValueError as error:
        told = str(error)
    else:
        write_report(path, tmp_path / "report", figures=False)
        for pair in ((base, path), (path, base)):
            with suppress(ValueError):  # other settings, or another span, have nothing in common
                regression.compare(*map(reading.rows, pair))
        return
    assert told.startswith(f"{path}: damaged (table {table}, row ")


@pytest.mark.parametrize(
    ("states", "said"),
    [
        (zlib.compress(bytes(64 * 8)), "no 64 states"),
        (None, "no 64 states"),
        (b"not compressed", "incorrect header"),
        (zlib.compress(bytes(64 * 2 * 8))[:-4], "no 64 states"),
        (b"", "no 64 states"),
    ],
    ids=["short", "a gigabyte", "no stream", "cut", "none"],
)
def test_states_that_are_none_are_refused(change: Change, states: bytes | None, said: str) -> None:
    if states is None:  # a gigabyte in a megabyte, which takes seconds to make: not while tests are collected
        states = zlib.compress(bytes(1 << 30), 9)
    path = change(("UPDATE sampled_states SET states = ?, dimension = 2", (states,)), seal=("sampled_states",))
    with pytest.raises(ValueError, match=rf"table sampled_states, row \d+: .*{said}"):
        store.states(path)


def test_a_text_of_no_bound_is_refused_with_its_row(change: Change) -> None:
    path = change("UPDATE trials SET title = hex(zeroblob(10000000)) WHERE rowid = 3")
    with pytest.raises(ValueError, match="table trials, row 3: more than 16777216 bytes"):
        store.load(path)


@pytest.mark.parametrize("kind", ["text", "empty", "folder", "header", "pipe", "absent", "loop"])
def test_what_is_no_database_is_named(
    tmp_path: Path, kind: str, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "theirs"
    if kind == "text":
        path.write_text("SQLite" * 1000)
    elif kind == "empty":
        path.touch()
    elif kind == "folder":
        (path / "results.sqlite").mkdir(parents=True)
    elif kind == "header":
        path.write_bytes(b"SQLite format 3\0" + bytes(4080))
    elif kind == "pipe":
        os.mkfifo(path)
    elif kind == "loop":
        path.symlink_to(path)
    monkeypatch.chdir(tmp_path)
    for arguments in (["export", path], ["compare", path, path], ["report", path]):
        assert gnomon(*map(str, arguments)) == 2
        _one_line(capfd, str(path), "an empty file" if kind == "empty" else "")
    if kind in ("text", "header"):
        with pytest.raises(ValueError, match=str(path)):
            store.Store(path)


def test_a_journal_that_names_another_file_deletes_nothing(results: Path) -> None:
    """SQLite deletes the file that a journal names after rolling the journal back."""
    victim = results.with_name("thesis.txt")
    victim.write_text("mine")
    magic = bytes.fromhex("d9d505f920a163d7")
    name = str(victim).encode()
    head = (magic + struct.pack(">IIIII", 0, 1, results.stat().st_size // 4096, 512, 4096)).ljust(512, b"\0")
    end = struct.pack(">II", len(name), sum(name)) + magic
    journal = results.with_name(results.name + "-journal")
    journal.write_bytes(head + struct.pack(">I", (1 << 30) // 4096 + 1) + name + end)
    for use in (store.load, store.Store):
        with pytest.raises(ValueError, match="journal"):
            use(results)
        assert victim.read_text() == "mine"
    shutil.copy(journal, results.with_name("other-journal"))
    with changing(
        shutil.copy(results, results.with_name("other"))
    ) as db:  # shows that the attack works on SQLite alone
        db.execute("SELECT count(*) FROM runs").fetchone()
    assert not victim.exists()


def test_a_first_write_that_was_killed_is_taken_back(tmp_path: Path) -> None:
    """Killed between the journal and the tables: the file is empty again, and can be used."""
    path = tmp_path / "results.sqlite"
    with changing(path) as db:
        db.execute("PRAGMA cache_size = 1")
        db.execute("PRAGMA cache_spill = 1")
        db.execute("BEGIN")
        db.execute("CREATE TABLE trials (a)")
        db.executemany("INSERT INTO trials VALUES (?)", [("x" * 4000,)] * 100)
        for name in ("results.sqlite", "results.sqlite-journal"):
            shutil.copy(tmp_path / name, tmp_path / f"killed{name.removeprefix('results')}")
    killed = tmp_path / "killed.sqlite"
    assert killed.stat().st_size
    with pytest.raises(ValueError, match="was interrupted"):
        store.load(killed)
    with store.Store(killed) as opened:
        opened.begin_run("quick", "", {})
    assert len(store.runs(killed)) == 1


SHOWN = f"{ESCAPE}<script>alert(1)</script>=1+1|`[x](http://e.vil)*\u202e\n# x"


@pytest.mark.parametrize("figures", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_names_are_shown_as_the_text_that_they_are(
    figures: bool, change: Change, tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """In the terminal, the page, the summary and a spreadsheet: nothing in a name is a command, a tag or a formula."""
    columns = ("title", "section", "stresses", "case", "integrator_id", "library", "sampling", "machine")
    changes = [(f'UPDATE trials SET "{name}" = ? || "{name}"', (SHOWN,)) for name in columns]
    other = {"measurements": ("reason", "output"), "runs": ("suite", "command"), "environment": ("value",)}
    changes += [(f"UPDATE {table} SET {name} = ?", (SHOWN,)) for table, names in other.items() for name in names]
    path = change(*changes, seal=tuple(schema.TABLES))
    to = tmp_path / "report"
    page = write_report(path, to, figures=figures)
    summary = (to / "summary.md").read_text(encoding="utf-8")
    for text in (read_page(page).partition("<body")[2], summary):
        assert "<script>alert" not in text
        assert not re.search(r"[\x00-\x08\x0b-\x1f\u202e]", text)
    assert not re.search(r"(?<!\\)\](?=\()|^# x", summary, re.MULTILINE)
    tables = [len(re.findall(r"(?<!\\)\|", line)) for line in summary.splitlines() if line.startswith("|")]
    assert set(tables) == {6}
    inside = {found for found in tmp_path.rglob("*") if found.is_file() and path.name not in found.name}
    assert all(to in found.parents for found in inside)
    assert gnomon("compare", str(path), str(path)) == 0
    assert "\x1b" not in "".join(capfd.readouterr())
    table = tmp_path / "table.csv"
    assert gnomon("export", str(path), "--out", str(table)) == 0
    assert "\x1b" not in table.read_text()


@pytest.mark.parametrize("start", ["=", "+", "-", "@", "\t", "\r", "\uff1d"])
def test_a_csv_starts_no_formula_and_keeps_its_numbers(change: Change, tmp_path: Path, start: str) -> None:
    formula = ("UPDATE measurements SET reason = ?", (f"{start}cmd|' /C calc'!A0",))
    path = change(formula, "UPDATE trials SET title = '-1.5e-3', stresses = 'a=b'", seal=("measurements", "trials"))
    target = tmp_path / "table.csv"
    export.export(path, target, "csv")
    found, expected = pandas.read_csv(target), store.load(path)
    assert found["reason"].str.match(r"['\\]").all()
    assert set(found["title"]) == {-0.0015}
    assert set(found["stresses"]) == {"a=b"}
    assert list(found["setting"].dropna()) == pytest.approx(list(expected["setting"].dropna()), rel=4e-16)
    export.export(path, target, "csv", raw=True)
    assert list(pandas.read_csv(target)["reason"]) == list(expected["reason"])


READ = """
import sys
from gnomon.harness.results import store
frame = store.load(sys.argv[1])
print(len(frame), len(store.states(sys.argv[1])), len(store.runs(sys.argv[1])))
"""


def _namespaces() -> bool:
    command = ["sh", "-c", "unshare -rm true"]
    return subprocess.run(command, capture_output=True, check=False).returncode == 0


@pytest.mark.skipif(not _namespaces(), reason="needs util-linux's `unshare`, and leave to make a namespace of mounts")
@pytest.mark.parametrize(
    "beside",
    [(), ("-wal",), pytest.param(("-wal", "-shm"), marks=pytest.mark.slow)],
    ids=["alone", "with its log", "with both"],
)
def test_results_on_a_medium_that_cannot_be_written_are_read(
    results: Path, tmp_path: Path, beside: tuple[str, ...]
) -> None:
    """The folder is mounted read-only in a separate namespace. Rows in the write-ahead log are read too."""
    medium = tmp_path / "medium"
    medium.mkdir()
    rows, states = len(store.load(results)), len(store.states(results))
    with changing(results) as db:
        db.execute("PRAGMA wal_autocheckpoint = 0")
        db.execute("INSERT INTO runs (run, started, suite) VALUES (9, 'now', 'late')")
        schema.with_checksums(db)
        schema.seal_all(db, "runs")
        for ending in ("", *beside):
            shutil.copy(f"{results}{ending}", medium / f"it#1{ending}")
    script = 'mount --bind "$1" "$1" && mount -o remount,ro,bind "$1" && ! touch "$1/x" 2>/dev/null && exec "$2" -c "$3" "$1/it#1"'
    told = subprocess.run(
        ["unshare", "-rm", "sh", "-c", script, "sh", medium, sys.executable, READ],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert told.stdout.split() == [str(rows), str(states), "2" if beside else "1"], told.stderr
    assert {found.name for found in medium.iterdir()} == {f"it#1{ending}" for ending in ("", *beside)}
