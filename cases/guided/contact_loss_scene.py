"""Scene of a particle on a circle that it can leave: a guide that holds on one side.

Tokens `curved_guide` and `loss_of_contact`.
"""

from __future__ import annotations

from math import atan2, cos, hypot, sin

from gnomon.cases.core.scene import Body, Guide, Readings, Scene, SceneForm, Vector

Values = tuple[float, ...]
NEEDS = frozenset({"curved_guide", "loss_of_contact"})


def _one_sided(up: int) -> SceneForm:
    """`up` is 1 if theta is measured from the top and the particle leaves outward, -1 if from the bottom and inward."""

    def build(state: Values, parameters: Values) -> Scene:
        theta, h, omega, u = state
        g, radius = parameters
        r, rate = radius + up * h, up * u
        s, c = sin(theta), cos(theta)

        def circle(angle: float) -> Vector:
            return radius * sin(angle), 0.0, up * radius * cos(angle)

        velocity = (rate * s + r * omega * c, 0.0, up * (rate * c - r * omega * s))
        body = Body("particle", 1.0, (0.0, 0.0, 0.0), (r * s, 0.0, up * r * c), velocity=velocity)
        return Scene((0.0, 0.0, -g), (body,), guides=(Guide("circle", "particle", circle, theta, omega),))

    def observe(readings: Readings, parameters: Values) -> Values:
        _g, radius = parameters
        (x, _, z), _, (vx, _, vz), _ = readings.bodies["particle"]
        r = hypot(x, z)
        rate = (x * vx + z * vz) / r
        return atan2(x, up * z), up * (r - radius), up * (z * vx - x * vz) / (r * r), up * rate

    return SceneForm(build, observe, NEEDS, conservative=False)


SPHERE, LOOP = _one_sided(1), _one_sided(-1)
