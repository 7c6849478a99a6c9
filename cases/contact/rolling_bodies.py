"""Rolling bodies: down an incline with or without slip, and the yo-yo.

Cases: rolling_bodies, yo_yo.
"""

from __future__ import annotations

import math
from functools import cached_property
from math import cos, sin
from typing import Any, ClassVar

from gnomon.cases.core.case import Case, Event, Invariant, Variant
from gnomon.cases.core.forms import Hybrid, Mode, Separable, Transition, Values
from gnomon.cases.core.numbers import Coordinate, Domain, Parameter, Range, positive
from gnomon.cases.core.scene import Body, Contact, Readings, Scene, SceneForm, Slider
from gnomon.reference.contact.block_incline_friction import holds
from gnomon.reference.contact.rolling_bodies import RollingBody
from gnomon.reference.flight.projectile_stokes_drag import StokesDrag
from gnomon.reference.numerics.precision import Number, exact, publish, working


def slipping_body(t: Any, state: Values, parameters: Values) -> Values:
    """Friction opposes the slip, whose sign is a constant of the mode."""
    g, alpha, mu, k, radius, side = parameters
    friction = side * mu * g * cos(alpha)
    return state[1], g * sin(alpha) - friction, friction / (k * radius)


def rolling_body(t: Any, state: Values, parameters: Values) -> Values:
    g, alpha, _mu, k, radius = parameters
    forward = g * sin(alpha) / (1 + k)
    return state[1], forward, forward / radius


def body_slip(t: Any, state: Values, parameters: Values) -> Values:
    return (state[1] - parameters[4] * state[2],)


def no_slip(t: Any, state: Values, parameters: Values) -> Values:
    return state[0], state[1], state[1] / parameters[4]


def mode_without_slip(t: Any, state: Values, parameters: Values) -> str:
    """The body rolls if tan(alpha) <= mu (1 + 1/k), decided exactly for the given numbers."""
    _g, alpha, mu, k, *_ = parameters
    return "roll" if holds(exact(alpha), exact(mu) * (1 + 1 / exact(k))) else "ahead"


def rolling_mode(t: Any, state: Values, parameters: Values) -> str:
    (slip,) = body_slip(t, state, parameters)
    return "ahead" if slip > 0 else "behind" if slip < 0 else mode_without_slip(t, state, parameters)


def body_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass."""
    g, alpha, _mu, k, radius = parameters
    turning = radius * state[2]
    return ((state[1] * state[1] + k * turning * turning) / 2 - g * sin(alpha) * state[0],)


def yo_yo_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    g, m, inertia, radius = parameters
    return (g / (1 + inertia / (m * radius * radius)),)


def yo_yo_potential(t: Any, q: Values, parameters: Values) -> Values:
    g, m, inertia, radius = parameters
    return (-g / (1 + inertia / (m * radius * radius)) * q[0],)


def yo_yo_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over m + I/r^2."""
    return (state[1] * state[1] / 2 + yo_yo_potential(t, state[:1], parameters)[0],)


def rolling_scene(state: Values, parameters: Values) -> Scene:
    """A ball with the body's moment on a horizontal plane with tilted gravity: it moves like the cylinder."""
    s, v, w = state
    g, alpha, mu, k, radius = parameters
    moment = k * radius * radius
    ball = Body(
        "body",
        1.0,
        (moment, moment, moment),
        (s, 0.0, radius),
        velocity=(v, 0.0, 0.0),
        angular_velocity=(0.0, w, 0.0),
        radius=radius,
    )
    plane = Contact("body", (0.0, 0.0, 1.0), friction=mu)
    return Scene((g * sin(alpha), 0.0, -g * cos(alpha)), (ball,), contacts=(plane,))


def rolling_reading(readings: Readings, parameters: Values) -> Values:
    position, _, velocity, spin = readings.bodies["body"]
    return position[0], velocity[0], spin[1]


def yo_yo_scene(state: Values, parameters: Values) -> Scene:
    """A vertical motion; a separate token states the string, which rotates the body as it falls."""
    g, m, inertia, _radius = parameters
    body = Body("yo-yo", m, (inertia, inertia, inertia))
    line = Slider("string", "yo-yo", (0.0, 0.0, 0.0), (0.0, 0.0, -1.0), *state)
    return Scene((0.0, 0.0, -g), (body,), sliders=(line,))


def yo_yo_reading(readings: Readings, parameters: Values) -> Values:
    return readings.joints["string"]


ROLLING_SCENE = SceneForm(rolling_scene, rolling_reading, frozenset({"coulomb_isotropic"}), conservative=False)
YO_YO_SCENE = SceneForm(yo_yo_scene, yo_yo_reading, frozenset({"slider", "unwinding_string"}))


class RollingBodies(Case):
    name = "rolling_bodies"
    title = "Cylinder, sphere or hoop on an incline, with or without slip"
    section = "10.12, 10.19"
    conventions = "s down the slope; k = I/(m R^2): 1/2 cylinder, 2/5 sphere, 1 hoop; one friction coefficient."
    state = (
        Coordinate("s", "m", "length"),
        Coordinate("v", "m/s", "velocity"),
        Coordinate("w", "rad/s", "angular velocity"),
    )
    parameter_list = (
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),
        Parameter("alpha", "rad", "0.4", "angle of the incline"),
        Parameter("mu", "1", "0.2", "coefficient of friction"),
        Parameter("k", "1", "0.5", "moment of inertia over m R^2"),
        Parameter("R", "m", "0.1", "radius"),
    )
    default_state = (0, 2, 0)
    domain = Domain(
        {
            "g": positive(),
            "alpha": Range(0.0, math.pi / 2, typical=(0.0, 1.3)),
            "mu": Range(low=0.0, typical=(0.0, 1.0)),
            "k": positive(0.1, 1.0),
            "R": positive(0.1, 2.0),
            **{name: Range(typical=(-5.0, 5.0)) for name in ("s", "v", "w")},
        }
    )
    variants = (
        Variant("rolls", "rolls from rest", initial_state=(0, 0, 0)),
        Variant("slips", "too steep: slips from rest without end", {"alpha": 1}, (0, 0, 0)),
        Variant(
            "limit_above",
            "mu (1 + 1/k) is the double just above tan(alpha), times a power of two: rolls",
            {"alpha": 0.4, "k": 1, "mu": 0.42279321873816184 / 2},
            (0, 0, 0),
        ),
        Variant(
            "limit_below",
            "the double just below: slips, but by less than an ulp of the distance",
            {"alpha": 0.4, "k": 1, "mu": 0.4227932187381618 / 2},
            (0, 0, 0),
        ),
        Variant("bowled", "thrown horizontally without spin: slips, then rolls", {"alpha": 0, "k": "0.4"}, (0, 8, 0)),
        Variant("hoop", "a hoop thrown horizontally: keeps half of its speed", {"alpha": 0, "k": 1}, (0, 8, 0)),
        Variant(
            "cylinder",
            "a cylinder thrown horizontally: keeps two thirds of its speed",
            {"alpha": 0, "k": "0.5"},
            (0, 8, 0),
        ),
        Variant("back_spin", "moves up the slope with back spin, which friction reduces", {"k": "0.4"}, (0, -3, 60)),
        Variant(
            "too_steep",
            "back spin on a slope too steep for rolling: the slip changes its sign",
            {"alpha": 1},
            (0, 0, 40),
        ),
    )
    invariants: ClassVar = {"energy": Invariant(body_energy, "decays")}
    scene = ROLLING_SCENE

    @cached_property
    def _exact(self) -> RollingBody:
        return RollingBody(*self.parameter_values(), *self.initial_state)

    def motion(self) -> RollingBody:
        return self._exact

    @property
    def time_scale(self) -> float:
        """The duration of the slip, at least the time of a fall through the radius."""
        fall = math.sqrt(float(self.parameters["R"] / self.parameters["g"]))
        return max(fall, float(self._exact.slip_time())) if self._exact.slip_ends else fall

    def natural_span(self) -> Number:
        """2.3 times the duration of the slip; 10 time scales if it does not end."""
        return (2.3 if self._exact.slip_ends else 10) * self.time_scale

    @property
    def forms(self) -> tuple[Hybrid, ...]:
        return (
            Hybrid(
                modes=(
                    Mode("ahead", slipping_body, (1.0,)),
                    Mode("behind", slipping_body, (-1.0,)),
                    Mode("roll", rolling_body),
                ),
                start=rolling_mode,
                transitions=(
                    Transition("grips_ahead", "ahead", body_slip, -1, no_slip, "roll"),
                    Transition("grips_behind", "behind", body_slip, 1, no_slip, mode_without_slip),
                ),
                settle=1e-9 * self.time_scale,
                terminal=frozenset({"roll"}),
            ),
        )

    def _listed(self, digits: int) -> tuple[Event, ...]:
        motion = self._exact
        if not motion.slip_ends or motion.slip_time(20) > self.span:
            return ()
        there = motion.slip_state(digits)
        return (Event(motion.slip_time(digits), "grips_ahead" if motion.slip > 0 else "grips_behind", there, there),)

    def same_course(self, other: Case) -> bool:
        theirs = RollingBody(*other.parameter_values(), *other.initial_state)
        mine = self._exact
        return (mine.can_roll, mine.slip > 0, mine.slip < 0) == (theirs.can_roll, theirs.slip > 0, theirs.slip < 0)

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """`friction_to_roll`: the least coefficient with which the body rolls from rest, tan(alpha)/(1 + 1/k)."""
        motion = self._exact
        found = {"rolling_acceleration": motion.rolling_acceleration(digits)} if motion.can_roll else {}
        if motion.slip_ends:
            found |= {"slip_time": motion.slip_time(digits), "rolling_speed": motion.slip_state(digits)[1]}
        with working(digits + 10) as mp:
            _g, alpha, _mu, k, _radius = map(mp.mpf, self.parameter_values())
            return found | {"friction_to_roll": publish([mp.tan(alpha) * k / (1 + k)], digits)[0]}


class YoYo(Case):
    name = "yo_yo"
    title = "Yo-yo unwinding from a vertical string"
    section = "10.12, 10.19"
    conventions = (
        "[inferred] y downward; a thin string unwinds without slip from an axle of radius r and stays vertical."
    )
    state = (Coordinate("y", "m", "length"), Coordinate("v", "m/s", "velocity"))
    parameter_list = (
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),
        Parameter("m", "kg", "0.05", "mass"),
        Parameter("I", "kg m^2", "2e-5", "moment of inertia about the axle"),
        Parameter("r", "m", "0.005", "radius of the axle"),
    )
    default_state = (0, 0)
    default_span = "1.5"
    domain = Domain(
        {name: positive() for name in ("g", "m", "I", "r")} | {name: Range(typical=(-5.0, 5.0)) for name in ("y", "v")}
    )
    variants = (
        Variant("rising", "thrown up along its string: returns", initial_state=(1, -1), span=4),
        Variant("thin", "I = 1e6 m r^2: descends slowly", {"I": "1.25"}, span=1000),
    )
    invariants: ClassVar = {"energy": Invariant(yo_yo_energy)}
    forms = (Separable(yo_yo_acceleration, yo_yo_potential),)
    scene = YO_YO_SCENE
    time_scale = 1.0

    @cached_property
    def _exact(self) -> StokesDrag:
        g, m, inertia, radius = self.parameter_values()
        y, v = self.initial_state
        return StokesDrag(exact(0), (g / (1 + inertia / (m * radius**2)),), (y,), (v,))

    def motion(self) -> StokesDrag:
        return self._exact

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """`acceleration`: downward (m/s^2); `string_force`: m (g - acceleration) (N)."""
        (acceleration,) = self._exact.acceleration
        force = self.parameters["m"] * (self.parameters["g"] - acceleration)
        with working(digits + 2) as mp:
            found = publish(map(mp.mpf, (acceleration, force)), digits)
        return dict(zip(("acceleration", "string_force"), found, strict=True))
