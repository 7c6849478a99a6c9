"""Exactly linear problems, one for each form: a step of any method is then a matrix, at any amplitude.

In most of them the eigenvalue is part of the state, so that one `prepare` and one ensemble serve all eigenvalues. For
gravitating bodies and scenes of physics engines it is a parameter.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from math import sqrt
from typing import Any

import numpy as np
from gnomon.cases.core.forms import (
    Charged,
    Constrained,
    FirstOrder,
    Hybrid,
    Impact,
    Mode,
    NBody,
    RigidBody,
    SecondOrder,
    SemiLinear,
    Values,
)
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Floats, Integrator
from gnomon.harness.contract.problem import first_taken
from numpy.typing import NDArray

Complex = NDArray[np.complexfloating[Any, Any]]

SMALL = 2.0**-30
"""Amplitude for problems that are linear only for small motions: its squares are below the unit round-off."""
LIGHT = 2.0**60
"""A speed of light so large that every motion is slow."""
FAR = 2.0**20
"""Distance of a wall that is never reached."""


@dataclass(frozen=True)
class LinearProblem:
    """y1 + i y2 follows y' = z y with time steps of 1; for an oscillator, z = i w, y1'' = -w^2 y1 and y2 = y1'/w.

    `start(z, y)`: the states (n, dim) for z (n,) and y (n, 2). `read(states)` -> (..., 2): y1 and y2, or for an
    oscillator y1 and y1'. `plane`: whether z may be any complex number. `parameters(z)`: the parameters of the form.
    `alone`: whether they depend on z.
    """

    what: str
    form: Any
    dimension: int
    start: Callable[[Complex, Floats], Floats]
    read: Callable[[Floats], Floats]
    plane: bool = False
    alone: bool = False
    parameters: Callable[[complex], tuple[float, ...]] = lambda z: ()


def problem_for(integrator: Integrator) -> LinearProblem | None:
    """The exactly linear problem whose form the integrator accepts; None without one."""
    form = first_taken(integrator, [problem.form for problem in PROBLEMS])
    return next((problem for problem in PROBLEMS if problem.form is form), None)


def rotation_equations(t: Any, state: Values, parameters: Values) -> Values:
    """y' = (a + i b) y, with y = u + i v."""
    a, b, u, v = state
    return 0 * a, 0 * b, a * u - b * v, b * u + a * v


def spring_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """x'' = -k x, k constant; a third coordinate stays 0."""
    x, k = q
    return -(k * x), 0 * k


def spring_field(t: Any, place: Values, parameters: Values) -> Values:
    """The spring as electric field, without a magnetic field."""
    x, k, z = place
    return -(k * x), 0 * k, 0 * z, 0 * x, 0 * x, 0 * x


def spring_in_space(t: Any, state: Values, parameters: Values) -> Values:
    """`spring_acceleration` as equations of first order, with the constant k and a coordinate z at rest."""
    x, k, z, vx, vk, vz = state
    return vx, vk, vz, -(k * x), 0 * k, 0 * z


def slow_spring_in_space(t: Any, state: Values, parameters: Values) -> Values:
    """`spring_in_space` for a charge whose Lorentz factor is 1 to far below an ulp."""
    x, k, z, ux, uk, uz = state
    factor = sqrt(1 + (ux * ux + uk * uk + uz * uz) / (LIGHT * LIGHT))
    return ux / factor, uk / factor, uz / factor, -(k * x), 0 * k, 0 * z


def speed_of_light(parameters: Values) -> Values:
    return (LIGHT,)


def spring_force(t: Any, q: Values, parameters: Values) -> Values:
    x, k, z = q
    return -(k * x), 0 * k, 0 * z


def on_plane(t: Any, q: Values, parameters: Values) -> Values:
    """The constraint z = 0 on q = (x, k, z)."""
    return (q[2],)


def plane_normal(t: Any, q: Values, parameters: Values) -> Values:
    """The gradient of `on_plane`."""
    x, k, z = q
    return 0 * x, 0 * k, 0 * z + 1


def no_linear_part(parameters: Values) -> Values:
    """The matrix 0: the whole equation is in the rest, which the method integrates step by step."""
    return (0,) * 16


def symmetric_inertia(parameters: Values) -> Values:
    return 1, 1, 2


def no_torque(t: Any, state: Values, parameters: Values) -> Values:
    return 0 * t, 0 * t, 0 * t


def spring_above_wall(t: Any, state: Values, parameters: Values) -> Values:
    x, k, vx, vk = state
    return vx, vk, -(k * x), 0 * k


def far_wall(t: Any, q: Values, parameters: Values) -> Values:
    """The gap to a wall at x = -FAR, which the motion never reaches."""
    return (q[0] + FAR,)


def wall_normal(t: Any, q: Values, parameters: Values) -> Values:
    """The gradient of `far_wall`."""
    x, k = q
    return 0 * x + 1, 0 * k


def elastic(parameters: Values) -> Values:
    return (1,)


def one_mode(t: Any, state: Values, parameters: Values) -> str:
    return "free"


def _in_plane(z: Complex, y: Floats) -> Floats:
    return np.column_stack([z.real, z.imag, y])


def _spring(*more: int) -> Callable[[Complex, Floats], Floats]:
    """Starts of positions x, k and `more` zeros, then their velocities."""
    zeros = [np.zeros] * sum(more)

    def start(z: Complex, y: Floats) -> Floats:
        rest = [zero(len(z)) for zero in zeros]
        return np.column_stack([y[:, 0], z.imag**2, *rest, y[:, 1], np.zeros(len(z)), *rest])

    return start


def _spinning(z: Complex, y: Floats) -> Floats:
    """Starts with attitude 1 and small components of the angular velocity across the axis, which turns with z.imag."""
    return np.column_stack([SMALL * y, z.imag, np.tile(np.eye(3).ravel(), (len(z), 1))])


def _above_primaries(z: Complex, y: Floats) -> Floats:
    """A particle on the axis of two primaries, which move on a circle by steps of drift, kick and drift.

    At the kicks, in the middle of the steps, the primaries are at distance 1 from the axis.
    """
    rows = []
    for w, (height, speed) in zip(z.imag, y, strict=True):
        n = w / sqrt(8)
        radius = math.cos(math.asin(min(n / 2, 1.0)))
        right, left = [radius, 0, 0, 0, n, 0], [-radius, 0, 0, 0, -n, 0]
        rows.append([*right, *left, 0, 0, SMALL * height, 0, 0, SMALL * speed])
    return np.array(rows, dtype=np.float64)


def primary_masses(parameters: Values) -> Values:
    return parameters[0], parameters[0], 0.0


def three_bodies(state: Values) -> tuple[Values, ...]:
    return tuple(tuple(state[k : k + 6]) for k in (0, 6, 12))


def of_three_bodies(bodies: tuple[Values, ...]) -> Values:
    return tuple(number for body in bodies for number in body)


def _columns(first: int, second: int, scale: float = 1.0) -> Callable[[Floats], Floats]:
    return lambda states: states[..., [first, second]] / scale


PLANE = FirstOrder(rotation_equations)
WALL = Impact(
    modes=(Mode("free", spring_above_wall),), start=one_mode, transitions=(), settle=1e-9, free=spring_above_wall,
    gap=far_wall, normal=wall_normal, restitution=elastic,
)  # fmt: skip
BODIES = NBody(primary_masses, three_bodies, of_three_bodies)
IN_PLANE = "y' = z y"
SPRING = "x'' = -w^2 x"

PROBLEMS = (
    LinearProblem(IN_PLANE, PLANE, 4, _in_plane, _columns(2, 3), plane=True),
    LinearProblem(SPRING, SecondOrder(spring_acceleration), 4, _spring(), _columns(0, 2)),
    LinearProblem(
        f"{IN_PLANE}, outside the linear part", SemiLinear(rotation_equations, linear=no_linear_part,
        rest=rotation_equations), 4, _in_plane, _columns(2, 3), plane=True,
    ),
    LinearProblem(
        f"{SPRING}, in an electric field", Charged(spring_in_space, fields=spring_field), 6, _spring(1), _columns(0, 3)
    ),
    LinearProblem(
        f"{SPRING}, in an electric field, by relativistic equations",
        Charged(slow_spring_in_space, fields=spring_field, light=speed_of_light), 6, _spring(1), _columns(0, 3),
    ),
    LinearProblem(
        f"{SPRING}, in a plane",
        Constrained(spring_in_space, force=spring_force, constraint=on_plane, gradient=plane_normal),
        6, _spring(1), _columns(0, 3),
    ),
    LinearProblem("a small nutation of a symmetric body", RigidBody(symmetric_inertia, no_torque), 12, _spinning,
                  _columns(0, 1, SMALL)),
    LinearProblem(
        f"{IN_PLANE}, without events",
        Hybrid(modes=(Mode("free", rotation_equations),), start=one_mode, transitions=(), settle=1e-9),
        4, _in_plane, _columns(2, 3), plane=True,
    ),
    LinearProblem(f"{SPRING}, far from a wall", WALL, 4, _spring(), _columns(0, 2)),
    LinearProblem(
        "a particle on the axis of two bodies on a circle", BODIES, 18, _above_primaries, _columns(14, 17, SMALL),
        alone=True, parameters=lambda z: (z.imag**2 / 2,),
    ),
    LinearProblem(
        "a mass on a spring", get("harmonic_oscillator").scene, 2, lambda z, y: y, _columns(0, 1),
        alone=True, parameters=lambda z: (1.0, z.imag**2),
    ),
)  # fmt: skip
"""In order, from the most general form."""
