"""Measures the number of spans over which a case is timed too: `python -m gnomon.harness.running.timing_spans`.

The time of one more period is a difference of two times. The number of spans is the smallest power of two, LEAST or more,
with which the null call is at most a tenth of the longer time of every contender (an integrator within a factor of two of
the least time) at every error of the report. `running/timing_spans.toml` keeps the numbers.
"""

import argparse
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from gnomon.cases.core.case import Case
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.registry import lookup
from gnomon.harness.results import analysis, store
from gnomon.harness.results.equal_error import TARGETS
from gnomon.harness.running import plan
from gnomon.harness.running.planned_run import run

from gnomon import cases

LEAST, LARGEST = 4, 2**12
LARGEST_NULL = 0.1
"""The largest share of the null call in the time of a contender."""
CONTENDER = 2.0
"""The largest ratio to the least time for a contender."""
LIMIT_SECONDS = 0.1
"""Time limit of a trial (s): a slower integrator is not a contender on the spans tried."""
AT_REST = min(TARGETS)
"""A motion has ended if it stays this close to its last state over half of its span, below all errors of the report."""
CONTENDER, LARGEST_NULL = 2.0, 0.1
"""The null call is at most LARGEST_NULL of the time of every integrator within CONTENDER of the least."""
REMAIN = 8.0
"""An integrator this far from the least time at every error does not become a contender on a span twice as long."""


def factor(name: str, integrators: Sequence[Integrator], folder: Path) -> int:
    """The factor of a case, from runs of these integrators.

    Raises ValueError if the motion ends on a shorter span, or if no factor up to LARGEST suffices.
    """
    suite = plan.suite("foundation").within(LIMIT_SECONDS).change(launches=1, turned=False)
    spans, tried = LEAST, list(integrators)
    while spans <= LARGEST:
        longer = plan.lengthen(cases.get(name), spans)
        if has_ended(longer[0]):
            raise ValueError(f"{name}: the motion ends within {spans} spans, before the null call is a tenth of a call")
        path = run(folder / f"{name} x{spans}", suite, [longer], tried)
        times = analysis.equal_error(analysis.tidy(store.load(path)).assign(variant=""))
        times = times.assign(ratio=times["seconds"] / times.groupby("target")["seconds"].transform("min"))
        if suffices(times):
            return spans
        near = set(times.loc[times["ratio"] < REMAIN, "integrator_id"])
        spans, tried = 2 * spans, [integrator for integrator in tried if integrator.id in near]
    raise ValueError(f"{name}: the null call is above a tenth of a contender's time on a span {LARGEST} times as long")


def has_ended(case: Case) -> bool:
    """Whether the exact motion is at rest in the second half of its span."""
    states = case.sample(case.times)
    later = states[len(states) // 2 :]
    return float(np.max(case.metric.distance(later, np.broadcast_to(states[-1], later.shape)))) < AT_REST


def suffices(times: pd.DataFrame) -> bool:
    """Whether the null call is at most LARGEST_NULL of the time of every contender in these rows."""
    near = times[times["ratio"] < CONTENDER]
    return len(near) > 0 and bool((near["null_share"] <= LARGEST_NULL).all())


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("cases", nargs="*", default=[name for name in plan.FOUNDATION if name not in plan.ENDS])
    names = parser.parse_args().cases
    integrators = [m for m in lookup.everything().values() if m.primary and lookup.missing(m) is None]
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            try:
                print(f"{name} = {factor(name, integrators, Path(folder))}", flush=True)
            except ValueError as error:
                print(f"# {error}", flush=True)


if __name__ == "__main__":
    main()
