"""Bodies that swing like a simple pendulum of another length: about a fixed axis, or rolling in a bowl.

Cases: rotation_fixed_axis_compound_pendulum, rolling_sphere_in_bowl.
"""

from __future__ import annotations

from fractions import Fraction
from functools import cached_property
from math import cos, sin, sqrt, tau
from typing import Any, ClassVar

from gnomon.cases.core.case import Case, Invariant, Level, Variant, same
from gnomon.cases.core.forms import Separable, Values
from gnomon.cases.core.numbers import Coordinate, Domain, Parameter, Range, Rule, positive
from gnomon.cases.core.scene import IDENTITY, Body, Guide, Hinge, Readings, Scene, SceneForm, Vector
from gnomon.cases.pendulums.pendulum_simple import PendulumSimple
from gnomon.cases.pendulums.pendulum_simple_scene import pendulum_reading
from gnomon.reference.numerics.precision import Number, publish, working
from gnomon.reference.pendulums.pendulum_simple import Pendulum


def swing(theta: Any, square: Any) -> Values:
    return (-square * sin(theta),)


def swing_potential(theta: Any, square: Any) -> Values:
    half = sin(theta / 2)
    return (2 * square * half * half,)


def body_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    inertia, m, g, arm = parameters
    return swing(q[0], m * g * arm / inertia)


def body_potential(t: Any, q: Values, parameters: Values) -> Values:
    inertia, m, g, arm = parameters
    return swing_potential(q[0], m * g * arm / inertia)


def body_energy_over_inertia(t: Any, state: Values, parameters: Values) -> Values:
    return (state[1] * state[1] / 2 + body_potential(t, state[:1], parameters)[0],)


def bowl_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    g, bowl, radius = parameters
    return swing(q[0], 5 * g / (7 * (bowl - radius)))


def bowl_potential(t: Any, q: Values, parameters: Values) -> Values:
    g, bowl, radius = parameters
    return swing_potential(q[0], 5 * g / (7 * (bowl - radius)))


def bowl_energy(t: Any, state: Values, parameters: Values) -> Values:
    return (state[1] * state[1] / 2 + bowl_potential(t, state[:1], parameters)[0],)


def compound_scene(state: Values, parameters: Values) -> Scene:
    """Engines take the moment about the centre of mass, I - m l^2 by Steiner's theorem."""
    theta, omega = state
    inertia, m, g, arm = parameters
    own = max(inertia - m * arm * arm, 0.0)
    body = Body("body", m, (own, own, own))
    hinge = Hinge("pivot", "body", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -arm), theta, omega)
    return Scene((0.0, 0.0, -g), (body,), hinges=(hinge,))


def bowl_scene(state: Values, parameters: Values) -> Scene:
    """The sphere's centre moves on a circle; a separate token states that the sphere rolls."""
    theta, omega = state
    g, bowl, radius = parameters
    way, moment = bowl - radius, 2 * radius * radius / 5

    def circle(angle: float) -> Vector:
        return way * sin(angle), 0.0, -way * cos(angle)

    sphere = Body("sphere", 1.0, (moment, moment, moment), circle(theta), IDENTITY, radius=radius)
    return Scene((0.0, 0.0, -g), (sphere,), guides=(Guide("bowl", "sphere", circle, theta, omega),))


def bowl_reading(readings: Readings, parameters: Values) -> Values:
    return readings.joints["bowl"]


COMPOUND_SCENE = SceneForm(compound_scene, pendulum_reading, frozenset({"hinge"}))
BOWL_SCENE = SceneForm(bowl_scene, bowl_reading, frozenset({"curved_guide", "rolling_without_slip"}))


class _Swinging(Case):
    """A pendulum whose subclass states the square of the frequency of small swings."""

    state = (Coordinate("theta", "rad", "angle"), Coordinate("omega", "rad/s", "angular velocity"))
    reversal = ("omega",)

    _CYCLES: ClassVar[dict[str, str]] = {}

    def square(self) -> Fraction:
        raise NotImplementedError

    @cached_property
    def _exact(self) -> Pendulum:
        theta, omega = self.initial_state
        return Pendulum(self.square(), Fraction(1), theta, omega)

    def motion(self) -> Pendulum:
        return self._exact

    @property
    def time_scale(self) -> float:
        """The time scale of a small swing; in fast rotation the time of a radian."""
        return min(1 / sqrt(float(self.square())), float(self._exact.period()) / tau)

    def natural_span(self) -> Number:
        """10.37 periods; 9 time scales on the separatrix."""
        if self._exact.regime == Pendulum.SEPARATRIX:
            return 9 * self.time_scale
        return float(self._exact.period(20)) * float(self._CYCLES.get(self.variant or "", "10.37"))

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        motion = self._exact
        found = {
            "small_swing_period": motion.small_swing_period(digits),
            "amplitude": motion.amplitude(digits),
            "top_speed": motion.top_speed(digits),
        }
        if motion.regime not in (Pendulum.SEPARATRIX, Pendulum.REST):
            found["turn_time" if motion.regime == Pendulum.ROTATION else "period"] = motion.period(digits)
        return found


class CompoundPendulum(_Swinging):
    name = "rotation_fixed_axis_compound_pendulum"
    title = "Rotation about a fixed axis: the compound pendulum"
    section = "10.11.1, 10.4"
    conventions = (
        "theta from the downward vertical, rad, not wrapped; I about the axis, l from it to the centre of mass."
    )
    parameter_list = (
        Parameter("I", "kg m^2", "0.35", "moment of inertia about the axis"),
        Parameter("m", "kg", 1, "mass"),
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),
        Parameter("l", "m", "0.5", "from the axis to the centre of mass"),
    )
    default_state = (2, 0)
    domain = Domain(
        {
            "I": positive(1.0, 10.0),
            "m": positive(0.5, 2.0),
            "g": positive(),
            "l": positive(0.1, 0.7),
            "theta": Range(typical=(-7.0, 7.0)),
            "omega": Range(typical=(-8.0, 8.0)),
        },
        (Rule("I >= m l^2 (the body's own moment is not negative)", lambda n: n["I"] >= n["m"] * n["l"] ** 2),),
    )
    variants = (
        Variant("rotation", "turns over the top", initial_state=("0.5", 12)),
        Variant("point", "I = m l^2: all mass in one point, the simple pendulum", {"I": "0.25"}),
        Variant("near_axis", "l = 1e-6: the axis almost at the centre of mass, a slow swing", {"l": "1e-6"}),
        Variant(
            "separatrix",
            "exactly the energy at the top, numbers exact in binary",
            {"I": "0.5", "m": 1, "g": 8, "l": "0.25"},
            (0, 4),
        ),
        Variant("upright", "released at rest 1e-12 rad from the top", initial_state=("3.141592653588793", 0)),
        Variant("long_1e4", "10,000 periods: phase error"),
    )
    invariants: ClassVar = {"energy": Invariant(body_energy_over_inertia)}
    forms = (Separable(body_acceleration, body_potential),)
    scene = COMPOUND_SCENE

    _CYCLES: ClassVar[dict[str, str]] = {"upright": "0.45", "long_1e4": "10000.37"}

    def square(self) -> Fraction:
        inertia, m, g, arm = self.parameter_values()
        return m * g * arm / inertia

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        """The simple pendulum of length l: all mass at the centre of mass."""
        _inertia, _m, g, arm = self.parameter_values()
        point = PendulumSimple(initial_state=self.initial_state, span=self.span, g=g, L=arm)
        return (Level(point, same, "all mass at the centre of mass"),)

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """`center_of_percussion`: its distance from the axis, I/(m l) (m). Reactions of the axis at the start (N)."""
        inertia, m, g, arm = self.parameter_values()
        theta, omega = self.initial_state
        with working(digits + 10) as mp:
            found = publish(
                (
                    mp.mpf(inertia / (m * arm)),
                    mp.mpf(m * g) * mp.cos(mp.mpf(theta)) + mp.mpf(m * arm * omega**2),
                    mp.mpf(m * g * (1 - m * arm * arm / inertia)) * mp.sin(mp.mpf(theta)),
                ),
                digits,
            )
        names = ("center_of_percussion", "reaction_along", "reaction_across")
        return super().quantities(digits) | dict(zip(names, found, strict=True))


class RollingSphereInBowl(_Swinging):
    name = "rolling_sphere_in_bowl"
    title = "Sphere rolling in a spherical bowl"
    section = "10.12, 10.19"
    conventions = (
        "[inferred] A solid sphere rolls without slip in a vertical plane of the bowl; theta is the angle of the line "
        "of centres from the downward vertical; contact is assumed to last."
    )
    parameter_list = (
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),
        Parameter("R", "m", 1, "radius of the bowl"),
        Parameter("r", "m", "0.1", "radius of the sphere"),
    )
    default_state = ("1.2", 0)
    domain = Domain(
        {
            "g": positive(),
            "R": positive(1.0, 10.0),
            "r": positive(0.1, 0.9),
            "theta": Range(typical=(-1.5, 1.5)),
            "omega": Range(typical=(-2.0, 2.0)),
        },
        (Rule("the sphere fits into the bowl, r < R", lambda n: n["r"] < n["R"]),),
    )
    variants = (
        Variant("small", "amplitude 1e-6", initial_state=("1e-6", 0)),
        Variant("tight", "r = 0.999999 R: a very fast small swing", {"r": "0.999999"}),
        Variant("long_1e4", "10,000 periods: phase error"),
    )
    invariants: ClassVar = {"energy": Invariant(bowl_energy)}
    forms = (Separable(bowl_acceleration, bowl_potential),)
    scene = BOWL_SCENE

    _CYCLES: ClassVar[dict[str, str]] = {"long_1e4": "10000.37"}

    def square(self) -> Fraction:
        g, bowl, radius = self.parameter_values()
        return 5 * g / (7 * (bowl - radius))
