"""Accelerations by d'Alembert's principle from positions in an inertial Cartesian frame, differentiated automatically.

A second derivation states the positions of the mass points of a system (functions of its coordinates and of time), the
Cartesian forces on them, potential energies and constraints, and nothing else. All are evaluated on series of second
order in time along a path q(t) = q + v t + a t^2/2: with a = 0, and with a = 1 in each coordinate in turn. The change
of the second coefficient of a position is its displacement with that coordinate, so sum (m r'' - F) . dr = 0 for all
displacements that the constraints allow is a linear system for the actual a. No acceleration, mass matrix, inertial
force or equation of motion is written down.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import flint

DIGITS = 220
"""Limits use numbers of up to 1e70 and divide by `SMALL`; about 80 digits remain."""
SMALL = flint.fmpq(1, 10**35)
"""The small parameter of a limit; the error is of its first power, so limits are accurate to about 35 digits."""
Derivation = Callable[..., None]


def _function(name: str) -> Callable[[Any], Any]:
    return lambda x: getattr(x if hasattr(x, name) else flint.arb(x), name)()


sin, cos, sqrt, exp, log, asin = map(_function, ("sin", "cos", "sqrt", "exp", "log", "asin"))


def coefficient(x: Any, k: int) -> Any:
    """The coefficient of t^k."""
    if isinstance(x, flint.arb_series):
        return x[k]
    return flint.arb(x) if k == 0 else flint.arb(0)


def rate(x: Any) -> Any:
    """The derivative in time along the path."""
    return x.derivative() if isinstance(x, flint.arb_series) else flint.arb(0)


class Vec(tuple[Any, ...]):
    """A Cartesian vector."""

    def __add__(self, other: Any) -> Vec:
        return Vec(a + b for a, b in zip(self, other, strict=True))

    def __sub__(self, other: Any) -> Vec:
        return Vec(a - b for a, b in zip(self, other, strict=True))

    def __neg__(self) -> Vec:
        return Vec(-a for a in self)

    def __mul__(self, factor: Any) -> Vec:
        return Vec(a * factor for a in self)

    def __truediv__(self, divisor: Any) -> Vec:
        return Vec(a / divisor for a in self)


def dot(a: Sequence[Any], b: Sequence[Any]) -> Any:
    return sum(x * y for x, y in zip(a, b, strict=True))


def cross(a: Sequence[Any], b: Sequence[Any]) -> Vec:
    return Vec((a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]))


def length(a: Sequence[Any]) -> Any:
    return sqrt(dot(a, a))


def velocity(place: Sequence[Any]) -> Vec:
    """The velocity of a point that moves along the path."""
    return Vec(coefficient(x, 1) for x in place)


def turned(place: Sequence[Any], axis: Sequence[Any], angle: Any) -> Vec:
    """The position rotated about a unit axis through the origin (Rodrigues' formula)."""
    c, s = cos(angle), sin(angle)
    return Vec(Vec(place) * c + cross(axis, place) * s + Vec(axis) * (dot(axis, place) * (1 - c)))


def polar(r: Any, angle: Any) -> Vec:
    return Vec((r * cos(angle), r * sin(angle)))


def integral(function: Callable[[Any], Any], start: Any, end: Any, nodes: int = 48) -> Any:
    """The integral over [start, end] by Gauss' quadrature: exact for polynomials, to about 60 digits for a sine."""
    half, total = (end - start) / 2, flint.arb(0)
    for x, weight in gauss(nodes):
        total = total + function(start + half * (1 + x)) * weight
    return total * half


def gauss(nodes: int) -> list[tuple[Any, Any]]:
    """Nodes and weights of Gauss' quadrature on [-1, 1]."""
    key = nodes, flint.ctx.prec
    if key not in _GAUSS:
        _GAUSS[key] = [flint.arb.legendre_p_root(nodes, k, weight=True) for k in range(nodes)]
    return _GAUSS[key]


_GAUSS: dict[tuple[int, int], list[tuple[Any, Any]]] = {}


class World:
    """Mass points, forces and constraints along one path, which a second derivation fills in.

    `t` is the time, `s` the state at its start, `mode` the mode of a hybrid case, or `at` and the name of a transition.
    """

    def __init__(self, t: Any, s: SimpleNamespace, mode: str) -> None:
        self.t, self.s, self.mode = t, s, mode
        self.masses: list[tuple[Any, Sequence[Any]]] = []
        self.forces: list[tuple[Sequence[Any], Sequence[Any]]] = []
        self.potential: Any = flint.arb(0)
        self.kept: list[Any] = []
        self.slips: list[Any] = []
        self.impulses: list[tuple[Sequence[Any], Sequence[Any]]] = []
        self.kicks: list[tuple[Any, Any]] = []

    def mass(self, m: Any, place: Sequence[Any], gravity: Sequence[Any] | None = None) -> None:
        """A mass point, and its weight in a uniform field of gravity."""
        self.masses.append((m, place))
        if gravity is not None:
            self.force(place, [m * a for a in gravity])

    def force(self, place: Sequence[Any], vector: Sequence[Any]) -> None:
        self.forces.append((place, vector))

    def energy(self, potential: Any) -> None:
        self.potential = self.potential + potential

    def spring(self, k: Any, natural: Any, a: Sequence[Any], b: Sequence[Any]) -> None:
        stretch = length(Vec(b) - a) - natural
        self.energy(k * stretch * stretch / 2)

    def keep(self, value: Any) -> None:
        """A holonomic constraint: the value stays constant."""
        self.kept.append(value)

    def no_slip(self, speed: Any) -> None:
        """A constraint on velocities: the speed, made with `rate`, stays constant; a transition makes it zero."""
        self.slips.append(speed)

    def impulse(self, place: Sequence[Any], vector: Sequence[Any]) -> None:
        """For a transition: a given impulse at a position."""
        self.impulses.append((place, vector))

    def kick(self, value: Any, change: Any) -> None:
        """For a transition: an impulse and its reaction along `value`, which change its rate by `change`."""
        self.kicks.append((value, change))

    def strike(self, gap: Any, restitution: Any) -> None:
        """For a transition: the gap, which closes, opens with the restitution (Newton's law of impact)."""
        self.kick(gap, -(1 + restitution) * coefficient(gap, 1))


@dataclass(frozen=True)
class System:
    """A second derivation at a time and a state."""

    derivation: Derivation
    p: SimpleNamespace
    t: Any
    s: SimpleNamespace
    mode: str

    def along(self, q: Sequence[Any], v: Sequence[Any], a: Sequence[Any]) -> World:
        world = World(flint.arb_series([self.t, 1, 0], 3), self.s, self.mode)
        self.derivation(world, self.p, *(flint.arb_series([x, y, z / 2], 3) for x, y, z in zip(q, v, a, strict=True)))
        return world

    def paths(self, q: Sequence[Any], v: Sequence[Any]) -> tuple[World, list[World]]:
        n = len(q)
        units = [[flint.arb(int(i == j)) for j in range(n)] for i in range(n)]
        return self.along(q, v, [flint.arb(0)] * n), [self.along(q, v, unit) for unit in units]

    def velocities(self, q: Sequence[Any], v: Sequence[Any], momenta: dict[int, Any]) -> list[Any]:
        """`v` with the velocities of some coordinates replaced, so that sum m r' . dr/dq_i are the given momenta."""
        unknown = list(momenta)
        v = [flint.arb(0) if i in unknown else x for i, x in enumerate(v)]
        base, moved = self.paths(q, v)
        shifts = [_shifts(base.masses, moved[i].masses) for i in unknown]
        carried = [velocity(place) for _, place in base.masses]
        matrix = [[_work(base, one, other) for other in shifts] for one in shifts]
        right = [momenta[i] - _work(base, one, carried) for i, one in zip(unknown, shifts, strict=True)]
        for i, x in zip(unknown, solve(matrix, right), strict=True):
            v[i] = x
        return v

    def accelerations(self, q: Sequence[Any], v: Sequence[Any]) -> tuple[list[Any], list[Any]]:
        """a, and the multipliers: the forces of the constraints, positive if they increase the constrained value."""
        base, moved = self.paths(q, v)
        now = [Vec(2 * coefficient(x, 2) for x in place) for _, place in base.masses]
        shifts = [_shifts(base.masses, world.masses) for world in moved]
        loads = []
        for world, shift in zip(moved, shifts, strict=True):
            uphill = 2 * (coefficient(world.potential, 2) - coefficient(base.potential, 2))
            loads.append(_load(base.forces, world.forces) - uphill - _work(base, shift, now))
        return _constrained(base, shifts, loads, *_constraints(base, moved))

    def jump(self, q: Sequence[Any], v: Sequence[Any]) -> list[Any]:
        """Velocities after the impulses of a transition."""
        base, moved = self.paths(q, v)
        shifts = [_shifts(base.masses, world.masses) for world in moved]
        loads = [_load(base.impulses, world.impulses) for world in moved]
        rows, _ = _constraints(base, moved)
        rows += [_row([w.kicks[k][0] for w in moved], gap) for k, (gap, _) in enumerate(base.kicks)]
        changes = [-coefficient(x, 1) for x in base.kept] + [-coefficient(x, 0) for x in base.slips]
        change, _ = _constrained(base, shifts, loads, rows, changes + [change for _, change in base.kicks])
        return [a + b for a, b in zip(v, change, strict=True)]


def _constraints(base: World, moved: list[World]) -> tuple[list[list[Any]], list[Any]]:
    """A, row by row, and the right-hand side of A a = held."""
    rows = [_row([w.kept[k] for w in moved], x) for k, x in enumerate(base.kept)]
    rows += [[coefficient(w.slips[k], 1) - coefficient(x, 1) for w in moved] for k, x in enumerate(base.slips)]
    return rows, [-2 * coefficient(x, 2) for x in base.kept] + [-coefficient(x, 1) for x in base.slips]


def _constrained(base: World, shifts: Any, loads: Any, rows: Any, held: Any) -> tuple[list[Any], list[Any]]:
    """The solution of M a - A^T f = loads, A a = held: a and f."""
    n = len(loads)
    matrix = [[_work(base, one, other) for other in shifts] + [-row[i] for row in rows] for i, one in enumerate(shifts)]
    matrix += [[*row, *([0] * len(rows))] for row in rows]
    found = solve(matrix, [*loads, *held])
    return found[:n], found[n:]


def _row(moved: Sequence[Any], value: Any) -> list[Any]:
    """The derivative of a value by each coordinate."""
    return [2 * (coefficient(x, 2) - coefficient(value, 2)) for x in moved]


def _load(forces: Any, moved: Any) -> Any:
    """The work of forces on a displacement of their positions."""
    pairs = zip(forces, moved, strict=True)
    return sum((dot(_shift(a, b), [coefficient(x, 0) for x in f]) for (a, f), (b, _) in pairs), flint.arb(0))


def _shift(place: Sequence[Any], moved: Sequence[Any]) -> Vec:
    return Vec(_row([b], a)[0] for a, b in zip(place, moved, strict=True))


def _shifts(masses: Any, moved: Any) -> list[Vec]:
    return [_shift(place, other) for (_, place), (_, other) in zip(masses, moved, strict=True)]


def _work(base: World, one: Sequence[Vec], other: Sequence[Vec]) -> Any:
    return sum((m * dot(a, b) for (m, _), a, b in zip(base.masses, one, other, strict=True)), flint.arb(0))


def solve(matrix: list[list[Any]], right: list[Any]) -> list[Any]:
    if not right:
        return []
    found = flint.arb_mat(matrix).solve(flint.arb_mat([[x] for x in right]))
    return [found[i, 0] for i in range(len(right))]
