"""The gyrocompass with its axis held in the horizontal plane; its equation is that of a pendulum on a turning hoop."""

from __future__ import annotations

from fractions import Fraction
from typing import Any, ClassVar

from gnomon.cases.core.case import Invariant, Level, Variant, same
from gnomon.cases.core.forms import Separable, Values
from gnomon.cases.core.hinge_scene import hinged_pull
from gnomon.cases.core.numbers import Domain, Parameter, Range, positive
from gnomon.cases.guided.pendulum_on_hoop import HoopCase, hoop_acceleration, hoop_potential
from gnomon.cases.pendulums.pendulum_simple import PendulumSimple
from gnomon.reference.numerics.precision import publish, working


def compass_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    across, along, spin, earth, cosine = parameters
    rate = earth * cosine
    return hoop_acceleration(q[0], along * spin * rate / across, rate * rate)


def compass_potential(t: Any, q: Values, parameters: Values) -> Values:
    across, along, spin, earth, cosine = parameters
    rate = earth * cosine
    return hoop_potential(q[0], along * spin * rate / across, rate * rate)


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
    parameter_list = (
        Parameter("A", "kg m^2", "0.08", "transverse moment, gimbal included"),
        Parameter("C", "kg m^2", "0.1", "axial moment"),
        Parameter("s", "rad/s", 1000, "axial spin"),
        Parameter("Om", "rad/s", "7.292115e-5", "rate of the Earth"),
        Parameter("coslat", "1", "0.7", "cosine of the latitude"),
    )
    default_state = ("0.5", 0)
    domain = Domain(
        {
            "A": positive(0.1, 1.0),
            "C": positive(0.1, 1.0),
            "s": Range(typical=(-20.0, 20.0)),
            "Om": Range(typical=(-5.0, 5.0)),
            "coslat": Range(0.0, 1.0, typical=(0.0, 1.0)),
            "theta": Range(typical=(-7.0, 7.0)),
            "omega": Range(typical=(-8.0, 8.0)),
        }
    )
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
    invariants: ClassVar = {"jacobi": Invariant(compass_jacobi)}
    forms = (Separable(compass_acceleration, compass_potential),)
    scene = SCENE

    def coefficients(self) -> tuple[Fraction, Fraction]:
        across, along, spin, earth, cosine = self.parameter_values()
        rate = earth * cosine
        return along * spin * rate / across, rate * rate

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """`small_angle_period`: 2 pi sqrt(A/(C s W)), without the square of the Earth's rate."""
        found, (pull, _) = super().quantities(digits), self.coefficients()
        if pull <= 0:
            return found
        with working(digits + 10) as mp:
            return found | {"small_angle_period": publish([2 * mp.pi / mp.sqrt(mp.mpf(pull))], digits)[0]}

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        """The pendulum equation that remains without the square of the Earth's rate."""
        pull, _ = self.coefficients()
        if pull <= 0:
            return ()
        pendulum = PendulumSimple(initial_state=self.initial_state, span=self.span, g=pull, L=1)
        return (
            *pendulum.hierarchy,
            Level(
                pendulum,
                same,
                "restoring torque proportional to the sine, without the square of the Earth's rate",
            ),
        )
