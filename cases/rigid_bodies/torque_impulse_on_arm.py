"""A torque impulse on an arm: its rate jumps, its angle does not."""

from gnomon.cases.core.scene import Impulse
from gnomon.cases.declare import *
from gnomon.reference.numerics.precision import publish, working
from gnomon.reference.pendulums.kicked_pendulum import KickedPendulum
from gnomon.reference.pendulums.pendulum_simple import Pendulum


def arm_swings(t: Any, state: Values, parameters: Values) -> Values:
    """theta'' = -(3 g/2 l) sin(theta), for a uniform rod hinged at its end."""
    theta, omega = state
    g, _m, length, _H, _blow = parameters
    return omega, -3 * g / (2 * length) * sin(theta)


def until_the_blow(t: Any, state: Values, parameters: Values) -> Values:
    return (t - parameters[4],)


def arm_is_struck(t: Any, state: Values, parameters: Values) -> Values:
    """I (omega' - omega) = H, I = m l^2/3."""
    theta, omega = state
    _g, m, length, H, _blow = parameters
    return theta, omega + 3 * H / (m * length * length)


def arm_mode(t: Any, state: Values, parameters: Values) -> str:
    return "before" if t < parameters[4] else "after"


ORIGIN = (0.0, 0.0, 0.0)


ACROSS = (0.0, -1.0, 0.0)
"""The hinge axis about which a positive angle turns a hanging body towards +x."""


def arm_scene(state: Values, parameters: Values) -> Scene:
    """A uniform rod; the blow is a couple about the hinge."""
    theta, omega = state
    g, m, length, H, blow = parameters
    moment = m * length * length / 12
    rod = Body("arm", m, (moment, moment, 0.0))
    hinge = Hinge("pivot", "arm", ORIGIN, ACROSS, (0.0, 0.0, -length / 2), theta, omega)
    return Scene((0.0, 0.0, -g), (rod,), hinges=(hinge,), impulses=(Impulse("arm", blow, angular=(0.0, -H, 0.0)),))


ARM = SceneForm(arm_scene, joint("pivot"), frozenset({"hinge", "impulse"}), conservative=False)


class TorqueImpulseOnArm(Case):
    name = "torque_impulse_on_arm"
    title = "Torque impulse on a swinging arm"
    section = "7.3"
    conventions = (
        "A uniform rod hinged at one end in a vertical plane, theta from the downward vertical; at t1 a torque impulse H "
        "acts about the hinge, positive towards growing theta."
    )
    theta = Coordinate("rad", "0.8", typical(-3, 3))
    omega = Coordinate("rad/s", 0, typical(-3, 3))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(1, 10))
    m = Parameter("kg", 3, "mass of the arm", positive(0.5, 3))
    l = Parameter("m", 1, "length of the arm", positive(0.5, 3))
    H = Parameter("N m s", 3, "torque impulse", typical(-5, 5))
    t1 = Parameter("s", "1.3", "time of the impulse", positive(0.1, 2))
    exact_motion = bind(
        lambda c: KickedPendulum(Pendulum(c.g, c.l * 2 / 3, *c.initial_state), c.t1, 3 * c.H / (c.m * c.l**2))
    )
    variants = (
        Variant("at_rest", "at rest until the impulse", {"H": 4}, (0, 0)),
        Variant("knocked_over", "swings before the impulse, turns over the top repeatedly after it", {"H": 12}),
        Variant(
            "to_the_top",
            "exactly the energy at the top: an error at the impulse decides on which side the arm ends",
            {"g": "9.8125", "m": 1, "l": "14.71875", "H": "144.427734375"},
            (0, 0),
        ),
        Variant(
            "stopped",
            "passes the bottom when the impulse takes all but 1e-9 of its rate: cancellation",
            {"g": 10, "m": 3, "l": "1.5", "H": "-4.4999999955", "t1": "2e-9"},
            (0, 2),
        ),
        Variant("huge", "the rate jumps by 1e6 rad/s", {"H": 10**6}, span="1.31"),
    )
    autonomous = False
    scene = ARM
    forms = (
        Hybrid(
            modes=(Mode("before", arm_swings), Mode("after", arm_swings)),
            start=arm_mode,
            transitions=(Transition("blow", "before", until_the_blow, 1, arm_is_struck, "after"),),
            terminal=frozenset({"after"}),
        ),
    )

    @property
    def time_scale(self) -> float:
        """sqrt(2 l/3 g), or the time of a radian at the largest rate after the impulse if that is shorter."""
        small = sqrt(float(self.exact_motion.before.length / self.exact_motion.before.g))
        fastest = float(self.exact_motion.after().top_speed())
        return min(small, 1 / fastest) if fastest else small

    def natural_span(self) -> Number:
        """2.37 periods after the impulse; 4 times sqrt(2 l/3 g) without a period."""
        after = self.exact_motion.after()
        small = sqrt(float(self.exact_motion.before.length / self.exact_motion.before.g))
        periodic = after.regime in (Pendulum.LIBRATION, Pendulum.ROTATION)
        return float(self.exact_motion.blow) + (2.37 * float(after.period()) if periodic else 4 * small)

    def list_events(self, digits: int) -> tuple[Event, ...]:
        motion = self.exact_motion
        if motion.blow > self.span:
            return ()
        with working(digits + 5) as mp:
            time = publish([mp.mpf(motion.blow)], digits)[0]
        theta, before, after = motion.at_the_blow(digits)
        return (Event(time, "blow", (theta, before), (theta, after)),)

    def derived(self, digits: int) -> dict[str, Any]:
        """`jump` of the rate, H/I (rad/s); `work` of the impulse, H times the mean of the rates before and after (J)."""
        motion, after = self.exact_motion, self.exact_motion.after(digits + 60)
        return {
            "jump": motion.jump,
            "work": self.H * (after.omega0 - motion.jump / 2),
            "amplitude_before": motion.before.amplitude(digits),
            "amplitude_after": after.amplitude(digits),
        }
