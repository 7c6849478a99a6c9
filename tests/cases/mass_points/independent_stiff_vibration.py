"""Second derivations for stiff vibration: a chain of stiff and soft springs, a stiff rope, a steep valley, a fast pivot."""

from itertools import pairwise
from typing import Any

from independent_mechanics import Vec, World, cos, sqrt
from independent_models import model
from independent_pendulums import hanging


@model("stiff_spring_pendulum")
def stiff_spring_pendulum(w: World, p: Any, x: Any, y: Any) -> None:
    w.mass(1, (x, y), (0, -p.g))
    w.spring(p.w * p.w, p.L, (0, 0), (x, y))


@model("fermi_pasta_ulam")
def chain_of_stiff_and_soft_springs(w: World, p: Any, q1: Any, q2: Any, q3: Any, s1: Any, s2: Any, s3: Any) -> None:
    """Six unit masses between two walls, by their own displacements; (x sqrt 2)^4 = 4 x^4."""
    places: list[Any] = [0]
    for q, s in ((q1, s1), (q2, s2), (q3, s3)):
        places += [(q - s) / sqrt(2 + 0 * q), (q + s) / sqrt(2 + 0 * q)]
    places.append(0)
    for x in places[1:-1]:
        w.mass(1, (x,))
    for number, (left, right) in enumerate(pairwise(places)):
        stretch = right - left
        square = stretch * stretch
        w.energy(p.w * p.w * square / 4 if number % 2 else p.b * square * square)


@model("stiff_load_forced")
def load_on_a_rope(w: World, p: Any, x1: Any, x2: Any) -> None:
    w.mass(p.M, (x1,))
    w.mass(p.m, (x2,))
    w.energy((p.K * x1 * x1 + p.k * (x2 - x1) * (x2 - x1)) / 2)
    w.force((x1,), (p.F * cos(p.w * w.t),))


@model("stiff_valley")
def point_in_a_valley(w: World, p: Any, x: Any, y: Any) -> None:
    w.mass(1, (x, y))
    local = p.w * p.w * (1 + p.b * x * x)
    w.energy((p.k * x * x + local * y * y) / 2)


@model("kapitza_pendulum_driven")
def pendulum_on_a_shaken_pivot(w: World, p: Any, theta: Any) -> None:
    w.mass(1, Vec((0, p.a * cos(p.w * w.t))) + hanging(p.L, theta), (0, -p.g))
