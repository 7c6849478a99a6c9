"""The connection to a Dask cluster: a scheduler that runs already, or processes of this machine."""

from __future__ import annotations

import asyncio
import logging
import time
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from typing import Any, TypeVar

from gnomon.harness.cluster.identity import difference
from gnomon.harness.system import extras
from gnomon.harness.system.child_process import interrupts_ignored

LOCAL = "local"
CONNECT_SECONDS, CLOSE_SECONDS = 20.0, 2.0
LOST = "the connection to the scheduler was lost"
AHEAD = 2
"""Calls under way for each worker, so that no worker waits for the client. More would fill the scheduler's memory."""
FEWEST_AHEAD = 8
"""The least number of calls under way: a cluster that adapts starts workers when there are tasks."""
COUNT_SECONDS = 1.0
"""Time between two counts of the workers, which come and go."""

Item = TypeVar("Item")


class Lost(Exception):  # noqa: N818 (it names the event)
    """Raised after the scheduler ended or tasks failed; results that came back before are recorded."""


@dataclass
class Cluster:
    """A client of a Dask scheduler."""

    client: Any
    completed: Any
    """Dask's iterator over futures in the sequence in which they end."""

    def compare(self, wanted: Mapping[str, str]) -> None:
        """Raise ValueError, which names a worker, if its versions or sources differ from the client's in `wanted`."""
        differences = self.client.run(difference, dict(wanted), on_error="return")
        for worker, different in sorted(differences.items()):
            if isinstance(different, BaseException):
                different = f"cannot run gnomon ({type(different).__name__}: {different})"
            if different is not None:
                raise ValueError(
                    f"the worker {worker} {different}; start the workers with the client's versions and sources"
                )

    def map(
        self, function: Callable[..., bytes], calls: Iterable[tuple[tuple[Any, ...], Item]], name: str
    ) -> Iterator[tuple[Item, bytes | Exception]]:
        """Yield the item of each call (arguments, item) with its result, in the sequence in which calls end.

        The result is an exception if the call raised one. Dask repeats a call whose worker ends. Raises Lost if the
        scheduler ends.
        """
        calls, number = iter(calls), 0
        waiting: dict[Any, Item] = {}
        completed, counted, most = (
            self.completed(loop=self.client.loop, with_results=True, raise_errors=False),
            -COUNT_SECONDS,
            0,
        )
        while True:
            if time.monotonic() - counted >= COUNT_SECONDS:
                most = max(FEWEST_AHEAD, AHEAD * self._workers())
                counted = time.monotonic()
            while len(waiting) < most and (call := next(calls, None)) is not None:
                arguments, item = call
                number += 1
                future = self.client.submit(function, *arguments, key=f"{name}-{number}", pure=False)
                waiting[future] = item
                completed.add(future)
            if not waiting:
                return
            future, result = next(completed)
            item = waiting.pop(future)
            if future.status not in ("finished", "error"):
                raise Lost(LOST)
            yield item, result[1] if future.status == "error" else result

    def _workers(self) -> int:
        """The number of workers. Raises Lost if the scheduler ended."""
        if self.client.status == "running":
            with suppress(OSError):
                return len(self.client.ncores())
        raise Lost(LOST)


@contextmanager
def connect(address: str, workers: int) -> Iterator[Cluster]:
    """Connect to the cluster at the address of a scheduler, or for `local` start `workers` processes on this machine.

    Raises ValueError if Dask is not installed, or if no scheduler answers.
    """
    extras.require("cluster", "--dask")
    # Imported here and not above: Dask is optional, and slow to load.
    import dask
    from distributed import Client, LocalCluster, as_completed

    logging.getLogger("distributed").setLevel(logging.ERROR)  # else each lost worker prints a page
    with ExitStack() as stack:
        place: Any = address
        if address == LOCAL:
            # Without dashboards, whose ports a second run would find in use.
            stack.enter_context(dask.config.set({"distributed.worker.daemon": False}))
            with interrupts_ignored():
                place = stack.enter_context(
                    LocalCluster(
                        n_workers=workers,
                        threads_per_worker=1,
                        host="127.0.0.1",
                        dashboard_address=None,
                        worker_dashboard_address=None,
                    )
                )
        try:
            if address != LOCAL:
                with ThreadPoolExecutor(1) as pool:  # a notebook has a loop in this thread
                    pool.submit(asyncio.run, _greet(address)).result()
            client = Client(place, timeout=CONNECT_SECONDS, set_as_default=False)
        except Exception as error:  # any program may answer
            why = " ".join(str(error).split()) or f"none within {CONNECT_SECONDS:g} s"
            raise ValueError(f"--dask {address}: no scheduler answers there ({why}); give tcp://host:port") from None
        stack.callback(client.close, CLOSE_SECONDS)  # without this limit it waits as long as a new connection may take
        yield Cluster(client, as_completed)


async def _greet(address: str) -> None:
    """Raise an exception unless a scheduler answers.

    Dask's client, whose connection failed, would keep the process from ending.
    """
    from distributed.comm.addressing import get_address_host_port
    from distributed.comm.core import connect
    from distributed.security import Security

    get_address_host_port(address)
    trust = Security().get_connection_args("client")
    greeting = connect(address, CONNECT_SECONDS, **trust)
    (await asyncio.wait_for(greeting, CONNECT_SECONDS)).abort()
