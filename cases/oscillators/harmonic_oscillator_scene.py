"""Scene of the harmonic oscillator: a mass on a slider, with the spring as a force."""

from __future__ import annotations

from gnomon.cases.core.scene import Body, Force, Readings, Scene, SceneForm, Slider, Vector


def spring_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    x, v = state
    m, k = parameters

    def spring(t: float, position: Vector, velocity: Vector) -> Vector:
        return -k * position[0], 0.0, 0.0

    slider = Slider("rail", "mass", (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), x, v)
    body = Body("mass", m, (0.0, 0.0, 0.0))
    return Scene((0.0, 0.0, 0.0), (body,), sliders=(slider,), forces=(Force("mass", "position_force", spring),))


def spring_reading(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
    return readings.joints["rail"]


SCENE = SceneForm(spring_scene, spring_reading, frozenset({"slider", "position_force"}))
