"""Second derivations of the chaotic cases: a star in a galaxy, a driven pendulum, three bodies in a plane."""

from typing import Any

import mpmath
from independent_mechanics import Vec, World, coefficient, cos, polar, sin, velocity
from independent_models import model
from independent_particles import attraction
from independent_quantities import ObservedMotion, oracle


@model("henon_heiles")
def star(w: World, p: Any, x: Any, y: Any) -> None:
    """The cubic potential is lam/3 times the imaginary part of (x + iy)^3: it has the symmetry of a triangle."""
    real, imaginary = x * x - y * y, 2 * x * y
    w.mass(1, (x, y))
    w.spring(p.w * p.w, 0, (0, 0), (x, y))
    w.energy(p.lam * (real * y + imaginary * x) / 3)


@model("driven_pendulum")
def driven_pendulum(w: World, p: Any, theta: Any) -> None:
    """A unit mass 1 m below a pivot in the gravity w0^2, with a drag and a tangential push."""
    place, push = polar(1, theta), p.F * coefficient(cos(p.w * w.t), 0)
    across = Vec((-coefficient(sin(theta), 0), coefficient(cos(theta), 0)))
    w.mass(1, place, (p.w0 * p.w0, 0))
    w.force(place, across * push - velocity(place) * p.c)


@model("three_body_pythagorean")
def three_in_a_plane(w: World, p: Any, *q: Any) -> None:
    bodies = list(zip((p.m1, p.m2, p.m3), (q[:2], q[2:4], q[4:]), strict=True))
    for i, (m, place) in enumerate(bodies):
        w.mass(m, place)
        for other, there in bodies[:i]:
            attraction(w, p.G * m * other, there, place)


@oracle("henon_heiles.escape_share")
def over_the_saddle(observed: ObservedMotion, value: Any) -> Any:
    """The energy over the potential at the saddle on the y axis, where its slope, a difference, is zero."""
    potential, p = observed.case.forms[0].potential, tuple(vars(observed.p).values())

    def along(y: Any) -> Any:
        return potential(0, (mpmath.mpf(0), y), p)[0]

    saddle = mpmath.findroot(lambda y: mpmath.diff(along, y), observed.p.w**2 / observed.p.lam * mpmath.mpf("1.01"))
    return observed.invariant("energy") / along(saddle)
