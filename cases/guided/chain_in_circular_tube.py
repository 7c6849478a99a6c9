"""A uniform chain in a smooth circular tube, which moves exactly like a pendulum."""

from gnomon.cases.declare import *
from gnomon.cases.pendulums.equivalent_pendulum import EquivalentPendulumCase
from gnomon.reference.guided.chain_in_circular_tube import TubeChain
from gnomon.reference.numerics.precision import working


def tube_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """theta'' = -(2 g/L) sin(L/2R) sin(theta)."""
    (theta,) = q
    g, length, radius = parameters
    return (-(2 * g / length) * sin(length / (2 * radius)) * sin(theta),)


def tube_potential(t: Any, q: Values, parameters: Values) -> Values:
    (theta,) = q
    g, length, radius = parameters
    return (-(2 * g / length) * sin(length / (2 * radius)) * cos(theta),)


def tube_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over m R^2, zero at the rest position."""
    theta, omega = state
    g, length, radius = parameters
    height = 2 * sin(theta / 2) * sin(theta / 2)
    return (omega * omega / 2 + (2 * g / length) * sin(length / (2 * radius)) * height,)


def _shorter_than_the_tube(length: Fraction, radius: Fraction) -> bool:
    """Decided with enough digits: 2 pi R is not rational."""
    with working(60) as mp:
        return bool(mp.mpf(length / radius) < 2 * mp.pi)


def tube_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    """The chain in the tube moves as a rigid arc about the centre of the circle."""
    theta, omega = state
    g, length, radius = parameters
    arm = 2 * radius * radius / length * sin(length / (2 * radius))
    moment = max(radius * radius - arm * arm, 0.0)  # rounding makes it negative for a very short chain
    arc = Body("arc", 1.0, (moment, moment, moment))
    hinge = Hinge("pivot", "arc", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -arm), theta, omega)
    return Scene((0.0, 0.0, -g), (arc,), hinges=(hinge,))


TUBE = SceneForm(tube_scene, joint("pivot"), frozenset({"hinge"}))


class ChainInCircularTube(EquivalentPendulumCase):
    """A uniform chain that slides in a smooth circular tube in a vertical plane."""

    name = "chain_in_circular_tube"
    title = "Uniform chain sliding in a smooth circular tube (exactly a pendulum)"
    section = "8.12"
    conventions = "theta=angle of chain mid-point from the bottom; chain length L<2 pi R."
    theta = Coordinate("rad", 2, typical(-6, 6))
    omega = Coordinate("rad/s", 0, typical(-5, 5))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    L = Parameter("m", 2, "length of the chain", positive(0.1, 6))
    R = Parameter("m", 1, "radius of the tube", positive(1, 5))
    rules = (Rule("L < 2 pi R (the chain fits into the tube)", lambda n: _shorter_than_the_tube(n["L"], n["R"])),)
    exact_motion = bind(TubeChain, length="L", radius="R")
    variants = (
        Variant("short", "a chain of 1e-6 m: nearly a bead", {"L": "1e-6"}),
        Variant("rotation", "the chain runs around the tube without stopping", initial_state=(0, 6)),
        Variant(
            "neutral",
            "L is the double just below 2 pi R: hardly any restoring force, a period of 4e8 s",
            {"L": 6.283185307179586},
            (2, 0),
        ),
        Variant("long_1e4", "10,000 periods: phase error", periods=10000.37),
    )
    invariants = conserved(energy=tube_energy)
    forms = (Separable(tube_acceleration, tube_potential),)
    scene = TUBE

    def derived(self, digits: int) -> dict[str, Any]:
        """`pendulum_length`: L/(2 sin(L/2R)), the length of the simple pendulum with the same motion (m)."""
        rate = self.exact_motion.frequency(digits + 5)
        return super().derived(digits) | {"pendulum_length": lambda mp: mp.mpf(self.g) / mp.mpf(rate) ** 2}
