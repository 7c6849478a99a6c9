"""A ballistic pendulum: the bullet's speed follows from the height of the swing."""

from collections.abc import Callable

from gnomon.cases.declare import *
from gnomon.cases.scenes.two_masses import NO_INERTIA
from gnomon.reference.contact.ballistic_pendulum import BallisticPendulum
from gnomon.reference.numerics.precision import publish, working
from gnomon.reference.pendulums.pendulum_simple import Pendulum
from mpmath import mpf


def bullet_flies(t: Any, state: Values, parameters: Values) -> Values:
    _, _, u, omega = state
    g, length, _m, _M = parameters
    return u, omega, 0, -g / length * sin(state[1])


def bullet_distance(t: Any, state: Values, parameters: Values) -> Values:
    return (state[0],)


def bullet_sticks(t: Any, state: Values, parameters: Values) -> Values:
    """The angular momentum about the pivot is constant; the bullet stays in the block."""
    _, theta, u, omega = state
    _g, length, m, M = parameters
    return 0, theta, 0, omega + m * (u / length - omega) / (m + M)


def at_the_block(t: Any, state: Values, parameters: Values) -> Values:
    _, theta, u, omega = state
    return 0, theta, u, omega


def bullet_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy, zero at the lowest position. After the impact x carries no energy."""
    _, theta, u, omega = state
    g, length, m, M = parameters
    half, speed = sin(theta / 2), length * omega
    return ((m * u * u + (m + M) * speed * speed) / 2 + 2 * (m + M) * g * length * half * half,)


def bullet_mode(t: Any, state: Values, parameters: Values) -> str:
    return "flight" if state[0] < 0 else "swing"


def _number(value: Fraction) -> Callable[[Any], Any]:
    return lambda mp: mp.mpf(value)


ORIGIN = (0.0, 0.0, 0.0)


ACROSS = (0.0, -1.0, 0.0)
"""The hinge axis about which a positive angle turns a hanging body towards +x."""


def ballistic_scene(state: Values, parameters: Values) -> Scene:
    """The bullet moves on a rail without weight until it sticks to the block (token `adhesion`)."""
    x, theta, u, omega = state
    g, length, m, M = parameters
    bodies = (Body("bullet", m, NO_INERTIA), Body("block", M, NO_INERTIA))
    pivot = Hinge("pivot", "block", ORIGIN, ACROSS, (0.0, 0.0, -length), theta, omega)
    barrel = Slider("barrel", "bullet", (0.0, 0.0, -length), (1.0, 0.0, 0.0), x, u)
    contact = Contact("bullet", (1.0, 0.0, 0.0), partner="block")
    return Scene((0.0, 0.0, -g), bodies, hinges=(pivot,), sliders=(barrel,), contacts=(contact,))


def ballistic_reading(readings: Readings, parameters: Values) -> Values:
    (x, u), (theta, omega) = readings.joints["barrel"], readings.joints["pivot"]
    return x, theta, u, omega


BALLISTIC = SceneForm(
    ballistic_scene, ballistic_reading, frozenset({"hinge", "slider", "body_contact", "adhesion"}), conservative=False
)


class BallisticPendulumCase(Case):
    name = "ballistic_pendulum"
    title = "Ballistic pendulum: an impulsive impact, then the exact swing"
    section = "7.2, 7.3"
    conventions = (
        "-x is the bullet's distance from the block, which hangs at rest; x is 0 after the impact; theta from the downward "
        "vertical. The block is a point on a massless rod of length L; the bullet's weight counts after the impact."
    )
    x = Coordinate("m", -10, Range(high=0.0, high_open=True, typical=(-20.0, -1.0)))
    theta = Coordinate("rad", 0, Range(low=0.0, high=0.0, typical=(0.0, 0.0)))
    u = Coordinate("m/s", 400, positive(50, 300))
    omega = Coordinate("rad/s", 0, Range(low=0.0, high=0.0, typical=(0.0, 0.0)))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(1, 10))
    L = Parameter("m", 2, "length of the rod", positive(0.5, 3))
    m = Parameter("kg", "0.01", "mass of the bullet", positive(0.01, 0.1))
    M = Parameter("kg", "1.99", "mass of the block", positive(0.5, 3))
    exact_motion = bind(BallisticPendulum, length="L")
    quantity_names = ("rate", "rise", "energy_lost", "swing_angle=swing.amplitude")
    """`rise`: the height that the block reaches (m); the bullet's speed is (m + M)/m sqrt(2 g rise)."""
    variants = (
        Variant(
            "slow", "a slow bullet as heavy as the block: half of the energy remains", {"m": 1, "M": 1}, (-3, 0, 4, 0)
        ),
        Variant("over", "fast enough to turn over the top", {}, (-10, 0, 2000, 0)),
        Variant(
            "to_the_top",
            "exactly the energy at the top, omega^2 = 4 g/L: an error at the impact decides on which side it ends",
            {"g": "9.8125", "L": "9.8125", "m": 1, "M": 1},
            (-2, 0, "39.25", 0),
        ),
        Variant("light_bullet", "m/M = 1e-9 at 1e6 m/s: swings by 0.2 mrad", {"m": "2e-9"}, (-(10**5), 0, 10**6, 0)),
    )
    invariants = decaying(energy=bullet_energy)
    scene = BALLISTIC
    forms = (
        Hybrid(
            modes=(Mode("flight", bullet_flies), Mode("swing", bullet_flies)),
            start=bullet_mode,
            transitions=(Transition("impact", "flight", bullet_distance, 1, bullet_sticks, "swing", at_the_block),),
            terminal=frozenset({"swing"}),
        ),
    )

    @property
    def time_scale(self) -> float:
        """sqrt(L/g), the time of the flight, or of a radian of the swing, whichever is shortest."""
        length, g = float(self.L), float(self.g)
        return min(sqrt(length / g), float(self.exact_motion.impact_time), 1 / float(self.exact_motion.rate))

    def natural_span(self) -> Number:
        """2.37 periods after the impact; 4 sqrt(L/g) without a period."""
        swing = self.exact_motion.swing
        small = sqrt(float(self.L / self.g))
        after = 4 * small if swing.regime == Pendulum.SEPARATRIX else 2.37 * float(swing.period())
        return float(self.exact_motion.impact_time) + after

    def list_events(self, digits: int) -> tuple[Event, ...]:
        motion = self.exact_motion
        if motion.impact_time > self.span:
            return ()
        with working(digits + 5) as mp:
            time, u, omega = publish(map(mp.mpf, (motion.impact_time, motion.u, motion.rate)), digits)
        zero = mpf(0)
        return (Event(time, "impact", (zero, zero, u, zero), (zero, zero, zero, omega)),)
