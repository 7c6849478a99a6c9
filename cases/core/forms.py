"""The forms in which a case states its dynamics.

Every function here is plain: tuples of scalars in, tuples out, with functions of `math`, no branch, no `abs`. The
same source is evaluated in floats, compiled, vectorised, in mpmath and in ball arithmetic by rebinding its globals.
States stand in the order (q..., q'...). `parameters` is the tuple of parameter values in the order the case
declares them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

Values = tuple[Any, ...]
Equations = Callable[[Any, Values, Values], Values]
"""(t, state, parameters) -> derivatives, or any other tuple-valued function of the three."""


@dataclass(frozen=True)
class FirstOrder:
    """y' = equations(t, y, parameters); `jacobian` (optional) gives df/dy row by row, flattened.

    `source` is the stronger form that these equations were derived from, where they were: it is what gets compiled.
    """

    equations: Equations
    jacobian: Equations | None = None
    source: SecondOrder | RigidBody | None = None


@dataclass(frozen=True, kw_only=True)
class Charged(FirstOrder):
    """A charge in electromagnetic fields, state (place, velocity), or (place, u = gamma velocity) with `light`.

    `fields(t, place, parameters)` -> (ax, ay, az, wx, wy, wz): charge over mass times E and B, so that
    u' = a + v x w. `light(parameters)` -> (c,): the speed of light where the motion is relativistic.
    """

    fields: Equations
    light: Callable[[Values], Values] | None = None


@dataclass(frozen=True, kw_only=True)
class Constrained(FirstOrder):
    """Coordinates of unit mass under one holonomic constraint: q'' = force - lam gradient, constraint(q) = constant.

    State (q..., q'...), tangent to the constraint. `force(t, q, parameters)` without the constraint's own,
    `constraint` -> (g,), `gradient` -> dg/dq. `equations` are those of index 1, with the multiplier eliminated.
    """

    force: Equations
    constraint: Equations
    gradient: Equations


@dataclass(frozen=True, kw_only=True)
class SemiLinear(FirstOrder):
    """y' = L y + rest(t, y, parameters), `linear(parameters)` giving L row by row: the stiff part, if any, is in L."""

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
    """Gravitating bodies. `masses(parameters)` holds G*m of each; `bodies(state)` -> ((x, y, z, vx, vy, vz), ...).

    `state(bodies)` reads the state of the case back. A body with G*m = 0 is a test particle.
    """

    masses: Callable[[Values], Values]
    bodies: Callable[[Values], tuple[Values, ...]]
    state: Callable[[tuple[Values, ...]], Values]


@dataclass(frozen=True)
class Mode:
    """One smooth regime of a hybrid case. `constants` are appended to the parameters (signs, mostly)."""

    name: str
    equations: Equations
    constants: tuple[float, ...] = ()


@dataclass(frozen=True)
class Transition:
    """What ends a mode: `guard(t, state, parameters)` -> (value,) crosses zero in `direction` (+1 up, -1 down).

    `reset` maps the state on the guard to the state after. `target` is the name of the next mode, or a function
    (t, state_after, parameters) -> name, which runs on floats or mpf and may branch. `onto` (only where the
    reset jumps) is the nearest state on the guard.
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
    """Modes and transitions. `start(t, state, parameters)` names the mode of a starting state.

    A mode in `terminal` has no way out. When a transition in `limits` fires twice within `settle` seconds, the motion
    enters the limit mode: `limits[transition] = (mode, map of the state)`.
    """

    modes: tuple[Mode, ...]
    start: Callable[[Any, Values, Values], str]
    transitions: tuple[Transition, ...]
    settle: float
    terminal: frozenset[str] = frozenset()
    limits: tuple[tuple[str, str, Equations], ...] = ()
    """(transition, limit mode, map of the state) for each Zeno sequence."""

    def mode(self, name: str) -> Mode:
        return next(mode for mode in self.modes if mode.name == name)


@dataclass(frozen=True, kw_only=True)
class Impact(Hybrid):
    """A hybrid motion that is a free one above a smooth wall: the same as a law for measures, without modes.

    State (q..., q'...). `free(t, state, parameters)` -> the state's derivative without the wall;
    `gap(t, q, parameters)` -> (distance,), its gradient `normal` of unit length; `restitution(parameters)` -> (e,).
    """

    free: Equations
    gap: Equations
    normal: Equations
    restitution: Callable[[Values], Values]


@dataclass(frozen=True, kw_only=True)
class Friction(Hybrid):
    """A hybrid motion on a line with dry friction, the same as a law for measures, without modes. State (x, v).

    `sliding(t, state, (*parameters, side))` is the mode of sliding to a side, without friction for side = 0;
    `bounds(t, state, parameters)` -> (kinetic, static): friction over mass while it slides, and the most while it holds.
    """

    sliding: Equations
    bounds: Equations


Form = FirstOrder | SecondOrder | RigidBody | NBody | Hybrid


def first_order(form: Form) -> FirstOrder | None:
    """The first-order form that a form implies, in any arithmetic; None where there is none (Hybrid, NBody)."""
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
