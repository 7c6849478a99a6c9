"""The billiard ball: oblique sliding with spin, then rolling."""

import numpy as np
from gnomon.cases.declare import *
from gnomon.cases.flight.projectile_parabola import ProjectileParabola
from gnomon.cases.scenes.billiard_ball import SCENE
from gnomon.reference.contact.billiard_ball import BilliardBall


def slip_velocity(state: Values, radius: Any) -> Values:
    """Velocity of the lowest point."""
    return state[2] - radius * state[5], state[3] + radius * state[4]


def ball_sliding(t: Any, state: Values, parameters: Values) -> Values:
    """v' = -mu g s/|s| with the slip s, as -mu g c/|c| with c = s/(s.a), where a = (ax, ay) is the axis nearest to s.

    c keeps its direction when s passes zero. So the force keeps its direction too if a trial step of an integrator passes
    the end of sliding.
    """
    radius, mu, g, ax, ay = parameters
    sx, sy = slip_velocity(state, radius)
    along = sx * ax + sy * ay
    cx, cy = sx / along, sy / along
    push = mu * g / sqrt(cx * cx + cy * cy)
    dx, dy = -push * cx, -push * cy
    return state[2], state[3], dx, dy, 5 * dy / (2 * radius), -5 * dx / (2 * radius), 0 * push


def ball_rolling(t: Any, state: Values, parameters: Values) -> Values:
    return state[2], state[3], 0, 0, 0, 0, 0


def slip_east(t: Any, state: Values, parameters: Values) -> Values:
    return (state[2] - parameters[0] * state[5],)


def slip_north(t: Any, state: Values, parameters: Values) -> Values:
    return (state[3] + parameters[0] * state[4],)


def start_rolling(t: Any, state: Values, parameters: Values) -> Values:
    """The state when the slip ends: rolling with the angular momentum about the point of contact, which friction keeps.

    At the end the direction of the slip is round-off, and the last stage of a step there has a force in any direction.
    That force leaves a slip and changes nothing else, so the new state is computed from the angular momentum only.
    """
    radius = parameters[0]
    vx, vy = (5 * state[2] + 2 * radius * state[5]) / 7, (5 * state[3] - 2 * radius * state[4]) / 7
    return (*state[:2], vx, vy, -vy / radius, vx / radius, *state[6:])


def slip_mode(t: Any, state: Values, parameters: Values) -> str:
    sx, sy = slip_velocity(state, parameters[0])
    if sx == 0 and sy == 0:
        return "roll"
    if abs(sx) >= abs(sy):
        return "slide_east" if sx > 0 else "slide_west"
    return "slide_north" if sy > 0 else "slide_south"


def until_it_rolls(sliding: Equations, rolling: Equations, start: Equations) -> Hybrid:
    """Sliding in four modes, by the axis nearest to the slip, then rolling."""
    axes = {"east": (1.0, 0.0), "west": (-1.0, 0.0), "north": (0.0, 1.0), "south": (0.0, -1.0)}
    guards = {"east": (slip_east, -1), "west": (slip_east, 1), "north": (slip_north, -1), "south": (slip_north, 1)}
    return Hybrid(
        modes=(*(Mode(f"slide_{way}", sliding, axis) for way, axis in axes.items()), Mode("roll", rolling)),
        start=slip_mode,
        transitions=tuple(
            Transition(f"rolls_{way}", f"slide_{way}", guard, direction, start, "roll")
            for way, (guard, direction) in guards.items()
        ),
        terminal=frozenset({"roll"}),
    )


def ball_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass."""
    _x, _y, vx, vy, wx, wy, wz = state
    radius = parameters[0]
    return ((vx * vx + vy * vy) / 2 + radius * radius * (wx * wx + wy * wy + wz * wz) / 5,)


class BilliardBallCase(Case):
    name = "billiard_ball"
    title = "Billiard ball: oblique sliding with spin, then rolling"
    section = "10.15"
    conventions = (
        "z up; a solid sphere, I = (2/5) m R^2; w in space; no friction against the spin wz, no rolling friction."
    )
    x = Coordinate("m", 0, typical(-3, 3))
    y = Coordinate("m", 0, typical(-3, 3))
    vx = Coordinate("m/s", 2, typical(-3, 3))
    vy = Coordinate("m/s", "0.5", typical(-3, 3))
    wx = Coordinate("rad/s", 20, typical(-30, 30))
    wy = Coordinate("rad/s", -30, typical(-30, 30))
    wz = Coordinate("rad/s", 10, typical(-30, 30))
    R = Parameter("m", "0.03", "radius", positive(0.02, 0.5))
    mu = Parameter("1", "0.2", "coefficient of friction", nonnegative(0, 1))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(1, 15))
    exact_motion = bind(BilliardBall)
    variants = (
        Variant("draw", "back spin: stops, then rolls back", initial_state=(0, 0, 1, 0, 0, -150, 0)),
        Variant("masse", "side spin bends the path", initial_state=(0, 0, 1, 0, -100, 40, 50)),
        Variant("dead_stop", "spin and speed balance: ends exactly at rest", {"R": "0.03125"}, (0, 0, 1, 0, 0, -80, 0)),
        Variant(
            "almost_rolling",
            "a slip of 1e-12 m/s: round-off soon dominates its direction",
            initial_state=(0, 0, 3, "1e-12", 0, 100, 0),
            span=2,
        ),
        Variant("rolls", "rolls from the start", {"R": "0.03125"}, (0, 0, 1, 0, 0, 32, 5)),
        Variant("smooth", "mu = 0: nothing changes", {"mu": 0}),
        Variant(
            "engines",
            "the parameters of engine tests: 3 m/s without spin, 2 s",
            {"R": "0.1"},
            (0, 0, 3, 0, 0, 0, 0),
            2,
        ),
    )
    invariants = decaying(energy=ball_energy)
    forms = (until_it_rolls(ball_sliding, ball_rolling, start_rolling),)
    scene = SCENE

    @property
    def _ends(self) -> bool:
        """Whether the ball slides at first and rolls later."""
        return self.exact_motion.slides and self.exact_motion.will_roll

    @property
    def time_scale(self) -> float:
        """The duration of sliding, at least the time of a fall through the radius."""
        fall = sqrt(float(self.R / self.g))
        return max(fall, float(self.exact_motion.rolling_time())) if self._ends else fall

    def natural_span(self) -> Number:
        """2.3 times the duration of sliding; 20 time scales without sliding."""
        return (2.3 if self._ends else 20) * self.time_scale

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        """The deceleration against the initial slip never ends: a throw, with axes across and along this slip."""
        sx, sy = map(float, self.exact_motion.slip)
        size = hypot(sx, sy)
        if not size:
            return ()
        along, radius = (sx / size, sy / size), float(self.R)
        start = np.array([float(x) for x in self.initial_state])
        turn = np.array([[-along[1], along[0]], along])
        thrown = ProjectileParabola(
            initial_state=[*(turn @ start[:2]).tolist(), *(turn @ start[2:4]).tolist()],
            span=self.span,
            g=self.mu * self.g,
        )

        def add_spin(states: Floats) -> Floats:
            """States (n, 7) of the ball from states (n, 4) of the throw: friction changes spin and velocity together."""
            position, velocity = states[:, :2] @ turn, states[:, 2:] @ turn
            change = 5 / (2 * radius) * (velocity - start[2:4])
            spin = np.stack([start[4] + change[:, 1], start[5] - change[:, 0], 0 * change[:, 0] + start[6]], axis=1)
            return np.concatenate([position, velocity, spin], axis=1)

        return (Level(thrown, add_spin, "sliding only, in the initial direction of the slip"),)

    def list_events(self, digits: int) -> tuple[Event, ...]:
        """The end of sliding."""
        if not self._ends or self.exact_motion.rolling_time(20) > self.span:
            return ()
        there = self.exact_motion.rolling_state(digits)
        mode = slip_mode(0, self.initial_state, self.parameter_values())
        return (Event(self.exact_motion.rolling_time(digits), mode.replace("slide", "rolls"), there, there),)

    def same_course(self, other: Case) -> bool:
        mine, theirs = (slip_mode(0, case.initial_state, case.parameter_values()) for case in (self, other))
        return mine == theirs

    @property
    def quantity_names(self) -> tuple[str, ...]:
        """`energy_loss`: per unit mass (J/kg)."""
        return ("rolling_time", "rolling_vx rolling_vy=rolling_velocity", "energy_loss") if self._ends else ()
