"""The tables of a results file: their columns, and the checksum of each row. A file of another schema is refused."""

import sqlite3
import struct
import zlib
from collections.abc import Iterator
from functools import lru_cache

from gnomon.harness.contract.declared import read_declared

SCHEMA_VERSION = 3
APPLICATION_ID = 0x676E6F6D  # "gnom": distinguishes results files from other SQLite files

_FOUND = read_declared("results", "schema.toml")
TABLES: dict[str, dict[str, str]] = _FOUND["tables"]
"""The columns of every table without its `checksum`; schema.toml explains them."""
TRIAL_COLUMNS, MEASUREMENT_COLUMNS = TABLES["trials"], TABLES["measurements"]
TIMES = tuple(name for name in MEASUREMENT_COLUMNS if "seconds" in name and name != "limit_seconds")
"""The columns of measured times, which are compared on one machine only."""
TIMING_SPAN = " timing span x"
"""Text after "default", before the factor, in the variant of a series over several spans of its case."""
_PRIMARY_KEYS: dict[str, str] = _FOUND["primary_keys"]
_CHECKSUM_BEFORE: dict[str, str] = _FOUND["checksum_before"]
_HEAD, _NUMBER = struct.Struct("<cq"), struct.Struct("<cqd")
_NOTHING = _HEAD.pack(b"n", 0)
"""The bytes of null in a checksum. Of each value it takes the type, the length of the content, and the content."""


class Damaged(Exception):  # noqa: N818 (it describes a file)
    """A file that was changed after it was written; the message names the table and the row."""


def create(db: sqlite3.Connection) -> None:
    """Create all tables in an empty file, in one transaction."""
    with db:
        db.execute("BEGIN IMMEDIATE")
        if version(db) == SCHEMA_VERSION:
            return  # another process was faster
        for _, _, statement in list_structure():
            db.execute(statement)
        db.execute(f"PRAGMA application_id = {APPLICATION_ID}")
        db.execute(f"PRAGMA user_version = {SCHEMA_VERSION}")


def list_structure() -> Iterator[tuple[str, str, str]]:
    """The structure of a file: kind, name and SQL of its tables and its index."""
    for table, own in TABLES.items():
        kinds = {name: f'"{name}" {kind}' for name, kind in own.items()}
        before = _CHECKSUM_BEFORE.get(table)
        place = len(kinds) if before is None else [*kinds].index(before)
        parts = [*kinds.values()]
        parts.insert(place, "checksum INTEGER")
        parts += [f"PRIMARY KEY ({_PRIMARY_KEYS[table]})"] if table in _PRIMARY_KEYS else []
        yield "table", table, f"CREATE TABLE {table} ({', '.join(parts)})"
    yield "index", "measured", "CREATE INDEX measured ON measurements (trial_key, launch)"


def version(db: sqlite3.Connection) -> int:
    return int(db.execute("PRAGMA user_version").fetchone()[0])


def list_columns(table: str) -> str:
    """The columns of a table as a list for SELECT, without the checksum."""
    return ", ".join(f'{table}."{name}"' for name in TABLES[table])


def with_checksums(db: sqlite3.Connection) -> sqlite3.Connection:
    """The connection, with the function `row_checksum` that the statements of this module use."""
    db.create_function("row_checksum", -1, _row_checksum, deterministic=True)
    return db


def seal(db: sqlite3.Connection, table: str, row: int) -> None:
    """Store the checksum of the row with this rowid, computed from the values in the file."""
    db.execute(f"UPDATE {table} SET checksum = {_checksum_of(table)} WHERE rowid = ?", (row,))


def seal_all(db: sqlite3.Connection, table: str) -> None:
    """Store the checksum of every row of a table."""
    db.execute(f"UPDATE {table} SET checksum = {_checksum_of(table)}")


def verify(db: sqlite3.Connection, table: str) -> None:
    """Raise Damaged, which names the first such row, if the values of a row do not match its checksum."""
    right = _checksum_of(table)
    damaged = db.execute(f"SELECT rowid FROM {table} WHERE checksum IS NOT {right} LIMIT 1").fetchone()
    if damaged is not None:
        raise Damaged(f"table {table}, row {damaged[0]}: its values do not match its checksum")


def _checksum_of(table: str) -> str:
    return f"row_checksum({list_columns(table)})"


def _row_checksum(*values: object) -> int:
    """CRC-32 of the values with their types. It detects damage, and does not protect against a forged file."""
    pieces = [
        _NOTHING if value is None else _NUMBER.pack(b"f", 8, value) if type(value) is float else
        _piece(b"b", value) if type(value) is bytes else _encode_repeated(value)
        for value in values
    ]  # fmt: skip
    return zlib.crc32(b"".join(pieces))


@lru_cache(2048)
def _encode_repeated(value: object) -> bytes:
    """The bytes of a text or an integer in a checksum, kept because many rows repeat them."""
    if isinstance(value, int):
        return _piece(b"i", b"%d" % value)
    return _piece(b"t", str(value).encode("utf-8", "surrogatepass"))


def _piece(kind: bytes, content: bytes) -> bytes:
    return _HEAD.pack(kind, len(content)) + content
