"""Second derivations on a rotating planet: an inertial position is that on the planet, rotated in time.

`g` is apparent gravity in most of these cases: then a force is added with which a point at rest on the planet is in
equilibrium, the mass times the acceleration of such a point in the inertial frame.
"""

from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import flint
from independent_bodies import solid, spun
from independent_mechanics import Vec, World, coefficient, cos, cross, dot, length, rate, sin, sqrt, turned, velocity
from independent_models import at_rest, model

UP = Vec((0, 0, 1))


def pole(lat: Any) -> Vec:
    """The axis of the Earth: x east, y north, z up."""
    return Vec((0, cos(lat), sin(lat)))


def in_space(w: World, place: Sequence[Any], axis: Vec, turn: Any) -> Vec:
    return turned(place, axis, turn * w.t)


def carried(w: World, place: Sequence[Any], axis: Vec, turn: Any) -> Vec:
    """The acceleration in space of the point of the planet that is now at a position."""
    still = in_space(w, [coefficient(x, 0) for x in place], axis, turn)
    return Vec(2 * coefficient(x, 2) for x in still)


def apparent_weight(w: World, p: Any, place: Vec, at: Vec | None = None) -> None:
    """For mass 1: g, and the force with which a point rests at `at`, by default at `place` itself."""
    axis = pole(p.lat)
    w.mass(1, in_space(w, place, axis, p.Om))
    w.force(in_space(w, place, axis, p.Om), in_space(w, UP * -p.g, axis, p.Om))
    w.force(in_space(w, place, axis, p.Om), carried(w, place if at is None else at, axis, p.Om))


@model("free_fall_rotating_earth")
def falling(w: World, p: Any, x: Any, y: Any, z: Any) -> None:
    apparent_weight(w, p, Vec((x, y, z)))


@model("free_fall_rotating_frame_centrifugal")
def falling_about_the_axis(w: World, p: Any, x: Any, y: Any, z: Any) -> None:
    apparent_weight(w, p, Vec((x, y, z)), at=Vec((0, 0, 0)))


@model("free_fall_first_order")
def falling_with_the_unperturbed_velocity(w: World, p: Any, x: Any, y: Any, z: Any) -> None:
    """The force on a point that moves through the axis with the velocity u + g t."""
    w.mass(1, (x, y, z), (0, 0, -p.g))
    unperturbed = Vec((p.ux, p.uy, p.uz)) - UP * (p.g * w.t[0])
    since = w.t - w.t[0]
    path = turned(unperturbed * since, pole(p.lat), p.Om * since)
    w.force((x, y, z), [-2 * coefficient(c, 2) for c in path])


@model("tower_drop")
def falling_from_a_tower(w: World, p: Any, x: Any, y: Any, z: Any) -> None:
    place = in_space(w, (x, y, p.R + z), pole(p.lat), p.Om)
    w.mass(1, place)
    w.energy(-p.g * p.R * p.R / length(place))


@model("inertial_straight_line")
def straight_line(w: World, p: Any, x: Any, y: Any) -> None:
    w.mass(1, in_space(w, (x, y, 0), UP, p.Om))


@model("planet_tunnel_rotating")
def in_a_shaft(w: World, p: Any, x: Any, y: Any) -> None:
    w.mass(1, in_space(w, (x, y, 0), UP, p.Om))
    w.energy(p.g / p.R * (x * x + y * y) / 2)


def tangent(source: Any, p: Any, s: Any, mode: str) -> None:
    """A point off the unit sphere, as a rounded start may be, with a velocity tangent to the sphere through it."""
    e, v = Vec((s.ex, s.ey, s.ez)), Vec((s.vx, s.vy, s.vz))
    s.vx, s.vy, s.vz = v - e * (dot(e, v) / dot(e, e))


@model("foucault_pendulum_nonlinear", prepare=tangent)
def foucault_pendulum(w: World, p: Any, ex: Any, ey: Any, ez: Any) -> None:
    """e is the position over the length."""
    place = Vec((ex, ey, ez)) * p.L
    apparent_weight(w, p, place)
    w.keep(dot(place, place))


def below(p: Any, x: Any, y: Any) -> Vec:
    """The position on the sphere about the support, which is the origin."""
    return Vec((x, y, -sqrt(p.L * p.L - x * x - y * y)))


@model("foucault_pendulum_linear", about=at_rest)
def foucault_linear(w: World, p: Any, x: Any, y: Any) -> None:
    apparent_weight(w, p, below(p, x, y))


@model("foucault_pendulum_centrifugal", about=at_rest)
def foucault_centrifugal(w: World, p: Any, x: Any, y: Any) -> None:
    """g is apparent gravity at the point of rest only."""
    apparent_weight(w, p, below(p, x, y), at=below(p, flint.arb(0), flint.arb(0)))


@model("foucault_precession", about=at_rest)
def foucault_precession(w: World, p: Any, x: Any, y: Any) -> None:
    """A swing above ground that rotates about the local vertical at the vertical component of the Earth's rate."""
    place = in_space(w, below(p, x, y), UP, p.Om * sin(p.lat))
    w.mass(1, place, (0, 0, -p.g))


COMPASS = {
    "there": lambda p, s: ([s.theta, 0], [s.omega, None]),
    "momenta": lambda p: {1: p.C * p.s},
    "back": lambda p, s, q: [q[0], rate(q[0])],
}
"""The axial spin as a constant momentum."""


def rotor(w: World, p: Any, axis: Vec, across: Vec, psi: Any, earth: Vec) -> None:
    """A symmetric body on the rotating Earth, about its centre."""
    solid(w, (p.A, p.A, p.C), [in_space(w, e, earth, p.Om) for e in spun(axis, across, psi)])


def earth_axis(p: Any) -> Vec:
    return Vec((0, p.coslat, sqrt(1 - p.coslat * p.coslat)))


@model("gyrocompass", **COMPASS)
def gyrocompass(w: World, p: Any, theta: Any, psi: Any) -> None:
    axis = Vec((sin(theta), cos(theta), 0))
    rotor(w, p, axis, UP, psi, earth_axis(p))


def slow_earth(p: Any, s: SimpleNamespace, small: Any) -> Any:
    """A fast spin on a slowly rotating Earth: their product stays constant, the square of the Earth's rate vanishes."""
    return SimpleNamespace(**(vars(p) | {"Om": p.Om * small, "s": p.s / small})), s


@model("gyrocompass_damped_nonlinear", **COMPASS)
@model("gyrocompass_damped", about=at_rest, limit=slow_earth, **COMPASS)
def damped_gyrocompass(w: World, p: Any, theta: Any, psi: Any) -> None:
    """The damper is fixed to the Earth: at distance 1 on the axis, its force is c times the relative velocity."""
    gyrocompass(w, p, theta, psi)
    end = Vec((sin(theta), cos(theta), 0))
    earth = earth_axis(p)
    there = in_space(w, end, earth, p.Om)
    ground = in_space(w, [coefficient(x, 0) for x in end], earth, p.Om)
    w.force(there, (velocity(there) - velocity(ground)) * -p.c)


@model(
    "gyrocompass_tilting",
    there=lambda p, s: ([s.theta, s.beta, 0], [s.turn, s.tip, None]),
    momenta=lambda p: {2: p.C * p.s},
    back=lambda p, s, q: [q[0], q[1], rate(q[0]), rate(q[1])],
)
def tilting_gyrocompass(w: World, p: Any, theta: Any, beta: Any, psi: Any) -> None:
    """theta from north to the west, beta upward; a weight below the axis pulls it to the horizontal."""
    level = Vec((-sin(theta), cos(theta), 0))
    left = cross(UP, level)
    axis = level * cos(beta) + UP * sin(beta)
    rotor(w, p, axis, left, psi, pole(p.lat))
    w.energy(-p.K * cos(beta))
