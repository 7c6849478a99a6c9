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
    """Equations of first order: y' = equations(t, y, parameters).

    Attributes
    ----------
    equations : Callable
        (t, state, parameters) -> derivatives, tuples of numbers.
    source : SecondOrder or RigidBody, optional
        The more structured form from which these equations were derived; it is compiled instead.

    Examples
    --------
    >>> decay = FirstOrder(lambda t, y, p: (-p[0] * y[0],))
    >>> decay.equations(0, (3,), (2,))
    (-6,)
    """

    equations: Equations
    source: SecondOrder | RigidBody | None = field(default=None, kw_only=True)


@dataclass(frozen=True, kw_only=True)
class Charged(FirstOrder):
    """A charge in electromagnetic fields; state (position, velocity), or (position, u = gamma velocity) with `light`.

    `fields(t, place, parameters)` -> (ax, ay, az, wx, wy, wz): charge over mass times E and B, so that
    u' = a + v x w. `light(parameters)` -> (c,): the speed of light, for a relativistic motion.

    Examples
    --------
    >>> from gnomon.cases import get
    >>> isinstance(get("charge_in_E_and_B").forms[0], Charged)
    True
    """

    fields: Equations
    light: Callable[[Values], Values] | None = None


@dataclass(frozen=True, kw_only=True)
class Constrained(FirstOrder):
    """Coordinates under m holonomic constraints: M q'' = force + velocity_force - G^T lam, constraint(t, q) = constant.

    The state is (q..., q'...), with n coordinates. It is consistent: G q' + g_t = 0. The constants are those of the start.

    Attributes
    ----------
    equations : Callable
        The equations of index 1, with the multipliers lam eliminated; `gnomon.cases.core.elimination.index_one` makes them.
    force : Callable
        (t, q, parameters) -> the n forces without those of the constraints and without those that depend on velocities.
    constraint : Callable
        (t, q, parameters) -> (g_1, ..., g_m).
    gradient : Callable
        (t, q, parameters) -> G = dg/dq, row by row: m n numbers.
    mass : Callable, optional
        (t, q, parameters) -> M, symmetric and definite, row by row: n n numbers. None: unit masses.
    velocity_force : Callable, optional
        (t, state, parameters) -> n forces that depend on velocities, among them -(dM/dt) q' and its like. None: none.
    constraint_rate : Callable, optional
        (t, q, parameters) -> (g_t1, ..., g_tm), the derivatives at a constant place. None: constraints without time.

    Examples
    --------
    >>> from gnomon.cases import get
    >>> (form,) = get("holonomic_constraint_dae").forms
    >>> isinstance(form, Constrained)
    True
    """

    force: Equations
    constraint: Equations
    gradient: Equations
    mass: Equations | None = None
    velocity_force: Equations | None = None
    constraint_rate: Equations | None = None


@dataclass(frozen=True, kw_only=True)
class SemiLinear(FirstOrder):
    """Equations with a linear part: y' = L y + rest(t, y, parameters). Any stiff part is in L.

    Attributes
    ----------
    equations : Callable
        The whole right-hand side, as in `FirstOrder`.
    linear : Callable
        parameters -> the numbers of L, row by row.
    rest : Callable
        (t, state, parameters) -> the other part of the derivatives.

    Examples
    --------
    >>> form = SemiLinear(
    ...     lambda t, y, p: (-p[0] * y[0] + t,), linear=lambda p: (-p[0],), rest=lambda t, y, p: (t,)
    ... )
    >>> form.linear((5,))
    (-5,)
    """

    linear: Callable[[Values], Values]
    rest: Equations


@dataclass(frozen=True)
class SecondOrder:
    """Equations of second order: q'' = acceleration(t, q, parameters). The state is (q..., q'...).

    Attributes
    ----------
    acceleration : Callable
        (t, q, parameters) -> accelerations.

    Examples
    --------
    >>> SecondOrder(lambda t, q, p: (-p[0] * q[0],)).acceleration(0, (2,), (3,))
    (-6,)
    """

    acceleration: Equations


@dataclass(frozen=True)
class Separable(SecondOrder):
    """Equations of second order whose force has a potential: q'' = acceleration = -dV/dq, per unit mass.

    Attributes
    ----------
    acceleration : Callable
        (t, q, parameters) -> accelerations.
    potential : Callable
        (t, q, parameters) -> (V,) per unit mass.

    Examples
    --------
    >>> spring = Separable(lambda t, q, p: (-p[0] * q[0],), lambda t, q, p: (p[0] * q[0] ** 2 / 2,))
    >>> spring.potential(0, (2,), (3,))
    (6.0,)
    """

    potential: Equations


@dataclass(frozen=True)
class RigidBody:
    """Euler's equations with attitude: state (w1, w2, w3, R11..R33), w in the body, R body -> space.

    `inertia(parameters)` -> (I1, I2, I3), principal moments; `torque(t, state, parameters)` -> body components.

    Examples
    --------
    >>> free = RigidBody(inertia=lambda p: p, torque=lambda t, state, p: (0, 0, 0))
    >>> free.inertia((1, 2, 3))
    (1, 2, 3)
    """

    inertia: Callable[[Values], Values]
    torque: Equations


@dataclass(frozen=True)
class NBody:
    """Gravitating bodies. `masses(parameters)` -> G*m of each; `bodies(state)` -> ((x, y, z, vx, vy, vz), ...).

    `state(bodies)` converts back to the state of the case. A body with G*m = 0 is a test particle.

    Examples
    --------
    >>> fall = NBody(masses=lambda p: (p[0], 0), bodies=lambda s: ((0,) * 6, s), state=lambda bodies: bodies[1])
    >>> fall.masses((398600.0,))
    (398600.0, 0)
    """

    masses: Callable[[Values], Values]
    bodies: Callable[[Values], tuple[Values, ...]]
    state: Callable[[tuple[Values, ...]], Values]


@dataclass(frozen=True)
class Mode:
    """One smooth regime of a hybrid case.

    Attributes
    ----------
    name : str
        The name of the mode.
    equations : Callable
        (t, state, parameters) -> derivatives.
    constants : tuple of float
        Numbers, mostly signs, that are appended to the parameters in this mode.

    Examples
    --------
    >>> sliding = Mode("slides right", lambda t, y, p: (y[1], -p[1] * p[0]), constants=(1.0,))
    >>> sliding.equations(0, (0, 2), (4, *sliding.constants))
    (2, -4.0)
    """

    name: str
    equations: Equations
    constants: tuple[float, ...] = ()


@dataclass(frozen=True)
class Transition:
    """The end of a mode: its guard crosses zero.

    Attributes
    ----------
    name, mode : str
        The name of the transition, and of the mode that it ends.
    guard : Callable
        (t, state, parameters) -> (value,), which crosses zero at the event.
    direction : int
        +1 if the guard grows through zero, -1 if it falls.
    reset : Callable
        (t, state, parameters) -> the state after the event, from the state on the guard.
    target : str or Callable
        The name of the next mode, or a function (t, state_after, parameters) -> name, which may branch.
    onto : Callable, optional
        (t, state, parameters) -> the nearest state on the guard. Needed if `reset` changes the state.

    Examples
    --------
    >>> impact = Transition(
    ...     "impact", "flies", guard=lambda t, y, p: (y[0],), direction=-1,
    ...     reset=lambda t, y, p: (y[0], -p[0] * y[1]), target="flies", onto=lambda t, y, p: (0, y[1]),
    ... )
    >>> impact.reset(0, (0, -4), (0.5,))
    (0, 2.0)
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
    """A motion of smooth modes, which transitions end.

    Attributes
    ----------
    modes : tuple of Mode
        All modes.
    start : Callable
        (t, state, parameters) -> the name of the mode of an initial state.
    transitions : tuple of Transition
        All transitions.
    settle : float
        If a transition named in `limits` occurs twice within this time (s), the motion enters its limit mode. nan: a case
        sets it to 1e-9 of its time scale.
    terminal : frozenset of str
        Modes without a transition.
    limits : tuple
        (transition, limit mode, map of the state) for each Zeno sequence.

    Examples
    --------
    >>> from gnomon.cases import get
    >>> [mode.name for mode in get("bouncing_ball").hybrid.modes]
    ['flight', 'rest']
    """

    modes: tuple[Mode, ...]
    start: Callable[[Any, Values, Values], str]
    transitions: tuple[Transition, ...]
    settle: float = nan
    terminal: frozenset[str] = frozenset()
    limits: tuple[tuple[str, str, Equations], ...] = ()

    def mode(self, name: str) -> Mode:
        """The mode of this name."""
        return next(mode for mode in self.modes if mode.name == name)


@dataclass(frozen=True, kw_only=True)
class Impact(Hybrid):
    """A hybrid motion above a smooth wall, free between impacts; stated besides as a measure differential equation.

    State (q..., q'...). `free(t, state, parameters)` -> the state's derivative without the wall;
    `gap(t, q, parameters)` -> (distance,), its gradient `normal` of unit length; `restitution(parameters)` -> (e,).

    Examples
    --------
    >>> from gnomon.cases import get
    >>> get("bouncing_ball").forms[0].restitution((9.81, 0.5))
    (0.5,)
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

    Examples
    --------
    >>> from gnomon.cases import get
    >>> isinstance(get("block_incline_friction").forms[0], Friction)
    True
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
