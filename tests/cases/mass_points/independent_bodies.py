"""Second derivations for rigid bodies, each made of a few mass points with its mass, centre and moments."""

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import flint
from independent_mechanics import (
    Vec,
    World,
    coefficient,
    cos,
    cross,
    dot,
    polar,
    rate,
    sin,
    turned,
    velocity,
)
from independent_models import model

ORIGIN = Vec((0, 0, 0))


def solid(
    w: World,
    moments: Sequence[Any],
    axes: Sequence[Vec],
    centre: Vec = ORIGIN,
    mass: Any = 0,
    gravity: Sequence[Any] | None = None,
) -> list[tuple[Any, Vec]]:
    """A body with these principal moments about `centre`: points at distance 1 on its axes, the rest at the centre.

    The moments are sums of m (y^2 + z^2), so the sum of m x^2 is half the sum of all three less the one about x.
    """
    total = (moments[0] + moments[1] + moments[2]) / 2
    points = [
        ((total - moment) / 2, place)
        for moment, axis in zip(moments, axes, strict=True)
        for place in (centre + axis, centre - axis)
    ]
    points.append((mass - total, centre))
    for m, place in points:
        w.mass(m, place, gravity)
    return points


def flat_body(w: World, mass: Any, moment: Any, centre: Vec, angle: Any, gravity: Sequence[Any] | None = None) -> None:
    """A body that moves in a plane, with a moment about its centre."""
    for m, place in ((mass - moment, centre), *((moment / 2, centre + polar(side, angle)) for side in (1, -1))):
        w.mass(m, place, gravity)


def rod(w: World, mass: Any, one: Vec, other: Vec, gravity: Sequence[Any]) -> None:
    """A uniform rod: a sixth of its mass at each end, the rest in the middle (Simpson's rule)."""
    for share, place in ((1, one), (4, (one + other) / 2), (1, other)):
        w.mass(flint.arb(mass) * share / 6, place, gravity)


def small_turn(q: Sequence[Any]) -> list[Vec]:
    """Rows of exp(hat q) to second order about q = 0, which suffices for accelerations there."""
    h = [(0, -q[2], q[1]), (q[2], 0, -q[0]), (-q[1], q[0], 0)]
    return [
        Vec(int(i == j) + h[i][j] + sum(h[i][k] * h[k][j] for k in range(3)) / 2 for j in range(3)) for i in range(3)
    ]


def times(a: Sequence[Sequence[Any]], b: Sequence[Sequence[Any]]) -> list[Vec]:
    return [Vec(dot(row, column) for column in columns(b)) for row in a]


def columns(a: Sequence[Sequence[Any]]) -> list[Vec]:
    return [Vec(column) for column in zip(*a, strict=True)]


def attitude(s: SimpleNamespace) -> list[Vec]:
    return [Vec(getattr(s, f"R{i}{j}") for j in (1, 2, 3)) for i in (1, 2, 3)]


def spin(axes: Sequence[Vec]) -> Vec:
    """The angular velocity of orthonormal axes: half the sum of e x e'."""
    parts = [cross(e, [rate(x) for x in e]) for e in axes]
    return (parts[0] + parts[1] + parts[2]) / 2


def orthogonal(source: Any, p: Any, s: Any, mode: str) -> None:
    """A random attitude: a product of two rotations."""
    start = [Vec((1, 0, 0)), Vec((0, 1, 0)), Vec((0, 0, 1))]
    for axis in (start[2], Vec((3, 0, 4)) / flint.arb(5)):
        angle = flint.arb(source.uniform(-3, 3))
        start = [turned(row, axis, angle) for row in start]
    for i, row in enumerate(start, 1):
        for j, x in enumerate(row, 1):
            setattr(s, f"R{i}{j}", flint.arb(x))


def turning_there(p: Any, s: SimpleNamespace) -> Any:
    return [0, 0, 0], [s.w1, s.w2, s.w3]


def turning_back(p: Any, s: Any, q: Sequence[Any]) -> list[Any]:
    """Body components of w, and R = R(0) exp(hat q) row by row."""
    turn = times(attitude(s), small_turn(q))
    in_space = spin(columns(turn))
    w = [dot(in_space, axis) for axis in columns(turn)]
    return [*w, *(x for row in turn for x in row)]


def body_axes(w: World, q: Sequence[Any]) -> list[Vec]:
    return columns(times(attitude(w.s), small_turn(q)))


BODY = {"there": turning_there, "back": turning_back, "prepare": orthogonal}


@model("euler_top", **BODY)
def free_top(w: World, p: Any, *q: Any) -> None:
    solid(w, (p.I1, p.I2, p.I3), body_axes(w, q))


@model("symmetric_top_torque_free", **BODY)
def symmetric_top(w: World, p: Any, *q: Any) -> None:
    solid(w, (p.A, p.A, p.C), body_axes(w, q))


@model("lagrange_top_attitude", **BODY)
def heavy_top(w: World, p: Any, *q: Any) -> None:
    axes = body_axes(w, q)
    solid(w, (p.I1, p.I1, p.I3), axes)
    w.energy(p.W * axes[2][2])


def in_stokes_medium(w: World, points: Sequence[tuple[Any, Vec]], nu: Any) -> None:
    for m, place in points:
        w.force(place, -velocity(place) * (nu * m))


@model("rigid_body_stokes_medium", **BODY)
def braked_body(w: World, p: Any, *q: Any) -> None:
    in_stokes_medium(w, solid(w, (p.I1, p.I2, p.I3), body_axes(w, q)), p.nu)


@model("rigid_body_stokes_medium_torque", **BODY)
def driven_body(w: World, p: Any, *q: Any) -> None:
    """The torque is a couple of horizontal forces at two points of the body."""
    braked_body(w, p, *q)
    couple(w, columns(times(attitude(w.s), small_turn(q))), p.M)


def couple(w: World, axes: Sequence[Vec], torque: Any) -> None:
    """A torque about the vertical: opposite horizontal forces at the ends of the body's axes, shared among all three."""
    reach = sum(e[0] * e[0] + e[1] * e[1] for e in axes)
    for e in axes:
        w.force(e, cross((0, 0, 1), [coefficient(x, 0) for x in e]) * (torque / coefficient(reach, 0)))


def flying_there(p: Any, s: SimpleNamespace) -> Any:
    return [s.x, s.y, s.z, 0, 0, 0], [s.vx, s.vy, s.vz, s.w1, s.w2, s.w3]


def flying_back(p: Any, s: Any, q: Sequence[Any]) -> list[Any]:
    return [*q[:3], *map(rate, q[:3]), *turning_back(p, s, q[3:])]


FLYING = {"there": flying_there, "back": flying_back, "prepare": orthogonal}


@model("dynamics_of_free_rigid_body_in_gravity", **FLYING)
def thrown_body(w: World, p: Any, x: Any, y: Any, z: Any, *q: Any) -> None:
    solid(w, (p.I1, p.I2, p.I3), body_axes(w, q), Vec((x, y, z)), 1, (0, 0, -p.g))


@model("rigid_body_stokes_medium_falling", **FLYING)
def sinking_body(w: World, p: Any, x: Any, y: Any, z: Any, *q: Any) -> None:
    points = solid(w, (p.I1, p.I2, p.I3), body_axes(w, q), Vec((x, y, z)), 1, (0, 0, -p.g))
    in_stokes_medium(w, points, p.nu)


def spun(axis: Vec, across: Vec, psi: Any) -> tuple[Vec, Vec, Vec]:
    """Axes of a body whose third axis is `axis`, rotated by psi about it; `across` is perpendicular to it."""
    one = across * cos(psi) + cross(axis, across) * sin(psi)
    return one, cross(axis, one), axis


def euler_axes(theta: Any, phi: Any, psi: Any) -> tuple[Vec, Vec, Vec]:
    """The axes of R = Rz(phi) Rx(theta) Rz(psi): rotations about the vertical, the line of nodes and the axis."""
    nodes = Vec((cos(phi), sin(phi), 0))
    return spun(turned((0, 0, 1), nodes, theta), nodes, psi)


EULER = {
    "there": lambda p, s: ([s.theta, s.phi, s.psi], [s.omega_theta, None, None]),
    "back": lambda p, s, q: [q[0], rate(q[0]), q[1], q[2]],
}


@model("lagrange_top", momenta=lambda p: {1: p.b, 2: p.a}, **EULER)
@model("lagrange_top_sleeping_separatrix", momenta=lambda p: {1: p.a, 2: p.a}, **EULER)
@model(
    "lagrange_top_small_nutation",
    momenta=lambda p: {1: p.b, 2: p.a},
    about=lambda p, s: SimpleNamespace(**(vars(s) | {"theta": p.tilt, "omega_theta": flint.arb(0)})),
    **EULER,
)
def top(w: World, p: Any, theta: Any, phi: Any, psi: Any) -> None:
    axes = euler_axes(theta, phi, psi)
    solid(w, (p.I1, p.I1, p.I3), axes)
    w.energy(p.W * axes[2][2])


def fast_top(p: Any, t: Any, s: Any) -> list[Any]:
    """The angular momentum is a along the axis: the weight turns it about the vertical, without nutation."""
    path = [flint.arb_series([s.theta], 3), flint.arb_series([s.phi, 1], 3), flint.arb_series([s.psi], 3)]
    axis = euler_axes(*path)[2]
    here, turning = Vec(coefficient(x, 0) for x in axis), velocity(axis)
    torque = cross(here, (0, 0, -p.W))
    slow = dot(torque, turning) / (p.a * dot(turning, turning))
    return [flint.arb(0), flint.arb(0), slow, p.a / p.I3 - slow * here[2]]


model("lagrange_top_fast", own=fast_top)(top)
