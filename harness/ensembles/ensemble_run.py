"""Run an ensemble in parts, with equal bits one after the other, in processes of this machine or on a Dask cluster."""

from __future__ import annotations

import functools
import math
import pickle
import timeit
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

from gnomon.harness.contract.integrator import Refused
from gnomon.harness.ensembles import parquet
from gnomon.harness.ensembles.distribution import Distribution, count_samples
from gnomon.harness.ensembles.exact_formulas import exact_states, formula
from gnomon.harness.ensembles.samples import BLOCK, Ensemble
from gnomon.harness.system.progress import Progress
from gnomon.harness.system.supervisor import calls, require

MOST_PART, PARTS = 2**14, 64
"""A part has at most 2**14 samples, fewer if there would be less than 64 parts; only the number of samples counts."""
PROBE, PROBE_SECONDS = 32, 2.0
"""The number of samples that are measured before the start. It is a whole block if that takes at most PROBE_SECONDS."""
ATTEMPTS = 3


@dataclass(frozen=True)
class Job:
    """The data that a process needs for any part.

    `ensemble` and its number of `samples`; `keep`: the number of starts to keep; `sides` of the map; `folder` of the
    Parquet files.
    """

    ensemble: Ensemble
    samples: int
    keep: int = 10
    sides: tuple[int, int] = (0, 0)
    folder: str | None = None

    @property
    def part(self) -> int:
        """The number of samples in a part: a power of two, and whole blocks."""
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
    return pickle.dumps(count_samples(samples, job.sides, job.keep))


@dataclass(frozen=True)
class Cost:
    """The cost of an ensemble, measured before its start: seconds a sample for the integration and for the exact state.

    `by_formula`: whether a formula gives the exact states. `prepares_each`: whether each sample needs a preparation.
    """

    integration: float
    exact: float
    by_formula: bool
    prepares_each: bool

    def seconds(self, samples: int, workers: int) -> float:
        return (self.integration + self.exact) * samples / workers


def probe(ensemble: Ensemble) -> Cost:
    """Measure the cost of PROBE or BLOCK samples, after a first call that compiles.

    Raises ValueError if the integrator declines the problem.
    """
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
    return timeit.timeit(lambda: call(*arguments), number=1)


def probe_apart(ensemble: Ensemble) -> Cost:
    """Call `probe` in a process of its own, which an integrator may end.

    Raises ValueError as `probe` does, and ChildProcessError if the process ended.
    """
    ensemble.prepared  # noqa: B018 - wrong names are found here, where messages are short
    ((_, cost),) = calls(probe, [ensemble], 1)
    if isinstance(cost, ChildProcessError):
        raise ChildProcessError(
            f"{ensemble.integrator} ended its process in the first {PROBE} samples; gnomon run records such a trial"
        )
    probe_cost: Cost = require(cost)
    return probe_cost


class Mapper(Protocol):
    """Calls `execute` on parts of a job, in any sequence, and yields each part's first sample with its result."""

    def __call__(self, job: Job, firsts: Iterable[int]) -> Iterator[tuple[int, bytes]]: ...


def one_by_one(job: Job, firsts: Iterable[int]) -> Iterator[tuple[int, bytes]]:
    """A mapper that calls `execute` in this process."""
    for first in firsts:
        yield first, execute(job, first)


def in_processes(workers: int) -> Mapper:
    """A mapper for this number of processes. Parts of a process that ended run again, in at most ATTEMPTS attempts."""

    def mapped(job: Job, firsts: Iterable[int]) -> Iterator[tuple[int, bytes]]:
        for first, answer in calls(functools.partial(execute, job), firsts, workers, attempts=ATTEMPTS):
            if isinstance(answer, ChildProcessError):
                raise ChildProcessError(
                    f"a worker process ended {ATTEMPTS} times, with one of the first samples {first} to "
                    f"{min(first + job.part, job.samples) - 1}; run these by themselves"
                )
            yield first, require(answer)

    return mapped


def run(job: Job, mapper: Mapper = one_by_one, progress: Progress | None = None) -> Distribution:
    """The distribution of all samples of a job. Raises ValueError if no sample is in the domain with a known motion."""
    progress = progress or Progress(quiet=True)
    firsts = job.firsts
    progress.begin(f"parts of {job.part} samples", len(firsts))
    distribution = Distribution(job.keep)
    for _, answer in mapper(job, firsts):
        distribution = distribution.merged(pickle.loads(answer))
        progress.advance()
    if not distribution.inside:
        raise ValueError(
            f"{job.ensemble.case}: none of {job.samples} samples is in the domain with a known motion; "
            "vary fewer numbers, or in other limits"
        )
    return distribution


def samples_of(text: str) -> int:
    """The number of samples in a text: 1000, 1e6, 2**20 or 2^20; -1 for a text without a whole number."""
    base, power, exponent = text.replace("^", "**").partition("**")
    try:
        value = float(base) ** float(exponent) if power else float(base)
    except (ValueError, OverflowError, ZeroDivisionError):
        value = math.nan
    return int(value) if isinstance(value, float) and value.is_integer() else -1
