"""Scenes of one unit mass point under one force, free or on a rail, made from the equations of a case."""

from collections.abc import Callable
from typing import Any

from gnomon.cases.core.forms import Equations, Values
from gnomon.cases.core.scene import Body, Force, Readings, Scene, SceneForm, Slider, Vector

UP = (0, 2)
"""The engine's axes (z up) of plane coordinates (x, y up)."""
SPACE = (0, 1, 2)


def free_point(
    equations: Equations,
    axes: tuple[int, ...],
    *more: str,
    token: str = "velocity_force",
    fields: Equations | None = None,
) -> SceneForm:
    """A free point of mass 1 with state (position..., velocity...); the force is the velocity's derivative in `equations`.

    `axes` are the engine's axes of the state's coordinates; `token` says on what the force depends; `more` are further
    tokens that the engine must support. `fields`: the fields of a charge in space, as in `forms.Charged`.
    """
    half = len(axes)

    def placed(values: tuple[float, ...]) -> Vector:
        point = [0.0, 0.0, 0.0]
        for axis, value in zip(axes, values, strict=True):
            point[axis] = value
        return point[0], point[1], point[2]

    def picked(vector: Vector) -> tuple[float, ...]:
        return tuple(vector[axis] for axis in axes)

    def build(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
        def push(t: float, position: Vector, velocity: Vector) -> Vector:
            return placed(equations(t, (*picked(position), *picked(velocity)), parameters)[half:])

        def pair(t: float, position: Vector) -> tuple[Vector, Vector]:
            assert fields is not None
            ax, ay, az, wx, wy, wz = fields(t, position, parameters)
            return (ax, ay, az), (wx, wy, wz)

        body = Body("point", 1.0, (0.0, 0.0, 0.0), placed(state[:half]), velocity=placed(state[half:]))
        force = Force("point", token, push, fields=None if fields is None else pair)
        return Scene((0.0, 0.0, 0.0), (body,), forces=(force,))

    def observe(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
        position, _, velocity, _ = readings.bodies["point"]
        return (*picked(position), *picked(velocity))

    return SceneForm(build, observe, frozenset({token, *more}), conservative=token == "position_force" and not more)


def railed_pull(acceleration: Equations) -> SceneForm:
    """A point of mass 1 on a rail with state (x, v): x'' = acceleration(t, (x,), parameters) depends on x alone."""

    def equations(t: Any, state: Values, parameters: Values) -> Values:
        return (state[1], *acceleration(t, state[:1], parameters))

    return _railed(equations, "position_force", frozenset({"slider", "position_force"}), conservative=True)


def railed_point(equations: Equations, *more: str, token: str = "velocity_force") -> SceneForm:
    """A point of mass 1 on a rail with state (x, v); the force is the derivative of v in `equations`. Tokens as above."""
    return _railed(equations, token, frozenset({"slider", token, *more}), conservative=False)


def railed(force: Callable[[float, float, Values], float], token: str = "position_force") -> SceneForm:
    """A system with one coordinate and constant inertia, such as a chain in a tube: a point of mass 1 on a rail.

    State (x, v); `force(t, x, parameters)` is the force over the inertia.
    """

    def equations(t: Any, state: Values, parameters: Values) -> Values:
        return state[1], force(t, state[0], parameters)

    return _railed(equations, token, frozenset({"slider", token}), conservative=token == "position_force")


def _railed(equations: Equations, token: str, needs: frozenset[str], conservative: bool) -> SceneForm:
    def build(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
        def push(t: float, position: Vector, velocity: Vector) -> Vector:
            return equations(t, (position[0], velocity[0]), parameters)[1], 0.0, 0.0

        rail = Slider("rail", "point", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), *state)
        body = Body("point", 1.0, (0.0, 0.0, 0.0))
        force = Force("point", token, push)
        return Scene((0.0, 0.0, 0.0), (body,), sliders=(rail,), forces=(force,))

    def observe(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
        return readings.joints["rail"]

    return SceneForm(build, observe, needs, conservative)
