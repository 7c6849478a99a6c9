"""An ensemble on a Dask cluster, whose workers have the client's versions and sources."""

from __future__ import annotations

import secrets
import threading
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager

from gnomon.harness.cluster.connection import connect
from gnomon.harness.cluster.identity import difference, identity
from gnomon.harness.ensembles.ensemble_run import Job, Mapper, execute
from gnomon.harness.ensembles.samples import Ensemble

_ONE_AT_A_TIME = threading.Lock()
"""Prevents calls of an integrator by two threads of a worker at a time."""


@contextmanager
def on_cluster(address: str, workers: int, ensemble: Ensemble) -> Iterator[Mapper]:
    """A mapper for the cluster at the address of a scheduler, or for `local` a cluster of `workers` processes.

    Raises ValueError if Dask is missing, no scheduler answers, or a worker has other versions or sources. The mapper
    raises ChildProcessError for a part that failed, and Lost if the scheduler ends.
    """
    with connect(address, workers) as cluster:
        client = identity([ensemble.prepared.case], [ensemble.prepared.integrator])
        cluster.compare(client)

        def mapped(job: Job, firsts: Iterable[int]) -> Iterator[tuple[int, bytes]]:
            calls = (((client, job, first), first) for first in firsts)
            for first, answer in cluster.map(execute_there, calls, f"gnomon-{secrets.token_hex(4)}"):
                if isinstance(answer, Exception):
                    raise ChildProcessError(f"samples from {first}: {type(answer).__name__}: {answer}")
                yield first, answer

        yield mapped


def execute_there(client: Mapping[str, str], job: Job, first: int) -> bytes:
    """Call `execute` in a worker. Raises ValueError in a worker that came later with other versions or sources."""
    different = difference(client)
    if different is not None:
        raise ValueError(f"a worker {different}; start the workers with the client's versions and sources")
    with _ONE_AT_A_TIME:
        return execute(job, first)
