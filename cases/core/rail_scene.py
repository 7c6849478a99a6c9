"""Scene of a system with one coordinate and constant inertia: a point of mass 1 on a rail, with a force along it.

Examples: a block over a spring, a chain in a tube.
"""

from __future__ import annotations

from collections.abc import Callable

from gnomon.cases.core.scene import Body, Force, Readings, Scene, SceneForm, Slider, Vector

Values = tuple[float, ...]


def railed(force: Callable[[float, float, Values], float], token: str = "position_force") -> SceneForm:
    """State (x, v); `force(t, x, parameters)` is the force over the inertia."""

    def build(state: Values, parameters: Values) -> Scene:
        def push(t: float, position: Vector, velocity: Vector) -> Vector:
            return force(t, position[0], parameters), 0.0, 0.0

        rail = Slider("rail", "point", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), *state)
        point = Body("point", 1.0, (0.0, 0.0, 0.0))
        return Scene((0.0, 0.0, 0.0), (point,), sliders=(rail,), forces=(Force("point", token, push),))

    def observe(readings: Readings, parameters: Values) -> Values:
        return readings.joints["rail"]

    return SceneForm(build, observe, frozenset({"slider", token}), conservative=token == "position_force")
