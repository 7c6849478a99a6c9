"""A task of a cluster: a group of series, which a Dask worker runs in processes that can be killed."""

from __future__ import annotations

import hashlib
import math
import pickle
import threading
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from multiprocessing import process
from typing import Any, NamedTuple

import numpy as np
from gnomon.harness.cluster.identity import difference
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.measuring.reference_solution import CaseSpec, ReferenceSolution
from gnomon.harness.registry import environment
from gnomon.harness.registry.references import Reference, dereference
from gnomon.harness.results.store import Known
from gnomon.harness.running.messages import Message, decode, encode
from gnomon.harness.running.plan import Series, Suite
from gnomon.harness.running.planned_run import PlannedRun
from gnomon.harness.running.pool import Pool
from gnomon.harness.system.progress import Progress
from gnomon.harness.system.supervisor import Garbled, Inbox

History = dict[tuple[str, int], Known]
Row = tuple[dict[str, Any], dict[str, Any] | None, Floats | None]
"""A measurement, the engine options, the sampled states."""

_ONE_AT_A_TIME = threading.Lock()
"""Held by the thread that runs a task: the children of one process cannot be awaited by several threads."""


class Differs(ValueError):  # noqa: N818 (it names the finding)
    """A worker has other versions or sources than the client; the message names the worker and both."""


class Packed(NamedTuple):
    """A reference solution as bytes, and their hash."""

    content: bytes
    digest: str


@dataclass(frozen=True)
class Group:
    """The series of a task as plain data: a worker builds them from its own sources, which equal the client's.

    A series is the `reference` of its integrator, its case and formulation, and its label. `history` and
    `interruptions` hold the entries of the client's file about their trials, `again` the launches that run in any
    suite.
    """

    suite: Suite
    near_duplicates: bool
    series: tuple[tuple[Reference, CaseSpec, str], ...]
    exact: dict[CaseSpec, Packed]
    history: History
    interruptions: dict[tuple[str, int], int]
    again: dict[str, set[int]]


def pack(solution: ReferenceSolution) -> Packed:
    """A reference solution as data that `unpack` verifies."""
    arrays = {name: np.asarray(getattr(solution, name)) for name in ReferenceSolution.__dataclass_fields__}
    content = encode(Message(0, "exact", {}, arrays))
    return Packed(content, hashlib.sha256(content).hexdigest())


def unpack(packed: Packed) -> ReferenceSolution:
    """The reference solution in packed data. Raises ValueError if the content does not have its hash."""
    if hashlib.sha256(packed.content).hexdigest() != packed.digest:
        raise ValueError("an exact motion arrived damaged: its hash is another one")
    (message,) = Inbox(decode).take(packed.content)
    arrays: dict[str, Any] = dict(message.arrays)
    crowded, scale = arrays.pop("crowded").astype(np.bool_), float(arrays.pop("time_scale"))
    return ReferenceSolution(**arrays, crowded=crowded, time_scale=scale)


@dataclass
class _Recorder:
    """Takes the measurements of a run, instead of a file."""

    known: History
    interrupted: dict[tuple[str, int], int]
    rows: list[bytes] = field(default_factory=list)

    def history(self) -> History:
        return self.known

    def interruptions(self) -> dict[tuple[str, int], int]:
        return self.interrupted

    def plan(self, run: int, trials: Iterable[Mapping[str, Any]]) -> None:
        """Do nothing: the client records the plan."""

    def add_all(self, run: int, measurements: Iterable[Mapping[str, Any]]) -> None:
        """Do nothing: the client records pairs that cannot run."""

    def note(self, run: int, name: str, value: str) -> None:
        """Do nothing: a task has no rounds of repeated launches."""

    def timed(self) -> list[dict[str, Any]]:
        return []

    def add(self, run: int, measurement: Mapping[str, Any], options: Any = None, states: Any = None) -> None:
        row = {name: v.item() if isinstance(v, np.generic) else v for name, v in measurement.items()}
        content = {"row": row, "options": options}
        self.rows.append(encode(Message(run, "row", content, {} if states is None else {"states": states})))


def execute(client: Mapping[str, str], content: bytes) -> bytes:
    """Run a pickled Group; returns its measurements, which `rows` reads. A Dask worker calls this.

    A trial may allocate the memory that Dask gives to the worker. Raises Differs if versions or sources differ from the
    `client`.
    """
    from distributed import get_worker  # optional, but present in a worker

    worker, different = get_worker(), difference(client)
    if different is not None:
        raise Differs(
            f"the worker {worker.address} {different}; start the workers with the client's versions and sources"
        )
    memory = worker.memory_manager.memory_limit or math.inf
    with _ONE_AT_A_TIME:
        # Dask starts its workers as daemons, which multiprocessing forbids to have children, as these would outlive
        # them: the children of a run end with their parent.
        process.current_process()._config["daemon"] = False  # type: ignore[attr-defined]
        group: Group = pickle.loads(content)
        recorder = _Recorder(dict(group.history), dict(group.interruptions))
        known = {spec: unpack(packed) for spec, packed in group.exact.items()}
        progress, again = Progress(quiet=True), dict(group.again)
        run = PlannedRun(recorder, 0, group.suite, known, progress, group.near_duplicates, again=again)
        run.plan([_series(*fields) for fields in group.series])
        Pool(1, memory=memory).run(run.sweeps())
    return encode(Message(0, "environment", environment.describe(), {})) + b"".join(recorder.rows)


def _series(integrator: Reference, spec: CaseSpec, label: str) -> Series:
    case, formulation = spec.build()
    return Series(case, formulation, dereference(integrator), None, label)


def rows(content: bytes) -> tuple[dict[str, str], list[Row]]:
    """Read the result of `execute`: the environment of the worker and the measurements.

    Raises ValueError for other content.
    """
    try:
        first, *others = Inbox(decode).take(content)
        worker = {str(name): str(value) for name, value in first.content.items()}
        if "machine" not in worker:
            raise Garbled("no machine")
        return worker, [(m.content["row"], m.content["options"], m.arrays.get("states")) for m in others]
    except (Garbled, KeyError, ValueError) as error:
        raise ValueError(f"a worker's result cannot be read ({error!r}); restart the workers") from None
