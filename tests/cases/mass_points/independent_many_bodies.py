"""Second derivations of the cases of many bodies: Newton's law between each two of them."""

from typing import Any

from independent_earth import UP, in_space
from independent_mechanics import World
from independent_models import model
from independent_particles import attraction


def attracting(w: World, p: Any, count: int, size: int, q: tuple[Any, ...]) -> None:
    places = [q[k * size : (k + 1) * size] for k in range(count)]
    masses = [getattr(p, f"m{k}") for k in range(1, count + 1)]
    for i, (m, place) in enumerate(zip(masses, places, strict=True)):
        w.mass(m, place)
        for other, there in zip(masses[:i], places[:i], strict=True):
            attraction(w, p.G * m * other, there, place)


@model("pleiades")
def seven_stars(w: World, p: Any, *q: Any) -> None:
    attracting(w, p, 7, 2, q)


@model("outer_solar_system")
def sun_and_planets(w: World, p: Any, *q: Any) -> None:
    attracting(w, p, 6, 3, q)


@model("figure_eight")
def three_on_a_curve(w: World, p: Any, *q: Any) -> None:
    attracting(w, p, 3, 2, q)


@model("choreography_super_eight")
def four_on_a_curve(w: World, p: Any, *q: Any) -> None:
    attracting(w, p, 4, 2, q)


@model("choreography_five_bodies")
def five_on_a_curve(w: World, p: Any, *q: Any) -> None:
    attracting(w, p, 5, 2, q)


@model("arenstorf_orbit")
def satellite(w: World, p: Any, x: Any, y: Any) -> None:
    """A unit mass seen from axes that turn at the rate 1; distances to Earth and Moon are the same in both."""
    w.mass(1, in_space(w, (x, y, 0), UP, 1))
    attraction(w, 1 - p.mu, (-p.mu, 0), (x, y))
    attraction(w, p.mu, (1 - p.mu, 0), (x, y))
