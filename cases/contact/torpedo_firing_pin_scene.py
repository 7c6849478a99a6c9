"""Scene of the firing pin in the frame of the torpedo: a flat box on the wall of its guide.

The deceleration presses it on the wall, the plane z = 0; the primer is the plane x = 0 in front of it.
"""

from __future__ import annotations

from gnomon.cases.core.box_scene import HALF_EXTENTS
from gnomon.cases.core.scene import Body, Contact, Force, Readings, Scene, SceneForm, Vector

Values = tuple[float, ...]


def pin_scene(state: Values, parameters: Values) -> Scene:
    x, v = state
    m, k, d0, mu, a, gap = parameters
    front, side, height = HALF_EXTENTS
    inertia = (
        m * (side * side + height * height) / 3,
        m * (front * front + height * height) / 3,
        m * (front * front + side * side) / 3,
    )

    def spring(t: float, position: Vector, velocity: Vector) -> Vector:
        return k * (d0 - (position[0] + front + gap)), 0.0, 0.0

    pin = Body("pin", m, inertia, (x - gap - front, 0.0, height), velocity=(v, 0.0, 0.0), half_extents=HALF_EXTENTS)
    # one coefficient for both planes: nothing slides along the primer
    wall, primer = (Contact("pin", normal, friction=mu) for normal in ((0.0, 0.0, 1.0), (-1.0, 0.0, 0.0)))
    return Scene((0.0, 0.0, -a), (pin,), contacts=(wall, primer), forces=(Force("pin", "position_force", spring),))


def pin_reading(readings: Readings, parameters: Values) -> Values:
    position, _, velocity, _ = readings.bodies["pin"]
    return position[0] + HALF_EXTENTS[0] + parameters[5], velocity[0]


NEEDS = frozenset({"coulomb_isotropic", "rigid_impact", "position_force"})
STRIKING, CAUGHT = (
    SceneForm(pin_scene, pin_reading, NEEDS | more, conservative=False) for more in (set[str](), {"latch"})
)
"""A pin that stops before the primer is held by a catch, which contacts do not express."""
