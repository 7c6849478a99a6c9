"""Reads a results file: measurements, sampled states, runs. `opening` verifies the file first."""

import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from gnomon.cases.core.sampling import SAMPLES
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.results import opening, schema
from gnomon.harness.results.schema import TIMING_SPAN, Damaged
from gnomon.harness.results.visible import visible
from gnomon.harness.system import extras

LOADED = ("runs", "trials", "planned", "measurements", "settings_changed")
"""The tables whose rows `load` reads."""
IN_LINES = ("reason", "output")
"""Columns of text that may have several lines."""
TEXTS = {"suite", "settings_changed"} | {
    name
    for table in ("trials", "measurements")
    for name, kind in schema.TABLES[table].items()
    if kind.startswith("TEXT")
}
"""The columns of a frame that hold texts."""
APART, MORE_SCATTER = 2.25, 2.0
"""APART: least ratio r of two times whose difference is used. MORE_SCATTER: an upper bound of the relative scatter of this
difference over the relative scatter of one time, which is sqrt(r^2 + 1)/(r - 1)."""
ROWS = 1000
"""The number of rows that are read at a time."""

_CURRENT = """
SELECT {trials}, {measurements}, runs.suite,
    (SELECT json_group_object(name, value) FROM settings_changed s WHERE s.measurement = measurements.measurement)
        AS settings_changed
FROM measurements JOIN trials USING (trial_key) JOIN runs USING (run)
WHERE {condition} ORDER BY trials.rowid, measurements.launch, measurements.measurement
"""
LAST_PLANNED = (
    "SELECT trial_key FROM planned WHERE (series, run) IN (SELECT series, max(run) FROM planned GROUP BY series)"
)
"""The trials that count: the last planned ones of a series."""
NOT_SUPERSEDED = f"""
measurements.trial_key IN ({LAST_PLANNED})
AND measurements.measurement IN (SELECT max(measurement) FROM measurements GROUP BY trial_key, launch)
"""
"""The condition for the measurements that count: of the trials last planned for a series, the last of each launch."""


def load(path: str | Path, superseded: bool = False) -> Any:
    r"""Load the measurements of a results file.

    Parameters
    ----------
    path : str or Path
        A results file, or a folder that holds ``results.sqlite``.
    superseded : bool
        Whether to include measurements that a later run in the file replaced (edited source, other settings).

    Returns
    -------
    pandas.DataFrame
        One row for each measurement: the columns of its trial, then its own. Characters that would control
        a terminal are escaped, as \x1b.

    Raises
    ------
    ValueError
        If there is no results file at `path`, it is damaged, or pandas is not installed; `rows` does without.

    Examples
    --------
    >>> rows = load("runs/mine.sqlite")  # doctest: +SKIP
    >>> rows.groupby("integrator")["error_max"].min()  # doctest: +SKIP
    >>> load("no_such_file.sqlite")
    Traceback (most recent call last):
    ValueError: no_such_file.sqlite: no results here; give a results.sqlite that `gnomon run` wrote, or its folder
    """
    extras.require("report", "a table of results")
    import pandas  # slow to load: the command line starts without it

    by_name = columns(path, superseded)
    # Texts are objects in every version of pandas: as its own type of texts they take more memory and time.
    return pandas.DataFrame(
        {name: pandas.Series(by_name.pop(name), dtype=object if name in TEXTS else None) for name in list(by_name)}
    )


def rows(path: str | Path, superseded: bool = False) -> list[dict[str, Any]]:
    """Read the measurements of a results file as `load` does, without pandas.

    Parameters
    ----------
    path : str or Path
        A results file, or a folder that holds ``results.sqlite``.
    superseded : bool
        Whether to include measurements that a later run in the file replaced (edited source, other settings).

    Returns
    -------
    list of dict
        A dict for each measurement, with the names of the columns of `load`; null is None.

    Raises
    ------
    ValueError
        As `load` does.
    """
    by_name = columns(path, superseded)
    return [dict(zip(by_name, values, strict=True)) for values in zip(*by_name.values(), strict=True)]


def columns(path: str | Path, superseded: bool = False) -> dict[str, list[Any]]:
    """The columns of `load` by name. Texts are visible; equal texts are one object, since many rows repeat them."""
    condition = "1" if superseded else NOT_SUPERSEDED
    with opening.reading(path, LOADED) as db:
        selected = {table: schema.list_columns(table) for table in ("trials", "measurements")}
        cursor = db.execute(_CURRENT.format(condition=condition, **selected))
        names = [column[0] for column in cursor.description]  # trial_key comes from both tables
        by_name: dict[str, list[Any]] = {name: [] for name in names}
        shown: dict[str, dict[Any, Any]] = {name: {None: None} for name in TEXTS}
        while part := cursor.fetchmany(ROWS):
            for name, values in dict(zip(names, zip(*part, strict=True), strict=True)).items():
                known = shown.get(name)
                if known is not None:
                    known |= {text: visible(text, name in IN_LINES) for text in set(values) - known.keys()}
                by_name[name] += values if known is None else map(known.__getitem__, values)
    both = zip(by_name["rhs_calls"], by_name["steps"], strict=True)
    by_name["work"] = [steps if calls is None else calls for calls, steps in both]
    by_name["more_seconds"] = _more_seconds(by_name)
    return by_name


def _more_seconds(by_name: Mapping[str, Sequence[Any]]) -> list[float | None]:
    """Seconds of one more pass over the case's span: from the times over several spans and over one, in one launch.

    Both are without waits for a processor, which a longer call has more of. None without this measurement, and where the
    longer time is less than APART times the other.
    """
    waits = zip(by_name["seconds_median"], by_name["delay_seconds"], strict=True)
    times = [None if seconds is None else seconds - (delay or 0.0) for seconds, delay in waits]
    names = ("variant", "case", "formulation", "library", "integrator_id", "setting", "machine", "run", "launch")
    longer: dict[tuple[Any, ...], tuple[int, float]] = {}
    timed = list(zip(by_name["error_max"], times, *(by_name[name] for name in names), strict=True))
    for error, seconds, variant, *rest in timed:
        own, label, factor = variant.partition(TIMING_SPAN)
        # A solution without an error is not finite: its time is no motion's.
        if label and factor.isdecimal() and int(factor) > 1 and None not in (seconds, error):
            longer[own, *rest] = int(factor), seconds
    more: list[float | None] = []
    for _, seconds, *key in timed:
        factor, whole = longer.get(tuple(key), (0, 0.0))
        is_apart = factor > 1 and seconds is not None and seconds > 0 and whole >= APART * seconds
        more.append((whole - seconds) / (factor - 1) if is_apart else None)
    return more


def states(path: str | Path, measurements: Sequence[int] | None = None) -> dict[int, Floats]:
    """Sampled states (64, dim) by measurement number, in the coordinates of the case; None selects all measurements.

    Raises ValueError as `load` does.
    """
    query = "SELECT measurement, dimension, states FROM sampled_states"
    with opening.reading(path, ["sampled_states"]) as db:
        if measurements is None:
            rows = db.execute(query).fetchall()
        else:
            cursors = (db.execute(f"{query} WHERE measurement = ?", (int(number),)) for number in measurements)
            rows = [row for cursor in cursors for row in cursor]
        return {number: _array(number, dimension, blob) for number, dimension, blob in rows}


def _array(number: int, dimension: int, blob: bytes) -> Floats:
    size = SAMPLES * dimension * 8
    unpacker = zlib.decompressobj()
    try:
        content = unpacker.decompress(blob, size + 1)  # a limit, since a small blob could expand without end
    except zlib.error as error:
        raise Damaged(f"table sampled_states, row {number}: {error}") from None
    if len(content) != size or not unpacker.eof:
        raise Damaged(f"table sampled_states, row {number}: it holds no {SAMPLES} states of {dimension} numbers")
    return np.frombuffer(content, dtype="<f8").reshape(SAMPLES, dimension)


def runs(path: str | Path) -> list[dict[str, Any]]:
    """Every run in the file, oldest first: run, started, ended, suite, command and `environment`, a dict.

    Raises ValueError as `load` does.
    """
    with opening.reading(path, ["runs", "environment"]) as db:
        all_runs = [
            {name: _show(value) for name, value in zip(schema.TABLES["runs"], row, strict=True)}
            for row in db.execute(f"SELECT {schema.list_columns('runs')} FROM runs ORDER BY run").fetchall()
        ]
        for run in all_runs:
            rows = db.execute("SELECT name, value FROM environment WHERE run = ?", (run["run"],))
            run["environment"] = {visible(name): _show(value) for name, value in rows}
    return all_runs


def _show(value: Any) -> Any:
    return visible(value) if isinstance(value, str) else value
