"""Scene of a flat box that slides along x on a plane with dry friction."""

from collections.abc import Callable

from gnomon.cases.core.scene import Body, Contact, Force, Readings, Scene, SceneForm, Vector

HALF_EXTENTS = (0.5, 0.5, 0.1)
"""So flat that no force of these scenes tips the box over (m)."""
Values = tuple[float, ...]


def flat_box(
    gravity: Callable[[Values], Vector],
    friction: Callable[[Values], float],
    *more: str,
    mass: Callable[[Values], float] = lambda parameters: 1.0,
    push: Callable[[float, float, Values], Vector] | None = None,
    token: str = "position_force",
    belt: Callable[[Values], float] = lambda parameters: 0.0,
) -> SceneForm:
    """State (x, v). `gravity`, kinetic `friction`, `mass` and `belt`, the plane's speed along x, follow from parameters.

    `push(t, x, parameters)` is a force on the box (N) with this `token`; `more` are further tokens of the scene.
    """

    def build(state: Values, parameters: Values) -> Scene:
        x, v = state
        a, b, c = HALF_EXTENTS
        m = mass(parameters)
        inertia = (m * (b * b + c * c) / 3, m * (a * a + c * c) / 3, m * (a * a + b * b) / 3)
        box = Body("box", m, inertia, (x, 0.0, c), velocity=(v, 0.0, 0.0), half_extents=HALF_EXTENTS)
        plane = Contact("box", (0.0, 0.0, 1.0), friction=friction(parameters), velocity=(belt(parameters), 0.0, 0.0))
        forces: tuple[Force, ...] = ()
        if push is not None:
            law = push
            forces = (Force("box", token, lambda t, place, _velocity: law(t, place[0], parameters)),)
        return Scene(gravity(parameters), (box,), contacts=(plane,), forces=forces)

    needs = {"coulomb_isotropic", *more} | ({token} if push is not None else set())
    return SceneForm(build, box_reading, frozenset(needs), conservative=False)


def box_reading(readings: Readings, parameters: Values) -> Values:
    position, _, velocity, _ = readings.bodies["box"]
    return position[0], velocity[0]
