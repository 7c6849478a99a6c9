"""Runs an ensemble in parts: processes of this machine, a Dask cluster, or one after the other give the same bits."""

from __future__ import annotations

import functools
import math
import pickle
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from gnomon.harness.contract.integrator import Refused
from gnomon.harness.ensembles import parquet
from gnomon.harness.ensembles.distribution import Distribution, counted
from gnomon.harness.ensembles.exact_formulas import exact_states, formula
from gnomon.harness.ensembles.samples import BLOCK, Ensemble
from gnomon.harness.running.progress import Progress
from gnomon.harness.system.child_process import interrupts_ignored, process_pool

MOST_PART, PARTS = 2**14, 64
"""A part has at most 2**14 samples, fewer where this gives less than 64 parts; their number is that of `samples` alone."""
PROBE, PROBE_SECONDS = 32, 2.0
"""Samples that are measured before the start; a block of them, if that takes no longer than this."""
ATTEMPTS = 3
AHEAD = 4
"""Parts under way for each process."""


@dataclass(frozen=True)
class Job:
    """What a process needs for any part: the ensemble, how many starts to keep, the map's sides, the Parquet files' folder."""

    ensemble: Ensemble
    samples: int
    keep: int = 10
    sides: tuple[int, int] = (0, 0)
    folder: str | None = None

    @property
    def part(self) -> int:
        """Samples in a part: a power of two, and whole blocks."""
        share = max(self.samples // PARTS, 1)
        return max(BLOCK, min(MOST_PART, 1 << (share.bit_length() - 1)))

    @property
    def firsts(self) -> range:
        """The first sample of each part."""
        return range(0, self.samples, self.part)


def execute(job: Job, first: int) -> bytes:
    """The pickled distribution of the part that begins with sample `first`. Any process calls this.

    The samples are written as a Parquet file if the job names a folder.
    """
    count = min(job.part, job.samples - first)
    samples = job.ensemble.prepared.measured(first, count)
    if job.folder is not None:
        parquet.write(Path(job.folder), job.ensemble, job.samples, samples)
    return pickle.dumps(counted(samples, job.sides, job.keep))


@dataclass(frozen=True)
class Cost:
    """Measured before the start: seconds a sample for the integration and for the exact state, and by what the latter."""

    integration: float
    exact: float
    by_formula: bool
    prepares_each: bool

    def seconds(self, samples: int, workers: int) -> float:
        return (self.integration + self.exact) * samples / workers


def probe(ensemble: Ensemble) -> Cost:
    """The cost of samples, from PROBE or BLOCK of them, after a first time that compiles. Raises ValueError where the
    integrator declines the problem."""
    ready = ensemble.prepared
    if not ready.parameters_vary:
        try:
            _ = ready.solver
        except Refused as error:
            raise ValueError(f"{ready.integrator.id} declines {ready.case.id}: {error}") from None
    ready.measured(0, PROBE)
    count, whole = PROBE, _seconds(ready.measured, 0, PROBE)
    if whole * BLOCK / PROBE <= PROBE_SECONDS:
        # A whole block, as in the run: some methods share work between its samples.
        count, whole = BLOCK, _seconds(ready.measured, 0, BLOCK)
    exact = _seconds(exact_states, ready.case, *ready.split(ready.drawn(0, count)[1]), ready.times)
    return Cost(max(whole - exact, 0.0) / count, exact / count, formula(ready.case) is not None, ready.parameters_vary)


def _seconds(call: Callable[..., Any], *arguments: Any) -> float:
    began = time.perf_counter()
    call(*arguments)
    return time.perf_counter() - began


def probe_apart(ensemble: Ensemble) -> Cost:
    """`probe` in a process of its own, which an integrator may end. Raises ValueError, or ChildProcessError if it did."""
    ensemble.prepared  # noqa: B018 - wrong names are found here, where messages are short
    try:
        with process_pool(1) as pool:
            with interrupts_ignored():
                future = pool.submit(probe, ensemble)
            return future.result()
    except BrokenProcessPool:
        raise ChildProcessError(
            f"{ensemble.integrator} ended its process in the first {PROBE} samples; gnomon run records such a trial"
        ) from None


class Mapper(Protocol):
    """Calls `execute` on parts of a job, in any sequence, and yields each part's first sample with its result."""

    def __call__(self, job: Job, firsts: Iterable[int]) -> Iterator[tuple[int, bytes]]: ...


def one_by_one(job: Job, firsts: Iterable[int]) -> Iterator[tuple[int, bytes]]:
    """In this process."""
    for first in firsts:
        yield first, execute(job, first)


def in_processes(workers: int) -> Mapper:
    """In this number of processes. What a process that ends had under way runs again, at most ATTEMPTS times."""

    def mapped(job: Job, firsts: Iterable[int]) -> Iterator[tuple[int, bytes]]:
        left, broken = list(firsts), 0
        while left:
            done = set[int]()
            try:
                for first, answer in _in_one_pool(functools.partial(execute, job), left, workers):
                    done.add(first)
                    yield first, answer
            except BrokenProcessPool:
                broken = 1 if done else broken + 1
                if broken == ATTEMPTS:
                    raise ChildProcessError(
                        f"a worker process ended {ATTEMPTS} times, with one of the first samples {left[0]} to "
                        f"{min(left[0] + AHEAD * workers * job.part, job.samples) - 1}; run these by themselves"
                    ) from None
            left = [first for first in left if first not in done]

    return mapped


def _in_one_pool(call: Callable[[int], bytes], firsts: list[int], workers: int) -> Iterator[tuple[int, bytes]]:
    with process_pool(workers) as pool:
        waiting: dict[Future[bytes], int] = {}
        rest = iter(firsts)
        while True:
            with interrupts_ignored():
                while len(waiting) < AHEAD * workers and (first := next(rest, None)) is not None:
                    waiting[pool.submit(call, first)] = first
            if not waiting:
                return
            for future in wait(waiting, return_when=FIRST_COMPLETED).done:
                yield waiting.pop(future), future.result()


def run(job: Job, mapper: Mapper = one_by_one, progress: Progress | None = None) -> Distribution:
    """The distribution of all samples of a job. Raises ValueError where no sample of the first part is in the domain."""
    progress = progress or Progress(quiet=True)
    firsts = job.firsts
    progress.begin(f"parts of {job.part} samples", len(firsts))
    found = Distribution(job.keep)
    for _, answer in mapper(job, firsts):
        found = found.merged(pickle.loads(answer))
        progress.advance()
    if not found.inside:
        raise ValueError(
            f"{job.ensemble.case}: none of {job.samples} samples is in the domain with a known motion; "
            "vary fewer numbers, or in other limits"
        )
    return found


def samples_of(text: str) -> int:
    """A number of samples as text: 1000, 1e6, 2**20 or 2^20. Raises ValueError."""
    base, power, exponent = text.replace("^", "**").partition("**")
    try:
        value = float(base) ** float(exponent) if power else float(base)
    except (ValueError, OverflowError, ZeroDivisionError):
        value = math.nan
    return int(value) if isinstance(value, float) and value.is_integer() else -1
