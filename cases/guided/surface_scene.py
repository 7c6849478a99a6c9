"""Scene of a particle on a smooth surface of revolution. Most engines have only planes (token `curved_surface`)."""

from __future__ import annotations

from collections.abc import Callable
from math import atan2, cos, hypot, sin

from gnomon.cases.core.forms import Values
from gnomon.cases.core.scene import Body, Readings, Scene, SceneForm

Place = Callable[[float, Values], tuple[float, float, float, float]]
"""(x, parameters) -> distance from the axis and height on the meridian, and their derivatives by x."""


def on_surface(place: Place, coordinate: Callable[[float, float, Values], float]) -> SceneForm:
    """State (x, phi, x', phi'); `coordinate` gives x from distance and height; g is the last parameter."""

    def build(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
        x, phi, rate, w = state
        radius, height, out, up = place(x, parameters)
        c, s = cos(phi), sin(phi)
        velocity = (out * rate * c - radius * w * s, out * rate * s + radius * w * c, up * rate)
        particle = Body("particle", 1.0, (0.0, 0.0, 0.0), (radius * c, radius * s, height), velocity=velocity)
        return Scene((0.0, 0.0, -parameters[-1]), (particle,))

    def observe(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
        (px, py, pz), _, (vx, vy, vz), _ = readings.bodies["particle"]
        radius = hypot(px, py)
        x = coordinate(radius, pz, parameters)
        _, _, out, up = place(x, parameters)
        outward = (px * vx + py * vy) / radius
        rate = (out * outward + up * vz) / (out * out + up * up)
        return x, atan2(py, px), rate, (px * vy - py * vx) / radius**2

    return SceneForm(build, observe, frozenset({"curved_surface"}))
