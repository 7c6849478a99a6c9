"""A pendulum on an accelerated support, which moves exactly like a pendulum in the apparent gravity."""

from gnomon.cases.declare import *
from gnomon.cases.pendulums.equivalent_pendulum import EquivalentPendulumCase
from gnomon.reference.pendulums.moment_of_momentum_pendulum import CarriedPendulum


def carried_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """theta'' = -((g + ay)/L) sin(theta) - (ax/L) cos(theta)."""
    (theta,) = q
    g, length, ax, ay = parameters
    return (-((g + ay) / length) * sin(theta) - (ax / length) * cos(theta),)


def carried_potential(t: Any, q: Values, parameters: Values) -> Values:
    (theta,) = q
    g, length, ax, ay = parameters
    return (-((g + ay) / length) * cos(theta) + (ax / length) * sin(theta),)


def carried_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over m L^2 relative to the support, in the apparent gravity."""
    theta, omega = state
    g, length, ax, ay = parameters
    return (omega * omega / 2 - ((g + ay) / length) * cos(theta) + (ax / length) * sin(theta),)


def carried_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    theta, omega = state
    g, length, ax, ay = parameters
    bob = Body("bob", 1.0, (0.0, 0.0, 0.0))
    hinge = Hinge("pivot", "bob", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -length), theta, omega)
    # theta grows towards -x, the direction in which the support is accelerated.
    return Scene((ax, 0.0, -(g + ay)), (bob,), hinges=(hinge,))


SCENE = SceneForm(carried_scene, joint("pivot"), frozenset({"hinge"}))


class MomentOfMomentumPendulum(EquivalentPendulumCase):
    """A pendulum whose support has a constant acceleration; an example of moment of momentum about a moving point."""

    name = "moment_of_momentum_pendulum"
    title = "Pendulum on an accelerated support"
    section = "6.10"
    conventions = (
        "theta from the downward vertical, relative to the support; its constant acceleration is ax towards growing theta "
        "and ay upward."
    )
    theta = Coordinate("rad", 1, typical(-6, 6))
    omega = Coordinate("rad/s", 0, typical(-8, 8))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    L = Parameter("m", 1, "length of the pendulum", positive())
    ax = Parameter("m/s^2", 3, "horizontal acceleration of the support", typical(-10, 10))
    ay = Parameter("m/s^2", 1, "vertical acceleration of the support", typical(-5, 10))
    rules = (
        Rule(
            "g + ay and ax are not both zero (else the pendulum is weightless)",
            lambda n: n["g"] + n["ay"] != 0 or n["ax"] != 0,
        ),
    )
    exact_motion = bind(CarriedPendulum, length="L")
    variants = (
        Variant("braked", "released at rest along the true vertical", initial_state=(0, 0)),
        Variant(
            "falling",
            "the support falls with 1.0001 g: apparent gravity of 1e-4 g upward",
            {"ax": 0, "ay": "-9.810981"},
        ),
        Variant("sideways", "10 g to the side", {"ax": "98.1", "ay": 0}),
        Variant("long_1e4", "10,000 periods: phase error", periods=10000.37),
    )
    invariants = conserved(energy=carried_energy)
    forms = (Separable(carried_acceleration, carried_potential),)
    scene = SCENE
