"""Scenes of cases with one angle, made from their equations: a unit point mass on a hinge, 1 m from a vertical axis.

Its moment about the axis is 1 kg m^2, so a tangential force in newtons is the angular acceleration.
"""

from collections.abc import Callable
from math import atan2

from gnomon.cases.core.forms import Equations, Values
from gnomon.cases.core.scene import Body, Force, Hinge, Readings, Scene, SceneForm, Vector

ORIGIN: Vector = (0.0, 0.0, 0.0)


def hinged_pull(acceleration: Equations) -> SceneForm:
    """theta'' = acceleration(t, (theta,), parameters): depends on the angle alone, with period 2 pi."""
    return _hinged(lambda t, state, parameters: acceleration(t, state[:1], parameters)[0], "position_force", True)


def hinged_point(
    equations: Equations,
    *more: str,
    token: str = "velocity_force",
    friction: Callable[[Values], float] = lambda parameters: 0.0,
) -> SceneForm:
    """theta'' is the derivative of omega in first-order equations for (theta, omega).

    `token` says on what the force depends; `more` are further tokens that the engine must support. `friction` is the dry
    friction of the hinge, apart from the equations.
    """
    return _hinged(
        lambda t, state, parameters: equations(t, state, parameters)[1], token, False, *more, friction=friction
    )


def _hinged(
    torque: Callable[[float, Values, Values], float],
    token: str,
    conservative: bool,
    *more: str,
    friction: Callable[[Values], float] = lambda parameters: 0.0,
) -> SceneForm:
    def build(state: Values, parameters: Values) -> Scene:
        def push(t: float, position: Vector, velocity: Vector) -> Vector:
            (x, y, _), (vx, vy, _) = position, velocity
            size = torque(t, (atan2(y, x), x * vy - y * vx), parameters)
            return -y * size, x * size, 0.0

        dry = friction(parameters)
        hinge = Hinge("axis", "point", ORIGIN, (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), *state, friction=dry)
        return Scene(ORIGIN, (Body("point", 1.0, ORIGIN),), hinges=(hinge,), forces=(Force("point", token, push),))

    return SceneForm(build, hinge_reading, frozenset({"hinge", token, *more}), conservative)


def hinge_reading(readings: Readings, parameters: Values) -> Values:
    return readings.joints["axis"]
