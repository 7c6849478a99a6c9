"""A particle that slides off a sphere, one that leaves a loop, and a pendulum whose string goes slack.

Cases: bead_leaving_sphere, amusement_park, pendulum_on_string.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from functools import cached_property
from math import cos, pi, sin, sqrt
from typing import Any, ClassVar

from gnomon.cases.core.case import Case, Event, Invariant, Variant
from gnomon.cases.core.forms import Hybrid, Mode, Transition, Values
from gnomon.cases.core.numbers import Coordinate, Domain, Parameter, Range, Rule, positive
from gnomon.cases.core.scene import SceneForm
from gnomon.cases.guided.contact_loss_scene import LOOP, SPHERE
from gnomon.reference.guided.contact_loss import ContactLoss
from gnomon.reference.numerics.precision import Number, quantity, working
from mpmath import mpf


def on_sphere(t: Any, state: Values, parameters: Values) -> Values:
    """theta'' = (g/R) sin(theta)."""
    theta, _, omega, _ = state
    g, radius = parameters
    return omega, 0, g / radius * sin(theta), 0


def off_sphere(t: Any, state: Values, parameters: Values) -> Values:
    """Free flight in polar coordinates, r = R + h."""
    theta, h, omega, u = state
    g, radius = parameters
    r = radius + h
    return omega, u, (g * sin(theta) - 2 * u * omega) / r, r * omega * omega - g * cos(theta)


def sphere_force(t: Any, state: Values, parameters: Values) -> Values:
    """Normal force over the mass."""
    theta, _, omega, _ = state
    g, radius = parameters
    return (g * cos(theta) - radius * omega * omega,)


def in_loop(t: Any, state: Values, parameters: Values) -> Values:
    """theta'' = -(g/R) sin(theta)."""
    theta, _, omega, _ = state
    g, radius = parameters
    return omega, 0, -g / radius * sin(theta), 0


def across_loop(t: Any, state: Values, parameters: Values) -> Values:
    """Free flight in polar coordinates, r = R - h."""
    theta, h, omega, u = state
    g, radius = parameters
    r = radius - h
    return omega, u, (2 * u * omega - g * sin(theta)) / r, -r * omega * omega - g * cos(theta)


def loop_force(t: Any, state: Values, parameters: Values) -> Values:
    theta, _, omega, _ = state
    g, radius = parameters
    return (radius * omega * omega + g * cos(theta),)


def sphere_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Over the mass, from the top of the sphere."""
    theta, h, omega, u = state
    g, radius = parameters
    r, half = radius + h, sin(theta / 2)
    return ((r * r * omega * omega + u * u) / 2 + g * (h - 2 * r * half * half),)


def loop_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Over the mass, from the bottom of the loop."""
    theta, h, omega, u = state
    g, radius = parameters
    r, half = radius - h, sin(theta / 2)
    return ((r * r * omega * omega + u * u) / 2 + g * (h + 2 * r * half * half),)


def as_it_is(t: Any, state: Values, parameters: Values) -> Values:
    theta, h, omega, u = state
    return theta, h, omega, u


def sphere_start(t: Any, state: Values, parameters: Values) -> str:
    return "contact" if state[1] == 0 and state[3] == 0 else "flight"


def _carries(n: Mapping[str, Fraction]) -> bool:
    """Whether the sphere still pushes at the start, decided with 60 digits."""
    with working(60) as mp:
        return bool(mp.mpf(n["g"]) * mp.cos(mp.mpf(n["theta"])) > mp.mpf(n["R"] * n["omega"] ** 2))


def _leaves_the_top(n: Mapping[str, Fraction]) -> bool:
    """138 e-foldings from the top at most: what comes from nearer takes hundreds of digits."""
    away = n["theta"] ** 2 + n["R"] * n["omega"] ** 2 / n["g"]
    return away == 0 or away >= Fraction(1, 10**120)


class _ContactLossCase(Case):
    state = (
        Coordinate("theta", "rad", "angle"),
        Coordinate("h", "m", "length"),
        Coordinate("omega", "rad/s", "angular velocity"),
        Coordinate("u", "m/s", "velocity"),
    )
    parameter_list = (
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),
        Parameter("R", "m", 1, "radius"),
    )
    _INSIDE: ClassVar[bool]
    _SLIDES: ClassVar[Mode]
    _FLIES: ClassVar[Mode]
    _FORCE: ClassVar[Any]

    @cached_property
    def _exact(self) -> ContactLoss:
        theta, _, omega, _ = self.initial_state
        g, radius = self.parameter_values()
        return ContactLoss(g, radius, theta, omega, self._INSIDE)

    def motion(self) -> ContactLoss:
        return self._exact

    @property
    def forms(self) -> tuple[Hybrid, ...]:
        kind = type(self)
        return (
            Hybrid(
                modes=(kind._SLIDES, kind._FLIES),
                start=sphere_start,
                transitions=(Transition("leaves", "contact", kind._FORCE, -1, as_it_is, "flight"),),
                settle=1e-9 * self.time_scale,
                terminal=frozenset({"flight"}),
            ),
        )

    @property
    def scene(self) -> SceneForm:
        return SPHERE if not self._INSIDE else LOOP

    @property
    def time_scale(self) -> float:
        g, radius = map(float, self.parameter_values())
        return sqrt(radius / g)

    def _listed(self, digits: int) -> tuple[Event, ...]:
        """`leaves`, where the normal force vanishes."""
        motion = self._exact
        if not motion.leaves or motion.leaving_time(20) > self.span:
            return ()
        there = (motion.leaving_angle(digits), mpf(0), motion.leaving_rate(digits), mpf(0))
        return (Event(motion.leaving_time(digits), "leaves", there, there),)

    def same_course(self, other: Case) -> bool:
        return isinstance(other, _ContactLossCase) and other._exact.leaves == self._exact.leaves

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        motion = self._exact
        if not motion.leaves:
            return {}
        return {
            "leaving_time": motion.leaving_time(digits),
            "leaving_angle": motion.leaving_angle(digits),
            "leaving_rate": motion.leaving_rate(digits),
        }


class BeadLeavingSphere(_ContactLossCase):
    """A particle that slides down a smooth sphere until it leaves it."""

    name = "bead_leaving_sphere"
    title = "Particle sliding off a smooth sphere, contact-loss event"
    section = "6.3.4, 7.5, 7.11.1"
    conventions = "theta from the top. h is the height over the surface, zero until contact is lost, and u its rate."
    default_state = ("0.1", 0, 0, 0)
    domain = Domain(
        {
            "g": positive(1.0, 10.0),
            "R": positive(0.5, 3.0),
            "theta": Range(low=0.0, high=pi / 2, typical=(0.01, 0.7)),
            "h": Range(0.0, 0.0, typical=(0.0, 0.0)),
            "omega": Range(low=0.0, typical=(0.0, 1.0)),
            "u": Range(0.0, 0.0, typical=(0.0, 0.0)),
        },
        (
            Rule("R omega^2 < g cos(theta) (the sphere still carries)", _carries),
            Rule("theta = omega = 0, or theta^2 + R omega^2/g >= 1e-120 (it leaves the top in time)", _leaves_the_top),
        ),
    )
    variants = (
        Variant(
            "near_top",
            "released 1e-9 rad from the top: 21 e-foldings before anything moves",
            initial_state=("1e-9", 0, 0, 0),
        ),
        Variant("at_top", "exactly at the top: must not slide", initial_state=(0, 0, 0, 0)),
        Variant("launched", "starts at the top with speed", initial_state=(0, 0, 1, 0)),
    )
    invariants: ClassVar = {"energy": Invariant(sphere_energy)}
    _INSIDE = False
    _SLIDES = Mode("contact", on_sphere)
    _FLIES = Mode("flight", off_sphere)
    _FORCE = staticmethod(sphere_force)

    def natural_span(self) -> Number:
        """Until half a time scale after contact is lost; ten time scales at the top."""
        motion = self._exact
        return float(motion.leaving_time()) + 0.5 * self.time_scale if motion.leaves else 10 * self.time_scale


class AmusementPark(_ContactLossCase):
    """A particle in a smooth vertical loop, too slow to stay in contact."""

    name = "amusement_park"
    title = "Loop-the-loop: contact loss inside a vertical circle"
    section = "6.3.4"
    conventions = (
        "theta from the bottom. h is the distance from the loop, zero until contact is lost, and u its rate. The motion "
        "ends before the next contact."
    )
    default_state = (0, 0, "6.5", 0)
    domain = Domain(
        {
            "g": positive(5.0, 10.0),
            "R": positive(0.5, 2.0),
            "theta": Range(low=0.0, high=pi / 2, typical=(0.0, 1.0)),
            "h": Range(0.0, 0.0, typical=(0.0, 0.0)),
            "omega": Range(low=0.0, typical=(1.0, 8.0)),
            "u": Range(0.0, 0.0, typical=(0.0, 0.0)),
        }
    )
    variants: ClassVar[tuple[Variant, ...]] = (
        Variant("through", "fast enough: contact is kept all round", initial_state=(0, 0, "7.2", 0)),
        Variant(
            "just_short",
            "1e-9 below sqrt(5 g/R): leaves 1e-4 rad before the top, where the force only touches zero",
            {"g": 5},
            (0, 0, "4.999999995", 0),
        ),
        Variant("swings", "too slow to reach the side: a pendulum", initial_state=(0, 0, 4, 0)),
    )
    invariants: ClassVar = {"energy": Invariant(loop_energy)}
    _INSIDE = True
    _SLIDES = Mode("contact", in_loop)
    _FLIES = Mode("flight", across_loop)
    _FORCE = staticmethod(loop_force)

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        motion = self._exact
        if motion.leaves and self.span >= Fraction(float(motion.leaving_time() + motion.flight_time())):
            raise ValueError(
                f"{self.name}: span = {float(self.span):g} s reaches the next contact; give a span that ends before "
                f"{float(motion.leaving_time() + motion.flight_time()):.10g} s"
            )

    def natural_span(self) -> Number:
        """Nine tenths of the flight; ten time scales where contact is kept."""
        motion = self._exact
        if not motion.leaves:
            return 10 * self.time_scale
        return float(motion.leaving_time()) + 0.9 * float(motion.flight_time())

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        found = super().quantities(digits)
        return found | {"flight_time": self._exact.flight_time(digits)} if found else found


class PendulumOnString(AmusementPark):
    """A mass on a string, which pulls and does not push."""

    name = "pendulum_on_string"
    title = "Pendulum on a string that goes slack"
    section = "7.10"
    conventions = (
        "theta from the downward vertical. h is by how much the mass is nearer than the string is long, zero while that is "
        "taut, and u its rate: the motion of the loop-the-loop. It ends before the string is taut again."
    )
    parameter_list = (
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),
        Parameter("R", "m", 1, "length of the string"),
    )
    default_state = (1, 0, "5.4", 0)
    variants: ClassVar[tuple[Variant, ...]] = (
        Variant("through", "fast enough: the string stays taut all round", initial_state=(0, 0, "7.2", 0)),
        Variant(
            "just_short",
            "1e-9 below sqrt(5 g/R): the tension only touches zero, 1e-4 rad before the top",
            {"g": 5},
            (0, 0, "4.999999995", 0),
        ),
        Variant("swings", "too slow to reach the side: the string stays taut", initial_state=(0, 0, 4, 0)),
        Variant(
            "just_slack",
            "goes slack 8e-5 rad above the side, and is taut again 0.04 s later",
            {"g": 1},
            (0, 0, "1.4143", 0),
        ),
    )

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """`tension_start` over the mass (m/s^2); times and angle of `leaving` are those at which the string goes slack."""
        theta, _, omega, _ = self.initial_state
        g, radius = self.parameter_values()
        tension = quantity(digits, lambda mp: mp.mpf(radius * omega**2) + mp.mpf(g) * mp.cos(mp.mpf(theta)))
        return {"tension_start": tension} | super().quantities(digits)
