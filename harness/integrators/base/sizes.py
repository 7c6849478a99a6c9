"""The error norm of adaptive methods: the error of each component is divided by the size of its group.

The size of a group is the largest absolute value of its components at the ends of all steps so far; in the first step
it is at least the change at the rates of the start. A group that is still at zero takes its size at the end of the
attempted step: if it were left out, no error would limit the first step from rest. A motion that leaves zero as a power
of time above the order has an error of its own size in a step of any length. Then the size is the size at the end of
the longest attempt from which on, down to steps of `SHORTEST`, the motion follows one power. A size from attempts alone
would be wrong: over many periods of an oscillator an explicit step grows as a power of its length, too.

After a rejected step, the rates are evaluated once more, at the state perturbed by its round-off: a shorter step cannot
reduce an error below the effect of this perturbation over a step (a pendulum that stands upright stays there). The norm
does not depend on units: if lengths or times are scaled by a power of two, the steps are equal but scaled.

Sizes never decrease. At equal error, this takes 8 % fewer right-hand sides than 1 + |y| (`absolute`) with DOP853 and 12
% fewer with Radau IIA 5, in the geometric mean over pendulums, Kepler's orbits of e = 0.3 to 0.999, Duffing's
oscillator, tops and damped oscillators; 12 to 55 % fewer at e = 0.99, where the error of a slow body far out matters
least. Dormand and Prince's 5(4) and extrapolation take as many, within 2 %: a tolerance that gives a larger error gives
less work. Sizes that decrease with the state to 1/4 or 1/16 of the largest size, or by half in 32 steps, lose most or
all of this gain, and take up to 28 % more on oscillators, whose states pass through zero. Relaxation oscillations are
an exception: the phase of Van der Pol's oscillator (mu = 10 and 100) depends on its slow parts, whose rates are a
hundredth of the largest rate, and most adaptive methods take 7 to 35 % more than with `absolute`. For these motions use
`absolute`, in units in which slow rates are about 1.

`groups` (dim,) has the index of the group of each component, `sizes` (dim,) the size of each group, `inverse` (dim,)
the reciprocal of the size of each component's group.
"""

from math import log, sqrt

import numpy as np
from gnomon.harness.contract.integrator import Floats
from numpy.typing import NDArray

Integers = NDArray[np.int64]

ABSOLUTE = 0
"""Set when a method is compiled: 1 if errors are divided by 1 + |y| in SI units instead of by sizes."""

SMALLEST = 2.0**-1022
"""The smallest normal number: smaller sizes are replaced by it, so that their reciprocals are finite."""

LAST_STEP, LAST_SIZE, POWER, STEADY, LONGEST, YOUNG = 0, 1, 2, 3, 4, 5
"""Rows of the array `young` (YOUNG, dim), for components of groups that a step moves from zero, over the attempts at this
step. LAST_STEP, LAST_SIZE: step and size of the last attempt; POWER: the power of the step that sizes follow; STEADY:
the size at the longest attempt from which on they do; LONGEST: the step of the first attempt, 0 before it."""

SHORTEST = 1e-8
"""The shortest step of a search for the size of a group, as a fraction of a time scale."""

TRIAL = 1e-6
"""The longest trial step, as a fraction of the argument `most` of `trial_step`."""


def enlarge(values: Floats, groups: Integers, sizes: Floats) -> bool:
    """Raise the sizes of groups to the absolute values of their components; returns whether one was raised."""
    raised = False
    for i in range(values.size):
        if abs(values[i]) > sizes[groups[i]]:
            sizes[groups[i]] = abs(values[i])
            raised = True
    return raised


def invert(groups: Integers, sizes: Floats, inverse: Floats) -> None:
    """Set `inverse` to the reciprocal of the size of each component's group, 0 for a group without a size."""
    for i in range(inverse.size):
        size = sizes[groups[i]]
        inverse[i] = 1.0 / max(size, SMALLEST) if size > 0.0 else 0.0


def first_sizes(y: Floats, changes: Floats, groups: Integers, sizes: Floats, inverse: Floats) -> None:
    """Set the sizes from the initial state `y`; `inverse` also includes the `changes` of a first step at its rates."""
    sizes[:] = 0.0
    enlarge(changes, groups, sizes)
    enlarge(y, groups, sizes)
    invert(groups, sizes, inverse)
    sizes[:] = 0.0
    enlarge(y, groups, sizes)


def size_by_end(h: float, end: Floats, groups: Integers, inverse: Floats, young: Floats) -> bool:
    """Set `inverse` of groups at zero from their size at the `end` of an attempt; returns whether one has moved.

    `young` (YOUNG, dim) follows their sizes over the attempts at a step.
    """
    moved = False
    for i in range(inverse.size):
        moved = moved or (ABSOLUTE == 0 and inverse[i] == 0.0 and end[i] != 0.0)
    if moved:
        for i in range(inverse.size):
            if inverse[i] == 0.0:
                size = 0.0
                for j in range(inverse.size):
                    if groups[j] == groups[i]:
                        size = max(size, abs(end[j]))
                if 0.0 < size < np.inf:
                    inverse[i] = 1.0 / max(size, SMALLEST)
                    follow_power(h, size, i, young)
    return moved


def follow_power(h: float, size: float, i: int, young: Floats) -> None:
    """Record in `young` the size of component i after a tried step h, and the power of h that the size follows."""
    if young[LONGEST, i] == 0.0:
        young[LONGEST, i], young[STEADY, i], young[POWER, i] = h, size, 0.0
    else:
        power = log(young[LAST_SIZE, i] / size) / log(young[LAST_STEP, i] / h)
        if young[POWER, i] > 0.0 and abs(power - young[POWER, i]) > 0.5:
            young[STEADY, i] = size
        young[POWER, i] = power
    young[LAST_STEP, i], young[LAST_SIZE, i] = h, size


def size_by_power(groups: Integers, sizes: Floats, young: Floats) -> float:
    """Give groups at zero their steady sizes, which ends the search at this step; returns its first attempt."""
    longest = 0.0
    for i in range(groups.size):
        if young[LONGEST, i] > 0.0:
            sizes[groups[i]] = max(sizes[groups[i]], young[STEADY, i])
            longest = max(longest, young[LONGEST, i])
    forget(young)
    return longest


def forget(young: Floats) -> None:
    """Begin the attempts at another step."""
    for i in range(young.shape[1]):
        young[LONGEST, i] = 0.0


def perturb_by_roundoff(y: Floats, x: Floats) -> None:
    """Set `x` to the first components of `y`, perturbed by one to three units of round-off of alternating sign."""
    for i in range(x.size):
        x[i] = y[i] + (1 + i % 3) * (-1) ** i * 2.0**-52 * abs(y[i])


def enlarge_roundoff(slope: Floats, perturbed: Floats, first: int, groups: Integers, rough: Floats) -> None:
    """Raise `rough`, the effect of round-off of the state on the rates of each group, to |perturbed - slope|.

    The slopes belong to the components from `first` on.
    """
    for i in range(slope.size):
        rough[groups[first + i]] = max(rough[groups[first + i]], abs(perturbed[i] - slope[i]))


def limit_by_roundoff(share: float, groups: Integers, rough: Floats, inverse: Floats) -> bool:
    """Limit `inverse` so that errors are divided by at least the effect of round-off on a step over the tolerance.

    This effect is 4 h |change of the rate|. `share`: the step over the tolerance. Returns whether a component is near
    the limit.
    """
    near = False
    for i in range(inverse.size):
        level = 4.0 * share * rough[groups[i]]
        near = near or level * inverse[i] > 0.1
        if level * inverse[i] > 1.0:
            inverse[i] = 1.0 / level
    return near


def one_over(i: int, y: Floats, end: Floats, inverse: Floats) -> float:
    """The reciprocal of the number that divides the error of component i."""
    if ABSOLUTE == 1:
        return float(1.0 / (1.0 + max(abs(y[i]), abs(end[i]))))
    return float(inverse[i])


def trial_step(y: Floats, rates: Floats, groups: Integers, most: float) -> float:
    """A step over which rates differ measurably.

    It is a millionth of `most`, but not above a hundredth of the time in which the slowest group changes by its own
    size.
    """
    size, rate = np.zeros(y.size), np.zeros(y.size)
    enlarge(y, groups, size)
    enlarge(rates, groups, rate)
    slowest = 0.0
    for g in range(y.size):
        if size[g] > 0.0:
            slowest = max(slowest, size[g] / rate[g] if rate[g] > 0.0 else np.inf)
    return min(TRIAL * most, 0.01 * slowest) if slowest > 0.0 else TRIAL * most


def turning_time(y: Floats, rates: Floats, later: Floats, h: float, groups: Integers, most: float) -> float:
    """The time in which the motion leaves its tangent: the least T of a group with |y''| T^2 = |y| + |y'| T.

    The state, its `rates`, and the rates `later` after a step of h along the tangent determine it; at most `most`.
    """
    size, rate, bend, change = np.zeros(y.size), np.zeros(y.size), np.zeros(y.size), np.empty(y.size)
    for i in range(y.size):
        change[i] = (later[i] - rates[i]) / h
    enlarge(y, groups, size)
    enlarge(rates, groups, rate)
    enlarge(change, groups, bend)
    least = most
    for g in range(y.size):
        s, d, b = size[g], rate[g], bend[g]
        if b > 0.0 and (s > 0.0 or d > 0.0):
            # d/b is a time and s/b the square of a time: no product of two sizes overflows.
            half = d / b / 2
            least = min(least, half + sqrt(half * half + s / b))
    return least
