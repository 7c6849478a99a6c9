"""Rolling bodies: down an incline with or without slip, and the yo-yo.

Cases: rolling_bodies, yo_yo.
"""

from gnomon.cases.declare import *
from gnomon.reference.contact.block_incline_friction import holds
from gnomon.reference.contact.rolling_bodies import RollingBody
from gnomon.reference.flight.projectile_stokes_drag import StokesDrag
from gnomon.reference.numerics.precision import exact


def slipping_body(t: Any, state: Values, parameters: Values) -> Values:
    """Friction opposes the slip, whose sign is a constant of the mode."""
    g, alpha, mu, k, radius, side = parameters
    friction = side * mu * g * cos(alpha)
    return state[1], g * sin(alpha) - friction, friction / (k * radius)


def rolling_body(t: Any, state: Values, parameters: Values) -> Values:
    g, alpha, _mu, k, radius = parameters
    forward = g * sin(alpha) / (1 + k)
    return state[1], forward, forward / radius


def body_slip(t: Any, state: Values, parameters: Values) -> Values:
    return (state[1] - parameters[4] * state[2],)


def no_slip(t: Any, state: Values, parameters: Values) -> Values:
    return state[0], state[1], state[1] / parameters[4]


def mode_without_slip(t: Any, state: Values, parameters: Values) -> str:
    """The body rolls if tan(alpha) <= mu (1 + 1/k), decided exactly for the given numbers."""
    _g, alpha, mu, k, *_ = parameters
    return "roll" if holds(exact(alpha), exact(mu) * (1 + 1 / exact(k))) else "ahead"


def rolling_mode(t: Any, state: Values, parameters: Values) -> str:
    (slip,) = body_slip(t, state, parameters)
    return "ahead" if slip > 0 else "behind" if slip < 0 else mode_without_slip(t, state, parameters)


def body_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass."""
    g, alpha, _mu, k, radius = parameters
    turning = radius * state[2]
    return ((state[1] * state[1] + k * turning * turning) / 2 - g * sin(alpha) * state[0],)


def yo_yo_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    g, m, inertia, radius = parameters
    return (g / (1 + inertia / (m * radius * radius)),)


def yo_yo_potential(t: Any, q: Values, parameters: Values) -> Values:
    g, m, inertia, radius = parameters
    return (-g / (1 + inertia / (m * radius * radius)) * q[0],)


def yo_yo_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over m + I/r^2."""
    return (state[1] * state[1] / 2 + yo_yo_potential(t, state[:1], parameters)[0],)


def rolling_scene(state: Values, parameters: Values) -> Scene:
    """A ball with the body's moment on a horizontal plane with tilted gravity: it moves like the cylinder."""
    s, v, w = state
    g, alpha, mu, k, radius = parameters
    moment = k * radius * radius
    ball = Body(
        "body",
        1.0,
        (moment, moment, moment),
        (s, 0.0, radius),
        velocity=(v, 0.0, 0.0),
        angular_velocity=(0.0, w, 0.0),
        radius=radius,
    )
    plane = Contact("body", (0.0, 0.0, 1.0), friction=mu)
    return Scene((g * sin(alpha), 0.0, -g * cos(alpha)), (ball,), contacts=(plane,))


def rolling_reading(readings: Readings, parameters: Values) -> Values:
    position, _, velocity, spin = readings.bodies["body"]
    return position[0], velocity[0], spin[1]


def yo_yo_scene(state: Values, parameters: Values) -> Scene:
    """A vertical motion; a separate token states the string, which rotates the body as it falls."""
    g, m, inertia, _radius = parameters
    body = Body("yo-yo", m, (inertia, inertia, inertia))
    line = Slider("string", "yo-yo", (0.0, 0.0, 0.0), (0.0, 0.0, -1.0), *state)
    return Scene((0.0, 0.0, -g), (body,), sliders=(line,))


ROLLING_SCENE = SceneForm(rolling_scene, rolling_reading, frozenset({"coulomb_isotropic"}), conservative=False)
YO_YO_SCENE = SceneForm(yo_yo_scene, joint("string"), frozenset({"slider", "unwinding_string"}))


class RollingBodies(Case):
    name = "rolling_bodies"
    title = "Cylinder, sphere or hoop on an incline, with or without slip"
    section = "10.12, 10.19"
    conventions = "s down the slope; k = I/(m R^2): 1/2 cylinder, 2/5 sphere, 1 hoop; one friction coefficient."
    s = Coordinate("m", 0, typical(-5, 5))
    v = Coordinate("m/s", 2, typical(-5, 5))
    w = Coordinate("rad/s", 0, typical(-5, 5))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    alpha = Parameter("rad", "0.4", "angle of the incline", Range(0.0, pi / 2, typical=(0.0, 1.3)))
    mu = Parameter("1", "0.2", "coefficient of friction", nonnegative(0, 1))
    k = Parameter("1", "0.5", "moment of inertia over m R^2", positive(0.1, 1))
    R = Parameter("m", "0.1", "radius", positive(0.1, 2))
    exact_motion = bind(RollingBody)
    variants = (
        Variant("rolls", "rolls from rest", initial_state=(0, 0, 0)),
        Variant("slips", "too steep: slips from rest without end", {"alpha": 1}, (0, 0, 0)),
        Variant(
            "limit_above",
            "mu (1 + 1/k) is the double just above tan(alpha), times a power of two: rolls",
            {"alpha": 0.4, "k": 1, "mu": 0.42279321873816184 / 2},
            (0, 0, 0),
        ),
        Variant(
            "limit_below",
            "the double just below: slips, but by less than an ulp of the distance",
            {"alpha": 0.4, "k": 1, "mu": 0.4227932187381618 / 2},
            (0, 0, 0),
        ),
        Variant("bowled", "thrown horizontally without spin: slips, then rolls", {"alpha": 0, "k": "0.4"}, (0, 8, 0)),
        Variant("hoop", "a hoop thrown horizontally: keeps half of its speed", {"alpha": 0, "k": 1}, (0, 8, 0)),
        Variant(
            "cylinder",
            "a cylinder thrown horizontally: keeps two thirds of its speed",
            {"alpha": 0, "k": "0.5"},
            (0, 8, 0),
        ),
        Variant("back_spin", "moves up the slope with back spin, which friction reduces", {"k": "0.4"}, (0, -3, 60)),
        Variant(
            "too_steep",
            "back spin on a slope too steep for rolling: the slip changes its sign",
            {"alpha": 1},
            (0, 0, 40),
        ),
    )
    invariants = decaying(energy=body_energy)
    scene = ROLLING_SCENE
    forms = (
        Hybrid(
            modes=(
                Mode("ahead", slipping_body, (1.0,)),
                Mode("behind", slipping_body, (-1.0,)),
                Mode("roll", rolling_body),
            ),
            start=rolling_mode,
            transitions=(
                Transition("grips_ahead", "ahead", body_slip, -1, no_slip, "roll"),
                Transition("grips_behind", "behind", body_slip, 1, no_slip, mode_without_slip),
            ),
            terminal=frozenset({"roll"}),
        ),
    )

    @property
    def time_scale(self) -> float:
        """The duration of the slip, at least the time of a fall through the radius."""
        fall = sqrt(float(self.R / self.g))
        return max(fall, float(self.exact_motion.slip_time())) if self.exact_motion.slip_ends else fall

    def natural_span(self) -> Number:
        """2.3 times the duration of the slip; 10 time scales if it does not end."""
        return (2.3 if self.exact_motion.slip_ends else 10) * self.time_scale

    def list_events(self, digits: int) -> tuple[Event, ...]:
        motion = self.exact_motion
        if not motion.slip_ends or motion.slip_time(20) > self.span:
            return ()
        there = motion.slip_state(digits)
        return (Event(motion.slip_time(digits), "grips_ahead" if motion.slip > 0 else "grips_behind", there, there),)

    def same_course(self, other: Case) -> bool:
        theirs = RollingBody(*other.parameter_values(), *other.initial_state)
        mine = self.exact_motion
        return (mine.can_roll, mine.slip > 0, mine.slip < 0) == (theirs.can_roll, theirs.slip > 0, theirs.slip < 0)

    def derived(self, digits: int) -> dict[str, Any]:
        """`friction_to_roll`: the least coefficient with which the body rolls from rest, tan(alpha)/(1 + 1/k)."""
        motion = self.exact_motion
        return {
            "rolling_acceleration": motion.rolling_acceleration(digits) if motion.can_roll else None,
            "slip_time": motion.slip_time(digits) if motion.slip_ends else None,
            "rolling_speed": motion.slip_state(digits)[1] if motion.slip_ends else None,
            "friction_to_roll": lambda mp: mp.tan(mp.mpf(self.alpha)) * mp.mpf(self.k) / (1 + mp.mpf(self.k)),
        }


class YoYo(Case):
    name = "yo_yo"
    title = "Yo-yo unwinding from a vertical string"
    section = "10.12, 10.19"
    conventions = (
        "[inferred] y downward; a thin string unwinds without slip from an axle of radius r and stays vertical."
    )
    y = Coordinate("m", 0, typical(-5, 5))
    v = Coordinate("m/s", 0, typical(-5, 5))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    m = Parameter("kg", "0.05", "mass", positive())
    I = Parameter("kg m^2", "2e-5", "moment of inertia about the axle", positive())
    r = Parameter("m", "0.005", "radius of the axle", positive())
    exact_motion = bind(lambda c: StokesDrag(exact(0), (c.g / (1 + c.I / (c.m * c.r**2)),), (c.y,), (c.v,)))
    default_span = "1.5"
    variants = (
        Variant("rising", "thrown up along its string: returns", initial_state=(1, -1), span=4),
        Variant("thin", "I = 1e6 m r^2: descends slowly", {"I": "1.25"}, span=1000),
    )
    invariants = conserved(energy=yo_yo_energy)
    forms = (Separable(yo_yo_acceleration, yo_yo_potential),)
    scene = YO_YO_SCENE
    reversal = None
    time_scale = 1.0

    def derived(self, digits: int) -> dict[str, Any]:
        """`acceleration`: downward (m/s^2); `string_force`: m (g - acceleration) (N)."""
        (acceleration,) = self.exact_motion.acceleration
        return {"acceleration": acceleration, "string_force": self.m * (self.g - acceleration)}
