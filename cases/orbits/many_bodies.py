"""Equations of bodies that attract each other in pairs, for any number of bodies in a plane or in space.

The parameters are (G, m1, ..., mn), the state (positions of body 1, of body 2, ..., then the velocities likewise).
"""

from collections.abc import Sequence
from itertools import combinations
from typing import ClassVar

from gnomon.cases.declare import *
from gnomon.cases.scenes.two_masses import attracting


def _vectors(numbers: Values, count: int) -> tuple[Values, ...]:
    """The numbers of each body, from those of all."""
    size = len(numbers) // count
    return tuple(numbers[i * size : (i + 1) * size] for i in range(count))


def _pairs(count: int) -> tuple[tuple[int, int], ...]:
    """Each two bodies once; equations are compiled from functions of their own module, so that itertools is out."""
    return tuple((i, j) for i in range(count) for j in range(i + 1, count))


def _difference(a: Values, b: Values) -> Values:
    return tuple(x - y for x, y in zip(a, b, strict=True))


def _square(a: Values) -> Any:
    total = a[0] * a[0]
    for x in a[1:]:
        total = total + x * x
    return total


def pairs_attract(t: Any, q: Values, parameters: Values) -> Values:
    """ri'' = the sum over j of G mj (rj - ri)/|rj - ri|^3."""
    G, *masses = parameters
    places = _vectors(q, len(masses))
    pulls: list[list[Any]] = [[] for _ in masses]
    for i, j in _pairs(len(masses)):
        apart = _difference(places[j], places[i])
        square = _square(apart)
        pull = G / (square * sqrt(square))
        there = tuple(pull * x for x in apart)
        pulls[i].append(tuple(masses[j] * x for x in there))
        pulls[j].append(tuple(-masses[i] * x for x in there))
    return tuple(_sum(tuple(pull[axis] for pull in own)) for own in pulls for axis in range(len(places[0])))


def _sum(terms: Sequence[Any]) -> Any:
    total = terms[0]
    for term in terms[1:]:
        total = total + term
    return total


def pair_energy(t: Any, state: Values, parameters: Values) -> Values:
    G, *masses = parameters
    half = len(state) // 2
    places, speeds = _vectors(state[:half], len(masses)), _vectors(state[half:], len(masses))
    kinetic = _sum(tuple(m * _square(v) for m, v in zip(masses, speeds, strict=True))) / 2
    bound = [masses[i] * masses[j] / sqrt(_square(_difference(places[i], places[j]))) for i, j in _pairs(len(masses))]
    return (kinetic - G * _sum(tuple(bound)),)


def _momentum(state: Values, parameters: Values, axis: int) -> Values:
    masses = parameters[1:]
    speeds = _vectors(state[len(state) // 2 :], len(masses))
    return (_sum(tuple(m * v[axis] for m, v in zip(masses, speeds, strict=True))),)


def momentum_x(t: Any, state: Values, parameters: Values) -> Values:
    return _momentum(state, parameters, 0)


def momentum_y(t: Any, state: Values, parameters: Values) -> Values:
    return _momentum(state, parameters, 1)


def momentum_z(t: Any, state: Values, parameters: Values) -> Values:
    return _momentum(state, parameters, 2)


def spin_about_z(t: Any, state: Values, parameters: Values) -> Values:
    """Angular momentum about the z axis through the origin."""
    masses, half = parameters[1:], len(state) // 2
    places, speeds = _vectors(state[:half], len(masses)), _vectors(state[half:], len(masses))
    return (_sum(tuple(m * (r[0] * v[1] - r[1] * v[0]) for m, r, v in zip(masses, places, speeds, strict=True))),)


def all_masses(parameters: Values) -> Values:
    G, *masses = parameters
    return tuple(G * m for m in masses)


def nbody(count: int, size: int) -> NBody:
    """The form for integrators that own their equations, of `count` bodies in `size` dimensions; in a plane z = 0."""
    flat = (0,) * (3 - size)

    def bodies(state: Values) -> tuple[Values, ...]:
        half = len(state) // 2
        pairs = zip(_vectors(state[:half], count), _vectors(state[half:], count), strict=True)
        return tuple((*place, *flat, *speed, *flat) for place, speed in pairs)

    def state(bodies: tuple[Values, ...]) -> Values:
        return (*(x for body in bodies for x in body[:size]), *(v for body in bodies for v in body[3 : 3 + size]))

    return NBody(all_masses, bodies, state)


def are_apart(numbers: Mapping[str, Fraction], count: int, axes: str) -> bool:
    places = [[numbers[f"{axis}{k}"] for axis in axes] for k in range(1, count + 1)]
    return all(a != b for a, b in combinations(places, 2))


class ManyBodies(IntegratedCase):
    """A case of `count` bodies; a subclass declares x1, y1, ..., vx1, vy1, ..., G, m1, ... and its variants.

    Examples
    --------
    >>> from gnomon.cases import get
    >>> isinstance(get("figure_eight"), ManyBodies)
    True
    """

    section = "8.9.2"
    count: ClassVar[int]
    axes: ClassVar[str]

    def __init_subclass__(cls, count: int, axes: str = "xy") -> None:
        bodies, size = range(1, count + 1), len(axes)
        momenta = {"momentum_x": momentum_x, "momentum_y": momentum_y, "momentum_z": momentum_z}
        own = {name: momenta[name] for name in (f"momentum_{axis}" for axis in axes)}
        names = (*axes, *(f"v{axis}" for axis in axes), "m")
        declared = {
            "count": count,
            "axes": axes,
            "rules": (Rule("no two bodies are at the same position", lambda n: are_apart(n, count, axes)),),
            "invariants": conserved(energy=pair_energy, **own, spin=spin_about_z),
            "forms": (SecondOrder(pairs_attract), nbody(count, size)),
            "scene": attracting(lambda p: p[1:], lambda r, p: p[0] / r**3, tuple(range(size))),
            "alike": tuple(tuple(f"{name}{k}" for name in names) for k in bodies),
            "mirror": tuple(f"{name}{k}" for k in bodies for name in ("x", "vx")),
        }
        for name, value in declared.items():
            setattr(cls, name, value)
        super().__init_subclass__()

    @property
    def time_scale(self) -> float:
        """The shortest sqrt(s^3/GM) at the start, s the distance of two bodies: a radian of these on a circle."""
        G, *masses = map(float, self.parameter_values())
        places = _vectors(tuple(map(float, self.initial_state[: self.count * len(self.axes)])), self.count)
        return min(
            sqrt(_square(_difference(places[i], places[j])) ** 1.5 / (G * (masses[i] + masses[j])))
            for i, j in _pairs(self.count)
        )
