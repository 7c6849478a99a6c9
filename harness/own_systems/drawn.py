"""Systems that are drawn at random, none of which is a case: on them a recommendation shows whether it holds elsewhere.

The seed was fixed before any of them was solved. Each family has a stream of random numbers of its own, so that a further
family changes no other. Every second system of a family belongs to the half `margin`, which may choose; what is published
comes from the half `test`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from gnomon.cases.core.forms import Form
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.own_systems import drawn_equations
from gnomon.harness.results.advice.outside import MARGIN, TEST
from gnomon.harness.running.own_functions import Arguments
from gnomon.harness.running.pieces import Stated

SEED = 20261129
MEMBERS = 6
Random = np.random.Generator
Made = tuple[Callable[..., Any] | Form, Sequence[float] | Floats, Sequence[float] | Floats, float]
"""The equations, their numbers, the start, the span."""
TURN = 2 * math.pi


@dataclass(frozen=True)
class Drawn:
    """A system of a draw."""

    name: str
    family: str
    need: str
    """A key of `results/advice/needs.toml`."""
    half: str
    stated: Stated = field(repr=False)
    span: float
    start: tuple[float, ...]


def draw(seed: int = SEED) -> list[Drawn]:
    """All systems of a seed, family by family."""
    systems = []
    for place, (family, (need, make)) in enumerate(FAMILIES.items()):
        random = np.random.default_rng([seed, place])
        for number in range(MEMBERS):
            fun, numbers, start, span = make(random, number)
            accelerations = not isinstance(fun, Form) and fun in ACCELERATIONS
            stated = Stated(fun, Arguments(tuple(map(float, numbers))), (), accelerations)
            half = TEST if number % 2 else MARGIN
            name = f"drawn_{family}_{number + 1}"
            systems.append(Drawn(name, family, need, half, stated, float(span), tuple(map(float, start))))
    return systems


def _between(random: Random, low: float, high: float) -> float:
    return float(random.uniform(low, high))


def _decades(random: Random, low: float, high: float) -> float:
    """A number whose logarithm is uniform."""
    return float(math.exp(random.uniform(math.log(low), math.log(high))))


def _direction(random: Random, dimension: int = 3) -> Any:
    vector = random.normal(size=dimension)
    return vector / np.linalg.norm(vector)


def _turn(random: Random) -> Any:
    """A random rotation."""
    q, r = np.linalg.qr(random.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else -q


def _potential(random: Random, number: int) -> Made:
    count = 2 if number % 2 == number // 2 % 2 else 3  # both in both halves
    squares, quartic = random.uniform(0.3, 3, count), random.uniform(0.3, 1.5, count)
    cubic = random.normal(0, 0.4, 2 if count == 2 else 4)
    start = [*random.normal(0, 1, count), *random.normal(0, 0.7, count)]
    fun = drawn_equations.valley if count == 2 else drawn_equations.deep_valley
    return fun, [*squares, *cubic, *quartic], start, _decades(random, 10, 60)


def _springs(random: Random, number: int) -> Made:
    count = 2 if number < 4 else 3
    angles = TURN * (np.arange(count) + random.uniform(0, 0.5, count)) / count
    posts = random.uniform(1, 2, count)[:, None] * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    numbers: list[float] = []
    for post in posts:
        numbers += [_decades(random, 0.3, 3), *post, _between(random, 0.5, 3)]
    for _ in range(count * (count - 1) // 2):
        numbers += [_decades(random, 0.5, 8), _between(random, 0.5, 2), _between(random, 0, 1)]
    start = [*(posts + random.normal(0, 0.3, posts.shape)).ravel(), *random.normal(0, 0.5, 2 * count)]
    return drawn_equations.network, numbers, start, _decades(random, 10, 40)


def _pendulums(random: Random, number: int) -> Made:
    count = 3 if number >= 4 else 2
    friction = random.uniform(0.02, 0.3, count) * (number // 2 % 2)
    masses, lengths = random.uniform(0.3, 3, count), random.uniform(0.4, 1.5, count)
    start = [*random.uniform(-2.5, 2.5, count), *random.normal(0, 1, count)]
    fun = drawn_equations.double_pendulum if count == 2 else drawn_equations.triple_pendulum
    return fun, [*masses, *lengths, *friction, 9.81], start, _decades(random, 2, 8)


def _orbit(random: Random, nearest: float, eccentricity: float, mu: float) -> tuple[Any, Any, float]:
    """Place and velocity at the nearest point of an orbit in space, and its period."""
    frame, length = _turn(random), nearest / (1 - eccentricity)
    speed = math.sqrt(mu * (1 + eccentricity) / nearest)
    return nearest * frame[:, 0], speed * frame[:, 1], TURN * math.sqrt(length**3 / mu)


def _eccentricity(random: Random, number: int) -> float:
    """From 0 to .95, one of each sixth."""
    return 0.95 * (number + _between(random, 0, 1)) / MEMBERS


def _satellites(random: Random, number: int) -> Made:
    mu, eccentricity = _decades(random, 0.5, 2), _eccentricity(random, number)
    place, velocity, period = _orbit(random, _between(random, 0.5, 2), eccentricity, mu)
    orbits = _decades(random, 1, 100)
    second = mu * (0.0 if number % 2 == number // 2 % 2 else _decades(random, 1e-3, 0.5))
    share = second / (mu + second)
    speed = velocity * math.sqrt(1 + second / mu)  # of the relative motion, whose G m is the sum
    start = [*(-share * place), *(-share * speed), *((1 - share) * place), *((1 - share) * speed)]
    return drawn_equations.ATTRACTING, [mu, second], start, orbits * period / math.sqrt(1 + second / mu)


def _centre(random: Random, number: int) -> Made:
    """A satellite of an oblate planet, or of a round one, by turns of two."""
    mu, eccentricity = _decades(random, 0.5, 2), _eccentricity(random, number)
    orbits = _decades(random, 1, 100)
    if number % 2 == number // 2 % 2:
        place, velocity, period = _orbit(random, _between(random, 1.05, 2), eccentricity, mu)
        return (
            drawn_equations.oblate, [mu, _decades(random, 3e-4, 3e-2)], [*place, *velocity], min(orbits, 30) * period
        )  # fmt: skip
    nearest, angle = _between(random, 0.5, 2), _between(random, 0, TURN)
    speed = math.sqrt(mu * (1 + eccentricity) / nearest)
    start = [
        nearest * math.cos(angle), nearest * math.sin(angle), -speed * math.sin(angle), speed * math.cos(angle)
    ]  # fmt: skip
    return drawn_equations.satellite, [mu], start, orbits * TURN * math.sqrt((nearest / (1 - eccentricity)) ** 3 / mu)


def _planets(random: Random, number: int) -> Made:
    count = 2 + number % 3
    masses, bodies, nearest = [1.0], [], _between(random, 0.5, 1)
    first = TURN * nearest**1.5
    for _ in range(count):
        eccentricity, small = _between(random, 0, 0.25), _decades(random, 1e-6, 3e-3)
        axes = np.linalg.qr(np.eye(3) + random.normal(0, 0.05, (3, 3)))[0]
        angle = _between(random, 0, TURN)
        here = axes @ np.array([math.cos(angle), math.sin(angle), 0])
        ahead = axes @ np.array([-math.sin(angle), math.cos(angle), 0])
        speed = math.sqrt((1 + small) * (1 + eccentricity) / nearest)
        masses.append(small)
        bodies.append((nearest * here, speed * ahead))
        nearest *= _between(random, 1.8, 2.6)
    return drawn_equations.ATTRACTING, masses, _move_to_centre(masses, bodies), first * _decades(random, 2, 15)


def _move_to_centre(masses: Sequence[float], others: Sequence[tuple[Any, Any]]) -> list[float]:
    """The start of bodies about the first one, seen from the centre of mass."""
    bodies = np.array([np.zeros(6), *(np.concatenate(body) for body in others)])
    bodies -= np.average(bodies, axis=0, weights=masses)
    return [float(x) for x in bodies.ravel()]


def _crowds(random: Random, number: int) -> Made:
    count = 3 + number % 3
    masses = random.uniform(0.3, 1.5, count)
    places, speeds = random.normal(0, 1, (count, 3)), random.normal(0, 0.5, (count, 3))
    bodies = np.concatenate([places, speeds], axis=1)
    bodies -= np.average(bodies, axis=0, weights=masses)
    return drawn_equations.ATTRACTING, masses, bodies.ravel(), _between(random, 1, 3)


def _tops(random: Random, number: int) -> Made:
    squares = random.uniform(0.3, 2, 3)  # of the axes: any three are moments of inertia by pairs
    inertia = squares.sum() - squares
    centre, force = _decades(random, 0.1, 1) * _direction(random), _decades(random, 1, 10) * _direction(random)
    start = [*(_decades(random, 0.5, 10) * _direction(random)), *_turn(random).ravel()]
    return drawn_equations.HEAVY_TOP, [*inertia, *centre, *force], start, _decades(random, 2, 15)


def _charges(random: Random, number: int) -> Made:
    electric = [*random.uniform(0, 0.5, 3), _between(random, 0, 0.5), _decades(random, 0.1, 3)]
    magnetic = [*random.normal(0, 1, 2), *random.normal(0, 0.3, 3)]
    start = [*random.normal(0, 0.7, 3), *random.normal(0, 1, 3)]
    return drawn_equations.CHARGE, [*electric, *magnetic], start, _decades(random, 5, 50)


def _dashpots(random: Random, number: int) -> Made:
    count = 2 + number % 3
    numbers = [_between(random, 0.1, 2) for _ in range(count)]
    for k in range(count * (count - 1) // 2):
        rate = _decades(random, 1e3, 1e7) if k % 2 == 0 else _decades(random, 0.1, 10)
        numbers += [rate, _decades(random, 0.3, 3)]
    numbers += [_between(random, 0.5, 2), _decades(random, 0.3, 3)]
    return drawn_equations.dashpots, numbers, random.normal(0, 1, count), _decades(random, 2, 15)


def _thick(random: Random, number: int) -> Made:
    if number >= 4:
        numbers = [_decades(random, 1e3, 1e5), _between(random, 0.8, 1.2), _between(random, -0.3, 0.3)]
        return drawn_equations.relaxation, numbers, [_between(random, 1.2, 2.2), 0.0], _between(random, 0.5, 2.5)
    numbers = [*(_decades(random, 1e3, 1e7) for _ in range(2)), *random.uniform(0.5, 2, 2)]
    numbers += [
        *random.uniform(0.1, 1, 2),
        _between(random, 0.1, 2),
        _between(random, 0, 1.5),
        _decades(random, 0.3, 3),
    ]
    return (
        drawn_equations.viscous_pendulums, numbers, [*random.uniform(-2.5, 2.5, 2), *random.normal(0, 1, 2)],
        _decades(random, 2, 10),
    )  # fmt: skip


def _vibrations(random: Random, number: int) -> Made:
    if number >= 4:
        stiffness, length, g = _decades(random, 1e3, 1e5), _between(random, 0.5, 1.5), 9.81
        angle = _between(random, 0.3, 1.2)
        stretched = length * (1 + _between(random, -0.01, 0.01))
        start = [stretched * math.sin(angle), 0, -stretched * math.cos(angle), 0, _between(random, 0.2, 1), 0]
        return drawn_equations.spring_pendulum, [stiffness, length, g], start, _between(random, 1, 4)
    count = 2 + 2 * (number % 2)
    numbers = [*random.uniform(0.5, 2, count)]
    for k in range(count + 1):
        numbers += [_decades(random, 1e3, 1e5), 0.0] if k % 2 else [_between(random, 0.5, 3), _between(random, 0, 2)]
    return (
        drawn_equations.stiff_springs,
        numbers,
        [*random.normal(0, 0.3, count), *[0.0] * count],
        _between(random, 1.5, 5),
    )


def _walls(random: Random, number: int) -> Made:
    half = _between(random, 0.5, 1.5)
    numbers = [_between(random, 0, 2), _between(random, 0, 0.3), _between(random, 0, 3), _decades(random, 0.5, 5)]
    numbers += [_between(random, 2, 10), half, *random.uniform(0.5, 1, 2), _between(random, 0.8, 1)]
    start = [half * _between(random, -0.8, 0.8), _between(random, 0.3, 2), *random.normal(0, 2, 2)]
    flight = (start[3] + math.sqrt(start[3] ** 2 + 2 * numbers[4] * start[1])) / numbers[4]
    return drawn_equations.WALLS, numbers, start, flight * _between(random, 1.5, 4)


def _belts(random: Random, number: int) -> Made:
    kinetic = _between(random, 0.2, 1.5)
    numbers = [_decades(random, 1, 20), _between(random, 0, 0.3), _between(random, 0, 2), _decades(random, 0.5, 3)]
    numbers += [_between(random, -0.5, 0.5), kinetic, kinetic * _between(random, 1.05, 1.6)]
    start = [_between(random, -1.5, 1.5), _between(random, -1.5, 1.5)]
    return drawn_equations.STICK_SLIP, numbers, start, _decades(random, 4, 20)


def _surfaces(random: Random, number: int) -> Made:
    if number % 3 == 2:
        frame, length = _direction(random), _between(random, 0.5, 2)
        middle, drift, turning = random.normal(0, 1, 3), random.normal(0, 0.7, 3), random.normal(0, 1, 3)
        across = np.cross(turning, frame * length) / 2
        start = [*(middle + frame * length / 2), *(middle - frame * length / 2), *(drift + across), *(drift - across)]
        numbers = [*random.uniform(0.3, 3, 4), _between(random, 0, 3)]
        return drawn_equations.DUMBBELL, numbers, start, _decades(random, 5, 30)
    squares, quartic = random.uniform(0.5, 2, 3), random.uniform(0, 0.5, 2)
    numbers = [*squares, *quartic, _between(random, -0.4, 0.4), _between(random, 1, 10)]
    place = _direction(random)
    gradient = np.array(drawn_equations.ON_SURFACE.gradient(0, tuple(place.tolist()), tuple(numbers)))
    gradient /= np.linalg.norm(gradient)
    velocity = random.normal(0, 1.5, 3)
    return (
        drawn_equations.ON_SURFACE,
        numbers,
        [*place, *(velocity - gradient * (velocity @ gradient))],
        _decades(random, 4, 20),
    )


def _balls(random: Random, number: int) -> Made:
    numbers = [9.81, _decades(random, 1e-3, 0.1), _between(random, -0.5, 0.5), *random.normal(0, 3, 1)]
    numbers += [_between(random, -0.1, 0.3), _between(random, 0, 1)]
    speed, angle = _decades(random, 5, 60), _between(random, 0.2, 1.4)
    start = [0, 1, 0, speed * math.cos(angle), speed * math.sin(angle), _between(random, -2, 2)]
    return drawn_equations.drag, numbers, start, 2 * speed * math.sin(angle) / 9.81 * _between(random, 0.4, 0.9)


def _long(random: Random, number: int) -> Made:
    a, c = _between(random, 0.5, 2), _decades(random, 0.05, 1)
    b = _between(random, -1, 1) * math.sqrt(a * c)
    return (
        drawn_equations.long_oscillator, [a, b, c], [_decades(random, 0.3, 2), 0.0],
        TURN / math.sqrt(a) * _decades(random, 300, 1000),
    )  # fmt: skip


ACCELERATIONS = {
    drawn_equations.valley, drawn_equations.deep_valley, drawn_equations.network, drawn_equations.satellite, drawn_equations.oblate,
    drawn_equations.stiff_springs, drawn_equations.spring_pendulum, drawn_equations.long_oscillator,
}  # fmt: skip
"""The functions that give accelerations from positions."""
FAMILIES: dict[str, tuple[str, Callable[[Random, int], Made]]] = {
    "potential": ("position", _potential),
    "springs": ("accurate", _springs),
    "pendulums": ("drag", _pendulums),
    "satellite": ("gravitation", _satellites),
    "centre": ("position", _centre),
    "planets": ("gravitation", _planets),
    "crowd": ("encounters", _crowds),
    "top": ("rigid", _tops),
    "charge": ("magnetic", _charges),
    "dashpots": ("stiff", _dashpots),
    "thick": ("stiff", _thick),
    "vibration": ("vibration", _vibrations),
    "walls": ("impact", _walls),
    "belt": ("events", _belts),
    "surface": ("constraints", _surfaces),
    "ball": ("rough", _balls),
    "long": ("long", _long),
}
"""By family the need that it belongs to, and what draws a system of it."""
