"""Second derivations for impacts: the impulse acts along the gap that closes, and opens it with the restitution."""

from collections.abc import Sequence
from typing import Any

import flint
from independent_mechanics import Vec, World, cos, length, polar, sin, velocity
from independent_models import model


def on_the_plane(source: Any, p: Any, s: Any, mode: str) -> None:
    """At a bounce the ball moves down; at rest or sliding it has no normal velocity."""
    height, speed = ("y", "vy") if hasattr(s, "vy") else ("y", "v")
    if mode != "flight":
        setattr(s, height, flint.arb(0))
    if mode in ("rest", "slide"):
        setattr(s, speed, flint.arb(0))
    if mode in ("at bounce", "at limit"):
        setattr(s, speed, -abs(getattr(s, speed)))


@model("bouncing_ball", prepare=on_the_plane)
def bouncing_ball(w: World, p: Any, y: Any) -> None:
    w.mass(1, (y,), (-p.g,))
    bounces(w, y, p.e)


def bounces(w: World, gap: Any, restitution: Any) -> None:
    """At the limit, after infinitely many bounces, the normal velocity is zero."""
    if w.mode in ("rest", "slide"):
        w.keep(gap)
    if w.mode in ("at bounce", "at limit"):
        w.strike(gap, restitution if w.mode == "at bounce" else 0)


@model("bouncing_ball_incline", prepare=on_the_plane)
def ball_on_an_incline(w: World, p: Any, x: Any, y: Any) -> None:
    w.mass(1, (x, y), (p.g_along, -p.g_across))
    bounces(w, y, p.e)


def on_the_table(source: Any, p: Any, s: Any, mode: str) -> None:
    if mode == "at bounce":
        s.z, s.u = flint.arb(0), -abs(s.u)


@model("bouncing_ball_table", prepare=on_the_table)
def ball_on_a_table(w: World, p: Any, z: Any) -> None:
    w.mass(1, (p.b * w.t * w.t / 2 + p.A * sin(p.w * w.t) + z,), (-p.g,))
    bounces(w, z, p.e)


def chattering(source: Any, p: Any, s: Any, mode: str) -> Any:
    """The table releases the ball when it falls with g, and holds it in the half turn in which it is below."""
    if mode in ("rest", "at release"):
        s.z, s.u = flint.arb(0), flint.arb(0)
    if mode == "rest":
        return (1 + source.random()) * flint.arb.pi() / p.w
    if mode == "at release":
        angle = flint.arb(source.uniform(0.2, 1.3))
        p.g = p.A * p.w * p.w * sin(angle)
        return angle / p.w
    if mode != "flight":
        s.z, s.u = flint.arb(0), -abs(s.u)
    return None


@model("chattering_ball", prepare=chattering)
def ball_that_chatters(w: World, p: Any, z: Any) -> None:
    w.mass(1, (p.A * sin(p.w * w.t) + z,), (-p.g,))
    bounces(w, z, p.e)


def at_the_stop(source: Any, p: Any, s: Any, mode: str) -> None:
    if mode == "at impact":
        s.x, s.v = p.s, abs(s.v)


@model("impact_oscillator", prepare=at_the_stop)
def oscillator_before_a_stop(w: World, p: Any, x: Any) -> None:
    """The gap to the stop is s - x; force and damper act on the mass."""
    w.mass(p.m, (x,))
    w.energy(p.k * x * x / 2)
    w.force((x,), -velocity((x,)) * p.c)
    w.force((x,), (p.F * cos(p.w * w.t),))
    if w.mode == "at impact":
        w.strike(p.s - x, p.e)


def on_an_edge(source: Any, p: Any, s: Any, mode: str) -> None:
    s.theta = {"right": abs(s.theta), "left": -abs(s.theta)}.get(mode, flint.arb(0))


@model("rocking_block", prepare=on_an_edge)
def block_on_two_edges(w: World, p: Any, theta: Any) -> None:
    """Weight over the edge is an unstable spring; the rate keeps its sign, a restitution of -r."""
    w.mass(1, (theta,))
    side = 1 if theta[0] > 0 else -1
    w.energy(-p.p * p.p * (theta - side * p.alpha) * (theta - side * p.alpha) / 2)
    if w.mode == "at impact":
        w.strike(theta, -p.r)


def on_the_spring(source: Any, p: Any, s: Any, mode: str) -> None:
    s.y = {"flight": abs(s.y), "spring": -abs(s.y)}.get(mode, flint.arb(0))
    s.v = {"at touch": -abs(s.v), "at lift": abs(s.v)}.get(mode, s.v)


@model("work_energy_spring_block", prepare=on_the_spring)
def block_on_an_upright_spring(w: World, p: Any, y: Any) -> None:
    """The spring only pushes."""
    w.mass(p.m, (y,), (-p.g,))
    if y[0] < 0:
        w.energy(p.k * y * y / 2)


def touching(source: Any, p: Any, s: Any, mode: str) -> None:
    """Balls in a row: balls that collide have the same coordinate."""
    if mode.startswith("at impact"):
        left, right = mode[-2], mode[-1]
        setattr(s, f"x{right}", getattr(s, f"x{left}"))


def in_a_row(w: World, masses: Sequence[Any], places: Sequence[Any], restitution: Any) -> None:
    for m, x in zip(masses, places, strict=True):
        w.mass(m, (x,))
    if w.mode.startswith("at impact"):
        left, right = (int(k) - 1 for k in w.mode[-2:])
        w.strike(places[right] - places[left], restitution)


@model("three_ball_chain", prepare=touching)
def three_balls(w: World, p: Any, *x: Any) -> None:
    in_a_row(w, (p.m1, p.m2, p.m3), x, p.e)


@model("newtons_cradle", prepare=touching)
def cradle(w: World, p: Any, *x: Any) -> None:
    in_a_row(w, (1, 1, 1, 1, 1), x, p.e)


def at_the_wall(source: Any, p: Any, s: Any, mode: str) -> None:
    if mode == "at blocks":
        s.x2 = s.x1
    if mode == "at wall":
        s.x1 = flint.arb(0)


@model("restitution_impact_1d_2d", prepare=at_the_wall)
def blocks_before_a_wall(w: World, p: Any, x1: Any, x2: Any) -> None:
    w.mass(p.m1, (x1,))
    w.mass(p.m2, (x2,))
    if w.mode == "at blocks":
        w.strike(x2 - x1, 1)
    if w.mode == "at wall":
        w.strike(x1, 1)


def in_touch(source: Any, p: Any, s: Any, mode: str) -> None:
    if mode == "at impact":
        s.x2, s.y2 = Vec((s.x1, s.y1)) + polar(p.R, flint.arb(source.uniform(-3, 3)))


@model("oblique_impact", prepare=in_touch)
def two_discs(w: World, p: Any, x1: Any, y1: Any, x2: Any, y2: Any) -> None:
    w.mass(p.m1, (x1, y1))
    w.mass(p.m2, (x2, y2))
    if w.mode == "at impact":
        w.strike(length((x2 - x1, y2 - y1)), p.e)


def around_the_burst(source: Any, p: Any, s: Any, mode: str) -> Any:
    return p.t_burst * {"whole": source.random(), "burst": 1 + source.random(), "at burst": 1}[mode]


@model("exploding_projectile", prepare=around_the_burst)
def two_parts(w: World, p: Any, x1: Any, y1: Any, x2: Any, y2: Any) -> None:
    """The burst is an impulse between the parts."""
    w.mass(p.m1, (x1, y1), (0, -p.g))
    w.mass(p.m2, (x2, y2), (0, -p.g))
    if w.mode == "at burst":
        w.kick(x2 - x1, p.wx)
        w.kick(y2 - y1, p.wy)
