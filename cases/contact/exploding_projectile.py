"""A projectile that bursts in flight into two parts."""

from collections.abc import Callable

from gnomon.cases.contact.ball_line import published
from gnomon.cases.core.scene import Impulse
from gnomon.cases.declare import *
from gnomon.cases.scenes.two_masses import NO_INERTIA, times
from gnomon.reference.contact.exploding_projectile import Fragments


def fragments_fall(t: Any, state: Values, parameters: Values) -> Values:
    _, _, _, _, vx1, vy1, vx2, vy2 = state
    g = parameters[0]
    return vx1, vy1, vx2, vy2, 0, -g, 0, -g


def until_the_burst(t: Any, state: Values, parameters: Values) -> Values:
    return (t - parameters[3],)


def bursts(t: Any, state: Values, parameters: Values) -> Values:
    """Each part gets a share of the relative velocity, inversely proportional to its mass."""
    x1, y1, x2, y2, vx1, vy1, vx2, vy2 = state
    _g, m1, m2, _burst, wx, wy = parameters
    first, second = m2 / (m1 + m2), m1 / (m1 + m2)
    return x1, y1, x2, y2, vx1 - first * wx, vy1 - first * wy, vx2 + second * wx, vy2 + second * wy


def fragments_momentum_x(t: Any, state: Values, parameters: Values) -> Values:
    return (parameters[1] * state[4] + parameters[2] * state[6],)


def fragments_momentum_y(t: Any, state: Values, parameters: Values) -> Values:
    """P_y + (m1 + m2) g t."""
    g, m1, m2, *_ = parameters
    return (m1 * state[5] + m2 * state[7] + (m1 + m2) * g * t,)


def fragments_centre_x(t: Any, state: Values, parameters: Values) -> Values:
    """x_C - v_C t."""
    _g, m1, m2, *_ = parameters
    return ((m1 * (state[0] - state[4] * t) + m2 * (state[2] - state[6] * t)) / (m1 + m2),)


def fragments_centre_y(t: Any, state: Values, parameters: Values) -> Values:
    """y_C - v_C t - g t^2/2."""
    g, m1, m2, *_ = parameters
    return ((m1 * (state[1] - state[5] * t) + m2 * (state[3] - state[7] * t)) / (m1 + m2) - g * t * t / 2,)


def fragments_mode(t: Any, state: Values, parameters: Values) -> str:
    return "whole" if t < parameters[3] else "burst"


def _number(value: Fraction) -> Callable[[Any], Any]:
    return lambda mp: mp.mpf(value)


def fragments_scene(state: Values, parameters: Values) -> Scene:
    """The parts fly together until the burst: opposite impulses on both, the relative velocity times the reduced mass."""
    x1, y1, x2, y2, vx1, vy1, vx2, vy2 = state
    g, m1, m2, burst, wx, wy = parameters
    push = (m1 * m2 / (m1 + m2) * wx, 0.0, m1 * m2 / (m1 + m2) * wy)
    bodies = (
        Body("part 1", m1, NO_INERTIA, (x1, 0.0, y1), velocity=(vx1, 0.0, vy1)),
        Body("part 2", m2, NO_INERTIA, (x2, 0.0, y2), velocity=(vx2, 0.0, vy2)),
    )
    impulses = (Impulse("part 1", burst, times(-1.0, push)), Impulse("part 2", burst, push))
    return Scene((0.0, 0.0, -g), bodies, impulses=impulses)


def fragments_reading(readings: Readings, parameters: Values) -> Values:
    (r1, _, v1, _), (r2, _, v2, _) = (readings.bodies[f"part {n}"] for n in (1, 2))
    return r1[0], r1[2], r2[0], r2[2], v1[0], v1[2], v2[0], v2[2]


FRAGMENTS = SceneForm(fragments_scene, fragments_reading, frozenset({"impulse"}), conservative=False)


class ExplodingProjectile(Case):
    name = "exploding_projectile"
    title = "Projectile that bursts in flight: the centre of mass moves on unchanged"
    section = "8.2, 8.4"
    conventions = (
        "y upward; two parts fly together until the burst, at which their relative velocity jumps by (wx, wy)."
    )
    x1 = Coordinate("m", 0, typical(-3, 3))
    y1 = Coordinate("m", 0, typical(-3, 3))
    x2 = Coordinate("m", 0, typical(-3, 3))
    y2 = Coordinate("m", 0, typical(-3, 3))
    vx1 = Coordinate("m/s", 30, typical(-20, 20))
    vy1 = Coordinate("m/s", 20, typical(-20, 20))
    vx2 = Coordinate("m/s", 30, typical(-20, 20))
    vy2 = Coordinate("m/s", 20, typical(-20, 20))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", nonnegative())
    m1 = Parameter("kg", 2, "mass of part 1", positive(0.5, 5))
    m2 = Parameter("kg", 1, "mass of part 2", positive(0.5, 5))
    t_burst = Parameter("s", "1.3", "time of the burst", positive(0.1, 2))
    wx = Parameter("m/s", 6, "relative velocity that the burst adds, x", typical(-20, 20))
    wy = Parameter("m/s", 15, "relative velocity that the burst adds, y", typical(-20, 20))
    exact_motion = bind(Fragments, burst="t_burst", places="x1 y1 x2 y2", velocities="vx1 vy1 vx2 vy2")
    default_span = Span(2.87, "time scale")
    variants = (
        Variant("splinter", "m2 = 1e-9 kg at 1e5 m/s: part 1 hardly changes its velocity", {"m2": "1e-9", "wx": 10**5}),
        Variant("at_rest", "at rest without gravity: all motion is due to the burst", {"g": 0}, (0,) * 8, span=3),
    )
    autonomous = False
    invariants = conserved(
        momentum_x=fragments_momentum_x,
        momentum_y_and_weight=fragments_momentum_y,
        centre_of_mass_start_x=fragments_centre_x,
        centre_of_mass_start_y=fragments_centre_y,
    )
    scene = FRAGMENTS
    forms = (
        Hybrid(
            modes=(Mode("whole", fragments_fall), Mode("burst", fragments_fall)),
            start=fragments_mode,
            transitions=(Transition("burst", "whole", until_the_burst, 1, bursts, "burst"),),
            terminal=frozenset({"burst"}),
        ),
    )

    @property
    def time_scale(self) -> float:
        """The time until the burst."""
        return float(self.t_burst)

    def list_events(self, digits: int) -> tuple[Event, ...]:
        motion = self.exact_motion
        if motion.burst > self.span:
            return ()
        states = published(motion.before_the_burst(), digits), published(motion.at(motion.burst), digits)
        return (Event(published((motion.burst,), digits)[0], "burst", *states),)

    def derived(self, digits: int) -> dict[str, Any]:
        """`apex`: height of the centre of mass above its start, which the burst does not change (m)."""
        rise = max((self.m1 * self.vy1 + self.m2 * self.vy2) / (self.m1 + self.m2), Fraction(0))
        apex = rise**2 / (2 * self.g) if self.g else None
        return {"energy_released": self.exact_motion.energy_released, "apex": apex}
