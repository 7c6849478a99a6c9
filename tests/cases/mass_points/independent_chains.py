"""Second derivations for chains on curves and over edges, and for bodies that lose contact."""

from types import SimpleNamespace
from typing import Any

import flint
from independent_bodies import rod
from independent_mechanics import Vec, World, asin, cos, gauss, integral, sin
from independent_models import model
from independent_pendulums import hanging


@model("chain_in_circular_tube")
def chain_in_a_tube(w: World, p: Any, theta: Any) -> None:
    """A chain of mass 1, whose links are the nodes of a quadrature."""
    for x, weight in gauss(48):
        w.mass(weight / 2, hanging(p.R, theta + x * p.L / (2 * p.R)), (0, -p.g))


@model("chain_smooth_curve")
def chain_on_a_cycloid(w: World, p: Any, s: Any) -> None:
    for x, weight in gauss(16):
        half = asin((s + x * p.L / 2) / (4 * p.a))
        w.mass(weight / 2, (p.a * (2 * half + sin(2 * half)), p.a * (1 - cos(2 * half))), (0, -p.g))


def chain(w: World, p: Any, s: Any, pieces: list[tuple[Any, Any, Any]]) -> None:
    """A chain of density 1, guided along a path with its front at s; all links move by the same distance.

    `pieces`: for each piece of the path the depth below its start as a function of the arc length, and start and end
    of the part of the chain on it.
    """
    w.mass(p.L, (s,))
    for depth, start, end in pieces:
        w.energy(-p.g * integral(depth, start, end))


def off_the_table(source: Any, p: Any, s: Any, mode: str) -> None:
    s.v = abs(s.v)
    s.s = p.L * {"sliding": source.random(), "at leaves": 1}.get(mode, 1 + source.random())


@model("chain_off_table", prepare=off_the_table)
def chain_over_an_edge(w: World, p: Any, s: Any) -> None:
    """Friction on the part on the table opposes its velocity."""
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
    """A horizontal table, a quarter circle and a vertical."""
    quarter, tail, nothing = flint.arb.pi() * p.R / 2, s - p.L, flint.arb(0)
    pieces = []
    if tail[0] < quarter:
        front = s if s[0] < quarter else quarter
        pieces.append((lambda u: p.R * (1 - cos(u / p.R)), tail if tail[0] > 0 else nothing, front))
    if s[0] > quarter:
        pieces.append((lambda u: p.R + u - quarter, tail if tail[0] > quarter else quarter, s))
    chain(w, p, s, pieces)


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
    s.omega = flint.arb(0) if mode in ("flat", "stands") else abs(s.omega)


def on_the_floor(p: Any, s: SimpleNamespace) -> Any:
    """In the second phase the position on the floor is arbitrary: here as if the rod still touched the wall."""
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
    """A rod of mass 1, its lower end on the floor, its middle at x from the wall."""
    half = Vec((p.L / 2 * sin(theta), -p.L / 2 * cos(theta)))
    middle = Vec((x, p.L / 2 * cos(theta)))
    rod(w, 1, middle + half, middle - half, (0, -p.g))
    if w.mode == "wall":
        w.keep(x - p.L / 2 * sin(theta))
    if w.mode in ("flat", "stands"):
        w.keep(theta)
    if w.mode == "at lies":
        w.strike((middle - half)[1], 0)
