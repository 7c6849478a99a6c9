"""Andrews' squeezing mechanism of the Test Set for IVP Solvers: seven bodies, six constraints, one freedom."""

from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.cases.core.elimination import multipliers
from gnomon.cases.declare import *
from gnomon.cases.mechanisms.squeezer_equations import (
    accelerations_of_the_joints,
    closures,
    normals_of_the_joints,
    squeezer_energy,
    squeezer_forces,
    squeezer_masses,
    squeezer_rates,
)
from gnomon.reference.numerics.precision import publish, working

FORM = Constrained(
    squeezer_rates,
    force=squeezer_forces,
    constraint=closures,
    gradient=normals_of_the_joints,
    mass=squeezer_masses,
    velocity_force=accelerations_of_the_joints,
)
MULTIPLIERS = multipliers(FORM)
"""Forces of the six constraints, as in the test set."""


def closure_x(t: Any, state: Values, parameters: Values) -> Values:
    """The knee along the lever's chain (m), constant."""
    return (closures(t, state[:7], parameters)[0],)


def closure_y(t: Any, state: Values, parameters: Values) -> Values:
    return (closures(t, state[:7], parameters)[1],)


RATES = ("vbeta", "vtheta", "vgamma", "vphi", "vdelta", "vomega", "vepsilon")


def _angle(start: str) -> Coordinate:
    near = float(start)
    return Coordinate("rad", start, typical(near - 0.02, near + 0.02))


def _rate() -> Coordinate:
    return Coordinate("rad/s", 0, typical(0, 0))


def _size(unit: str, value: str, meaning: str) -> Parameter:
    return Parameter(unit, value, meaning, positive(0.95 * float(value), 1.05 * float(value)))


class AndrewsSqueezer(IntegratedCase):
    """Seven bodies in a plane: a driven crank and coupler move a knee, to which a sprung lever and two dyads are joined."""

    name = "andrews_squeezer"
    title = "Andrews' squeezing mechanism: seven angles, six constraints (certified Taylor)"
    section = "11.2.1"
    conventions = (
        "[inferred] Andrews' squeezing mechanism of the Test Set for IVP Solvers (CWI, Bari; Hairer and Wanner II, VII.7), "
        "index 1: the multipliers are eliminated. Angles and numbers have its names; ax, ay is the pivot B from the spring's "
        "anchor C. The pivots stand where the start puts them: that of the test set, 30 digits, closes to 4e-28 m."
    )
    beta = _angle("-0.0617138900142764496358948458001")
    theta = Coordinate("rad", 0, typical(-0.02, 0.02))
    gamma = _angle("0.455279819163070380255912382449")
    phi = _angle("0.222668390165885884674473185609")
    delta = _angle("0.487364979543842550225598953530")
    omega = _angle("-0.222668390165885884674473185609")
    epsilon = _angle("1.23054744454982119249735015568")
    vbeta, vtheta, vgamma, vphi, vdelta, vomega, vepsilon = (_rate() for _ in range(7))
    m1 = _size("kg", "0.04325", "mass of the crank")
    m2 = _size("kg", "0.00365", "mass of the coupler")
    m3 = _size("kg", "0.02373", "mass of the lever")
    m4 = _size("kg", "0.00706", "mass of the rod of phi")
    m5 = _size("kg", "0.07050", "mass of the body of delta")
    m6 = _size("kg", "0.00706", "mass of the rod of omega")
    m7 = _size("kg", "0.05498", "mass of the body of epsilon")
    I1 = _size("kg m^2", "2.194e-6", "moment of inertia of the crank about its centre of mass")
    I2 = _size("kg m^2", "4.410e-7", "of the coupler")
    I3 = _size("kg m^2", "5.255e-6", "of the lever")
    I4 = _size("kg m^2", "5.667e-7", "of the rod of phi")
    I5 = _size("kg m^2", "1.169e-5", "of the body of delta")
    I6 = _size("kg m^2", "5.667e-7", "of the rod of omega")
    I7 = _size("kg m^2", "1.912e-5", "of the body of epsilon")
    d = _size("m", "0.028", "length of the coupler")
    da = _size("m", "0.0115", "its centre of mass from the crank")
    e = _size("m", "0.02", "length of the rod of phi")
    ea = _size("m", "0.01421", "its centre of mass from the knee")
    rr = _size("m", "0.007", "length of the crank")
    ra = _size("m", "0.00092", "its centre of mass from the axis")
    ss = _size("m", "0.035", "pivot B to the knee")
    sa = _size("m", "0.01874", "centre of mass of the lever from B, along")
    sb = _size("m", "0.01043", "and across")
    sc = _size("m", "0.018", "end of the spring from B, along")
    sd = _size("m", "0.02", "and across")
    ta = _size("m", "0.02308", "centre of mass of the body of delta from A, along")
    tb = _size("m", "0.00916", "and across")
    u = _size("m", "0.04", "pivot A to the rod of omega")
    ua = _size("m", "0.01228", "centre of mass of the body of epsilon from A, along")
    ub = _size("m", "0.00449", "and across")
    zf = _size("m", "0.02", "length of the rod of omega")
    zt = _size("m", "0.04", "pivot A to the rod of phi")
    fa = _size("m", "0.01421", "centre of mass of the rod of omega from the knee")
    ax = Parameter("m", "-0.05035", "pivot B from the spring's anchor, to the right", typical(-0.052, -0.048))
    ay = Parameter("m", "-0.03927", "and upwards", typical(-0.041, -0.037))
    c0 = _size("N/m", "4530", "stiffness of the spring")
    l0 = _size("m", "0.07785", "natural length of the spring")
    mom = _size("N m", "0.033", "torque of the drive")
    rules = (Rule("the mechanism starts at rest", lambda numbers: not any(numbers[name] for name in RATES)),)
    default_span = "0.03"
    variants = (
        Variant(
            "fast_drive", "ten times the torque, through the same turn in less time", {"mom": "0.33"}, span="0.009"
        ),
        Variant(
            "weak_drive", "a millionth of the torque: it leaves the spring's dead centre slowly", {"mom": "3.3e-8"}
        ),
        Variant("stiff_spring", "a spring a hundred times as stiff: the lever snaps", {"c0": 453_000}, span="0.004"),
        Variant(
            "light_crank",
            "crank and coupler of a hundredth of their moments of inertia",
            {"I1": "2.194e-8", "I2": "4.41e-9"},
            span="0.006",
        ),
    )
    invariants = conserved(energy=squeezer_energy, closure_x=closure_x, closure_y=closure_y)
    forms = (FORM,)
    reversal = RATES

    @property
    def time_scale(self) -> float:
        """The time in which the crank alone would turn by a radian, by the spring at its end or by the torque."""
        crank = self.I1 + self.m1 * self.ra**2
        return sqrt(float(min(crank / (self.c0 * self.rr**2), crank / self.mom)))

    @property
    def fastest_time(self) -> float:
        """A radian of the crank at its highest speed, about four times as fast."""
        return self.time_scale / 4

    def derived(self, digits: int) -> dict[str, Any]:
        """The forces of the first two constraints at the start; those of the others are zero (N)."""
        with working(digits + 10) as mp:
            multipliers = rebind(MULTIPLIERS, mpmath_arithmetic(mp))
            state, values = (tuple(map(mp.mpf, numbers)) for numbers in (self.initial_state, self.parameter_values()))
            first, second, *_ = multipliers(mp.mpf(0), state, values)
            return dict(zip(("multiplier_1", "multiplier_2"), publish((first, second), digits), strict=True))
