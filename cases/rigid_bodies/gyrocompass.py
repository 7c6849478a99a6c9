"""The gyrocompass with its axis held in the horizontal plane, which moves like a pendulum on a turning hoop."""

from gnomon.cases.declare import *
from gnomon.cases.guided.pendulum_on_hoop import HoopCase
from gnomon.cases.pendulums.pendulum_simple import PendulumSimple
from gnomon.cases.scenes.hinge import hinged_pull


def compass_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """theta'' = W^2 sin(theta) cos(theta) - (C s W/A) sin(theta), W = Om coslat the horizontal rate of the Earth."""
    (theta,) = q
    across, along, spin, earth, cosine = parameters
    rate = earth * cosine
    return (rate * rate * sin(theta) * cos(theta) - along * spin * rate / across * sin(theta),)


def compass_potential(t: Any, q: Values, parameters: Values) -> Values:
    """Zero at north, without the cancellation of -(C s W/A) cos(theta) there."""
    (theta,) = q
    across, along, spin, earth, cosine = parameters
    rate, half = earth * cosine, sin(theta / 2)
    return (2 * (along * spin * rate / across) * half * half - rate * rate * sin(theta) * sin(theta) / 2,)


def compass_jacobi(t: Any, state: Values, parameters: Values) -> Values:
    return (state[1] * state[1] / 2 + compass_potential(t, state[:1], parameters)[0],)


SCENE = hinged_pull(compass_acceleration)


class Gyrocompass(HoopCase):
    name = "gyrocompass"
    title = "Gyrocompass, its axis held in the horizontal plane"
    section = "10.13, 11.12.3"
    conventions = (
        "theta from true north to the spin axis in the horizontal plane, rad; s is the conserved total axial spin; C "
        "axial moment, A transverse with the gimbal; coslat is the cosine of the latitude."
    )
    theta = Coordinate("rad", "0.5", typical(-7, 7))
    omega = Coordinate("rad/s", 0, typical(-8, 8))
    A = Parameter("kg m^2", "0.08", "transverse moment, gimbal included", positive(0.1, 1))
    C = Parameter("kg m^2", "0.1", "axial moment", positive(0.1, 1))
    s = Parameter("rad/s", 1000, "axial spin", typical(-20, 20))
    Om = Parameter("rad/s", "7.292115e-5", "rate of the Earth", typical(-5, 5))
    coslat = Parameter("1", "0.7", "cosine of the latitude", Range(0.0, 1.0, typical=(0.0, 1.0)))
    variants = (
        Variant(
            "slow_spin",
            "C s = A W/2: the quadratic term dominates, equilibrium is 60 degrees from north",
            {"A": "0.1", "C": "0.1", "s": "0.5", "Om": 1, "coslat": 1},
        ),
        Variant(
            "south_seeking",
            "negative spin: the axis seeks south",
            {"s": -1000},
            (3, 0),
        ),
        Variant(
            "bifurcation",
            "exactly C s = A W: no restoring torque at north to first order",
            {"A": "0.1", "C": "0.1", "s": 1, "Om": 1, "coslat": 1},
            ("0.01", 0),
        ),
        Variant("fast_spin", "the quadratic term is 1e-9 of the linear one", {"s": 40834.0, "Om": "7.292115e-5"}),
        Variant("pole", "no horizontal rate: the axis turns uniformly", {"coslat": 0}, ("0.5", "0.01")),
        Variant("turning", "starts fast enough to turn all round", initial_state=("0.5", "0.5")),
    )
    invariants = conserved(jacobi=compass_jacobi)
    forms = (Separable(compass_acceleration, compass_potential),)
    scene = SCENE

    def coefficients(self) -> tuple[Fraction, Fraction]:
        across, along, spin, earth, cosine = self.parameter_values()
        rate = earth * cosine
        return along * spin * rate / across, rate * rate

    def derived(self, digits: int) -> dict[str, Any]:
        """`small_angle_period`: 2 pi sqrt(A/(C s W)), without the square of the Earth's rate."""
        pull, _ = self.coefficients()
        return {"small_angle_period": (lambda mp: 2 * mp.pi / mp.sqrt(mp.mpf(pull))) if pull > 0 else None}

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        """The pendulum equation that remains without the square of the Earth's rate."""
        pull, _ = self.coefficients()
        if pull <= 0:
            return ()
        effect = "restoring torque proportional to the sine, without the square of the Earth's rate"
        pendulum = self.level(PendulumSimple, effect, g=pull, L=1)
        return (*pendulum.case.hierarchy, pendulum)
