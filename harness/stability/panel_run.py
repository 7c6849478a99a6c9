"""Measures panels for integrators, each integrator in its own process, because it may hang or crash."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from gnomon.cases.core.numbers import nearest
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.contract.status import Status
from gnomon.harness.registry import environment, lookup
from gnomon.harness.stability import tiers
from gnomon.harness.stability.panel import Panel, for_json, panels
from gnomon.harness.system.limitations import need_fork
from gnomon.harness.system.supervisor import Job, Send, run
from gnomon.reference.storage import diskcache

SCHEMA = 1
"""Version of the JSON result; it changes when a key disappears or changes its meaning."""
DEPTHS = {"normal": 2.0, "high": 60.0}
"""Approximate processor seconds that a panel may spend on a method."""
LONGEST = 120.0
"""Multiple of these seconds after which a panel's process is ended; reference solutions, computed once, take longer."""


@dataclass(frozen=True)
class Row:
    """The result of a panel for an integrator, with the processor time in seconds."""

    integrator: str
    panel: str
    seconds: float
    data: Mapping[str, Any]
    sentences: Sequence[str]
    marks: Sequence[Mapping[str, Any]] = ()
    """The marks of the integrator in the panel's figure, see `Mark`."""
    sources: str = ""
    """The sources of gnomon at the time of the measurement, as in `environment.versions`."""

    @property
    def reason(self) -> str | None:
        """Why nothing was measured; None if something was."""
        for word in ("not_applicable", Status.REFUSED):
            if word in self.data:
                return f"{word.replace('_', ' ')}: {self.data[word]}"
        return None

    def with_sentences(self) -> Row:
        """The row with the sentences and marks that follow from its data, empty if nothing was measured."""
        if self.reason is not None:
            return replace(self, sentences=[], marks=[])
        panel = panels()[self.panel]
        marks = [for_json(asdict(mark)) for mark in panel.marks(self.data)]
        return replace(self, sentences=panel.sentences(self.data), marks=marks)


@dataclass(eq=False)
class PanelsJob(Job):
    """The panels of an integrator that are still to be measured."""

    integrator: Integrator
    seconds: float
    add: Callable[[Row], None]
    pending: list[str]
    limit: float

    def work(self, send: Send) -> None:
        for name in self.pending:
            panel, began = panels()[name], time.process_time()
            data = panel.measured(self.integrator, self.seconds)
            seconds, sources = round(time.process_time() - began, 3), environment.sources()
            send(asdict(Row(self.integrator.id, name, seconds, data, [], sources=sources).with_sentences()))

    def receive(self, message: Any) -> None:
        del self.pending[0]
        self.add(Row(**message))

    def lose(self, why: str, late: bool = False) -> None:
        data: dict[str, Any] = {Status.REFUSED: why}
        self.add(Row(self.integrator.id, self.pending.pop(0), 0.0, data, [], sources=environment.sources()))


def choose_panels(names: Sequence[str] | None) -> dict[str, Panel]:
    """The panels of these names, or all panels without names. Raises ValueError for an unknown name."""
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


def measure_panels(
    integrators: Sequence[Integrator],
    names: Sequence[str] | None = None,
    depth: str = "normal",
    workers: int = 2,
    progress: Callable[[Row], None] = lambda row: None,
    former: Sequence[Row] = (),
) -> list[Row]:
    """The rows of all panels, or of the named ones, for each integrator; rows in `former` are not measured again.

    Raises ValueError for a wrong name or depth.
    """
    need_fork()
    chosen = choose_panels(names)
    seconds = seconds_of(depth)
    rows = list(former)
    measured = {(row.integrator, row.panel) for row in former}

    def add(row: Row) -> None:
        rows.append(row)
        progress(row)

    planned = []
    for integrator in integrators:
        missing = lookup.missing(integrator)
        pending = [name for name in chosen if (integrator.id, name) not in measured]
        planned.append(PanelsJob(integrator, seconds, add, pending, LONGEST * seconds))
        while missing is not None and planned[-1].pending:
            planned[-1].lose(missing)
    run(planned, workers)
    places = {name: place for place, name in enumerate(panels())}
    order = list(dict.fromkeys([row.integrator for row in former] + [integrator.id for integrator in integrators]))
    return sorted(rows, key=lambda row: (places[row.panel], order.index(row.integrator)))


def keep_rows(path: Path, depth: str, again: Set[tuple[str, str]] | None = None) -> list[Row]:
    """The rows of a file from `write` that still hold, of integrators that come with gnomon, with new sentences.

    With `again`, pairs of integrator and panel, rows of any revision hold, except for these pairs: their rows hold only
    if the present revision measured them. Raises ValueError if the file holds something else, or was made at another
    depth, elsewhere, or, without `again`, by another revision.
    """
    if not path.exists():
        return []
    try:
        content = json.loads(path.read_text(encoding="utf-8"))
        own, made_by = lookup.own(), content["environment"]["sources"]
        rows = [Row(**{"sources": made_by} | row) for row in content["rows"]]
        rows = [row for row in rows if row.integrator in own and row.panel in panels()]
        here = environment.comparable(environment.describe())
        origin = content["schema"], content["depth"], environment.comparable(content["environment"])
    except (ValueError, TypeError, KeyError, RecursionError):
        raise ValueError(f"{path}: no result of `gnomon stability`; name another file with --out") from None
    if again is not None and origin[2].get("machine") == here["machine"]:
        origin = *origin[:2], here
        rows = [r for r in rows if (r.integrator, r.panel) not in again or r.sources == environment.sources()]
    if origin != (SCHEMA, depth, here):
        raise ValueError(
            f"{path}: measured at another depth, on another machine, or by other versions; name another file with --out"
        )
    try:
        rows = [row.with_sentences() for row in rows]
        as_json(rows, depth)  # fails before the measurement, not after it
    except Exception as error:  # the sentences of a panel may raise anything from data of another shape
        raise ValueError(
            f"{path}: no result of `gnomon stability` ({type(error).__name__}: {error}); name another file with --out"
        ) from None
    return rows


def write(rows: Sequence[Row], depth: str, path: Path) -> None:
    """Write `as_json` to a temporary file, which then replaces `path`."""
    with diskcache.whole(path) as part:
        part.write_text(as_json(rows, depth), encoding="utf-8")


def as_json(rows: Sequence[Row], depth: str) -> str:
    """The rows as JSON, with the version of its schema, the revision of gnomon and the machine."""
    titles = {name: panel.title for name, panel in panels().items() if any(row.panel == name for row in rows)}
    whole = {"schema": SCHEMA, "depth": depth, "panel_seconds": DEPTHS[depth], "environment": environment.record()}
    figures = {
        name: {"cells": panel.cells, "columns": [asdict(column) for column in panel.columns]}
        for name, panel in panels().items()
        if name in titles
    }
    whole |= {"panels": titles, "figures": figures, "tiers": tiers_of(rows), "rows": [asdict(row) for row in rows]}
    return json.dumps(whole, allow_nan=False) + "\n"


def tiers_of(rows: Sequence[Row]) -> dict[str, Any]:
    """Tiers and rank intervals of the methods by digits lost and by calls; empty if fewer than two were measured."""
    data = {row.integrator: row.data for row in rows if row.panel == "digits" and row.reason is None}
    return tiers.summary(data) if len(data) > 1 else {}
