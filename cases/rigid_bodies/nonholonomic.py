"""A sleigh and a skate on a knife edge: nonholonomic constraints.

Cases: chaplygin_sleigh, knife_edge_incline.
"""

from __future__ import annotations

import math
from functools import cached_property
from math import atan2, cos, sin, sqrt
from typing import Any, ClassVar

from gnomon.cases.core.case import Case, Invariant, Variant
from gnomon.cases.core.forms import FirstOrder, Values
from gnomon.cases.core.numbers import Coordinate, Domain, Parameter, Range, positive
from gnomon.cases.core.scene import Body, Readings, Scene, SceneForm
from gnomon.reference.numerics.precision import Number
from gnomon.reference.rigid_bodies.nonholonomic import ChaplyginSleigh, KnifeEdge


def sleigh_equations(t: Any, state: Values, parameters: Values) -> Values:
    v, w, _theta = state
    m, inertia, a = parameters
    return a * w * w, -m * a * v * w / (inertia + m * a * a), w


def sleigh_energy(t: Any, state: Values, parameters: Values) -> Values:
    v, w, _theta = state
    m, inertia, a = parameters
    return ((m * v * v + (inertia + m * a * a) * w * w) / 2,)


def sleigh_turn(t: Any, state: Values, parameters: Values) -> Values:
    """theta - (q/a) atan(v/(q w)), constant, q^2 = I/m + a^2; it determines the final direction."""
    v, w, theta = state
    m, inertia, a = parameters
    q = sqrt(inertia / m + a * a)
    return (theta - q / a * atan2(v * w, q * w * w),)


def skate_equations(t: Any, state: Values, parameters: Values) -> Values:
    _x, _y, th, v = state
    w, gs = parameters
    return v * cos(th), v * sin(th), w, gs * cos(th)


def skate_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Per unit mass; the edge does no work."""
    x, _y, _th, v = state
    _w, gs = parameters
    return (v * v / 2 - gs * x,)


def skate_speed(t: Any, state: Values, parameters: Values) -> Values:
    """w v - gs sin(theta)."""
    _x, _y, th, v = state
    w, gs = parameters
    return (w * v - gs * sin(th),)


def skate_turn(t: Any, state: Values, parameters: Values) -> Values:
    return (state[2] - parameters[0] * t,)


def on_edge(x: float, y: float, angle: float, speed: float, turn: float, body: tuple[float, float]) -> Body:
    """A body on a vertical knife edge at (x, y); `body` is its mass and its moment about the vertical."""
    mass, moment = body
    velocity = (speed * cos(angle), speed * sin(angle), 0.0)
    attitude = (0.0, 0.0, sin(angle / 2), cos(angle / 2))
    return Body("edge", mass, (moment, moment, moment), (x, y, 0.0), attitude, velocity, (0.0, 0.0, turn))


def read_edge(readings: Readings) -> tuple[float, float, float, float, float]:
    """x, y, angle, forward speed, rate of turn."""
    (x, y, _), (_, _, qz, qw), (vx, vy, _), (_, _, turn) = readings.bodies["edge"]
    angle = 2 * atan2(qz, qw)
    return x, y, angle, vx * cos(angle) + vy * sin(angle), turn


def sleigh_scene(state: Values, parameters: Values) -> Scene:
    """The edge is at the origin; the moment accounts for the centre of mass at a ahead of it."""
    v, w, theta = state
    m, inertia, a = parameters
    return Scene((0.0, 0.0, 0.0), (on_edge(0.0, 0.0, theta, v, w, (m, inertia + m * a * a)),))


def sleigh_reading(readings: Readings, parameters: Values) -> Values:
    _, _, angle, speed, turn = read_edge(readings)
    return speed, turn, angle


def skate_scene(state: Values, parameters: Values) -> Scene:
    x, y, th, v = state
    w, gs = parameters
    return Scene((gs, 0.0, 0.0), (on_edge(x, y, th, v, w, (1.0, 1.0)),))


def skate_reading(readings: Readings, parameters: Values) -> Values:
    return read_edge(readings)[:4]


EDGE = frozenset({"knife_edge"})
SLEIGH_SCENE = SceneForm(sleigh_scene, sleigh_reading, EDGE, conservative=False)
SKATE_SCENE = SceneForm(skate_scene, skate_reading, EDGE, conservative=False)


class ChaplyginSleighCase(Case):
    name = "chaplygin_sleigh"
    title = "Chaplygin sleigh (nonholonomic knife edge)"
    section = "11.2.2"
    conventions = (
        "v is the forward speed of the edge, with the centre of mass at a ahead of it. Energy is constant, but phase volume "
        "is not: every motion tends to straight ahead (v = V). The path of the edge follows from the state: "
        "x' = v cos(theta), y' = v sin(theta)."
    )
    state = (
        Coordinate("v", "m/s", "velocity"),
        Coordinate("w", "rad/s", "angular velocity"),
        Coordinate("theta", "rad", "angle"),
    )
    parameter_list = (
        Parameter("m", "kg", 2, "mass"),
        Parameter("I", "kg m^2", "0.5", "moment of inertia about the centre of mass"),
        Parameter("a", "m", "0.3", "from the edge to the centre of mass"),
    )
    default_state = ("-1.5", "0.4", 0)
    domain = Domain(
        {name: positive() for name in ("m", "I", "a")}
        | {name: Range(typical=(-5.0, 5.0)) for name in ("v", "w", "theta")}
    )
    variants = (
        Variant(
            "backward",
            "starts straight backward up to 1e-12: an unstable motion, then a sudden turn",
            initial_state=(-1, "1e-12", 0),
        ),
        Variant("spin", "starts with a fast rotation and no speed", initial_state=(0, 20, 0)),
        Variant("straight", "exactly straight backward: stays so, though unstable", initial_state=(-1, 0, 0), span=100),
        Variant("slow", "the centre of mass almost at the edge: a slow turn", {"a": "1e-4"}),
    )
    invariants: ClassVar = {"energy": Invariant(sleigh_energy), "turn": Invariant(sleigh_turn)}
    forms = (FirstOrder(sleigh_equations),)
    scene = SLEIGH_SCENE
    reversal = ("v", "w")

    @cached_property
    def _exact(self) -> ChaplyginSleigh:
        return ChaplyginSleigh(*self.parameter_values(), *self.initial_state)

    def motion(self) -> ChaplyginSleigh:
        return self._exact

    @property
    def time_scale(self) -> float:
        """q/(a V), the decay time of the rotation, or the time of a radian of it if that is shorter."""
        m, inertia, a = map(float, self.parameter_values())
        square = inertia / m + a * a
        speed = float(self._exact.speed())
        return min(square / (a * speed), math.sqrt(square) / speed) if speed else 1.0

    def natural_span(self) -> Number:
        """The time of the turn, and 5 decay times more."""
        m, inertia, a = map(float, self.parameter_values())
        speed, w = float(self._exact.speed()), abs(float(self.initial_state[1]))
        if not speed or not w:
            return 10 * self.time_scale
        square = inertia / m + a * a
        until = max(0.0, -math.asinh(float(self.initial_state[0]) / (math.sqrt(square) * w)))
        return (until + 5) * square / (a * speed)

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """`edge_x` and `edge_y`: the position of the edge at the end of the span, relative to its start (m)."""
        x, y = self._exact.path(self.span, digits)
        return {
            "final_speed": self._exact.speed(digits),
            "whole_turn": self._exact.whole_turn(digits),
            "edge_x": x,
            "edge_y": y,
        }


class KnifeEdgeIncline(Case):
    name = "knife_edge_incline"
    title = "Knife edge (skate) on an incline, constant turn rate"
    section = "11.2.2"
    conventions = "x down the slope, y across, gs = g sin(alpha); a turning skate drifts across the slope, not down."
    state = (
        Coordinate("x", "m", "length"),
        Coordinate("y", "m", "length"),
        Coordinate("th", "rad", "angle"),
        Coordinate("v", "m/s", "velocity"),
    )
    parameter_list = (
        Parameter("w", "rad/s", "0.7", "rate of turn"),
        Parameter("gs", "m/s^2", "1.7", "g sin(alpha)"),
    )
    default_state = (0, 0, 0, 0)
    domain = Domain(
        {"w": Range(typical=(-5.0, 5.0)), "gs": Range(low=0.0, typical=(0.0, 9.0))}
        | {name: Range(typical=(-5.0, 5.0)) for name in ("x", "y", "th", "v")}
    )
    variants = (
        Variant("long_1e4", "10,000 turns: the distance across grows, that down the slope must not", span="89763.5"),
        Variant("slow_turn", "w = 1e-8: formulas divide by w^2", {"w": "1e-8"}, span=20),
        Variant("straight", "w = 0: down the slope", {"w": 0}, (0, 0, "0.3", 0), span=20),
        Variant("launched", "starts with speed", initial_state=(0, 0, 1, 3)),
    )
    invariants: ClassVar = {
        "energy": Invariant(skate_energy),
        "speed": Invariant(skate_speed),
        "turn": Invariant(skate_turn),
    }
    forms = (FirstOrder(skate_equations),)
    scene = SKATE_SCENE
    reversal = ("v", "w")

    @cached_property
    def _exact(self) -> KnifeEdge:
        return KnifeEdge(*self.parameter_values(), *self.initial_state)

    def motion(self) -> KnifeEdge:
        return self._exact

    @property
    def time_scale(self) -> float:
        """The time of a radian of the turn."""
        w = abs(float(self.parameters["w"]))
        return 1 / w if w > 0.01 else 1.0

    def natural_span(self) -> Number:
        """10.37 turns; 10 s if it does not turn."""
        w = abs(float(self.parameters["w"]))
        return 10.37 * 2 * math.pi / w if w > 0.01 else 10.0

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """`drift`: the mean velocity across the slope, if started at rest (m/s)."""
        drift = self._exact.drift(digits)
        return {} if drift is None else {"drift": drift}
