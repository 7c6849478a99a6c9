"""The billiard ball with its attitude, and with drilling friction against the spin about the vertical.

Cases: billiard_ball_attitude, billiard_ball_drill.
"""

from functools import cached_property

from gnomon.cases.contact.billiard_ball import (
    BilliardBallCase,
    ball_energy,
    ball_rolling,
    ball_sliding,
    slip_mode,
    start_rolling,
    until_it_rolls,
)
from gnomon.cases.core.numbers import show
from gnomon.cases.declare import *
from gnomon.cases.scenes.billiard_ball import ATTITUDE_SCENE, DRILL_SCENE
from gnomon.reference.contact.billiard_ball_attitude import MOST_TURN, BilliardAttitude
from gnomon.reference.contact.billiard_ball_drill import DrillingBall

IDENTITY = (1, 0, 0, 0, 1, 0, 0, 0, 1)


def turning(state: Values) -> Values:
    """R' = hat(w) R, w in space."""
    wx, wy, wz, r11, r12, r13, r21, r22, r23, r31, r32, r33 = state[4:]
    return (
        wy * r31 - wz * r21,
        wy * r32 - wz * r22,
        wy * r33 - wz * r23,
        wz * r11 - wx * r31,
        wz * r12 - wx * r32,
        wz * r13 - wx * r33,
        wx * r21 - wy * r11,
        wx * r22 - wy * r12,
        wx * r23 - wy * r13,
    )


def sliding_and_turning(t: Any, state: Values, parameters: Values) -> Values:
    return (*ball_sliding(t, state[:7], parameters), *turning(state))


def rolling_and_turning(t: Any, state: Values, parameters: Values) -> Values:
    return (*ball_rolling(t, state[:7], parameters), *turning(state))


def turning_energy(t: Any, state: Values, parameters: Values) -> Values:
    return ball_energy(t, state[:7], parameters)


def drilling_ball(t: Any, state: Values, parameters: Values) -> Values:
    """Force and drill torque over the mass, -p s and -p rho^2 wz, p = mu g/(|s| + rho |wz|)."""
    _x, _y, vx, vy, wx, wy, wz = state
    radius, mu, g, rho = parameters
    sx, sy = vx - radius * wy, vy + radius * wx
    push = mu * g / (sqrt(sx * sx + sy * sy) + rho * sqrt(wz * wz))
    ax, ay = -push * sx, -push * sy
    twice = 2 * radius
    return vx, vy, ax, ay, 5 * ay / twice, -5 * ax / twice, -10 * push * rho * rho * wz / (twice * twice)


def kept_velocity_x(t: Any, state: Values, parameters: Values) -> Values:
    """vx + (2/5) R wy, constant: no moment acts about the horizontal axes through the point of contact."""
    return (state[2] + 2 * parameters[0] * state[5] / 5,)


def kept_velocity_y(t: Any, state: Values, parameters: Values) -> Values:
    return (state[3] - 2 * parameters[0] * state[4] / 5,)


class BilliardBallAttitude(Case):
    name = "billiard_ball_attitude"
    title = "Billiard ball with its attitude: sliding, then rolling"
    section = "10.15"
    conventions = (
        "As billiard_ball; w in space; R, row by row, takes body components to space, R' = hat(w) R. R(0) need not be "
        "orthogonal."
    )
    x = Coordinate("m", 0, typical(-3, 3))
    y = Coordinate("m", 0, typical(-3, 3))
    vx = Coordinate("m/s", 2, typical(-3, 3))
    vy = Coordinate("m/s", "0.5", typical(-3, 3))
    wx = Coordinate("rad/s", 20, typical(-30, 30))
    wy = Coordinate("rad/s", -30, typical(-30, 30))
    wz = Coordinate("rad/s", 10, typical(-30, 30))
    attitude = Attitude()
    R = Parameter("m", "0.03", "radius", positive(0.02, 0.5))
    mu = Parameter("1", "0.2", "coefficient of friction", nonnegative(0, 1))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(1, 15))
    exact_motion = bind(lambda c: BilliardAttitude(c._plain.exact_motion, c.initial_state[7:]))
    variants = (
        Variant(
            "draw",
            "back spin: stops, then rolls back; the axis of rotation moves",
            initial_state=(0, 0, 1, 0, 0, -150, 0, *IDENTITY),
        ),
        Variant(
            "masse",
            "side spin bends the path; the axis of rotation moves",
            initial_state=(0, 0, 1, 0, -100, 40, 50, *IDENTITY),
        ),
        Variant(
            "dead_stop",
            "spin and speed balance: ends exactly at rest; the axis of rotation moves",
            {"R": "0.03125"},
            (0, 0, 1, 0, 0, -80, 0, *IDENTITY),
        ),
        Variant(
            "rolls",
            "rolls from the start; the axis of rotation moves",
            {"R": "0.03125"},
            (0, 0, 1, 0, 0, 32, 5, *IDENTITY),
        ),
    )
    invariants = decaying(energy=turning_energy)
    forms = (until_it_rolls(sliding_and_turning, rolling_and_turning, start_rolling),)
    scene = ATTITUDE_SCENE

    @cached_property
    def _plain(self) -> BilliardBallCase:
        named: dict[str, Any] = dict(self.parameters)
        return BilliardBallCase(initial_state=self.initial_state[:7], span=1, **named)

    @property
    def time_scale(self) -> float:
        """The time scale of billiard_ball, or the time of a radian of the fastest rotation if that is shorter."""
        scale, rate = self._plain.time_scale, hypot(*map(float, self.initial_state[4:7]))
        if self._plain._ends:
            rate = max(rate, hypot(*map(float, self._plain.exact_motion.rolling_state()[4:7])))
        return min(scale, 1 / rate) if rate else scale

    def natural_span(self) -> Number:
        """The span of billiard_ball. Raises ArithmeticError if the ball turns further in it than the exact motion can follow."""
        span = float(self._plain.natural_span())
        mu, g, radius = (self.parameters[name] for name in ("mu", "g", "R"))
        slid = min(span, float(self._plain.exact_motion.rolling_time())) if self._plain._ends else 0.0
        turn = hypot(*map(float, self.initial_state[4:7])) * slid + 5 * float(mu * g / radius) * slid * slid
        if turn > MOST_TURN:
            raise ArithmeticError(
                f"it slides for {slid:.3g} s and turns by up to {turn:.3g} rad, more than {MOST_TURN}; give a shorter "
                "span, or other numbers"
            )
        return span

    def list_events(self, digits: int) -> tuple[Event, ...]:
        motion = self._plain.exact_motion
        if not self._plain._ends or motion.rolling_time(20) > self.span:
            return ()
        there = self.exact_motion.rolling_state(digits)
        mode = slip_mode(0, self.initial_state[:7], self.parameter_values())
        return (Event(motion.rolling_time(digits), mode.replace("slide", "rolls"), there, there),)

    def same_course(self, other: Case) -> bool:
        mine, theirs = (slip_mode(0, case.initial_state[:7], case.parameter_values()) for case in (self, other))
        return mine == theirs

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        return self._plain.quantities(digits)


class BilliardBallDrill(Case):
    name = "billiard_ball_drill"
    title = "Billiard ball with drilling friction, until sliding and drilling end"
    section = "10.15"
    conventions = (
        "[inferred] As billiard_ball, on a patch of contact of effective radius rho: over the mass, the force "
        "-mu g s/(|s| + rho |wz|) at the lowest point and the torque -mu g rho^2 wz/(|s| + rho |wz|) about the vertical "
        "(Zhuravlev's quotients for Contensou's integrals, with one length). Slip and wz end together; the span ends "
        "before."
    )
    x = Coordinate("m", 0, typical(-3, 3))
    y = Coordinate("m", 0, typical(-3, 3))
    vx = Coordinate("m/s", 2, typical(-3, 3))
    vy = Coordinate("m/s", "0.5", typical(-3, 3))
    wx = Coordinate("rad/s", 20, typical(-30, 30))
    wy = Coordinate("rad/s", -30, typical(-30, 30))
    wz = Coordinate("rad/s", 80, typical(-30, 30))
    R = Parameter("m", "0.03", "radius", positive(0.02, 0.05))
    mu = Parameter("1", "0.2", "coefficient of friction", positive(0.1, 1))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(1, 15))
    rho = Parameter("m", "0.012", "effective radius of the patch of contact, as on a soft cloth", positive(0.01, 0.02))
    rules = (
        Rule("the ball drills (wz is not 0; else see billiard_ball)", lambda n: n["wz"] != 0),
        Rule("the ball slides at the start (the slip is not 0)", lambda n: any(BilliardBallDrill.motion_of(n).slip)),
    )
    exact_motion = bind(DrillingBall)
    default_span = Span(0.9, lambda motion: motion.end_time())
    quantity_names = ("end_time", "final_vx final_vy=final_velocity")
    """`end_time`: when sliding and drilling end (s); then the ball rolls with the final velocity."""
    variants = (
        Variant("little", "rho = R/3e4: as billiard_ball except in the last 1e-4 of the slip", {"rho": "1e-6"}, span="0.4"),
        Variant("top", "spins about the vertical, hardly slides", initial_state=(0, 0, "0.01", 0, 0, 0, 150)),
        Variant("masse", "side spin bends the path longer than without drilling friction", initial_state=(0, 0, 1, 0, -100, 40, 200)),
        Variant("to_the_end", "over 0.99 of the time until all friction ends", initial_state=(0, 0, 1, 0, 0, 0, 50), periods=0.99),
    )  # fmt: skip
    invariants = decaying(energy=ball_energy) | conserved(velocity_x=kept_velocity_x, velocity_y=kept_velocity_y)
    forms = (FirstOrder(drilling_ball),)
    scene = DRILL_SCENE

    def __init__(self, *arguments: Any, **named: Any) -> None:
        super().__init__(*arguments, **named)
        end = float(self.exact_motion.end_time())
        if self.span >= end:
            raise ValueError(
                f"{self.name}: span = {show(self.span)} s: the ball neither slides nor drills from t = {end:.9g} s on; "
                "give a span below"
            )

    @property
    def time_scale(self) -> float:
        """The time in which the slip would end without drilling, at least the time of a fall through the radius."""
        n = self.parameters
        slide = 2 * hypot(*map(float, self.exact_motion.slip)) / (7 * float(n["mu"] * n["g"]))
        return max(slide, sqrt(float(n["R"] / n["g"])))

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        plain = self.level(BilliardBallCase, "rolls when the slip ends; no drilling friction")
        return (*plain.case.hierarchy, plain)
