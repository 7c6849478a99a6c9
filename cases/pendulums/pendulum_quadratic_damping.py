"""A pendulum with drag proportional to the square of its speed."""

from gnomon.cases.declare import *
from gnomon.cases.pendulums.pendulum_simple import PendulumSimple
from gnomon.reference.numerics.precision import exact
from gnomon.reference.pendulums.pendulum_quadratic_damping import DampedPendulum
from mpmath import mpf


def dragged_swing(t: Any, state: Values, parameters: Values) -> Values:
    """v' = -w2 sin(theta) - side c v^2; `side`, 1 forward and -1 backward, is a constant of the mode."""
    theta, v = state
    w2, c, side = parameters
    return v, -w2 * sin(theta) - side * c * v * v


def swing_rate(t: Any, state: Values, parameters: Values) -> Values:
    """v, which is zero at a turning point: an event."""
    _theta, v = state
    return (v,)


def at_rest(t: Any, state: Values, parameters: Values) -> Values:
    """The state after a turning point, with v exactly 0."""
    theta, _v = state
    return theta, 0


def dragged_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over m L^2, zero at the lowest position."""
    theta, v = state
    w2, _c = parameters
    return (v * v / 2 + 2 * w2 * sin(theta / 2) * sin(theta / 2),)


def swing_mode(t: Any, state: Values, parameters: Values) -> str:
    """The mode at the start: the sign of v or, from rest, of the acceleration."""
    theta, v = map(exact, state)
    forward = v > 0 if v else sin(theta) < 0
    return "forward" if forward else "backward"


def dragged_scene(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
    """A unit mass on a rod of 1 m, with drag -c |u| u at its velocity u."""
    theta, v = state
    w2, c = parameters

    def drag(t: float, position: Vector, velocity: Vector) -> Vector:
        vx, vy, vz = velocity
        pull = -c * sqrt(vx * vx + vy * vy + vz * vz)
        return pull * vx, pull * vy, pull * vz

    bob = Body("bob", 1.0, (0.0, 0.0, 0.0))
    hinge = Hinge("pivot", "bob", (0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0), theta, v)
    return Scene((0.0, 0.0, -w2), (bob,), hinges=(hinge,), forces=(Force("bob", "velocity_force", drag),))


SCENE = SceneForm(dragged_scene, joint("pivot"), frozenset({"hinge", "velocity_force"}), conservative=False)


def _moves(n: Mapping[str, Fraction]) -> bool:
    return n["w2"] * n["theta"] ** 2 + n["v"] ** 2 >= n["w2"] * LEAST**2


def _not_too_slow(n: Mapping[str, Fraction]) -> bool:
    return n["v"] == 0 or n["v"] ** 2 >= n["w2"] * SLOWEST**2


SLOWEST = Fraction(1, 10**50)
"""Fraction of sqrt(w2): binary64 does not resolve a slower start from rest, and its time integral needs many digits."""
LEAST = Fraction(1, 10**15)
"""Least amplitude a (rad): drag reduces a by about (4/3) c a^2 in a half swing, which is below an ulp for smaller a."""


MOST_RESTS = 500
"""Most events within a span: each takes two integrals."""


class PendulumQuadraticDamping(Case):
    name = "pendulum_quadratic_damping"
    title = "Pendulum with quadratic damping: a first integral for each half swing"
    section = "6.13.1"
    conventions = (
        "theta from the downward vertical, rad, not wrapped; the second derivative of the drag -c v |v| jumps where the "
        "pendulum comes to rest: an event. v^2 = K exp(-2 c theta) + A (cos theta - 2 c sin theta), A = 2 w2/(1 + 4 c^2), "
        "while v > 0; time by quadrature between these events."
    )
    theta = Coordinate("rad", "2.5", Range(-1e9, 1e9, typical=(-2.5, 2.5)))
    v = Coordinate("rad/s", 0, typical(-8, 8))
    w2 = Parameter("1/s^2", "9.81", "g/L", positive(1, 10))
    c = Parameter(
        "1", "0.1", "drag on the bob over m L theta'^2", Range(low=0.0, high=4.0, low_open=True, typical=(0.02, 0.5))
    )
    rules = (
        Rule("w2 theta^2 + v^2 >= 1e-30 w2 (the pendulum swings by 1e-15 rad or more)", _moves),
        Rule("v = 0 or v^2 >= 1e-100 w2 (it starts at rest, or at 1e-50 of its natural rate or more)", _not_too_slow),
    )
    exact_motion = bind(DampedPendulum)
    default_span = Span(10, "rest")
    variants = (
        Variant("turns", "turns over the top 5 times before it swings", {"c": "0.05"}, (0, 20)),
        Variant("weak", "c = 1e-8: nearly undamped, turning points differ by 1e-8", {"c": "1e-8"}),
        Variant("strong", "c = 2: each swing is 0.6 of the one before", {"c": 2}, ("-1.5", 0)),
        Variant(
            "just_over",
            "thrown 1e-9 too fast to stop at the top: passes it slowly, then turns round",
            {"w2": 1, "c": "0.125"},
            (0, 2.45170962707798 * (1 + 1e-9)),
            periods=2,
        ),
        Variant(
            "just_under",
            "thrown 1e-9 too slowly: comes to rest 4e-5 rad before the top and falls back",
            {"w2": 1, "c": "0.125"},
            (0, 2.45170962707798 * (1 - 1e-9)),
            periods=2,
        ),
        Variant("upright", "released at rest 1e-9 rad from the top", initial_state=("3.14159265458979", 0), periods=3),
        Variant("many", "60 half swings: amplitudes fall as 1/n, not exponentially", periods=60),
    )
    invariants = decaying(energy=dragged_energy)
    scene = SCENE
    forms = (
        Hybrid(
            modes=(Mode("forward", dragged_swing, (1.0,)), Mode("backward", dragged_swing, (-1.0,))),
            start=swing_mode,
            transitions=(
                Transition("rest", "forward", swing_rate, -1, at_rest, "backward"),
                Transition("rest", "backward", swing_rate, 1, at_rest, "forward"),
            ),
        ),
    )

    @property
    def time_scale(self) -> float:
        """1/sqrt(w2), the time of a small swing; the time of a radian at the start if that is shorter."""
        return 1 / max(sqrt(float(self.w2)), abs(float(self.v)))

    def natural_span(self) -> Number:
        """Until the pendulum has come to rest `periods` times, ten by default, and 0.37 of a small half swing more."""
        half = pi / sqrt(float(self.w2))
        return float(self.exact_motion.turning_point(int(self.periods))[0]) + 0.37 * half

    def list_events(self, digits: int) -> tuple[Event, ...]:
        """The times at which the pendulum comes to rest: at most one in the time of a small half swing."""
        self.limit_events(float(self.span) * sqrt(float(self.w2)) / pi, MOST_RESTS)
        events: list[Event] = []
        while True:
            time, angle = self.exact_motion.turning_point(len(events) + 1, digits)
            if time > self.span:
                return tuple(events)
            events.append(Event(time, "rest", (angle, mpf(0)), (angle, mpf(0))))

    def same_course(self, other: Case) -> bool:
        theirs = DampedPendulum(*other.parameter_values(), *other.initial_state)
        return (theirs.forward, theirs.turns) == (self.exact_motion.forward, self.exact_motion.turns)

    def derived(self, digits: int) -> dict[str, Any]:
        """`turns`: passages over the top before it swings. The first two amplitudes: they differ by (4/3) c a^2 or so."""
        motion, (time, first) = self.exact_motion, self.exact_motion.turning_point(1, digits)
        second = motion.turning_point(2, digits)[1]
        return {"turns": motion.turns, "first_rest": first, "first_rest_time": time, "second_rest": second}

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        """Without drag."""
        return (self.level(PendulumSimple, "no drag: the pendulum", g=self.w2, L=1),)
