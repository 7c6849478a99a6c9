"""Second derivations for particles: projectiles, charges, central forces, gravitating bodies, beads on curves."""

from types import SimpleNamespace
from typing import Any

import flint
from independent_mechanics import Vec, World, coefficient, cos, cross, dot, length, log, polar, sin, sqrt, velocity
from independent_models import model


@model("projectile_parabola")
def thrown(w: World, p: Any, x: Any, y: Any) -> None:
    w.mass(1, (x, y), (0, -p.g))


@model("projectile_parabolic_coordinates")
def thrown_in_parabolas(w: World, p: Any, xi: Any, eta: Any) -> None:
    w.mass(1, (xi * eta, (eta * eta - xi * xi) / 2), (0, -p.g))


@model("charge_in_E_and_B")
def charge(w: World, p: Any, x: Any, y: Any, z: Any) -> None:
    place = (x, y, z)
    w.mass(1, place)
    w.force(place, (Vec((p.Ex, p.Ey, p.Ez)) + cross(velocity(place), (p.Bx, p.By, p.Bz))) * p.q_m)


def proper_velocity(p: Any, t: Any, s: Any) -> list[Any]:
    """v from gamma v = u, and the acceleration from the power: c^2 gamma' = f . v, gamma v' = f - gamma' v."""
    u = Vec((s.ux, s.uy, s.uz))
    speed = length(u) / sqrt(1 + dot(u, u) / (p.c * p.c))
    v = u * (speed / length(u))
    f = (Vec((p.Ex, p.Ey, p.Ez)) + cross(v, (p.Bx, p.By, p.Bz))) * p.q_m
    gamma = 1 / sqrt(1 - speed * speed / (p.c * p.c))
    growth = dot(f, v) / (p.c * p.c)
    a = (f - v * growth) / gamma
    path = Vec(flint.arb_series([x, y], 3) for x, y in zip(v, a, strict=True))
    moved = path / sqrt(1 - dot(path, path) / (p.c * p.c))
    return [*v, *(coefficient(x, 1) for x in moved)]


model("relativistic_charge", own=proper_velocity)(charge)


def attraction(w: World, strength: Any, a: Any, b: Any) -> None:
    w.energy(-strength / length(Vec(b) - a))


@model("kepler_orbit")
def planet(w: World, p: Any, x: Any, y: Any) -> None:
    w.mass(1, (x, y))
    attraction(w, p.mu, (0, 0), (x, y))


@model("radial_fall_inverse_square")
def plunge(w: World, p: Any, r: Any) -> None:
    w.mass(1, (r,))
    w.energy(-p.mu / r)


@model("two_body")
def two_bodies(w: World, p: Any, x1: Any, y1: Any, x2: Any, y2: Any) -> None:
    w.mass(p.m1, (x1, y1))
    w.mass(p.m2, (x2, y2))
    attraction(w, p.G * p.m1 * p.m2, (x1, y1), (x2, y2))


@model("equilateral_three_body")
def three_bodies(w: World, p: Any, *q: Any) -> None:
    bodies = list(zip((p.m1, p.m2, p.m3), (q[:3], q[3:6], q[6:]), strict=True))
    for i, (m, place) in enumerate(bodies):
        w.mass(m, place)
        for other, there in bodies[:i]:
            attraction(w, p.G * m * other, there, place)


def in_the_planet(source: Any, p: Any, s: Any, mode: str) -> None:
    share = flint.arb(source.random())
    side = -1 if mode in ("at leaves_down", "at enters_up") else 1
    s.x = p.R * {"inside": 2 * share - 1, "above": 1 + share, "below": -1 - share}.get(mode, flint.arb(side))


@model("planet_tunnel", prepare=in_the_planet)
def fall_through_the_planet(w: World, p: Any, x: Any) -> None:
    """Inside, only the sphere below attracts; its mass is proportional to the cube of the distance."""
    w.mass(1, (x,))
    distance = abs(x[0])
    inner = distance if distance < p.R else p.R
    pull = p.g * p.R * p.R * (inner / p.R) ** 3 / (distance * distance)
    w.force((x,), (-pull * x[0] / distance,))


@model("central_force_conservation")
def isotropic(w: World, p: Any, x: Any, y: Any) -> None:
    w.mass(p.m, (x, y))
    w.spring(p.k, 0, (0, 0), (x, y))


@model("central_force_hanging_mass")
def hanging_mass(w: World, p: Any, r: Any, theta: Any) -> None:
    w.mass(p.m1, polar(r, theta))
    w.mass(p.m2, (r,), (-p.g,))


@model("central_force_logarithmic")
def logarithmic(w: World, p: Any, r: Any, theta: Any) -> None:
    place = polar(r, theta)
    w.mass(1, place)
    w.energy(p.k * log(length(place)))


@model("central_force_fifth_power")
def fifth_power(w: World, p: Any, x: Any, y: Any) -> None:
    w.mass(1, (x, y))
    square = x * x + y * y
    w.energy(-p.k / (4 * square * square))


@model("central_force_shortened_string")
def shortened_string(w: World, p: Any, theta: Any) -> None:
    w.mass(p.m, polar(p.r0 - p.c * w.t, theta))


@model(
    "dumbbell_spring",
    there=lambda p, s: ([s.r, s.theta, 0, 0], [s.vr, s.omega, 0, 0]),
    back=lambda p, s, q: [*q[:2], *(x.derivative() for x in q[:2])],
)
def spring_dumbbell(w: World, p: Any, r: Any, theta: Any, x: Any, y: Any) -> None:
    """(x, y) is mass 1, in free flight with the rest."""
    one = Vec((x, y))
    two = one + polar(r, theta)
    w.mass(p.m1, one)
    w.mass(p.m2, two)
    w.spring(p.k, p.l, one, two)


@model("dumbbell_free_flight")
def dumbbell(w: World, p: Any, x: Any, y: Any, theta: Any) -> None:
    w.mass(p.m1, (x, y), (0, -p.g))
    w.mass(p.m2, Vec((x, y)) + polar(p.l, theta), (0, -p.g))


@model("man_on_cart")
def man_and_cart(w: World, p: Any, x: Any) -> None:
    w.mass(p.M, (x,))
    w.mass(p.m, (x + p.d / 2 * (1 - cos(p.w * w.t)),))


@model("wedge_block_energy_momentum")
def block_on_a_wedge(w: World, p: Any, X: Any, s: Any) -> None:
    w.mass(p.M, (X, 0))
    w.mass(p.m, (X + s * cos(p.alpha), -s * sin(p.alpha)), (0, -p.g))


@model("slider_rotating_slot")
def slider(w: World, p: Any, r: Any) -> None:
    """The wall's force is the mass times the acceleration normal to the slot; friction is mu times that force."""
    place = polar(r, p.Om * w.t)
    w.mass(p.m, place)
    w.energy(p.k * (r - p.r0) * (r - p.r0) / 2)
    along, across = (Vec(coefficient(x, 0) for x in polar(1, p.Om * w.t + turn)) for turn in (0, flint.arb.pi() / 2))
    wall = p.m * dot([2 * coefficient(x, 2) for x in place], across)
    w.force(place, -along * (p.mu * abs(wall) * r[1] / abs(r[1])))


@model("bead_rotating_wire_vertical_plane")
def bead_on_a_wire(w: World, p: Any, r: Any) -> None:
    w.mass(1, polar(r, p.O * w.t), (0, -p.g))


@model("curve_sliding_small")
def bead_on_a_parabola(w: World, p: Any, x: Any) -> None:
    w.mass(1, (x, x * x / (4 * p.p)), (0, -p.g))


@model("curve_sliding_quartic")
def bead_on_a_quartic(w: World, p: Any, x: Any) -> None:
    w.mass(1, (x, x * x * x * x / (p.a * p.a * p.a)), (0, -p.g))


@model("curve_sliding_catenary")
def bead_on_a_catenary(w: World, p: Any, s: Any) -> None:
    """x = c arsinh(s/c), y = c cosh(x/c)."""
    x = p.c * log(s / p.c + sqrt(1 + s * s / (p.c * p.c)))
    w.mass(1, (x, p.c * ((x / p.c).exp() + (-x / p.c).exp()) / 2), (0, -p.g))


def turning(r: Any, phi: Any, z: Any) -> tuple[Any, Any, Any]:
    """Cylindrical coordinates."""
    return r * cos(phi), r * sin(phi), z


@model("ignorable_coordinates")
def in_a_cone(w: World, p: Any, s: Any, phi: Any) -> None:
    w.mass(1, turning(s * sin(p.alpha), phi, s * cos(p.alpha)), (0, 0, -p.g))


@model("particle_on_paraboloid")
def in_a_paraboloid(w: World, p: Any, r: Any, phi: Any) -> None:
    w.mass(1, turning(r, phi, r * r / (2 * p.p)), (0, 0, -p.g))


@model("particle_on_torus")
def in_a_ring_tube(w: World, p: Any, theta: Any, phi: Any) -> None:
    w.mass(1, turning(p.R + p.a * cos(theta), phi, p.a * sin(theta)), (0, 0, -p.g))


def skating(p: Any, s: SimpleNamespace) -> Any:
    return [s.x, s.y, s.th], [s.v * cos(s.th), s.v * sin(s.th), p.w]


@model(
    "knife_edge_incline",
    there=skating,
    back=lambda p, s, q: [*q, q[0].derivative() * cos(q[2]) + q[1].derivative() * sin(q[2])],
)
def skate(w: World, p: Any, x: Any, y: Any, th: Any) -> None:
    """The edge does not move sideways; its rate of turn stays constant."""
    w.mass(1, (x, y), (p.gs, 0))
    w.mass(1, polar(1, th))
    w.no_slip(y.derivative() * cos(th) - x.derivative() * sin(th))
    w.no_slip(th.derivative())


@model(
    "chaplygin_sleigh",
    there=lambda p, s: ([0, 0, s.theta], [s.v * cos(s.theta), s.v * sin(s.theta), s.w]),
    back=lambda p, s, q: [
        q[0].derivative() * cos(q[2]) + q[1].derivative() * sin(q[2]),
        q[2].derivative(),
        q[2],
    ],
)
def sleigh(w: World, p: Any, x: Any, y: Any, theta: Any) -> None:
    """A mass ahead of the edge, and half the moment of inertia on either side of it, at distance 1."""
    centre = Vec((x, y)) + polar(p.a, theta)
    w.mass(p.m - p.I, centre)
    w.mass(p.I / 2, centre + polar(1, theta))
    w.mass(p.I / 2, centre - polar(1, theta))
    w.no_slip(y.derivative() * cos(theta) - x.derivative() * sin(theta))
