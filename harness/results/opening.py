"""Opens a results file to read it. The file may come from somebody else: all of it is verified before it is used.

Only the tables and the index of `schema` may be in the file: a view in place of a table, a trigger or a generated
column would execute SQL of its author. Then all pages are verified, and each row of the tables that are read: the row
against its checksum, each value against the values that its column allows (`values`), each reference.
"""

import re
import shutil
import sqlite3
import tempfile
from collections.abc import Iterable, Iterator
from contextlib import ExitStack, contextmanager
from contextvars import ContextVar
from pathlib import Path

from gnomon.harness.results import schema, values
from gnomon.harness.results.schema import APPLICATION_ID, SCHEMA_VERSION, Damaged
from gnomon.harness.results.visible import shorten, visible

MOST_BYTES = 1 << 24
"""A row with a longer text or blob is refused: sampled states take some kilobytes."""
CANNOT_OPEN, READ_ONLY = 14, 8
"""SQLite's error codes for a file in WAL mode in a folder without permission to write."""
_NAMES_ANOTHER = bytes.fromhex("d9d505f920a163d7")
"""The last bytes of a rollback journal that names another file, which SQLite would delete after the rollback."""

_held: ContextVar[tuple[Path, sqlite3.Connection] | None] = ContextVar("_held", default=None)
"""The file of `one_state` and its connection."""


def results_file(path: str | Path) -> Path:
    """The results file itself, or the `results.sqlite` in a folder; raises ValueError without one."""
    path = Path(path)
    file = path / "results.sqlite" if path.is_dir() else path
    if not file.is_file():
        raise ValueError(f"{path}: no results here; give a results.sqlite that `gnomon run` wrote, or its folder")
    if file.stat().st_size == 0:
        raise ValueError(f"{file}: an empty file; give a results.sqlite that `gnomon run` wrote")
    return file


@contextmanager
def reading(path: str | Path, tables: Iterable[str]) -> Iterator[sqlite3.Connection]:
    """A connection that reads one state of a results file, after its `tables` are verified.

    Raises ValueError, which names the file and, for damage, the table and the row. Works also in a folder without
    permission to write.
    """
    file, held = results_file(path), _held.get()
    if held is not None and held[0] == file.resolve():
        yield held[1]  # all tables are verified
        return
    try:
        with ExitStack() as stack:
            db = _connect(file, stack)
            _verify_kind(db, file)
            verify(db, tables)
            yield db
    except Damaged as error:
        raise ValueError(
            f"{file}: damaged ({error}); restore it from a copy, or run it again into another file"
        ) from None
    except (sqlite3.Error, UnicodeDecodeError) as error:
        text = visible(shorten(str(error)))
        if str(error).startswith("file is not a database"):
            raise ValueError(f"{file}: not a readable results file of gnomon ({text})") from None
        raise ValueError(f"{file}: damaged ({text}); run it again into another file") from None


@contextmanager
def one_state(path: str | Path) -> Iterator[None]:
    """In this context all readings of a results file see one state, which is verified once."""
    with reading(path, schema.TABLES) as db:
        token = _held.set((results_file(path).resolve(), db))
        try:
            yield
        finally:
            _held.reset(token)


def verify(db: sqlite3.Connection, tables: Iterable[str]) -> None:
    """Raise Damaged, which names the place, unless the file has the structure of `schema` and its tables are sound."""
    _verify_structure(db)
    # For the whole file: if a table's first page was replaced by another, only the list of unused pages shows it.
    ((integrity,),) = db.execute("PRAGMA integrity_check(1)")
    if integrity != "ok":
        raise Damaged(" ".join(visible(shorten(integrity), lines=True).replace("*** in database main ***", "").split()))
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
    """Roll back a first write that was interrupted, if there is one, so that the file can be used again.

    Raises ValueError for a journal that names another file: gnomon never writes one, and SQLite would delete that file.
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
        raise ValueError(
            f"{path}: a write into it was interrupted ({visible(shorten(str(error)))}); remove both files"
        ) from None
    finally:
        db.close()


def _connect(path: Path, stack: ExitStack) -> sqlite3.Connection:
    """A connection within one reading transaction.

    In WAL mode SQLite creates more files in the folder of the results file. If it cannot create them and the log is empty, the
    results file is complete, and is opened as immutable. If the log holds writes, both files are copied to a temporary folder.
    """
    try:
        return _begin(path, "mode=ro", stack)
    except sqlite3.OperationalError as error:
        if error.sqlite_errorcode & 0xFF not in (CANNOT_OPEN, READ_ONLY):
            raise
    path = path.resolve()
    log, journal = (path.with_name(path.name + ending) for ending in ("-wal", "-journal"))
    if journal.exists() and journal.stat().st_size:
        raise Damaged(f"a write into it was interrupted, {journal.name} is beside it")
    if not log.exists() or log.stat().st_size == 0:
        return _begin(path, "mode=ro&immutable=1", stack)
    folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="gnomon-")))
    for source in (path, log):
        shutil.copyfile(source, folder / source.name)
    return _begin(folder / path.name, "mode=ro", stack)


def _begin(path: Path, how: str, stack: ExitStack) -> sqlite3.Connection:
    db = schema.with_checksums(sqlite3.connect(f"{path.resolve().as_uri()}?{how}", uri=True, timeout=30))
    try:
        db.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, MOST_BYTES)
        for pragma in ("trusted_schema = OFF", "cell_size_check = ON", "query_only = ON"):
            db.execute(f"PRAGMA {pragma}")
        db.execute("BEGIN")
        schema.version(db)
        db.execute("SELECT count(*) FROM sqlite_master").fetchone()
    except BaseException:
        db.close()
        raise
    stack.callback(db.close)
    return db


def _verify_kind(db: sqlite3.Connection, path: Path) -> None:
    """Raise ValueError unless it is a results file of this schema, because a missing column has no default value."""
    ((application,),) = db.execute("PRAGMA application_id")
    version = schema.version(db)
    if application != APPLICATION_ID:
        raise ValueError(
            f"{path}: an SQLite file, but not one of gnomon's; give a results.sqlite that `gnomon run` wrote"
        )
    if version != SCHEMA_VERSION:
        way = "upgrade gnomon" if version > SCHEMA_VERSION else f"run it again, or read it with {_writer(db)}"
        raise ValueError(f"{path}: written with schema {version}, this gnomon reads schema {SCHEMA_VERSION}; {way}")


def _writer(db: sqlite3.Connection) -> str:
    """The gnomon that wrote the last run of a file, in words."""
    last = "SELECT value FROM environment WHERE name = ? ORDER BY run DESC LIMIT 1"
    version, revision = (db.execute(last, (name,)).fetchone() for name in ("gnomon", "revision"))
    named = f" {visible(shorten(str(version[0])))}" if version and version[0] else ""
    named += f" of revision {visible(shorten(str(revision[0])))}" if revision and revision[0] else ""
    return f"the gnomon{named} that wrote it"


def _verify_structure(db: sqlite3.Connection) -> None:
    """Raise Damaged unless the file holds exactly the tables and the index of its schema."""
    expected = {(kind, name): _plain(sql) for kind, name, sql in schema.list_structure()}
    for kind, name, table, sql in db.execute("SELECT type, name, tbl_name, sql FROM sqlite_master").fetchall():
        if kind == "index" and sql is None and table in schema.TABLES:
            continue  # the index of a primary key
        shown = visible(shorten(f"{kind} {name}"))
        if (kind, name) not in expected:
            raise Damaged(f"it holds the {shown}, which gnomon does not make")
        if _plain(str(sql)) != expected.pop((kind, name)):
            raise Damaged(f"the {shown} is not made as gnomon makes it")
    for kind, name in expected:
        raise Damaged(f"no such {kind}: {name}")


def _plain(sql: str) -> str:
    """A statement without differences in form: quotes around names, spaces and new lines."""
    return re.sub(r"\s*([(),])\s*", r"\1", " ".join(sql.replace('"', "").split()))


def _too_long(db: sqlite3.Connection, table: str) -> int | None:
    """The first row that is too long to be read."""
    for (row,) in db.execute(f"SELECT rowid FROM {table}").fetchall():
        try:
            db.execute(f"SELECT * FROM {table} WHERE rowid = ?", (row,)).fetchone()
        except sqlite3.DataError:
            return int(row)
    return None
