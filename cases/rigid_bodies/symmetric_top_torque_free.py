"""The torque-free axisymmetric body: regular precession."""

from gnomon.cases.declare import *
from gnomon.cases.rigid_bodies.euler_top import (
    momentum_size,
    momentum_x,
    momentum_y,
    momentum_z,
    no_torque,
    spinning,
    twice_energy,
)
from gnomon.cases.scenes.attitude import euler_top_reading, euler_top_scene
from gnomon.reference.rigid_bodies.euler_top import EulerTop


def axial_moments(parameters: Values) -> Values:
    across, along = parameters
    return across, across, along


def axial_spin(t: Any, state: Values, parameters: Values) -> Values:
    return (state[2],)


def of_three_moments(function: Equations) -> Equations:
    """A function of the general body for parameters (A, C)."""

    def with_axis(t: Any, state: Values, parameters: Values) -> Values:
        return function(t, state, axial_moments(parameters))

    return with_axis


def axial_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    return euler_top_scene(state, axial_moments(parameters))


def axial_reading(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
    return euler_top_reading(readings, axial_moments(parameters))


SCENE = SceneForm(axial_scene, axial_reading, frozenset({"gyroscopic"}), conservative=False)


class SymmetricTopTorqueFree(Case):
    name = "symmetric_top_torque_free"
    title = "Torque-free axisymmetric body: regular precession"
    section = "10.17"
    conventions = (
        "C is the moment about the third axis, A the transverse one. w are body components; R, row by row, maps them to space, "
        "R' = R hat(w). R(0) need not be orthogonal."
    )
    w1 = Coordinate("rad/s", "0.4", typical(-2, 2))
    w2 = Coordinate("rad/s", "0.3", typical(-2, 2))
    w3 = Coordinate("rad/s", 2, typical(-2, 2))
    attitude = Attitude()
    A = Parameter("kg m^2", 2, "transverse moment of inertia", positive(0.8, 1.5))
    C = Parameter("kg m^2", 3, "axial moment of inertia", positive(0.5, 1.6))
    rules = (Rule("the triangle inequality C <= 2 A", lambda n: n["C"] <= 2 * n["A"]),)
    exact_motion = bind(EulerTop, moments="A A C", rates="w1 w2 w3")
    quantity_names = ("precession_rate=precession", "body_period")
    variants = (
        Variant("prolate", "a rod-like body: it precesses in the same sense as it spins", {"A": 3, "C": "0.3"}),
        Variant("disc", "a flat disc, C = 2 A: wobbles twice as fast as it spins", {"C": 4}, spinning("0.01", 0, 2)),
        Variant(
            "earth",
            "the Earth's free wobble of 305 days beside its daily rotation, three wobbles long",
            {"A": 1, "C": Fraction(306, 305)},
            spinning("1.458423e-10", 0, "7.292115e-5"),
            span="79100000",
        ),
        Variant("nearly_sphere", "C/A - 1 = 1e-9: the slow wobble is 1e-9 of the spin", {"A": 1, "C": "1.000000001"}),
        Variant("turns_1e5", "1e5 turns in space: drift by round-off", span=200000),
        Variant("engines", "the parameters of engine tests", initial_state=spinning("0.5", 0, 3), span=10),
    )
    invariants = conserved(
        twice_energy=of_three_moments(twice_energy),
        momentum=of_three_moments(momentum_size),
        momentum_x=of_three_moments(momentum_x),
        momentum_y=of_three_moments(momentum_y),
        momentum_z=of_three_moments(momentum_z),
        axial_spin=axial_spin,
    )
    forms = (RigidBody(axial_moments, no_torque),)
    scene = SCENE
    reversal = ("w1", "w2", "w3")

    @property
    def time_scale(self) -> float:
        """One radian at the initial rate."""
        rate = hypot(*map(float, self.initial_state[:3]))
        return 1 / rate if rate else 1.0

    def natural_span(self) -> Number:
        """10.37 turns about the angular momentum."""
        precession = float(self.exact_motion.precession())
        return 10.37 * 2 * pi / precession if precession else 10.0
