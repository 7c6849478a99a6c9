"""The values that each column of a results file allows; they are verified once, when a file is opened.

CHECK constraints in the file would not serve: whoever made the file may have left them out by giving it an older schema,
which has none, and `PRAGMA integrity_check` names the table of a violation but not the row.
"""

import json
import re
import sqlite3
from collections.abc import Iterable

from gnomon.harness.contract.status import SCORED, Status
from gnomon.harness.results import schema
from gnomon.harness.results.schema import Damaged
from gnomon.harness.results.visible import visible
from gnomon.reference.numerics.precision import shortened

MOST_LAUNCHES, MOST_ORDER, MOST_DIMENSION = 10**6, 10**3, 10**6
_FRACTION = re.compile(r"[+-]?[0-9]{1,4300}(/0*[1-9][0-9]{0,4200})?")
"""A number in the form of `str` of a Fraction, with at most the digits that Python converts."""


def _quote(statuses: Iterable[Status]) -> str:
    """Statuses as a list for IN of SQL."""
    return f"({', '.join(repr(status.value) for status in statuses)})"


_KINDS = {"TEXT": "text", "INTEGER": "integer", "REAL": "real", "BLOB": "blob"}
MOST = 1e150
"""Sizes above this, and below 1 / MOST, are refused: motions never have them, and their squares and ratios overflow."""
_SIZE = f"{{0}} BETWEEN {1 / MOST!r} AND {MOST!r}"
_SECONDS = f"({{0}} = 0 OR {_SIZE})"
_COUNT = "{0} >= 0"
_BOUNDED = f"{{0}} BETWEEN 0 AND {MOST!r}"
_RULES = {
    "trials": {
        "order_declared": f"{{0}} BETWEEN 0 AND {MOST_ORDER}",
        "setting": _SIZE,
        "dimension": f"{{0}} BETWEEN 1 AND {MOST_DIMENSION}",
        "span": _SIZE,
        "time_scale": _SIZE,
        "floor": _BOUNDED,
        "conditioning": _BOUNDED,
    },
    "measurements": {"launch": f"{{0}} BETWEEN 1 AND {MOST_LAUNCHES}", "status": f"{{0}} IN {_quote(Status)}"}
    | {name: _COUNT for name, declared in schema.MEASUREMENT_COLUMNS.items() if declared in ("REAL", "INTEGER")}
    | dict.fromkeys((*schema.TIMES, "limit_seconds"), _SECONDS),
    "sampled_states": {"dimension": f"{{0}} BETWEEN 1 AND {MOST_DIMENSION}"},
}
"""Conditions on values that are not null, besides their type; `{0}` is the column."""
_TOGETHER = {
    "trials": [
        (
            "SELECT max(row) FROM (SELECT max(rowid) AS row FROM trials"
            " GROUP BY integrator_id HAVING count(DISTINCT library) > 1)",
            "its integrator_id has another library in another row",
        )
    ],
    "measurements": [
        (
            "SELECT max(measurement) FROM measurements JOIN trials USING (trial_key)"
            f" WHERE setting IS NULL AND status IN {_quote(SCORED)}",
            "its status needs a setting, and its trial has none",
        ),
        (
            f"SELECT max(measurement) FROM measurements WHERE status != '{Status.DIVERGED}' AND error_max > {MOST!r}",
            f"an error_max above {MOST:g} belongs to a solution that diverged",
        ),
    ],
}
"""Conditions on several values together: a query for the last row that violates one (else null), and a message."""


def verify(db: sqlite3.Connection, table: str) -> None:
    """Raise Damaged if a value is not allowed in its column; it names the first such row, the column and the value."""
    holds = {name: _condition(table, name) for name in schema.TABLES[table]}
    wrong = db.execute(f"SELECT rowid FROM {table} WHERE NOT ({' AND '.join(holds.values())}) LIMIT 1").fetchone()
    if wrong is not None:
        for name in holds:
            ((fine, value),) = db.execute(f'SELECT {holds[name]}, "{name}" FROM {table} WHERE rowid = ?', wrong)
            if not fine:
                raise Damaged(f"table {table}, row {wrong[0]}: {name} = {_show(value)} is not allowed in this column")
    for query, words in _TOGETHER.get(table, ()):
        ((row,),) = db.execute(query)
        if row is not None:
            raise Damaged(f"table {table}, row {row}: {words}")
    if table == "trials":
        _verify_numbers(db)


def _condition(table: str, name: str) -> str:
    """SQL that is 1 if a value is allowed in its column, else 0."""
    declared, column = schema.TABLES[table][name], f'"{name}"'
    kind = f"typeof({column}) = '{_KINDS[declared.split()[0]]}'"
    rule = _RULES.get(table, {}).get(name)
    fine = f"({kind} AND {rule.format(column)})" if rule else kind
    return f"({fine})" if "NOT NULL" in declared or "KEY" in declared else f"({column} IS NULL OR {fine})"


def _verify_numbers(db: sqlite3.Connection) -> None:
    """Raise Damaged unless the exact numbers of every trial are a JSON object of fractions by name."""
    for row, text in db.execute("SELECT min(rowid), numbers FROM trials WHERE numbers IS NOT NULL GROUP BY numbers"):
        try:
            numbers = json.loads(text)
        except (ValueError, RecursionError):
            raise Damaged(f"table trials, row {row}: numbers = {_show(text)} is not JSON") from None
        if not isinstance(numbers, dict):
            raise Damaged(f"table trials, row {row}: numbers = {_show(text)} is not an object")
        for name, number in numbers.items():
            if not (isinstance(number, str) and _FRACTION.fullmatch(number)):
                raise Damaged(f"table trials, row {row}: numbers: {_show(name)} = {_show(number)} is not a fraction")


def _show(value: object) -> str:
    return visible(shortened(value))
