"""The matrix of a step on an exactly linear problem, its stability, and the intervals of stability."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from gnomon.harness.contract.integrator import Floats, Integrator, Problem
from gnomon.harness.measuring.solved import solve_within
from gnomon.harness.stability.linear_problems import Complex, LinearProblem
from gnomon.harness.stability.subjects import multiples, processor_seconds
from numpy.typing import NDArray

Flags = NDArray[np.bool_]

NORMAL = 1e-9
"""Excess of |R(z)| above 1 that counts as stable. Rounding in a step of many stages is below 1e-13; an unstable method,
even of order 8, exceeds it at the first point of the scan."""
DEFECTIVE = 3e-8
"""This excess for an oscillator: two eigenvalues meet at a limit, and rounding moves them by the root of an ulp."""
BISECTIONS = 20
"""Bisections of an edge between two points of a scan; `FEWER` for problems with a `prepare` for each point."""
FEWER = 12
TOUCHES, REFINEMENTS = 0.9, 5
"""A cosine of this size is refined around its peak, by five factors of ten."""
GROWTH = 10.0
"""Growth of a motion over many steps that counts as stable, for multistep methods."""


@dataclass(frozen=True)
class StepMatrix:
    """An integrator with steps of 1 on a linear problem."""

    integrator: Integrator
    problem: LinearProblem

    def propagated(self, z: Complex, samples: int = 1, steps: int = 1) -> Floats:
        """The matrices (n, samples, 2, 2) from the start to each sample, `steps` steps apart; nan without an answer."""
        if not self.problem.alone:
            return self._propagated(z, samples, steps)
        return np.concatenate([self._propagated(z[k : k + 1], samples, steps) for k in range(len(z))])

    def _propagated(self, z: Complex, samples: int, steps: int) -> Floats:
        own, times = self.problem, multiples(samples, float(steps))
        parameters = np.array(own.parameters(complex(z[0])), dtype=np.float64)
        problem = Problem(own.form, own.dimension, parameters, times, 1.0)
        units = [np.tile(unit, (len(z), 1)) for unit in np.eye(2)]
        starts = np.concatenate([own.start(z, unit) for unit in units])
        columns = own.read(solve_within(self.integrator, problem, 1.0, starts).states)
        return np.stack([columns[: len(z)], columns[len(z) :]], axis=-1)

    def matrices(self, z: Complex) -> Floats:
        """The matrix of a step (n, 2, 2), nan if successive steps differ.

        For a problem that is `alone` it is the matrix of the second step, because engines may treat the first step
        differently.
        """
        if not self.problem.alone:
            return np.asarray(self.propagated(z)[:, 0])
        first, second, third = np.moveaxis(self.propagated(z, 3), 1, 0)
        with np.errstate(all="ignore"):
            matrices = np.array([_quotient(a, b) for a, b in zip(first, second, strict=True)])
            again = np.einsum("nij,njk->nik", matrices, second)
            size = np.max(np.abs(third), axis=(1, 2))
            same = np.max(np.abs(again - third), axis=(1, 2)) <= 1e-6 * size
        return np.where(same[:, None, None], matrices, np.nan)

    @cached_property
    def tolerance(self) -> float:
        return NORMAL if self.problem.plane else DEFECTIVE

    def stable(self, z: Complex) -> Flags:
        """Whether motions do not grow in a step; False without an answer."""
        return spectral_radius(self.matrices(z)) <= 1 + self.tolerance

    def turning(self, w: Floats) -> tuple[Floats, Floats]:
        """(cosine of the angle by which a step turns the phase, square root of its change of areas) for frequencies w.

        The cosine is above 1 in size if the phase does not turn.
        """
        matrices = self.matrices(1j * w)
        with np.errstate(all="ignore"):
            size = np.sqrt(np.abs(np.linalg.det(matrices)))
            return np.trace(matrices, axis1=1, axis2=2) / 2 / size, size

    def touching(self, w: Floats) -> Floats:
        """Frequencies between scan points at which the angle of a step is nearest to pi or 2 pi.

        There a symplectic method may have a narrow tongue of instability.
        """
        if self.problem.plane or self.problem.alone:
            return np.zeros(0)
        near = np.abs(self.turning(w)[0])
        with np.errstate(all="ignore"):
            peaks = (near[1:-1] >= near[:-2]) & (near[1:-1] >= near[2:]) & (near[1:-1] > TOUCHES) & (near[1:-1] <= 1)
        frequencies = []
        for k in np.flatnonzero(peaks) + 1:
            points = np.linspace(w[k - 1], w[k + 1], 21)
            for _ in range(REFINEMENTS):
                best = int(np.clip(np.nanargmax(np.abs(self.turning(points)[0])), 1, 19))
                middle, points = points[best], np.linspace(points[best - 1], points[best + 1], 21)
            frequencies.append(middle)
        return np.array(frequencies)

    def bounded(self, z: Complex, steps: int = 16) -> Flags:
        """Whether a motion does not grow over 64 times `steps` steps; False without an answer."""
        return self.growth(z, steps) <= GROWTH

    def growth(self, z: Complex, steps: int = 16) -> Floats:
        """The largest element of the matrices to 64 samples, `steps` steps apart; infinity without an answer.

        Velocities of an oscillator are divided by w.
        """
        sizes = np.abs(self.propagated(z, 64, steps))
        if not self.problem.plane:
            sizes[..., 0, 1] *= np.abs(z)[:, None]
            sizes[..., 1, 0] /= np.abs(z)[:, None]
        sizes = np.max(sizes, axis=(1, 2, 3))
        return np.where(np.isnan(sizes), np.inf, sizes)

    def seconds_per_point(self, z: Complex) -> float:
        """Processor time of a matrix, without compilation."""
        self.matrices(z[:1])
        return max(processor_seconds(lambda: self.matrices(z)) / len(z), 1e-7)

    @property
    def bisections(self) -> int:
        return FEWER if self.problem.alone else BISECTIONS


def _quotient(first: Floats, second: Floats) -> Floats:
    """The matrix that maps the states after one step to the states after two; nan if the first is not invertible."""
    if not np.all(np.isfinite([first, second])) or abs(np.linalg.det(first)) < 1e-12 * np.max(np.abs(first)) ** 2:
        return np.full((2, 2), np.nan)
    return np.asarray(second @ np.linalg.inv(first))


def spectral_radius(matrices: Floats) -> Floats:
    """The largest modulus of an eigenvalue of each matrix (n, 2, 2); nan for a matrix that is not finite."""
    with np.errstate(all="ignore"):
        finite = np.all(np.isfinite(matrices), axis=(1, 2))
        radii = np.full(len(matrices), np.nan)
        radii[finite] = np.max(np.abs(np.linalg.eigvals(matrices[finite])), axis=-1)
    return radii


def stable_intervals(
    stable: Callable[[Floats], Flags], grid: Sequence[float] | Floats, bisections: int
) -> list[tuple[float, float]]:
    """The intervals of positive x in which `stable` holds, found on an increasing grid, with bisected edges.

    An interval begins at 0 if `stable` holds at the first point, and ends at the last point if `stable` holds there.
    """
    x = np.asarray(grid, dtype=np.float64)
    flags = np.append(stable(x), False)
    changes = np.flatnonzero(flags[1:] != flags[:-1])
    changes = changes[changes < len(x) - 1]
    low, high, before = x[changes], x[changes + 1], flags[changes]
    for _ in range(bisections if len(changes) else 0):
        middle = (low + high) / 2
        same = stable(middle) == before
        low, high = np.where(same, middle, low), np.where(same, high, middle)
    edges = [0.0] if flags[0] else []
    edges += ((low + high) / 2).tolist()
    if flags[len(x) - 1]:
        edges.append(float(x[-1]))
    return list(zip(edges[::2], edges[1::2], strict=True))
