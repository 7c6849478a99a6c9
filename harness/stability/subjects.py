"""The cases that a panel solves with an integrator, their sample times, and the processor time that it may spend."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from time import process_time

import numpy as np
from gnomon.cases.core.forms import Hybrid
from gnomon.cases.core.registry import get, names
from gnomon.harness.contract.integrator import Floats, Integrator, Refused
from gnomon.harness.contract.problem import takes
from gnomon.harness.measuring.reference_solution import CaseSpec
from gnomon.harness.measuring.trials import Extent, Trials

EXTENT = Extent(steps=64 * 1024, seconds=5.0)
"""The most that a solution of a panel takes."""


class Budget:
    """Processor seconds of this process that a measurement may spend, from now on."""

    def __init__(self, seconds: float) -> None:
        self._end = process_time() + seconds

    @property
    def left(self) -> float:
        return self._end - process_time()

    def extend(self, seconds: float) -> None:
        self._end += seconds

    def affords(self, seconds_each: float, fewest: int, most: int) -> int:
        """The number of solutions, of `seconds_each`, within the time left: at least `fewest` and at most `most`."""
        return max(fewest, min(most, int(self.left / max(seconds_each, 1e-9))))


def multiples(count: int, interval: float = 1.0) -> Floats:
    """`count` sample times, exact multiples of the interval."""
    return np.arange(1, count + 1, dtype=np.float64) * interval


def processor_seconds(run: Callable[[], object]) -> float:
    """Processor time of a call in this process."""
    began = process_time()
    run()
    return process_time() - began


def accepts(integrator: Integrator, name: str, variant: str | None = None) -> bool:
    """Whether an integrator can solve a case, by default its default variant."""
    return takes(integrator, get(name, variant).rounded())


def smooth_reason(integrator: Integrator) -> str | None:
    hybrid = all(issubclass(kind, Hybrid) for kind in integrator.accepts)
    return "it takes equations with events only, whose motion is not smooth" if hybrid else None


def trials_of(integrator: Integrator, name: str, variant: str | None = None) -> Trials:
    """The trials of an integrator on a case. The reference solutions of default variants come with the package."""
    trials = Trials.of(integrator, CaseSpec.of(get(name, variant).rounded()), EXTENT)
    trials.moving = True
    return trials


def subjects(integrator: Integrator, preferred: Sequence[str]) -> Iterator[Trials]:
    """Trials on each preferred case that the integrator accepts, else on the first of all cases that it accepts.

    Raises Refused if it accepts no case.
    """
    suited = [name for name in preferred if accepts(integrator, name)]
    suited = suited or [name for name in names() if accepts(integrator, name)][:1]
    if not suited:
        raise Refused("no case has a form that it accepts")
    yield from (trials_of(integrator, name) for name in suited)
