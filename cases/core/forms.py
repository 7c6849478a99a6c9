"""The forms in which a case states its dynamics.

Every function here takes and returns tuples of scalars and uses functions of `math`, without branches or `abs`. The
same source is evaluated in floats, compiled, vectorised, and in mpmath and ball arithmetic by replacing its globals.
States are (q..., q'...). `parameters` is the tuple of values of the case's `parameter_list`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from math import nan
from typing import Any

Values = tuple[Any, ...]
Equations = Callable[[Any, Values, Values], Values]
"""(t, state, parameters) -> derivatives, or any other tuple-valued function of the three."""


@dataclass(frozen=True)
class FirstOrder:
    """y' = equations(t, y, parameters).

    `source` is the more structured form from which these equations were derived, if there is one; it is compiled instead.
    """

    equations: Equations
    source: SecondOrder | RigidBody | None = field(default=None, kw_only=True)


@dataclass(frozen=True, kw_only=True)
class Charged(FirstOrder):
    """A charge in electromagnetic fields; state (position, velocity), or (position, u = gamma velocity) with `light`.

    `fields(t, place, parameters)` -> (ax, ay, az, wx, wy, wz): charge over mass times E and B, so that
    u' = a + v x w. `light(parameters)` -> (c,): the speed of light, for a relativistic motion.
    """

    fields: Equations
    light: Callable[[Values], Values] | None = None


@dataclass(frozen=True, kw_only=True)
class Constrained(FirstOrder):
    """Coordinates of unit mass under one holonomic constraint: q'' = force - lam gradient, constraint(q) = constant.

    State (q..., q'...), tangent to the constraint. `force(t, q, parameters)` without that of the constraint,
    `constraint` -> (g,), `gradient` -> dg/dq. `equations` have index 1: the multiplier is eliminated.
    """

    force: Equations
    constraint: Equations
    gradient: Equations


@dataclass(frozen=True, kw_only=True)
class SemiLinear(FirstOrder):
    """y' = L y + rest(t, y, parameters); `linear(parameters)` gives L row by row. Any stiff part is in L."""

    linear: Callable[[Values], Values]
    rest: Equations


@dataclass(frozen=True)
class SecondOrder:
    """q'' = acceleration(t, q, parameters)."""

    acceleration: Equations


@dataclass(frozen=True)
class Separable(SecondOrder):
    """q' = v, v' = acceleration = -dV/dq per unit mass, with `potential(t, q, parameters)` -> (V,) per unit mass."""

    potential: Equations


@dataclass(frozen=True)
class RigidBody:
    """Euler's equations with attitude: state (w1, w2, w3, R11..R33), w in the body, R body -> space.

    `inertia(parameters)` -> (I1, I2, I3), principal moments; `torque(t, state, parameters)` -> body components.
    """

    inertia: Callable[[Values], Values]
    torque: Equations


@dataclass(frozen=True)
class NBody:
    """Gravitating bodies. `masses(parameters)` -> G*m of each; `bodies(state)` -> ((x, y, z, vx, vy, vz), ...).

    `state(bodies)` converts back to the state of the case. A body with G*m = 0 is a test particle.
    """

    masses: Callable[[Values], Values]
    bodies: Callable[[Values], tuple[Values, ...]]
    state: Callable[[tuple[Values, ...]], Values]


@dataclass(frozen=True)
class Mode:
    """One smooth regime of a hybrid case. `constants`, mostly signs, are appended to the parameters."""

    name: str
    equations: Equations
    constants: tuple[float, ...] = ()


@dataclass(frozen=True)
class Transition:
    """The end of a mode: `guard(t, state, parameters)` -> (value,) crosses zero in `direction` (+1 up, -1 down).

    `reset` maps the state on the guard to the state after it. `target` is the name of the next mode, or a function
    (t, state_after, parameters) -> name of floats or mpf, which may branch. `onto`, given only if `reset` changes the
    state, maps a state to the nearest one on the guard.
    """

    name: str
    mode: str
    guard: Equations
    direction: int
    reset: Equations
    target: str | Callable[[Any, Values, Values], str]
    onto: Equations | None = None

    def lands(self, t: Any, state_after: Values, parameters: Values) -> str:
        """The name of the mode that follows."""
        return self.target if isinstance(self.target, str) else self.target(t, state_after, parameters)


@dataclass(frozen=True)
class Hybrid:
    """Modes and transitions. `start(t, state, parameters)` names the mode of an initial state.

    A mode in `terminal` has no transition. When a transition named in `limits` occurs twice within `settle` seconds, the
    motion enters its limit mode. nan: a case sets `settle` to 1e-9 of its time scale.
    """

    modes: tuple[Mode, ...]
    start: Callable[[Any, Values, Values], str]
    transitions: tuple[Transition, ...]
    settle: float = nan
    terminal: frozenset[str] = frozenset()
    limits: tuple[tuple[str, str, Equations], ...] = ()
    """(transition, limit mode, map of the state) for each Zeno sequence."""

    def mode(self, name: str) -> Mode:
        return next(mode for mode in self.modes if mode.name == name)


@dataclass(frozen=True, kw_only=True)
class Impact(Hybrid):
    """A hybrid motion above a smooth wall, free between impacts; stated besides as a measure differential equation.

    State (q..., q'...). `free(t, state, parameters)` -> the state's derivative without the wall;
    `gap(t, q, parameters)` -> (distance,), its gradient `normal` of unit length; `restitution(parameters)` -> (e,).
    """

    free: Equations
    gap: Equations
    normal: Equations
    restitution: Callable[[Values], Values]


@dataclass(frozen=True, kw_only=True)
class Friction(Hybrid):
    """A hybrid motion on a line with dry friction; stated besides as a measure differential equation. State (x, v).

    `sliding(t, state, (*parameters, side))`: equations of sliding in the direction `side`, without friction for side = 0;
    `bounds(t, state, parameters)` -> (kinetic, static): kinetic friction and the largest static friction, over mass.
    """

    sliding: Equations
    bounds: Equations


Form = FirstOrder | SecondOrder | RigidBody | NBody | Hybrid


def first_order(form: Form) -> FirstOrder | None:
    """The first-order form that a form implies, for any arithmetic; None for Hybrid and NBody, which imply none."""
    if isinstance(form, FirstOrder):
        return form
    if isinstance(form, SecondOrder):
        acceleration = form.acceleration

        def from_second_order(t: Any, state: Values, parameters: Values) -> Values:
            half = len(state) // 2
            return (*state[half:], *acceleration(t, state[:half], parameters))

        return FirstOrder(from_second_order, source=form)
    if isinstance(form, RigidBody):
        inertia, torque = form.inertia, form.torque

        def from_rigid_body(t: Any, state: Values, parameters: Values) -> Values:
            return euler_equations(state, inertia(parameters), torque(t, state, parameters))

        return FirstOrder(from_rigid_body, source=form)
    return None


def euler_equations(state: Values, inertia: Values, torque: Values) -> Values:
    """Euler's equations and R' = R hat(w)."""
    w1, w2, w3, r11, r12, r13, r21, r22, r23, r31, r32, r33 = state
    i1, i2, i3 = inertia
    t1, t2, t3 = torque
    return (
        ((i2 - i3) * w2 * w3 + t1) / i1,
        ((i3 - i1) * w3 * w1 + t2) / i2,
        ((i1 - i2) * w1 * w2 + t3) / i3,
        r12 * w3 - r13 * w2,
        r13 * w1 - r11 * w3,
        r11 * w2 - r12 * w1,
        r22 * w3 - r23 * w2,
        r23 * w1 - r21 * w3,
        r21 * w2 - r22 * w1,
        r32 * w3 - r33 * w2,
        r33 * w1 - r31 * w3,
        r31 * w2 - r32 * w1,
    )
