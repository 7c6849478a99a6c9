"""Motions from a start at zero with a slope of zero: no state there has a size that could control the first step."""

from collections.abc import Callable
from math import exp, pi, sin, sqrt
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import Constrained, FirstOrder, Form, Hybrid, Mode, SecondOrder, Values
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Tolerance
from gnomon.harness.integrators.gauss.radau import Radau5
from gnomon.harness.integrators.taylor.taylor import Taylor
from gnomon.harness.registry.lookup import own

ADAPTIVE = [
    method
    for method in own().values()
    if ".integrators." in type(method).__module__ and isinstance(method.sweep, Tolerance)
]
EVERY = pytest.mark.parametrize("method", ADAPTIVE, ids=lambda method: method.id)
HIGH = [method for method in ADAPTIVE if (method.order or 0) >= 8 and not isinstance(method, Taylor)]
"""Methods that resolve powers by attempts; Taylor's method reads the power from its coefficients."""
SPAN = 8.0

Accelerations = Callable[[float, Values, Values], Values]


def driven(t: float, q: Values, p: Values) -> Values:
    """An oscillator of rate p0, driven at the rate p1."""
    return (p[2] * sin(p[1] * t) - p[0] * p[0] * q[0],)


def steep(t: float, q: Values, p: Values) -> Values:
    """A motion that begins as t^12: no pair of lower order resolves its beginning, however short the step."""
    square = t * t
    fourth = square * square
    return (p[2] * fourth * fourth * square + 0 * q[0],)


def beside(accelerations: Accelerations) -> Accelerations:
    """The same motion beside a slow oscillator, whose state has a size from the start on."""

    def both(t: float, q: Values, p: Values) -> Values:
        return *accelerations(t, q[:1], p), -q[1] / 1024

    return both


def with_plane(accelerations: Accelerations) -> Accelerations:
    def all_of_them(t: float, q: Values, p: Values) -> Values:
        return *accelerations(t, q[:-1], p), 0 * q[0]

    return all_of_them


def height(t: float, q: Values, p: Values) -> Values:
    return (q[-1],)


def upward(t: float, q: Values, p: Values) -> Values:
    return (*(0 * x for x in q[:-1]), 1 + 0 * q[0])


def only(t: float, state: Values, p: Values) -> str:
    return "motion"


def form_for(method: Integrator, accelerations: Accelerations) -> Form:
    """The motion in a form that the method accepts."""

    def slopes(t: float, state: Values, p: Values) -> Values:
        n = len(state) // 2
        return *state[n:], *accelerations(t, state[:n], p)

    kind = method.accepts[-1]
    if kind is SecondOrder:
        return SecondOrder(accelerations)
    if kind is Hybrid:
        return Hybrid(modes=(Mode("motion", slopes),), start=only, transitions=(), settle=1e-9)
    if kind is Constrained:
        return Constrained(slopes, force=accelerations, constraint=height, gradient=upward)
    return FirstOrder(slopes)


def found(
    method: Integrator,
    accelerations: Accelerations,
    p: Any,
    others: Any = (),
    tolerance: float = 1e-6,
    first: Any = (0.0, 0.0),
) -> tuple[Floats, int]:
    """Position and velocity (samples, 2) of the first coordinate, and the number of steps.

    `first`: position and velocity at the start; `others`: the positions at which the other coordinates rest.
    """
    if method.accepts[-1] is Constrained:
        accelerations, others = with_plane(accelerations), (*others, 1.0)
    n = 1 + len(others)
    times = np.arange(1, 5) * (SPAN / 4)
    problem = Problem(form_for(method, accelerations), 2 * n, np.array(p), times, SPAN)
    solution = method.prepare(problem, tolerance)(np.array([[first[0], *others, first[1], *[0.0] * (n - 1)]]))
    assert solution.stopped is None
    return solution.states[0][:, [0, n]], solution.steps or 0


def exact(accelerations: Accelerations, p: Any) -> Floats:
    t = np.arange(1, 5) * (SPAN / 4)
    w, d, a = p
    if accelerations is steep:
        return a * np.stack([t**12 / 132, t**11 / 11], axis=1)
    place, speed = np.sin(d * t) - d / w * np.sin(w * t), d * (np.cos(d * t) - np.cos(w * t))
    return a / (w * w - d * d) * np.stack([place, speed], axis=1)


MOTIONS = {
    "of one time scale": (driven, (1.0, 2.0, 1.0)),
    "with a fast drive": (driven, (1.0, 40.0, 1.0)),
    "of a fast oscillator": (driven, (50.0, 40.0, 1.0)),
    "of a high power": (steep, (1.0, 1.0, 1.0)),
}
"""The time scale that a method is given is the span: the first attempt may be one over many periods."""


@EVERY
@pytest.mark.parametrize("motion", MOTIONS)
@pytest.mark.parametrize("alone", [True, False], ids=["alone", "beside a slow motion"])
def test_a_step_adds_its_tolerance_to_the_error(method: Integrator, motion: str, alone: bool) -> None:
    """The oscillators keep the size of an error. The norm of four components is their root mean square, so the error of
    one of them may be twice the tolerance. Without a size at the start, errors were up to 1e20 tolerances."""
    accelerations, p = MOTIONS[motion]
    if not alone and isinstance(method, Radau5):
        pytest.skip("compiled for each dimension, in ten seconds")
    tolerance, wanted = 1e-5, exact(accelerations, p)
    states, steps = (
        found(method, accelerations, p, tolerance=tolerance)
        if alone
        else found(method, beside(accelerations), p, (1.0,), tolerance)
    )
    error = np.max(np.abs(states - wanted) / np.max(np.abs(wanted), axis=0))
    assert error <= 2 * steps * tolerance


@EVERY
@pytest.mark.parametrize("motion", MOTIONS)
def test_steps_from_rest_do_not_depend_on_units(method: Integrator, motion: str) -> None:
    """No absolute number decides whether a motion has a size: a force of 2^-200 gives the same bits as one of 1."""
    accelerations, (w, d, one) = MOTIONS[motion]
    (small, few), (states, steps) = (found(method, accelerations, (w, d, size)) for size in (2.0**-200 * one, one))
    assert few == steps
    assert np.array_equal(small * 2.0**200, states)


def starting_late(t: float, q: Values, p: Values) -> Values:
    """Nothing moves, to all digits, in the first third of the span; then a pulse."""
    late = 8 * t - 40
    return (p[2] * exp(-late * late) + 0 * q[0],)


@EVERY
def test_a_motion_that_starts_late_is_not_passed_over(method: Integrator) -> None:
    """A step at rest may be long. If it ends after the pulse, the state there has the size of the error."""
    states, _ = found(method, starting_late, (0.0, 0.0, 1.0), tolerance=1e-6)
    assert states[-1, 1] == pytest.approx(sqrt(pi) / 8, rel=1e-3)


@pytest.mark.parametrize("method", HIGH, ids=lambda method: method.id)
def test_a_high_power_is_not_resolved_from_its_first_moment(method: Integrator) -> None:
    """The size at the longest attempt that follows the power controls the first steps: three to five times the steps of the
    same force on a motion with its final size. Relative to its own size, t^12 would take as many steps for each factor of
    time, from 1e-8 of the span on: more than twenty times."""
    p = 1.0, 1.0, 1.0
    _, steps = found(method, steep, p)
    _, known = found(method, steep, p, first=exact(steep, p)[-1])
    assert steps < 8 * known
