"""Scene of the cycloidal pendulum: a bead on a guide of that shape."""

from __future__ import annotations

from math import cos, sin

from gnomon.cases.core.scene import Body, Guide, Readings, Scene, SceneForm, Vector


def cycloid_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    phi, rate = state
    a, g = parameters

    def cycloid(phi: float) -> Vector:
        return a * (phi + sin(phi)), 0.0, a * (1 - cos(phi))

    bead = Body("bead", 1.0, (0.0, 0.0, 0.0))
    return Scene((0.0, 0.0, -g), (bead,), guides=(Guide("cycloid", "bead", cycloid, phi, rate),))


def cycloid_reading(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
    return readings.joints["cycloid"]


SCENE = SceneForm(cycloid_scene, cycloid_reading, frozenset({"curved_guide"}))
