"""Opens a results file to read it. What others made is data: nothing in it is believed before it was checked.

Only the tables and the index of `schema` may be there: a view in place of a table, a trigger or a generated column
would run what its author wrote. Then all pages are checked, and the tables that are read row by row: each row against
its checksum, each value against what its column holds (`values`), each reference.
"""

from __future__ import annotations

import re
import shutil
import sqlite3
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from gnomon.harness.results import schema, values
from gnomon.harness.results.schema import APPLICATION_ID, OLDEST_VERSION, SCHEMA_VERSION, Damaged
from gnomon.harness.results.visible import visible

MOST_BYTES = 1 << 24
"""A row with a longer text or blob is refused: sampled states take some kilobytes."""
CANNOT_OPEN, READ_ONLY = 14, 8
"""SQLite's codes where a file in WAL mode lies in a folder that cannot be written."""
_NAMES_ANOTHER = bytes.fromhex("d9d505f920a163d7")
"""Ends a rollback journal that names a further file, which SQLite would delete after the rollback."""


def results_file(path: str | Path) -> Path:
    """The results file itself, or the `results.sqlite` in a folder; ValueError where there is none."""
    path = Path(path)
    found = path / "results.sqlite" if path.is_dir() else path
    if not found.is_file():
        raise ValueError(f"{path}: no results here; give a results.sqlite that `gnomon run` wrote, or its folder")
    if found.stat().st_size == 0:
        raise ValueError(f"{found}: an empty file; give a results.sqlite that `gnomon run` wrote")
    return found


@contextmanager
def reading(path: str | Path, tables: Iterable[str]) -> Iterator[sqlite3.Connection]:
    """A connection that reads one state of a results file, its `tables` checked.

    Raises ValueError, which names the file and, of damage, the table and the row. Nothing is written beside the file
    where its folder cannot be written.
    """
    found = results_file(path)
    try:
        with ExitStack() as stack:
            db = _connect(found, stack)
            _check_kind(db, found)
            check(db, tables)
            yield db
    except Damaged as error:
        raise ValueError(
            f"{found}: damaged ({error}); restore it from a copy, or run it again into another file"
        ) from None
    except (sqlite3.Error, UnicodeDecodeError) as error:
        told = visible(str(error))
        if str(error).startswith("file is not a database"):
            raise ValueError(f"{found}: not a readable results file of gnomon ({told})") from None
        raise ValueError(f"{found}: damaged ({told}); run it again into another file") from None


def check(db: sqlite3.Connection, tables: Iterable[str]) -> None:
    """Raise Damaged, which names the place, unless the file is made as ours are and the tables are sound."""
    _check_made(db)
    # Of the whole file: a page that took the place of a table's first one shows only in those that are used by none.
    ((told,),) = db.execute("PRAGMA integrity_check(1)")
    if told != "ok":
        raise Damaged(" ".join(visible(told, lines=True).replace("*** in database main ***", "").split()))
    for table in tables:
        try:
            schema.verify(db, table)
            values.verify(db, table)
        except sqlite3.DataError:
            raise Damaged(f"table {table}, row {_too_long(db, table)}: more than {MOST_BYTES} bytes") from None
        lost = db.execute(f"PRAGMA foreign_key_check({table})").fetchone()
        if lost is not None:
            raise Damaged(f"table {table}, row {lost[1]}: it belongs to a row of {lost[2]} that is not there")


def recover(path: Path) -> None:
    """Take back a first write that was broken off, if one was, so that the file can be used again.

    Raises ValueError for a journal that names a further file: none of ours does, and SQLite would delete that file.
    """
    journal = path.with_name(path.name + "-journal")
    if not journal.is_file() or journal.stat().st_size == 0 or not path.is_file():
        return
    with journal.open("rb") as file:
        file.seek(-min(len(_NAMES_ANOTHER), journal.stat().st_size), 2)
        if file.read() == _NAMES_ANOTHER:
            raise ValueError(f"{journal}: names another file, as no journal of gnomon's does; remove it")
    db = sqlite3.connect(path, timeout=30)
    try:
        db.execute("SELECT count(*) FROM sqlite_master").fetchone()
    except (sqlite3.Error, UnicodeDecodeError) as error:
        raise ValueError(f"{path}: a write into it was broken off ({visible(str(error))}); remove both files") from None
    finally:
        db.close()


def _connect(path: Path, stack: ExitStack) -> sqlite3.Connection:
    """A connection within one reading transaction.

    In WAL mode SQLite makes files beside the one it reads. Where it cannot, and no write is left in such a file, nobody
    writes here: the file itself is all that there is. Else both are copied.
    """
    try:
        return _begun(path, "mode=ro", stack)
    except sqlite3.OperationalError as error:
        if error.sqlite_errorcode & 0xFF not in (CANNOT_OPEN, READ_ONLY):
            raise
    path = path.resolve()
    log, journal = (path.with_name(path.name + ending) for ending in ("-wal", "-journal"))
    if journal.exists() and journal.stat().st_size:
        raise Damaged(f"a write into it was broken off, {journal.name} lies beside it")
    if not log.exists() or log.stat().st_size == 0:
        return _begun(path, "mode=ro&immutable=1", stack)
    folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="gnomon-")))
    for source in (path, log):
        shutil.copyfile(source, folder / source.name)
    return _begun(folder / path.name, "mode=ro", stack)


def _begun(path: Path, how: str, stack: ExitStack) -> sqlite3.Connection:
    db = schema.with_checksums(sqlite3.connect(f"{path.resolve().as_uri()}?{how}", uri=True, timeout=30))
    try:
        db.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MOST_BYTES)
        for setting in ("trusted_schema = OFF", "cell_size_check = ON", "query_only = ON"):
            db.execute(f"PRAGMA {setting}")
        db.execute("BEGIN")
        schema.version(db)
        db.execute("SELECT count(*) FROM sqlite_master").fetchone()
    except BaseException:
        db.close()
        raise
    stack.callback(db.close)
    return db


def _check_kind(db: sqlite3.Connection, path: Path) -> None:
    """Raise ValueError unless it is a results file of this schema or an older one that is still read."""
    ((application,),) = db.execute("PRAGMA application_id")
    version = schema.version(db)
    if application != APPLICATION_ID:
        raise ValueError(
            f"{path}: an SQLite file, but not one of gnomon's; give a results.sqlite that `gnomon run` wrote"
        )
    if not OLDEST_VERSION <= version <= SCHEMA_VERSION:
        raise ValueError(
            f"{path}: written with schema {version}, this gnomon reads schemas {OLDEST_VERSION} to {SCHEMA_VERSION};"
            f" {'upgrade gnomon' if version > SCHEMA_VERSION else 'run it again'}"
        )


def _check_made(db: sqlite3.Connection) -> None:
    """Raise Damaged unless the file holds the tables and the index of its schema, and nothing else."""
    expected = {(kind, name): _plain(sql) for kind, name, sql in schema.made(schema.version(db))}
    for kind, name, table, sql in db.execute("SELECT type, name, tbl_name, sql FROM sqlite_master").fetchall():
        if kind == "index" and sql is None and table in schema.TABLES:
            continue  # of a primary key
        told = f"{visible(str(kind))} {visible(str(name))}"
        if (kind, name) not in expected:
            raise Damaged(f"it holds the {told}, which gnomon does not make")
        if _plain(str(sql)) != expected.pop((kind, name)):
            raise Damaged(f"the {told} is not made as gnomon makes it")
    for kind, name in expected:
        raise Damaged(f"no such {kind}: {name}")


def _plain(sql: str) -> str:
    """A statement without what makes no difference: quotes around names, spaces and new lines."""
    return re.sub(r"\s*([(),])\s*", r"\1", " ".join(sql.replace('"', "").split()))


def _too_long(db: sqlite3.Connection, table: str) -> int | None:
    """The first row that cannot be read for its length."""
    for (row,) in db.execute(f"SELECT rowid FROM {table}").fetchall():
        try:
            db.execute(f"SELECT * FROM {table} WHERE rowid = ?", (row,)).fetchone()
        except sqlite3.DataError:
            return int(row)
    return None
