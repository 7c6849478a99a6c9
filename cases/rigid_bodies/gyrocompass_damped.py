"""The gyrocompass with viscous damping, for small angles."""

from gnomon.cases.declare import *
from gnomon.cases.scenes.hinge import hinged_point
from gnomon.reference.oscillators.damped_oscillator import DampedMotion


def damped_compass(t: Any, state: Values, parameters: Values) -> Values:
    across, along, spin, earth, cosine, c = parameters
    return state[1], -(along * spin * earth * cosine * state[0] + c * state[1]) / across


def compass_matrix(parameters: Values) -> Values:
    across, along, spin, earth, cosine, c = parameters
    return 0, 1, -along * spin * earth * cosine / across, -c / across


def nothing_else(t: Any, state: Values, parameters: Values) -> Values:
    return 0, 0


SCENE = hinged_point(damped_compass)


def damped_compass_energy(t: Any, state: Values, parameters: Values) -> Values:
    across, along, spin, earth, cosine, _c = parameters
    return ((across * state[1] * state[1] + along * spin * earth * cosine * state[0] * state[0]) / 2,)


class GyrocompassDamped(Case):
    name = "gyrocompass_damped"
    title = "Gyrocompass with viscous damping, small angles"
    section = "11.12.3"
    conventions = (
        "theta from true north in the horizontal plane, linearised, without the square of the Earth's rate: "
        "A theta'' = -C s Om coslat theta - c theta'."
    )
    theta = Coordinate("rad", "0.1", typical(-0.3, 0.3))
    omega = Coordinate("rad/s", 0, typical(-0.3, 0.3))
    A = Parameter("kg m^2", "0.08", "transverse moment, gimbal included", positive(0.1, 1))
    C = Parameter("kg m^2", "0.1", "axial moment", positive(0.1, 1))
    s = Parameter("rad/s", 1000, "axial spin", positive(1, 20))
    Om = Parameter("rad/s", "7.292115e-5", "rate of the Earth", positive(0.1, 5))
    coslat = Parameter("1", "0.7", "cosine of the latitude", Range(0.0, 1.0, low_open=True, typical=(0.1, 1.0)))
    c = Parameter("N m s", "0.004", "damping constant", nonnegative(0, 2))
    exact_motion = bind(lambda c: DampedMotion(c.A, c.c, c._stiffness, *c.initial_state))
    variants = (
        Variant(
            "critical",
            "exactly critical, numbers exact in binary",
            {"A": 1, "C": 1, "s": 4, "Om": 1, "coslat": 1, "c": 4},
        ),
        Variant("overdamped", "approaches north slowly: rates differ by a factor 4e4", {"c": 4}),
        Variant("undamped", "c = 0: never settles", {"c": 0}),
    )
    invariants = decaying(energy=damped_compass_energy)
    forms = (SemiLinear(damped_compass, linear=compass_matrix, rest=nothing_else),)
    scene = SCENE

    @property
    def _stiffness(self) -> Fraction:
        n = self.parameters
        return n["C"] * n["s"] * n["Om"] * n["coslat"]

    @property
    def time_scale(self) -> float:
        return sqrt(float(self.A / self._stiffness))

    @property
    def fastest_time(self) -> float:
        return min(self.time_scale, 1 / float(self.exact_motion.decay)) if self.exact_motion.decay else self.time_scale

    def natural_span(self) -> Number:
        """10.37 damped periods, at most 10 decay times; 10 decay times of the slow mode if nothing oscillates."""
        if self.exact_motion.regime != DampedMotion.UNDERDAMPED:
            return 10 / float(self.exact_motion.rates()[0])
        cycles, decay = 10.37 * float(self.exact_motion.period()), float(self.exact_motion.decay)
        return cycles if decay * cycles <= 10 else 10 / decay

    @property
    def quantity_names(self) -> tuple[str, ...]:
        oscillates = self.exact_motion.regime == DampedMotion.UNDERDAMPED
        return ("damping_ratio", "undamped_period", *(("period",) if oscillates else ()))
