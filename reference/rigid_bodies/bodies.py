"""Bodies as maps of a box (u, v, w) into space, for quadratures over their mass.

Each map takes f (a module with cos, sin, sqrt: math, numpy or an mpmath context), (u, v, w) and the sizes of the body.
It returns (x, y, z, weight), with the weight proportional to the mass per du dv dw. Edges of None are a full turn: the
moments are trigonometric polynomials in that variable and polynomials in the others, so that few nodes are exact.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from gnomon.reference.numerics.quadrature import gauss_legendre

Point = tuple[Any, Any, Any, Any]
Edges = tuple[float, float] | None
NODES, STEPS = 4, 12
"""Exact for polynomials of degree 7 and for harmonics up to the 11th; second moments need 6 and 4."""


def box(f: Any, u: Any, v: Any, w: Any, a: Any, b: Any, c: Any) -> Point:
    return a * u, b * v, c * w, 1 + 0 * u


def ellipsoid(f: Any, u: Any, v: Any, w: Any, a: Any, b: Any, c: Any) -> Point:
    """u: fraction of the radius, v: azimuth, w: cosine of the polar angle."""
    across = f.sqrt(1 - w * w) * u
    return a * across * f.cos(v), b * across * f.sin(v), c * u * w, u * u


def sphere(f: Any, u: Any, v: Any, w: Any, r: Any) -> Point:
    return ellipsoid(f, u, v, w, r, r, r)


def shell(f: Any, u: Any, v: Any, w: Any, r: Any) -> Point:
    return ellipsoid(f, 1 + 0 * u, v, w, r, r, r)


def cylinder(f: Any, u: Any, v: Any, w: Any, r: Any, h: Any) -> Point:
    return r * u * f.cos(v), r * u * f.sin(v), h * w, u


def tube(f: Any, u: Any, v: Any, w: Any, r: Any, inner: Any, h: Any) -> Point:
    radius = inner + (r - inner) * u
    return radius * f.cos(v), radius * f.sin(v), h * w, radius


def cone(f: Any, u: Any, v: Any, w: Any, r: Any, h: Any) -> Point:
    """From the apex at the origin; w: fraction of the height."""
    radius = r * u * w
    return radius * f.cos(v), radius * f.sin(v), h * w, u * w * w


def torus(f: Any, u: Any, v: Any, w: Any, R: Any, r: Any) -> Point:
    """u: fraction of the radius of the tube, v: around the axis, w: around the tube."""
    from_axis = R + r * u * f.cos(w)
    return from_axis * f.cos(v), from_axis * f.sin(v), r * u * f.sin(w), u * from_axis


def ring(f: Any, u: Any, v: Any, w: Any, r: Any) -> Point:
    return r * f.cos(v), r * f.sin(v), 0 * v, 1 + 0 * v


def lamina(f: Any, u: Any, v: Any, w: Any, a: Any, b: Any) -> Point:
    return a * u, b * v, 0 * u, 1 + 0 * u


@dataclass(frozen=True)
class Body:
    """A map, the names of its sizes, and the edges of u, v, w; moments are about the centre of mass or the origin."""

    place: Callable[..., Point]
    sizes: tuple[str, ...]
    edges: tuple[Edges, Edges, Edges]
    about_origin: bool = False


HALF, UNIT, BOTH, TURN = (-0.5, 0.5), (0.0, 1.0), (-1.0, 1.0), None
BODIES = {
    "box": Body(box, ("a", "b", "c"), (HALF, HALF, HALF)),
    "ellipsoid": Body(ellipsoid, ("a", "b", "c"), (UNIT, TURN, BOTH)),
    "sphere": Body(sphere, ("r",), (UNIT, TURN, BOTH)),
    "spherical_shell": Body(shell, ("r",), (UNIT, TURN, BOTH)),
    "hemisphere": Body(sphere, ("r",), (UNIT, TURN, UNIT)),
    "cylinder": Body(cylinder, ("r", "h"), (UNIT, TURN, HALF)),
    "tube": Body(tube, ("r", "inner", "h"), (UNIT, TURN, HALF)),
    "cone": Body(cone, ("r", "h"), (UNIT, TURN, UNIT)),
    "cone_apex": Body(cone, ("r", "h"), (UNIT, TURN, UNIT), about_origin=True),
    "torus": Body(torus, ("R", "r"), (UNIT, TURN, TURN)),
    "ring": Body(ring, ("r",), (UNIT, TURN, UNIT)),
    "lamina": Body(lamina, ("a", "b"), (HALF, HALF, UNIT)),
}


def masses(mp: Any, body: Body, sizes: Sequence[Any]) -> list[Point]:
    """Points (x, y, z, mass), of total mass 1, with the same moments as the body up to the second."""
    axes = [
        [(2 * mp.pi * k / STEPS, mp.mpf(1) / STEPS) for k in range(STEPS)]
        if edges is None
        else gauss_legendre(mp, mp.mpf(edges[0]), mp.mpf(edges[1]), NODES)
        for edges in body.edges
    ]
    points = []
    for u, a in axes[0]:
        for v, b in axes[1]:
            for w, c in axes[2]:
                x, y, z, weight = body.place(mp, u, v, w, *sizes)
                points.append((x, y, z, a * b * c * weight))
    total = mp.fsum(m for *_, m in points)
    return [(x, y, z, m / total) for x, y, z, m in points]


def second_moments(mp: Any, points: Sequence[Point], origin: Sequence[Any] = (0, 0, 0)) -> list[list[Any]]:
    """The inertia tensor of points (x, y, z, mass) about `origin`."""
    tensor = [[mp.mpf(0)] * 3 for _ in range(3)]
    for *place, m in points:
        r = [x - o for x, o in zip(place, origin, strict=True)]
        square = mp.fsum(x * x for x in r)
        for i in range(3):
            for j in range(3):
                tensor[i][j] += m * ((square if i == j else 0) - r[i] * r[j])
    return tensor


def centre(mp: Any, points: Sequence[Point]) -> tuple[Any, Any, Any]:
    """The centre of mass of points (x, y, z, mass)."""
    total = mp.fsum(point[3] for point in points)
    x, y, z = (mp.fsum(point[i] * point[3] for point in points) / total for i in range(3))
    return x, y, z
