"""A damaged results file gives the numbers that were written, or one line that names the file, but no other numbers."""

import random
import shutil
import sqlite3
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pandas
import pytest
from changes import changing
from gnomon.harness.results import schema, store

pytestmark = pytest.mark.usefixtures("no_hang")

EACH, ORDINARY = 200, 20
Chance = random.Random


def flipped(path: Path, chance: Chance) -> None:
    """Up to four bytes with a bit changed."""
    content = bytearray(path.read_bytes())
    for _ in range(chance.choice((1, 1, 2, 4))):
        content[chance.randrange(len(content))] ^= 1 << chance.randrange(8)
    path.write_bytes(content)


def truncated(path: Path, chance: Chance) -> None:
    size = path.stat().st_size
    with path.open("r+b") as file:
        file.truncate(chance.choice((chance.randrange(1, size), size // _page(path) // 2 * _page(path), 100, 16, 1)))


def zeroed(path: Path, chance: Chance) -> None:
    content, size = bytearray(path.read_bytes()), _page(path)
    start = chance.randrange(len(content) // size) * size
    content[start : start + size] = bytes(size)
    path.write_bytes(content)


def swapped(path: Path, chance: Chance) -> None:
    content, size = path.read_bytes(), _page(path)
    pages = [content[k : k + size] for k in range(0, len(content), size)]
    a, b = chance.sample(range(1, len(pages)), 2)
    pages[a], pages[b] = pages[b], pages[a]
    path.write_bytes(b"".join(pages))


def changed(path: Path, chance: Chance) -> None:
    """A cell with another value of its type."""
    with changing(path) as db:
        table, name, row, value = _cell(db, chance)
        if isinstance(value, str | bytes):
            other: Any = value + (b" " if isinstance(value, bytes) else " ")
        else:
            other = 1 if value is None else -value or 1
        _update(db, table, name, row, other)


def mistyped(path: Path, chance: Chance) -> None:
    """A cell with a value of another type, in a row whose checksum is made to fit."""
    wrong: dict[str, list[Any]] = {
        "TEXT": [b"\xff\xfe", b""],
        "INTEGER": ["text", 0.5, b"1", -(2**63)],
        "REAL": ["text", b"\0", "nan"],
        "BLOB": ["text", None, 7],
    }
    with changing(path) as db:
        schema.with_checksums(db)
        table, name, row, _ = _cell(db, chance)
        _update(db, table, name, row, chance.choice(wrong[schema.TABLES[table][name].split()[0]]))
        schema.seal_all(db, table)


def without_column(path: Path, chance: Chance) -> None:
    table, name = chance.choice([(table, name) for table, names in schema.TABLES.items() for name in names])
    with changing(path) as db:
        try:
            db.execute(f'ALTER TABLE {table} DROP COLUMN "{name}"')
        except sqlite3.OperationalError:  # of a key, or in an index
            db.execute(f'ALTER TABLE {table} RENAME COLUMN "{name}" TO other')


KINDS = (flipped, truncated, zeroed, swapped, changed, mistyped, without_column)
NEVER_RIGHT = (mistyped, without_column)


def _page(path: Path) -> int:
    size = int.from_bytes(path.read_bytes()[16:18], "big")
    return 65536 if size == 1 else size


def _cell(db: sqlite3.Connection, chance: Chance) -> tuple[str, str, int, Any]:
    """Any cell of a table that has rows: table, column, row, value."""
    filled = [table for table in schema.TABLES if db.execute(f"SELECT 1 FROM {table}").fetchone()]
    table = chance.choice(filled)
    name = chance.choice(list(schema.TABLES[table]))
    return table, name, *chance.choice(db.execute(f'SELECT rowid, "{name}" FROM {table}').fetchall())


def _update(db: sqlite3.Connection, table: str, name: str, row: int, value: Any) -> None:
    try:
        db.execute(f'UPDATE {table} SET "{name}" = ? WHERE rowid = ?', (value, row))
    except sqlite3.Error:  # a key that is there already, null where none may be: another cell of the table
        spare = next(name for name, kind in schema.TABLES[table].items() if "KEY" not in kind and name != "run")
        db.execute(f"UPDATE {table} SET {spare} = ? WHERE rowid = ?", (b"\0" if spare != "states" else "text", row))


def read(path: Path) -> tuple[Any, dict[int, bytes], list[dict[str, Any]]]:
    states = {number: array.tobytes() for number, array in store.states(path).items()}
    return store.load(path), states, store.runs(path)


@pytest.fixture(scope="module")
def expected(measured: Path) -> Any:
    found = read(measured)
    assert set(found[0]["status"]) >= {"ok"}
    assert found[1]
    return found


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    "seeds", [range(ORDINARY), pytest.param(range(ORDINARY, EACH), marks=pytest.mark.slow)], ids=["a tenth", "the rest"]
)
def test_a_damaged_file_gives_what_was_written_or_one_line(
    measured: Path, expected: Any, tmp_path: Path, kind: Callable[[Path, Chance], None], seeds: range
) -> None:
    lines: list[str] = []
    for seed in seeds:
        path = Path(shutil.copy(measured, tmp_path / f"{seed}.sqlite"))
        kind(path, random.Random(f"{kind.__name__} {seed}"))
        try:
            found = read(path)
        except ValueError as error:
            lines.append(str(error))
        else:
            pandas.testing.assert_frame_equal(found[0], expected[0], check_exact=True, obj=f"seed {seed}")
            assert found[1:] == expected[1:], f"seed {seed}"
        path.unlink()
    assert [line for line in lines if not (line.startswith(f"{tmp_path}/") and line.isprintable())] == []
    assert len(lines) >= (len(seeds) if kind in NEVER_RIGHT else len(seeds) // 4)
    assert {found.name for found in tmp_path.iterdir()} <= {
        f"{seed}.sqlite{end}" for seed in seeds for end in ("-wal", "-shm")
    }
