"""Measures panels for integrators, each integrator in a process of its own that a hang or a crash of it ends."""

from __future__ import annotations

import json
import multiprocessing
import os
import sys
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from functools import partial
from multiprocessing.connection import Connection, wait
from typing import Any

from gnomon.cases.core.numbers import nearest
from gnomon.harness.contract import environment
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.contract.status import Status
from gnomon.harness.registry import lookup
from gnomon.harness.stability import tiers
from gnomon.harness.stability.panel import Panel, panels
from gnomon.harness.system.child_process import guarded, queued_seconds
from gnomon.harness.system.limitations import need_fork

SCHEMA = 1
"""Version of the JSON result: it changes when a key changes its meaning or goes."""
DEPTHS = {"normal": 2.0, "high": 60.0}
"""Processor seconds that a panel may spend on a method, about."""
LONGEST = 120.0
"""A panel may take so many times these seconds before its process is ended: reference solutions are computed once."""


@dataclass(frozen=True)
class Row:
    """What a panel found of an integrator, with the processor time in seconds that it took."""

    integrator: str
    panel: str
    seconds: float
    data: Mapping[str, Any]
    sentences: Sequence[str]

    @property
    def reason(self) -> str | None:
        """Why nothing was measured, None where something was."""
        for word in ("not_applicable", Status.REFUSED):
            if word in self.data:
                return f"{word.replace('_', ' ')}: {self.data[word]}"
        return None


@dataclass
class Job:
    """The panels that are still to be measured of an integrator, and the process that does it."""

    integrator: Integrator
    pending: list[str]
    process: Any
    connection: Connection
    limit: float
    """Seconds in which each panel is to be measured."""
    deadline: float
    queued: float = 0.0
    """Seconds that the process had waited for a processor when the deadline was set."""


def chosen_panels(names: Sequence[str] | None) -> dict[str, Panel]:
    """The panels of these names, all of them without names. Raises ValueError for an unknown name."""
    known = panels()
    for name in names or ():
        if name not in known:
            raise ValueError(f"no panel is called {name!r}; {nearest(name, known)}")
    return {name: known[name] for name in known if not names or name in names}


def seconds_of(depth: str) -> float:
    """The processor seconds of a panel at a depth. Raises ValueError for an unknown name."""
    if depth not in DEPTHS:
        raise ValueError(f"no depth is called {depth!r}; {nearest(depth, DEPTHS)}")
    return DEPTHS[depth]


def measured(
    integrators: Sequence[Integrator],
    names: Sequence[str] | None = None,
    depth: str = "normal",
    workers: int = 2,
    progress: Callable[[Row], None] = lambda row: None,
) -> list[Row]:
    """The rows of all panels, or of those named, for each integrator. Raises ValueError for a wrong name or depth."""
    need_fork()
    chosen = chosen_panels(names)
    seconds = seconds_of(depth)
    rows: list[Row] = []

    def add(row: Row) -> None:
        rows.append(row)
        progress(row)

    waiting: list[tuple[Integrator, list[str]]] = []
    for integrator in integrators:
        missing = lookup.missing(integrator)
        if missing is None:
            waiting.append((integrator, list(chosen)))
        else:
            for name in chosen:
                add(Row(integrator.id, name, 0.0, {Status.REFUSED: missing}, []))
    running: list[Job] = []
    try:
        while waiting or running:
            while waiting and len(running) < workers:
                running.append(_started(*waiting.pop(0), seconds))
            wait([job.connection for job in running], 1.0)
            for job in list(running):
                lost = _read(job, add)
                if lost is not None or not job.pending:
                    running.remove(job)
                    _end(job)
                if lost is not None:
                    add(Row(job.integrator.id, job.pending.pop(0), 0.0, {Status.REFUSED: lost}, []))
                    waiting += [(job.integrator, job.pending)] if job.pending else []
    finally:
        for job in running:
            _end(job)
    places = {integrator.id: place for place, integrator in enumerate(integrators)}
    return sorted(rows, key=lambda row: (list(chosen).index(row.panel), places[row.integrator]))


def as_json(rows: Sequence[Row], depth: str) -> str:
    """The rows as JSON, with the version of its schema, the revision of gnomon and the machine."""
    titles = {name: panel.title for name, panel in panels().items() if any(row.panel == name for row in rows)}
    whole = {"schema": SCHEMA, "depth": depth, "panel_seconds": DEPTHS[depth], "environment": environment.describe()}
    whole |= {"panels": titles, "tiers": tiers_of(rows), "rows": [asdict(row) for row in rows]}
    return json.dumps(whole, allow_nan=False) + "\n"


def tiers_of(rows: Sequence[Row]) -> dict[str, Any]:
    """Tiers and rank intervals of the methods by digits lost and by calls; empty if fewer than two were measured."""
    data = {row.integrator: row.data for row in rows if row.panel == "digits" and row.reason is None}
    return tiers.summary(data) if len(data) > 1 else {}


def _started(integrator: Integrator, pending: list[str], seconds: float) -> Job:
    context = multiprocessing.get_context("fork")  # the user's object need not be found again by name
    ours, theirs = context.Pipe()
    work = partial(_serve, theirs, integrator, list(pending), seconds)
    process: Any = context.Process(target=guarded, args=(work,))  # type: ignore[attr-defined]
    sys.stdout.flush()
    process.start()
    theirs.close()
    limit = LONGEST * seconds
    return Job(integrator, pending, process, ours, limit, time.monotonic() + limit)


def _serve(connection: Connection, integrator: Integrator, names: Sequence[str], seconds: float) -> None:
    """Measure panels in a child process, and send each row; what the integrator prints is discarded."""
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 1)
    os.dup2(null, 2)
    for name in names:
        panel, began = panels()[name], time.process_time()
        data = panel.measured(integrator, seconds)
        sentences = [] if {Status.REFUSED, "not_applicable"} & set(data) else panel.sentences(data)
        row = Row(integrator.id, name, round(time.process_time() - began, 3), data, sentences)
        connection.send_bytes(json.dumps(asdict(row)).encode())


def _read(job: Job, add: Callable[[Row], None]) -> str | None:
    """Take the rows that a process sent. Why there will be no more, though panels are pending; None otherwise."""
    try:
        while job.pending and job.connection.poll():
            row = Row(**json.loads(job.connection.recv_bytes()))  # data only: the user's code runs in the process
            job.pending.remove(row.panel)
            job.deadline, job.queued = time.monotonic() + job.limit, queued_seconds(job.process.pid)
            add(row)
    except (EOFError, OSError):
        job.process.join()
        return f"its process ended with exit code {job.process.exitcode}"
    if not job.pending or time.monotonic() <= job.deadline:
        return None
    waited = queued_seconds(job.process.pid) - job.queued
    if waited > 1e-3:  # the machine was busy
        job.deadline, job.queued = job.deadline + waited, job.queued + waited
        return None
    return f"no answer within {job.limit:g} s"


def _end(job: Job) -> None:
    if job.process.is_alive():
        job.process.terminate()
    job.process.join()
    job.connection.close()
