"""Scenes of pendulums: on rods, strings and springs, on hoops that turn, on carts, and chains in a vertical plane."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import flint
from independent_bodies import flat_body, rod, solid
from independent_mechanics import Vec, World, asin, cos, dot, gauss, integral, polar, sin
from independent_models import model
from independent_oscillators import drag


def hanging(r: Any, theta: Any) -> Vec:
    """The place at r from the origin, theta from the downward vertical."""
    return Vec((r * sin(theta), -r * cos(theta)))


@model("pendulum_simple")
def pendulum(w: World, p: Any, theta: Any) -> None:
    w.mass(1, hanging(p.L, theta), (0, -p.g))


def swinging(source: Any, p: Any, s: Any, mode: str) -> None:
    s.v = {"forward": abs(s.v), "backward": -abs(s.v)}.get(mode, flint.arb(0))


@model("pendulum_quadratic_damping", prepare=swinging)
def pendulum_in_air(w: World, p: Any, theta: Any) -> None:
    """Of length and mass 1."""
    w.mass(1, hanging(1, theta), (0, -p.w2))
    drag(w, hanging(1, theta), p.c)


@model("cycloidal_pendulum")
def cycloid(w: World, p: Any, phi: Any) -> None:
    w.mass(1, (p.a * (phi + sin(phi)), p.a * (1 - cos(phi))), (0, -p.g))


@model("moment_of_momentum_pendulum")
def carried_pendulum(w: World, p: Any, theta: Any) -> None:
    support = Vec((p.ax, p.ay)) * (w.t * w.t / 2)
    w.mass(1, support + hanging(p.L, theta), (0, -p.g))


def tangent(source: Any, p: Any, s: Any, mode: str) -> None:
    speed = source.uniform(-2, 2)
    s.vx, s.vy = -s.y * speed, s.x * speed


@model("holonomic_constraint_dae", prepare=tangent)
def pendulum_with_multiplier(w: World, p: Any, x: Any, y: Any) -> None:
    w.mass(1, (x, y), (0, -p.g))
    w.keep(x * x + y * y)


@model("spring_pendulum")
def spring_pendulum(w: World, p: Any, x: Any, y: Any) -> None:
    w.mass(p.m, (x, y), (0, -p.g))
    w.spring(p.k, p.L, (0, 0), (x, y))


@model("swinging_atwood")
def swinging_atwood(w: World, p: Any, r: Any, theta: Any) -> None:
    w.mass(1, hanging(r, theta), (0, -p.g))
    w.mass(p.mu, (r,), (-p.g,))


@model("double_pendulum")
def double_pendulum(w: World, p: Any, th1: Any, th2: Any) -> None:
    upper = hanging(p.l1, th1)
    w.mass(p.m1, upper, (0, -p.g))
    w.mass(p.m2, upper + hanging(p.l2, th2), (0, -p.g))


@model("pendulum_on_cart")
def pendulum_on_cart(w: World, p: Any, x: Any, theta: Any) -> None:
    w.mass(p.M, (x, 0))
    w.mass(p.m, Vec((x, 0)) + hanging(p.L, theta), (0, -p.g))


@model("rotation_fixed_axis_compound_pendulum")
def compound_pendulum(w: World, p: Any, theta: Any) -> None:
    flat_body(w, p.m, p.I - p.m * p.l * p.l, hanging(p.l, theta), theta, (0, -p.g))


def around_the_blow(source: Any, p: Any, s: Any, mode: str) -> Any:
    return p.t1 * {"before": source.random(), "after": 1 + source.random(), "at blow": 1}[mode]


@model("torque_impulse_on_arm", prepare=around_the_blow)
def arm(w: World, p: Any, theta: Any) -> None:
    """The blow is an impulse H/l across the free end."""
    rod(w, p.m, hanging(0, theta), hanging(p.l, theta), (0, -p.g))
    if w.mode == "at blow":
        w.impulse(hanging(p.l, theta), Vec((cos(theta), sin(theta))) * (p.H / p.l))


def on_a_hoop(r: Any, theta: Any, phi: Any) -> tuple[Any, Any, Any]:
    """At theta from the downward vertical, in the plane at the azimuth phi."""
    return r * sin(theta) * cos(phi), r * sin(theta) * sin(phi), -r * cos(theta)


@model("rotating_pendulum")
def bead_on_a_hoop(w: World, p: Any, theta: Any) -> None:
    w.mass(1, on_a_hoop(p.R, theta, p.Om * w.t), (0, 0, -p.g))


@model("rotating_pendulum_swept")
def bead_on_a_swept_hoop(w: World, p: Any, theta: Any) -> None:
    w.mass(1, on_a_hoop(p.R, theta, p.Om * w.t + p.sweep * w.t * w.t / 2), (0, 0, -p.g))


@model("rotating_pendulum_free_hoop")
def bead_on_a_free_hoop(w: World, p: Any, theta: Any, phi: Any) -> None:
    """The hoop is a mass I at the distance 1 from the axis."""
    w.mass(p.m, on_a_hoop(p.R, theta, phi), (0, 0, -p.g))
    w.mass(p.I, polar(1, phi))


@model(
    "spherical_pendulum",
    there=lambda p, s: ([s.theta, s.phi], [s.omega, None]),
    momenta=lambda p: {1: p.L * p.L * p.h},
    back=lambda p, s, q: [q[0], q[0].derivative(), q[1]],
)
def spherical_pendulum(w: World, p: Any, theta: Any, phi: Any) -> None:
    w.mass(1, on_a_hoop(p.L, theta, phi), (0, 0, -p.g))


@model("bearing_reaction_torque_stability")
def hinged_body(w: World, p: Any, theta: Any) -> None:
    phi = p.Om * w.t
    along = Vec(on_a_hoop(1, theta, phi))
    across = Vec(on_a_hoop(1, theta + flint.arb.pi() / 2, phi))
    hinge = Vec((sin(phi), -cos(phi), 0))
    solid(w, (p.I_a, p.I_b, p.I_c), (hinge, across, along))
    w.energy(p.mgl * along[2])


@model("engineering_design_analysis")
def governor(w: World, p: Any, theta: Any, phi: Any) -> None:
    """Balls on both arms, the sleeve twice as far down as they are; the rotor is a mass I at the distance 1."""
    for side in (0, flint.arb.pi()):
        w.mass(p.m, on_a_hoop(p.L, theta, phi + side), (0, 0, -p.g))
    w.mass(p.M, (-2 * p.L * cos(theta),), (-p.g,))
    w.mass(p.I, polar(1, phi))


@model(
    "rolling_sphere_in_bowl",
    there=lambda p, s: ([s.theta, 0], [s.omega, 0]),
    back=lambda p, s, q: [q[0], q[0].derivative()],
)
def sphere_in_a_bowl(w: World, p: Any, theta: Any, spin: Any) -> None:
    """The point of the sphere that touches the bowl keeps its velocity along it, which is zero."""
    centre = hanging(p.R - p.r, theta)
    flat_body(w, 1, p.r * p.r * 2 / 5, centre, spin, (0, -p.g))
    tangential = Vec((cos(theta), sin(theta)))
    swept = dot([x.derivative() for x in centre], tangential)
    w.no_slip(swept + p.r * spin.derivative())


@model("chain_in_circular_tube")
def chain_in_a_tube(w: World, p: Any, theta: Any) -> None:
    """Of mass 1: its links are the nodes of a quadrature."""
    for x, weight in gauss(48):
        w.mass(weight / 2, hanging(p.R, theta + x * p.L / (2 * p.R)), (0, -p.g))


@model("chain_smooth_curve")
def chain_on_a_cycloid(w: World, p: Any, s: Any) -> None:
    for x, weight in gauss(16):
        half = asin((s + x * p.L / 2) / (4 * p.a))
        w.mass(weight / 2, (p.a * (2 * half + sin(2 * half)), p.a * (1 - cos(2 * half))), (0, -p.g))


def chain(w: World, p: Any, s: Any, pieces: list[tuple[Any, Any, Any]]) -> None:
    """Of density 1, guided along a path on which its front is at s: every link moves by the same way.

    `pieces` are depths below the start of the path, each a function of the place on it, with start and end of the
    part of the chain that lies there.
    """
    w.mass(p.L, (s,))
    for depth, start, end in pieces:
        w.energy(-p.g * integral(depth, start, end))


def off_the_table(source: Any, p: Any, s: Any, mode: str) -> None:
    s.v = abs(s.v)
    s.s = p.L * {"sliding": source.random(), "at leaves": 1}.get(mode, 1 + source.random())


@model("chain_off_table", prepare=off_the_table)
def chain_over_an_edge(w: World, p: Any, s: Any) -> None:
    """Friction on what lies on the table is against its velocity."""
    on_table = s[0] < p.L
    chain(w, p, s, [(lambda y: y, 0 if on_table else s - p.L, s)])
    if on_table:
        w.force((s,), (-p.mu * p.g * (p.L - s[0]) * s[1] / abs(s[1]),))


def off_the_pulley(source: Any, p: Any, s: Any, mode: str) -> None:
    s.s = p.L / 2 * {"sliding": source.uniform(-1, 1), "at leaves": 1}.get(mode, 1 + source.random())


@model("chain_over_pulley", prepare=off_the_pulley)
def chain_over_a_pulley(w: World, p: Any, s: Any) -> None:
    front, rear = p.L / 2 + s, p.L / 2 - s
    over = s[0] < p.L / 2
    pieces = [(lambda y: y, 0, front), (lambda y: y, 0, rear)] if over else [(lambda y: y, front - p.L, front)]
    chain(w, p, s, pieces)


def over_a_quarter(source: Any, p: Any, s: Any, mode: str) -> None:
    quarter, share = flint.arb.pi() * p.R / 2, flint.arb(source.random())
    where = {"front_on_circle": share * quarter, "hanging": quarter + share * (p.L - quarter)}
    where |= {"tail_on_circle": p.L + share * quarter, "falling": p.L + (1 + share) * quarter}
    s.s = (where | {"at hangs": quarter, "at enters": p.L, "at leaves": p.L + quarter})[mode]


@model("chain_quarter_circle", prepare=over_a_quarter)
def chain_over_a_quarter(w: World, p: Any, s: Any) -> None:
    """A level table, a quarter of a circle, a vertical."""
    quarter, tail, nothing = flint.arb.pi() * p.R / 2, s - p.L, flint.arb(0)
    pieces = []
    if tail[0] < quarter:
        front = s if s[0] < quarter else quarter
        pieces.append((lambda u: p.R * (1 - cos(u / p.R)), tail if tail[0] > 0 else nothing, front))
    if s[0] > quarter:
        pieces.append((lambda u: p.R + u - quarter, tail if tail[0] > quarter else quarter, s))
    chain(w, p, s, pieces)


def before_the_impact(source: Any, p: Any, s: Any, mode: str) -> None:
    if mode != "swing":
        s.theta = flint.arb(0)
    if mode == "flight":
        s.omega = flint.arb(0)
    if mode != "flight":
        s.x = flint.arb(0)
    if mode == "swing":
        s.u = flint.arb(0)


def bullet_from_the_block(p: Any, s: SimpleNamespace) -> Any:
    """The bullet's velocity is one in space until it is inside, where it is none."""
    return [s.x, s.theta], [s.u - p.L * s.omega if s.u != 0 else s.u, s.omega]


@model("ballistic_pendulum", prepare=before_the_impact, there=bullet_from_the_block)
def bullet_and_block(w: World, p: Any, x: Any, theta: Any) -> None:
    """x: from the block, which hangs at rest until the bullet is in it, to the bullet. Its weight counts from then."""
    block = hanging(p.L, theta)
    inside = w.mode == "swing"
    w.mass(p.M, block, (0, -p.g))
    w.mass(p.m, block + Vec((x, 0)), (0, -p.g) if inside else None)
    if inside:
        w.keep(x)
    if w.mode == "at impact":
        w.strike(x, 0)


def of_contact(source: Any, p: Any, s: Any, mode: str) -> None:
    if mode == "flight":
        s.h = p.R * source.uniform(0, 0.5)
    else:
        s.h = s.u = flint.arb(0)


PUSH = {"leaves": lambda p, s, multipliers: multipliers[0]}
"""The guard is the force of the wall over the mass, which is 1."""


@model("bead_leaving_sphere", prepare=of_contact, guards=PUSH)
def bead_on_a_sphere(w: World, p: Any, theta: Any, h: Any) -> None:
    w.mass(1, -hanging(p.R + h, -theta), (0, -p.g))
    if w.mode == "contact":
        w.keep(h)


@model("amusement_park", "pendulum_on_string", prepare=of_contact, guards=PUSH)
def in_a_loop(w: World, p: Any, theta: Any, h: Any) -> None:
    w.mass(1, hanging(p.R - h, theta), (0, -p.g))
    if w.mode == "contact":
        w.keep(h)


def of_the_rod(source: Any, p: Any, s: Any, mode: str) -> None:
    angles = {"flat": flint.arb.pi() / 2, "at lies": flint.arb.pi() / 2, "stands": flint.arb(0)}
    s.theta = angles.get(mode, s.theta)
    if mode in ("flat", "stands"):
        s.omega = flint.arb(0)


def on_the_floor(p: Any, s: SimpleNamespace) -> Any:
    """Where the lower end stands on the floor is free in the second phase: here, as if it still touched the wall."""
    return [p.L / 2 * sin(s.theta), s.theta], [p.L / 2 * cos(s.theta) * s.omega, s.omega]


WALL = {"leaves_wall": lambda p, s, multipliers: multipliers[0] / (p.L / 2 * sin(s.theta))}


@model(
    "sliding_ladder",
    "rigid_link_plane_motion",
    prepare=of_the_rod,
    there=on_the_floor,
    back=lambda p, s, q: [q[1], q[1].derivative()],
    guards=WALL,
)
def falling_rod(w: World, p: Any, x: Any, theta: Any) -> None:
    """Of mass 1, its lower end on the floor, its middle at x from the wall."""
    half = Vec((p.L / 2 * sin(theta), -p.L / 2 * cos(theta)))
    middle = Vec((x, p.L / 2 * cos(theta)))
    rod(w, 1, middle + half, middle - half, (0, -p.g))
    if w.mode == "wall":
        w.keep(x - p.L / 2 * sin(theta))
    if w.mode in ("flat", "stands"):
        w.keep(theta)
    if w.mode == "at lies":
        w.strike((middle - half)[1], 0)
