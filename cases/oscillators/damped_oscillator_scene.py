"""Scene of the damped oscillator: a mass on a slider, with spring and damper as one force."""

from __future__ import annotations

from gnomon.cases.core.scene import Body, Force, Readings, Scene, SceneForm, Slider, Vector


def damped_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    x, v = state
    m, c, k = parameters

    def spring_and_damper(t: float, position: Vector, velocity: Vector) -> Vector:
        return -c * velocity[0] - k * position[0], 0.0, 0.0

    slider = Slider("rail", "mass", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), x, v)
    force = Force("mass", "velocity_force", spring_and_damper)
    body = Body("mass", m, (0.0, 0.0, 0.0))
    return Scene((0.0, 0.0, 0.0), (body,), sliders=(slider,), forces=(force,))


def damped_reading(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
    return readings.joints["rail"]


SCENE = SceneForm(damped_scene, damped_reading, frozenset({"slider", "velocity_force"}), conservative=False)
"""Not conservative: the damper's force depends on the velocity."""
