"""Second derivations for mechanisms: closed chains of bodies, their joints kept as constraints."""

from types import SimpleNamespace
from typing import Any

import flint
from independent_bodies import flat_body
from independent_mechanics import Vec, World, cos, dot, polar, sin, sqrt
from independent_models import MODELS, model
from independent_quantities import ObservedMotion, mp, oracle


@model("car_axis")
def car_axis(w: World, p: Any, xl: Any, yl: Any, xr: Any, yr: Any) -> None:
    """Two masses at the ends of the axle; the wheels are points that the road moves."""
    left, right = Vec((xl, yl)), Vec((xr, yr))
    height = p.c / p.w * sin(p.w * w.t)
    wheel = Vec((sqrt(p.L * p.L - height * height), height))
    for end, foot in ((left, Vec((0, 0))), (right, wheel)):
        w.mass(p.m / 2, end, (0, -p.g))
        w.spring(p.k, p.l0, foot, end)
    w.keep(dot(left, wheel))
    w.keep(dot(left - right, left - right))


def across(r: Any, angle: Any) -> Vec:
    """The position at r from the origin, `angle` from the downward vertical."""
    return Vec((r * sin(angle), -r * cos(angle)))


@model("andrews_squeezer")
def squeezer(
    w: World, p: Any, beta: Any, theta: Any, gamma: Any, phi: Any, delta: Any, omega: Any, epsilon: Any
) -> None:
    """Seven flat bodies; the pivots O, A and B of their chains are origins of their own, as no force depends on them."""
    elbow, bent, low, high = polar(p.rr, beta), beta + theta, phi + delta, omega + epsilon
    at_a_low, at_a_high = polar(p.zt, delta), across(p.u, epsilon)
    flat_body(w, p.m1, p.I1, polar(p.ra, beta), beta)
    flat_body(w, p.m2, p.I2, elbow - polar(p.da, bent), bent)
    flat_body(w, p.m3, p.I3, polar(p.sa, gamma) + across(p.sb, gamma), gamma)
    flat_body(w, p.m4, p.I4, at_a_low + across(p.e - p.ea, low), low)
    flat_body(w, p.m5, p.I5, polar(p.ta, delta) + across(p.tb, delta), delta)
    flat_body(w, p.m6, p.I6, at_a_high + polar(p.zf - p.fa, high), high)
    flat_body(w, p.m7, p.I7, polar(p.ua, epsilon) + across(p.ub, epsilon), epsilon)
    w.spring(p.c0, p.l0, (-p.ax, -p.ay), polar(p.sd, gamma) + across(p.sc, gamma))
    w.energy(-p.mom * beta)
    knee = elbow - polar(p.d, bent)
    for end in (across(p.ss, gamma), at_a_low + across(p.e, low), at_a_high + polar(p.zf, high)):
        for value in knee - end:
            w.keep(value)


@oracle("andrews_squeezer.multiplier_1", "andrews_squeezer.multiplier_2")
def forces_of_the_lever(observed: ObservedMotion, value: Any) -> Any:
    """From d'Alembert's principle; the forces of the second derivation increase what they keep."""
    p, s = (
        SimpleNamespace(**{k: flint.arb(str(x)) for k, x in vars(each).items()})
        for each in (observed.p, observed.at(0))
    )
    first, second, *_ = MODELS["andrews_squeezer"].multipliers(p, flint.arb(0), s, "")
    found = -(first if value is observed.found["multiplier_1"] else second)
    return mp.mpf(found.str(30, radius=False))


@oracle("car_axis.multiplier_axle", "car_axis.multiplier_shaft")
def forces_at_the_start(observed: ObservedMotion, value: Any) -> Any:
    """What the springs leave of the accelerations along the road, where the right wheel is at (L, 0)."""
    p, s = observed.p, observed.at(0)
    ahead = s.xr - p.L
    pull = 2 * p.k / p.m * (p.l0 / mp.sqrt(ahead * ahead + s.yr * s.yr) - 1) * ahead
    axle = pull - observed.rate("vxr")
    over = p.m / (2 * p.k)
    if value is observed.found["multiplier_axle"]:
        return axle * over / (2 * (s.xl - s.xr))
    return (observed.rate("vxl") + axle) * over / p.L


def uniform_rod(w: World, m: Any, g: Any, one: Vec, other: Vec) -> None:
    """Its masses at both ends and in the middle, by Simpson's rule, which is exact for moments up to the second."""
    for share, place in ((m / 6, one), (2 * m / 3, (one + other) / 2), (m / 6, other)):
        w.mass(share, place, (0, -g))


@model("slider_crank")
def slider_crank(w: World, p: Any, x: Any, y: Any, s: Any) -> None:
    pin, slider = Vec((x, y)), Vec((s, 0))
    uniform_rod(w, p.m1, p.g, Vec((0, 0)), pin)
    uniform_rod(w, p.m2, p.g, pin, slider)
    w.mass(p.m3, slider)
    w.keep(dot(pin, pin))
    w.keep(dot(slider - pin, slider - pin))


@model("four_bar_linkage")
def four_bar(w: World, p: Any, xa: Any, ya: Any, xb: Any, yb: Any) -> None:
    rods = (Vec((0, 0)), Vec((xa, ya)), Vec((xb, yb)), Vec((p.d, 0)))
    for m, one, other in zip((p.m1, p.m2, p.m3), rods, rods[1:], strict=False):
        uniform_rod(w, m, p.g, one, other)
        w.keep(dot(other - one, other - one))
