"""Writes the results of a run: one append-only SQLite file, which other processes may read during the run."""

import json
import os
import sqlite3
import zlib
from collections.abc import Iterable, Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, NamedTuple, Self

import numpy as np
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.contract.status import SCORED, STOPPED, Status, is_from_outside
from gnomon.harness.results import opening, schema
from gnomon.harness.results.export import export as export
from gnomon.harness.results.opening import results_file as results_file
from gnomon.harness.results.reading import NOT_SUPERSEDED
from gnomon.harness.results.reading import load as load
from gnomon.harness.results.reading import runs as runs
from gnomon.harness.results.reading import states as states
from gnomon.harness.system.locks import lock_results, release_results

TO_REPEAT = "to be run again: --repeat"
"""The reason of a trial that is recorded as interrupted because a run repeats it. Results files hold this text: it must
not change."""


_TIMED = (
    *("trial_key", "run", "launch", "status", "reason", "error_max", "rhs_calls", "steps", "turned_starts"),
    *("seconds_median", "null_seconds", "null_work", "delay_seconds"),
)
"""The columns of measurements in `Store.timed`."""


class Known(NamedTuple):
    """The result of a trial in an earlier measurement."""

    status: Status
    work: int | None
    """Number of right-hand sides, or of steps if right-hand sides were not counted."""
    limit_seconds: float | None
    seconds: float | None = None
    """The 10 % quantile of the timed calls without waits for a processor; None if no time was recorded."""
    turned: bool = False
    """Whether its errors come from turned starts."""
    first: bool = False
    """Whether the first use of its integrator was timed."""
    from_outside: bool = False
    """Whether a cause outside the integrator may have ended it (see `status.is_from_outside`)."""

    @classmethod
    def of(cls, row: Mapping[str, Any]) -> Self:
        """The result in a row of measurements, without the columns that are null."""
        work = row.get("steps") if row.get("rhs_calls") is None else row["rhs_calls"]
        turned, first = row.get("turned_starts") is not None, row.get("first_seconds") is not None
        seconds = row.get("seconds_low")
        if seconds is not None:  # waits for a processor are not a cost of the method
            seconds = max(seconds - (row.get("delay_seconds") or 0.0), 0.0)
        status = Status(row["status"])
        return cls(
            status, work, row.get("limit_seconds"), seconds, turned, first, is_from_outside(status, row.get("reason"))
        )

    def settles(self, limit_seconds: float, turned: bool = False, timed: bool = False, first: bool = False) -> bool:
        """Whether the trial need not run again.

        It must run again if it was interrupted, if a lower limit ended it, or if it lacks `turned` starts, times or the
        `first` use that the run wants.
        """
        lacking = (turned and not self.turned) or (timed and self.seconds is None) or (first and not self.first)
        if self.status in SCORED and lacking:
            return False
        if self.status == Status.INTERRUPTED:
            return False
        return self.status not in STOPPED or (self.limit_seconds or 0.0) >= limit_seconds


class Store:
    """An open results file. Every write is one transaction, so kill -9 loses at most the current trial."""

    def __init__(self, path: Path) -> None:
        """Open or create the file.

        Raises ValueError for a file that is not a results file of gnomon, of another schema, damaged, in use by another
        run, or that cannot be written.
        """
        if path.is_symlink():  # SQLite writes its files beside the target of a link
            path = Path(os.path.realpath(path))
        self.path = path
        path.parent.mkdir(parents=True, exist_ok=True)
        try:
            self._locks = lock_results(path)
        except OSError as error:
            raise ValueError(f"{path}: cannot be written ({error.strerror}); give another --out") from None
        try:
            self._open(path)
        except BaseException:
            release_results(self._locks)
            raise

    def _open(self, path: Path) -> None:
        opening.recover(path)
        fresh = not path.exists() or path.stat().st_size == 0
        if not fresh:
            with opening.reading(path, schema.TABLES):
                pass  # opening verifies the file
        try:
            self._connection = schema.with_checksums(sqlite3.connect(path, timeout=30))
            if fresh:  # before the journal mode is written: if there is no space for all tables, the file stays empty
                schema.create(self._connection)
            self._connection.execute("PRAGMA journal_mode = WAL")
            self._connection.execute("PRAGMA synchronous = NORMAL")
        except sqlite3.OperationalError as error:
            raise ValueError(f"{path}: cannot be written ({error}); give another --out") from None

    def begin_run(self, suite: str, command: str, environment: Mapping[str, Any]) -> int:
        """Add a row of `runs` with its environment; return its number."""
        with self._connection as db:
            run = _insert(db, "runs", {"started": _now(), "suite": suite, "command": command})
            for name, value in environment.items():
                text = None if value is None else str(value)
                _insert(db, "environment", {"run": run, "name": name, "value": text})
        return run

    def end_run(self, run: int) -> None:
        with self._connection as db:
            db.execute("UPDATE runs SET ended = ? WHERE run = ?", (_now(), run))
            schema.seal(db, "runs", run)

    def note(self, run: int, name: str, value: str) -> None:
        """Add a line to the environment of a run."""
        with self._connection as db:
            _insert(db, "environment", {"run": run, "name": name, "value": value})

    def noted(self, suite: str, name: str) -> str | None:
        """The last line of this name in the environment of the last run of a suite that ended; None without it."""
        query = "SELECT value FROM environment WHERE name = ? AND run = (SELECT max(run) FROM runs WHERE suite = ?)"
        row = self._connection.execute(query, (name, suite)).fetchone()
        return None if row is None else row[0]

    def timed(self) -> list[dict[str, Any]]:
        """The timed measurements that count, of default variants in the case's own formulation, for `contenders`."""
        names = ("case", "variant", "formulation", "library", "integrator_id", "setting", "machine")
        chosen = ", ".join([*(f'trials."{name}"' for name in names), *(f"measurements.{name}" for name in _TIMED)])
        cursor = self._connection.execute(
            f"SELECT {chosen} FROM measurements JOIN trials USING (trial_key) WHERE {NOT_SUPERSEDED}"
            " AND seconds_median > 0 AND formulation = 'standard' AND variant LIKE 'default%'"
            " ORDER BY trials.rowid, measurements.launch"
        )
        return [dict(zip((*names, *_TIMED), row, strict=True)) for row in cursor]

    def plan(self, run: int, trials: Iterable[Mapping[str, Any]]) -> None:
        """Record the trials of a run, rows with the TRIAL_COLUMNS; trials already in the file are not changed."""
        with self._connection as db:
            for trial in trials:
                _insert(db, "trials", trial, "OR IGNORE")
                row = {"run": run, "series": trial["series"], "trial_key": trial["trial_key"]}
                _insert(db, "planned", row, "OR IGNORE")

    def machines(self) -> list[str]:
        """The machines on which trials in the file were measured."""
        query = "SELECT DISTINCT machine FROM trials WHERE trial_key IN (SELECT trial_key FROM measurements)"
        return [machine for (machine,) in self._connection.execute(query)]

    def history(self) -> dict[tuple[str, int], Known]:
        """The last measurement of every trial and launch, by (trial_key, launch)."""
        names = ["trial_key", "launch", "status", "reason", "rhs_calls", "steps", "limit_seconds"]
        names += ["seconds_low", "delay_seconds", "turned_starts", "first_seconds"]
        rows = self._connection.execute(f"SELECT {', '.join(names)} FROM measurements ORDER BY measurement")
        return {row[:2]: Known.of(dict(zip(names, row, strict=True))) for row in rows}

    def interruptions(self) -> dict[tuple[str, int], int]:
        """Number of interruptions from outside since the last repetition of a trial, by (trial_key, launch)."""
        rows = self._connection.execute(
            "SELECT trial_key, launch, count(*) FROM measurements AS own WHERE status = ? AND NOT EXISTS ("
            "SELECT 1 FROM measurements AS later WHERE later.trial_key = own.trial_key AND later.launch = own.launch"
            " AND later.measurement >= own.measurement AND later.reason = ?) GROUP BY trial_key, launch",
            (Status.INTERRUPTED.value, TO_REPEAT),
        )
        return {(key, launch): count for key, launch, count in rows}

    def add(
        self,
        run: int,
        measurement: Mapping[str, Any],
        options: Mapping[str, Any] | None = None,
        states: Floats | None = None,
    ) -> None:
        """Append one measurement, the engine options that differ from defaults, and the sampled states (64, dim)."""
        self.add_batch(run, [(measurement, options, states)])

    def add_batch(
        self, run: int, rows: Iterable[tuple[Mapping[str, Any], Mapping[str, Any] | None, Floats | None]]
    ) -> None:
        """Append several measurements in one transaction, each with the arguments of `add`."""
        with self._connection as db:
            for measurement, options, states in rows:
                row = {"run": run, "recorded": _now(), **measurement}
                number = _insert(db, "measurements", row)
                for name, value in (options or {}).items():
                    _insert(db, "settings_changed", {"measurement": number, "name": name, "value": str(value)})
                if states is not None:
                    blob = zlib.compress(np.ascontiguousarray(states, dtype="<f8").tobytes(), 1)
                    row = {"measurement": number, "dimension": states.shape[1], "states": blob}
                    _insert(db, "sampled_states", row)

    def add_all(self, run: int, measurements: Iterable[Mapping[str, Any]]) -> None:
        """Append several measurements without options or states, in one transaction."""
        self.add_batch(run, ((measurement, None, None) for measurement in measurements))

    def close(self) -> None:
        self._connection.close()
        release_results(self._locks)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: object) -> None:
        self.close()
        if isinstance(error, sqlite3.DatabaseError):  # a full disk, a damaged file
            raise ValueError(
                f"{self.path}: cannot be written ({error}); what was recorded before stays in it. Repeat the command"
                " when there is space, or give another --out"
            ) from None


def _insert(db: sqlite3.Connection, table: str, row: Mapping[str, Any], conflict: str = "") -> int:
    """Insert a row and its checksum; return its rowid."""
    names = ", ".join(f'"{name}"' for name in row)
    marks = ", ".join("?" * len(row))
    cursor = db.execute(f"INSERT {conflict} INTO {table} ({names}) VALUES ({marks})", [_plain(v) for v in row.values()])
    number = int(cursor.lastrowid or 0)
    if cursor.rowcount:  # 0 for a row that the table had already
        schema.seal(db, table, number)
    return number


def _plain(value: Any) -> Any:
    """A value in a type of SQLite: containers as JSON, numpy numbers as Python's, nan as null."""
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and np.isnan(value):
        return None
    if isinstance(value, str):
        return value.encode(errors="replace").decode()  # half a surrogate pair, from a message of an integrator
    return json.dumps(value) if isinstance(value, dict | list | tuple) else value


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")
