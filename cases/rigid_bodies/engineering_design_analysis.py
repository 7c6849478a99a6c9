"""A flyball governor whose spindle spins freely."""

from gnomon.cases.declare import *
from gnomon.cases.guided.free_azimuth import FreeAzimuthCase
from gnomon.cases.scenes.hoop import GOVERNOR
from gnomon.reference.guided.free_azimuth import Governor


def governor_equations(t: Any, state: Values, parameters: Values) -> Values:
    """Lagrange's equations of arms (theta) and spindle (phi)."""
    theta, _phi, rate, spin = state
    g, m, sleeve, length, inertia = parameters
    sine, cosine = sin(theta), cos(theta)
    lift = m * spin * spin * cosine - 2 * sleeve * rate * rate * cosine - (m + sleeve) * g / length
    ball = 2 * m * length * length * sine
    return (
        rate,
        spin,
        sine * lift / (m + 2 * sleeve * sine * sine),
        -2 * ball * cosine * rate * spin / (inertia + ball * sine),
    )


def governor_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy, zero with the arms hanging straight down."""
    theta, _phi, rate, spin = state
    g, m, sleeve, length, inertia = parameters
    sine, half = sin(theta), sin(theta / 2)
    square = length * length
    arms = square * (m + 2 * sleeve * sine * sine) * rate * rate
    turning = (inertia / 2 + m * square * sine * sine) * spin * spin
    return (arms + turning + 4 * (m + sleeve) * g * length * half * half,)


def governor_momentum(t: Any, state: Values, parameters: Values) -> Values:
    """(I + 2 m L^2 sin^2(theta)) phi', the momentum conjugate to the ignorable azimuth."""
    theta, _phi, _rate, spin = state
    _g, m, _sleeve, length, inertia = parameters
    sine = sin(theta)
    return ((inertia + 2 * m * length * length * sine * sine) * spin,)


def _swings(n: Mapping[str, Fraction]) -> bool:
    return bool(EngineeringDesignAnalysis.motion_of(n).swings)


class EngineeringDesignAnalysis(FreeAzimuthCase):
    """Watt's governor (M = 0), or Porter's with a heavy sleeve, disconnected from the engine."""

    name = "engineering_design_analysis"
    title = "Flyball governor on a free spindle: ignorable azimuth"
    section = "11.12.1"
    conventions = (
        "[inferred] The book names a design analysis; the model is a governor with two arms L from a common pin on the "
        "spindle, a ball m on each, two links of the same length down to a sleeve M, and a spindle and rotor of moment "
        "I. theta from the spindle downward, phi the azimuth; no torque acts about the spindle."
    )
    theta = Coordinate("rad", "0.9", Range(low=-pi, high=pi, typical=(0.8, 1.1)))
    phi = Coordinate("rad", 0, typical(-3, 3))
    rate = Coordinate("rad/s", 0, typical(-0.3, 0.3))
    spin = Coordinate("rad/s", 16, typical(14, 16))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(9, 10))
    m = Parameter("kg", 1, "mass of each ball", positive(1, 2))
    M = Parameter("kg", 2, "mass of the sleeve", nonnegative(0, 2))
    L = Parameter("m", "0.25", "length of an arm", positive(0.25, 0.3))
    I = Parameter("kg m^2", "0.05", "moment of inertia of spindle and rotor", positive(0.05, 0.1))
    rules = (Rule("the energy is below that with the arms straight up (the arms swing)", _swings),)
    exact_motion = bind(Governor, sleeve="M", length="L", inertia="I")
    variants = (
        Variant("watt", "no sleeve: Watt's governor", {"M": 0}, ("0.9", 0, 0, 9)),
        Variant(
            "steady",
            "the steady angle 1 rad up to rounding: spin^2 = (m + M) g/(m L cos 1)",
            {},
            (1, 0, 0, 14.760691931118897),
        ),
        Variant(
            "heavy_sleeve",
            "M = 1e4 m: lifted only at 800 rad/s, 90 turns in each slow swing of the arms",
            {"M": 10**4},
            ("0.9", 0, 0, 800),
        ),
        Variant(
            "light_spindle",
            "I = 1e-4 kg m^2: the rate doubles each time the arms come in",
            {"I": "1e-4"},
            ("0.9", 0, 0, 9),
        ),
        Variant("slow", "too slow to lift the arms from the spindle: a rotating pendulum", {}, ("0.5", 0, 0, 4)),
        Variant(
            "through",
            "released low with a large rate: swings through the spindle's axis to the other side and back",
            {},
            ("0.2", 0, "-1.5", 12),
        ),
        Variant("long_1e4", "10,000 swings and 16,000 turns: phase errors of both", periods=10000.37),
    )
    invariants = conserved(energy=governor_energy, momentum=governor_momentum)
    forms = (FirstOrder(governor_equations),)
    scene = GOVERNOR

    _DRIVEN = "constant spin: a spindle that the arms do not slow"
