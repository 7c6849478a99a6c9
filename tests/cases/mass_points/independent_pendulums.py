"""Second derivations for pendulums: on rods, strings, springs, rotating hoops and carts."""

from types import SimpleNamespace
from typing import Any

import flint
from independent_bodies import flat_body, rod, solid
from independent_mechanics import Vec, World, cos, dot, polar, sin
from independent_models import model
from independent_oscillators import drag


def hanging(r: Any, theta: Any) -> Vec:
    """The position at r from the origin, theta from the downward vertical."""
    return Vec((r * sin(theta), -r * cos(theta)))


@model("pendulum_simple")
def pendulum(w: World, p: Any, theta: Any) -> None:
    w.mass(1, hanging(p.L, theta), (0, -p.g))


def swinging(source: Any, p: Any, s: Any, mode: str) -> None:
    s.v = {"forward": abs(s.v), "backward": -abs(s.v)}.get(mode, flint.arb(0))


@model("pendulum_quadratic_damping", prepare=swinging)
def pendulum_in_air(w: World, p: Any, theta: Any) -> None:
    """A pendulum of length and mass 1."""
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
    """The torque impulse is an impulse H/l normal to the arm at its free end."""
    rod(w, p.m, hanging(0, theta), hanging(p.l, theta), (0, -p.g))
    if w.mode == "at blow":
        w.impulse(hanging(p.l, theta), Vec((cos(theta), sin(theta))) * (p.H / p.l))


def on_a_hoop(r: Any, theta: Any, phi: Any) -> tuple[Any, Any, Any]:
    """The position at theta from the downward vertical in the plane with azimuth phi."""
    return r * sin(theta) * cos(phi), r * sin(theta) * sin(phi), -r * cos(theta)


@model("rotating_pendulum")
def bead_on_a_hoop(w: World, p: Any, theta: Any) -> None:
    w.mass(1, on_a_hoop(p.R, theta, p.Om * w.t), (0, 0, -p.g))


@model("rotating_pendulum_swept")
def bead_on_a_swept_hoop(w: World, p: Any, theta: Any) -> None:
    w.mass(1, on_a_hoop(p.R, theta, p.Om * w.t + p.sweep * w.t * w.t / 2), (0, 0, -p.g))


@model("rotating_pendulum_free_hoop")
def bead_on_a_free_hoop(w: World, p: Any, theta: Any, phi: Any) -> None:
    """The hoop is a mass I at distance 1 from the axis."""
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
    """Balls on both arms, the sleeve twice as far down as they are; the rotor is a mass I at distance 1."""
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
    """The velocity of the sphere's point of contact along the bowl stays zero."""
    centre = hanging(p.R - p.r, theta)
    flat_body(w, 1, p.r * p.r * 2 / 5, centre, spin, (0, -p.g))
    tangential = Vec((cos(theta), sin(theta)))
    swept = dot([x.derivative() for x in centre], tangential)
    w.no_slip(swept + p.r * spin.derivative())


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
    """The bullet's velocity is that in space until the impact, and zero after it."""
    return [s.x, s.theta], [s.u - p.L * s.omega if s.u != 0 else s.u, s.omega]


@model("ballistic_pendulum", prepare=before_the_impact, there=bullet_from_the_block)
def bullet_and_block(w: World, p: Any, x: Any, theta: Any) -> None:
    """x: from the block, which hangs at rest until the impact, to the bullet. The bullet has weight after the impact."""
    block = hanging(p.L, theta)
    inside = w.mode == "swing"
    w.mass(p.M, block, (0, -p.g))
    w.mass(p.m, block + Vec((x, 0)), (0, -p.g) if inside else None)
    if inside:
        w.keep(x)
    if w.mode == "at impact":
        w.strike(x, 0)
