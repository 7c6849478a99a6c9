"""Second derivations for masses on a line (springs, dampers, loads that depend on time), rubber tubes and drag."""

from itertools import pairwise
from typing import Any

import flint
from independent_mechanics import Vec, World, cos, exp, gauss, integral, length, log, sin, sqrt, velocity
from independent_models import model


@model("harmonic_oscillator")
def mass_on_a_spring(w: World, p: Any, x: Any) -> None:
    w.mass(p.m, (x,))
    w.energy(p.k * x * x / 2)


@model("duffing_unforced")
def hardening_spring(w: World, p: Any, x: Any) -> None:
    w.mass(1, (x,))
    w.energy(p.alpha * x * x / 2 + p.beta * x * x * x * x / 4)


@model("damped_oscillator")
def mass_with_a_damper(w: World, p: Any, x: Any) -> None:
    mass_on_a_spring(w, p, x)
    w.force((x,), -velocity((x,)) * p.c)


@model("forced_oscillator")
def driven_mass(w: World, p: Any, x: Any) -> None:
    mass_with_a_damper(w, p, x)
    w.force((x,), (p.F0 * cos(p.w * w.t),))


@model("second_order_linear_ode")
def loaded_mass(w: World, p: Any, x: Any) -> None:
    w.mass(1, (x,))
    w.energy(p.c * x * x / 2)
    w.force((x,), -velocity((x,)) * (2 * p.b))
    w.force((x,), (p.h0 + p.h1 * exp(p.r * w.t) * cos(p.p * w.t),))


def around_the_switch(source: Any, p: Any, s: Any, mode: str) -> Any:
    return p.off * {"driven": source.random(), "coasting": 1 + source.random(), "at off": 1}[mode]


@model("time_varying_force", prepare=around_the_switch)
def mass_under_a_force(w: World, p: Any, x: Any) -> None:
    w.mass(p.m, (x,))
    if w.t[0] < p.off:
        w.force((x,), (exp(-p.d * w.t) * (p.S * sin(p.w * w.t) + p.C * cos(p.w * w.t)),))


def around_the_pulse(source: Any, p: Any, s: Any, mode: str) -> Any:
    share = source.random()
    times = {"before": p.t1 * share, "pulse": p.t1 + p.T * share, "after": p.t1 + p.T * (1 + share)}
    return (times | {"at begins": p.t1, "at ends": p.t1 + p.T})[mode]


@model("impulse_instantaneous", prepare=around_the_pulse)
def pushed_mass(w: World, p: Any, x: Any) -> None:
    """The force is a half sine with the impulse J."""
    w.mass(p.m, (x,))
    if p.t1 < w.t[0] and w.t[0] < p.t1 + p.T:
        share = (w.t - p.t1) / p.T
        amplitude = p.J / (p.T * integral(lambda u: sin(flint.arb.pi() * u), 0, 1))
        w.force((x,), (amplitude * sin(flint.arb.pi() * share),))


@model("small_vibrations_3dof_chain")
def equal_chain(w: World, p: Any, x1: Any, x2: Any, x3: Any) -> None:
    places = [0, x1, x2, x3, 0]
    for x in (x1, x2, x3):
        w.mass(1, (x,))
    for left, right in pairwise(places):
        w.energy(p.k * (right - left) * (right - left) / 2)


@model("small_vibrations_mdof")
def masses_in_a_row(w: World, p: Any, x1: Any, x2: Any, x3: Any) -> None:
    for m, x, k in ((p.m1, x1, p.k1), (p.m2, x2, p.k2), (p.m3, x3, p.k3)):
        w.mass(m, (x,))
        w.energy(k * x * x / 2)
    w.energy(p.k12 * (x2 - x1) * (x2 - x1) / 2 + p.k23 * (x3 - x2) * (x3 - x2) / 2)


@model("rayleigh_dissipation_mdof")
def damped_row(w: World, p: Any, x1: Any, x2: Any) -> None:
    w.mass(p.m1, (x1,))
    w.mass(p.m2, (x2,))
    w.energy((p.k1 * x1 * x1 + p.k2 * (x2 - x1) * (x2 - x1) + p.k3 * x2 * x2) / 2)
    w.force((x1,), -velocity((x1,)) * p.c1)
    w.force((x2,), -velocity((x2,)) * p.c3)
    opening = velocity((x2 - x1,)) * p.c2
    w.force((x1,), opening)
    w.force((x2,), -opening)


@model("two_mass_spring")
def pair_on_a_rail(w: World, p: Any, x1: Any, x2: Any) -> None:
    w.mass(p.m1, (x1,))
    w.mass(p.m2, (x2,))
    w.energy(p.k * (x2 - x1 - p.l) * (x2 - x1 - p.l) / 2)


@model("center_of_mass_motion")
def thrown_pair(w: World, p: Any, x1: Any, y1: Any, x2: Any, y2: Any) -> None:
    w.mass(p.m1, (x1, y1), (0, -p.g))
    w.mass(p.m2, (x2, y2), (0, -p.g))
    w.energy(p.k * ((x2 - x1) * (x2 - x1) + (y2 - y1) * (y2 - y1)) / 2)


@model("hanging_springs")
def two_springs_in_series(w: World, p: Any, x: Any) -> None:
    """The massless joint is where both springs have the same tension."""
    joint = x * (p.k2 / (p.k1 + p.k2))
    w.mass(p.m, (x,), (p.g,))
    w.energy((p.k1 * joint * joint + p.k2 * (x - joint) * (x - joint)) / 2)


@model("rubber_tube_thin")
def thin_wall(w: World, p: Any, x: Any) -> None:
    """A neo-Hookean wall of density 1 and radius 1, mu = w^2, with stretch x along the circumference and 1/x radially."""
    w.mass(1, (x,))
    w.energy(p.w * p.w * (x * x + 1 / (x * x) - 2) / 2)


@model("rubber_tube_thick")
def thick_wall(w: World, p: Any, x: Any) -> None:
    """Rings of the wall: the one with R^2 = u unstressed has mass du and is at r^2 = u + x^2 - 1; A = 1, mu = w^2.

    The rings are the nodes of a quadrature in log(u + x^2 - 1) at the present x, so that none is close to a pole.
    """
    offset = x * x - 1
    inner, outer = log(1 + offset[0]), log(1 + p.gam + offset[0])
    half = (outer - inner) / 2
    for node, weight in gauss(60):
        square = exp(inner + half * (1 + node))
        u, mass = square - offset[0], square * half * weight
        r = sqrt(u + offset)
        stretch = r / sqrt(u)
        w.mass(mass, (r,))
        w.energy(mass * p.w * p.w * (stretch * stretch + 1 / (stretch * stretch) - 2) / 2)
    w.energy(-p.p * offset / 2)


def drag(w: World, place: Any, factor: Any) -> None:
    """Quadratic drag: factor times speed times velocity, against the velocity."""
    v = velocity(place)
    w.force(place, -v * (factor * length(v)))


def vertical(source: Any, p: Any, s: Any, mode: str) -> None:
    s.v = {"rising": abs(s.v), "falling": -abs(s.v), "at apex": flint.arb(0)}[mode]


@model("vertical_quadratic_drag", prepare=vertical)
def thrown_upward(w: World, p: Any, y: Any) -> None:
    w.mass(1, (y,), (-p.g,))
    drag(w, (y,), p.k)


@model("projectile_quadratic_drag")
def thrown_against_the_air(w: World, p: Any, x: Any, y: Any) -> None:
    w.mass(1, (x, y), (0, -p.g))
    drag(w, (x, y), p.k)


@model("projectile_stokes_drag")
def thrown_in_a_liquid(w: World, p: Any, x: Any, y: Any) -> None:
    w.mass(1, (x, y), (0, -p.g))
    w.force((x, y), -velocity((x, y)) * p.nu)


@model("millikan_oil_drop")
def oil_drop(w: World, p: Any, y: Any) -> None:
    """Weight of the oil, buoyancy of the air that it displaces, Stokes' law, the field."""
    volume = 4 * flint.arb.pi() / 3 * p.a * p.a * p.a
    w.mass(volume * p.rho, (y,), (-p.g,))
    w.force((y,), (volume * p.rho_air * p.g,))
    w.force((y,), Vec(velocity((y,))) * (-6 * flint.arb.pi() * p.eta * p.a))
    w.force((y,), (p.q * p.E,))


def along_the_jet(source: Any, p: Any, s: Any, mode: str) -> None:
    places = {"plates": p.l * source.random(), "flight": p.l + p.D * source.random(), "at leaves": p.l}
    s.x = places.get(mode, p.l + p.D)
    if mode == "paper":
        s.vx = s.vy = flint.arb(0)


@model("ink_jet_printer", prepare=along_the_jet)
def ink_drop(w: World, p: Any, x: Any, y: Any) -> None:
    w.mass(1, (x, y))
    w.force((x, y), -velocity((x, y)) * p.nu)
    if x[0] < p.l:
        w.force((x, y), (0, p.q_m * p.E))
    if w.mode == "paper":
        w.keep(x)
        w.keep(y)
    if w.mode == "at lands":
        w.strike(x, 0)
        w.strike(y, 0)
