"""Second derivations of the cases of many bodies: Newton's law between each two of them."""

from typing import Any

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
