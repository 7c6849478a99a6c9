"""The torque-free rigid body, with its attitude."""

from gnomon.cases.declare import *
from gnomon.cases.scenes.attitude import SCENE
from gnomon.reference.rigid_bodies.euler_top import EulerTop

TURN = 2 * pi
SLUG_SQUARE_FOOT = Fraction("1.3558179483314004")
"""1 slug ft^2 in kg m^2."""
TEN_DEGREES = Fraction("0.174532925199432957692369076849")


def principal_moments(parameters: Values) -> Values:
    return parameters


def no_torque(t: Any, state: Values, parameters: Values) -> Values:
    return 0, 0, 0


def twice_energy(t: Any, state: Values, parameters: Values) -> Values:
    """I1 w1^2 + I2 w2^2 + I3 w3^2."""
    w1, w2, w3 = state[:3]
    i1, i2, i3 = parameters
    return (i1 * w1 * w1 + i2 * w2 * w2 + i3 * w3 * w3,)


def momentum_size(t: Any, state: Values, parameters: Values) -> Values:
    """|L|, from body components."""
    w1, w2, w3 = state[:3]
    i1, i2, i3 = parameters
    m1, m2, m3 = i1 * w1, i2 * w2, i3 * w3
    return (sqrt(m1 * m1 + m2 * m2 + m3 * m3),)


def momentum_x(t: Any, state: Values, parameters: Values) -> Values:
    """x-component of L in space, which depends on the attitude too."""
    i1, i2, i3 = parameters
    return (state[3] * i1 * state[0] + state[4] * i2 * state[1] + state[5] * i3 * state[2],)


def momentum_y(t: Any, state: Values, parameters: Values) -> Values:
    i1, i2, i3 = parameters
    return (state[6] * i1 * state[0] + state[7] * i2 * state[1] + state[8] * i3 * state[2],)


def momentum_z(t: Any, state: Values, parameters: Values) -> Values:
    i1, i2, i3 = parameters
    return (state[9] * i1 * state[0] + state[10] * i2 * state[1] + state[11] * i3 * state[2],)


def _triangle(n: Mapping[str, Fraction]) -> bool:
    return 2 * max(n["I1"], n["I2"], n["I3"]) <= n["I1"] + n["I2"] + n["I3"]


TRIANGLE = Rule("the triangle inequality I1 + I2 >= I3, I2 + I3 >= I1, I3 + I1 >= I2", _triangle)
"""Principal moments of a body satisfy it."""


def spinning(w1: Number, w2: Number, w3: Number) -> tuple[Number, ...]:
    """The initial state with these body rates, the body axes along the axes of space."""
    return (w1, w2, w3, 1, 0, 0, 0, 1, 0, 0, 0, 1)


class EulerTopCase(Case):
    name = "euler_top"
    title = "Torque-free rigid body"
    section = "10.9, 10.14, 10.17"
    conventions = (
        "w are body components; R, row by row, takes body components to space, R' = R hat(w), hat(w) v = w x v. "
        "R(0) need not be orthogonal."
    )
    w1 = Coordinate("rad/s", 1, typical(-2, 2))
    w2 = Coordinate("rad/s", "0.6", typical(-2, 2))
    w3 = Coordinate("rad/s", "0.3", typical(-2, 2))
    attitude = Attitude()
    I1 = Parameter("kg m^2", 2, "principal moment of inertia", positive(0.8, 1.5))
    I2 = Parameter("kg m^2", 3, "principal moment of inertia", positive(0.8, 1.5))
    I3 = Parameter("kg m^2", 4, "principal moment of inertia", positive(0.8, 1.5))
    rules = (TRIANGLE,)
    exact_motion = bind(EulerTop, moments="I1 I2 I3", rates="w1 w2 w3")
    default_span = Span(10.37, "period in the body")
    turning = Turning(tuple((f"R1{j}", f"R2{j}", f"R3{j}") for j in (1, 2, 3)))
    variants = (
        Variant(
            "flips_1e6",
            "tumbles about the middle axis, 1e-6 from it at the start: long steady phases, sudden flips",
            {"I1": 1, "I2": 2, "I3": 3},
            spinning("1e-6", 1, "1e-6"),
        ),
        Variant(
            "flips_1e12",
            "tumbles, 1e-12 from the middle axis at the start, 1e-24 in energy: a rounding in one flip decides the next",
            {"I1": 1, "I2": 2, "I3": 3},
            spinning("1e-12", 1, "1e-12"),
        ),
        Variant(
            "separatrix",
            "exactly on the separatrix: approaches the unstable axis without end, errors grow as exp(1.6 t)",
            {"I1": 1, "I2": 2, "I3": "2.25"},
            spinning(3, 1, 4),
            span=12,
        ),
        Variant(
            "near_symmetric",
            "two moments differ by 1e-10: formulas divide by the difference",
            {"I1": 1, "I2": "1.0000000001", "I3": "1.5"},
            spinning(1, "0.6", "0.8"),
        ),
        Variant("flat", "a flat body, I3 = I1 + I2", {"I1": 1, "I2": 2, "I3": 3}, spinning(1, "0.6", "0.8")),
        Variant("revolutions_1e3", "1000 revolutions of w in the body: phase error", periods=1000.37),
        Variant("revolutions_1e4", "1e4 revolutions of w in the body: phase error", span="151902.75"),
        Variant("revolutions_1e5", "1e5 revolutions of w in the body: drift by round-off", span=1519002),
        Variant(
            "oblate", "two equal moments, the third greater", {"I1": 2, "I2": 2, "I3": 3}, spinning(1, "0.6", "0.8")
        ),
        Variant(
            "prolate", "two equal moments, the third smaller", {"I1": 1, "I2": 3, "I3": 3}, spinning(1, "0.6", "0.8")
        ),
        Variant("sphere", "three equal moments: rotation about a fixed axis", {"I1": 2, "I2": 2, "I3": 2}),
        Variant(
            "nasa_brick",
            "check case 2 of NASA/TM-2015-218675, without gravity: a brick that tumbles at 10, 20, 30 deg/s",
            {
                f"I{k}": SLUG_SQUARE_FOOT * Fraction(value)
                for k, value in enumerate(("0.00189422", "0.006211019", "0.007194665"), 1)
            },
            spinning(TEN_DEGREES, 2 * TEN_DEGREES, 3 * TEN_DEGREES),
            span=30,
        ),
        Variant(
            "engines",
            "the tumbling body of the engine tables",
            {"I1": 1, "I2": 2, "I3": 3},
            spinning("0.1", 3, "0.1"),
            span=10,
        ),
        Variant(
            "speed",
            "the body of the timing tables: 100.37 body periods, rates only",
            {"I1": 1, "I2": 2, "I3": 3},
            spinning(1, "0.6", 0),
            scored=("angular velocity",),
            periods=100.37,
        ),
    )
    invariants = conserved(
        twice_energy=twice_energy,
        momentum=momentum_size,
        momentum_x=momentum_x,
        momentum_y=momentum_y,
        momentum_z=momentum_z,
    )
    forms = (RigidBody(principal_moments, no_torque),)
    scene = SCENE
    reversal = ("w1", "w2", "w3")
    mirror = ("w1", "w2", "R11", "R12", "R21", "R22", "R31", "R32")
    alike = tuple((f"w{k}", f"R1{k}", f"R2{k}", f"R3{k}", f"I{k}") for k in (1, 2, 3))

    @property
    def time_scale(self) -> float:
        """One radian at the initial rate."""
        rate = hypot(*map(float, self.initial_state[:3]))
        return 1 / rate if rate else float(self.span)

    def natural_span(self) -> Number:
        """10.37 periods in the body; as many turns if w is constant in the body."""
        motion = self.exact_motion
        period = motion.body_period()
        precession = float(motion.precession())
        turn = TURN / precession if precession else 1.0
        return self.periods * (turn if period is None else float(period))

    def derived(self, digits: int) -> dict[str, Any]:
        motion = self.exact_motion
        quantities = {"precession_rate": motion.precession(digits)}
        period, precession = motion.body_period(digits + 5), motion.precession(digits + 5)
        if period is None:
            return quantities
        return quantities | {
            "precession_per_period": lambda mp: mp.mpf(precession) * mp.mpf(period),
            "body_period": lambda mp: mp.mpf(period),
            "flip_interval": (lambda mp: mp.mpf(period) / 2) if motion.kind == "general" else None,
        }
