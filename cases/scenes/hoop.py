"""Scenes of pendulums in a rotating plane: a hinge in the plane, and the centrifugal force.

Coriolis forces are perpendicular to the plane, and the hinge takes them. A hoop or a spindle that turns freely is a
hinge that carries the other hinges (token `chained_hinges`).
"""

from gnomon.cases.core.scene import Body, Force, Hinge, Readings, Scene, SceneForm, Vector, joint

ORIGIN: Vector = (0.0, 0.0, 0.0)


def bead_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    theta, omega = state
    g, radius, rate = parameters

    def centrifugal(t: float, position: Vector, velocity: Vector) -> Vector:
        return rate * rate * position[0], 0.0, 0.0

    bob = Body("bob", 1.0, (0.0, 0.0, 0.0))
    hinge = Hinge("pivot", "bob", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -radius), theta, omega)
    force = Force("bob", "position_force", centrifugal)
    return Scene((0.0, 0.0, -g), (bob,), hinges=(hinge,), forces=(force,))


def free_hoop_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    theta, phi, rate, spin = state
    g, radius, m, inertia = parameters
    hoop, bead = Body("hoop", 1.0, (inertia, inertia, inertia)), Body("bead", m, ORIGIN)
    upright = Hinge("spindle", "hoop", ORIGIN, (0.0, 0.0, 1.0), ORIGIN, phi, spin)
    carried = Hinge("arm", "bead", ORIGIN, (0.0, 1.0, 0.0), (0.0, 0.0, -radius), theta, rate, parent="hoop")
    return Scene((0.0, 0.0, -g), (hoop, bead), hinges=(upright, carried))


def governor_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    """One arm represents the linkage: the other arm, the links and the sleeve follow it (token `linkage`)."""
    theta, phi, rate, spin = state
    g, m, sleeve, length, inertia = parameters
    bodies = (Body("hoop", 1.0, (inertia, inertia, inertia)), Body("ball", m, ORIGIN), Body("sleeve", sleeve, ORIGIN))
    upright = Hinge("spindle", "hoop", ORIGIN, (0.0, 0.0, 1.0), ORIGIN, phi, spin)
    carried = Hinge("arm", "ball", ORIGIN, (0.0, 1.0, 0.0), (0.0, 0.0, -length), theta, rate, parent="hoop")
    return Scene((0.0, 0.0, -g), bodies, hinges=(upright, carried))


def carried_reading(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
    (theta, rate), (phi, spin) = readings.joints["arm"], readings.joints["spindle"]
    return theta, phi, rate, spin


FREE_HOOP = SceneForm(free_hoop_scene, carried_reading, frozenset({"hinge", "chained_hinges"}), conservative=False)
GOVERNOR = SceneForm(
    governor_scene, carried_reading, frozenset({"hinge", "chained_hinges", "linkage"}), conservative=False
)
SCENE = SceneForm(bead_scene, joint("pivot"), frozenset({"hinge", "position_force"}))
