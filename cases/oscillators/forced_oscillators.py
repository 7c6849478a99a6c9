"""Linear motion under loads that depend on time: forced vibration, the general equation, a force on a free mass.

Cases: forced_oscillator, second_order_linear_ode, time_varying_force.
"""

from gnomon.cases.declare import *
from gnomon.cases.scenes.point import railed_point
from gnomon.reference.oscillators.forced_oscillators import ForcedLinear, SwitchedOff

ZERO = Fraction(0)


def forced_equations(t: Any, state: Values, parameters: Values) -> Values:
    """x' = v, v' = -(c/m) v - (k/m) x + (F0/m) cos(w t)."""
    x, v = state
    m, c, k, f0, w = parameters
    return v, -(c / m) * v - (k / m) * x + f0 / m * cos(w * t)


def forced_matrix(parameters: Values) -> Values:
    m, c, k, _f0, _w = parameters
    return 0, 1, -k / m, -c / m


def harmonic_force(t: Any, state: Values, parameters: Values) -> Values:
    m, _c, _k, f0, w = parameters
    return 0, f0 / m * cos(w * t)


def linear_times(damping: float, stiffness: float) -> tuple[float, float]:
    """The characteristic and the shortest time of x'' + 2b x' + c x = 0 (s); infinite if b = c = 0."""
    square = damping**2 - stiffness
    if square <= 0:
        natural = 1 / sqrt(stiffness) if stiffness else inf
        return natural, min(natural, 1 / abs(damping) if damping else inf)
    fast = abs(damping) + sqrt(square)
    slow = abs(stiffness) / fast
    return 1 / slow if slow and damping > 0 and stiffness > 0 else 1 / fast, 1 / fast


FORCED_SCENE = railed_point(forced_equations, "time_force")


class ForcedOscillator(Case):
    """A mass on a spring with a damper under a harmonic force."""

    name = "forced_oscillator"
    title = "Harmonically forced oscillator: resonance, beats, damped steady state"
    section = "6.6, 6.12"
    conventions = (
        "x from the equilibrium; force F0 cos(w t). Unbalance: F0 = m_e e w^2. For a base that moves by Y cos(w t), x is "
        "relative to it and F0 = m Y w^2."
    )
    x = Coordinate("m", "0.5")
    v = Coordinate("m/s", 0)
    m = Parameter("kg", 1, "mass", positive())
    c = Parameter("N s/m", "0.4", "damping constant", nonnegative(0, 5))
    k = Parameter("N/m", 20, "stiffness of the spring", positive())
    F0 = Parameter("N", 2, "amplitude of the force")
    w = Parameter("rad/s", 3, "frequency of the force", nonnegative(0.1, 10))
    exact_motion = bind(
        lambda c: ForcedLinear(c.c / (2 * c.m), c.k / c.m, ZERO, c.F0 / c.m, ZERO, c.w, ZERO, *c.initial_state)
    )
    autonomous = False
    variants = (
        Variant("resonance", "undamped, w = w0 exactly: the amplitude grows with t", {"c": 0, "k": 9}),
        Variant(
            "near_resonance",
            "w - w0 = 1e-10: a beat of 2000 years, the textbook formula divides by nearly zero",
            {"c": 0, "k": 9, "w": "3.0000000001"},
        ),
        Variant("beats", "w differs from w0 by 1 %: one whole beat", {"c": 0, "k": 9, "w": "3.03"}, (0, 0), "231.7"),
        Variant("long_1e5", "100,000 periods of weakly damped vibration", {"c": "1e-5"}, span="209440.3"),
        Variant("stiff", "rates 1e-3 and 1e6 beside w = 3", {"c": 10**6, "k": 10**3}),
        Variant("critical", "critically damped, exactly", {"c": 4, "k": 4}),
        Variant("engines", "the parameters of engine tests, 10 s", span=10),
        Variant(
            "speed",
            "the parameters of the speed tables: x'' + 0.04 x' + x = 0.5 cos(1.3 t)",
            {"c": "0.04", "k": 1, "F0": "0.5", "w": "1.3"},
            (1, 0),
            200,
        ),
    )
    forms = (SemiLinear(forced_equations, linear=forced_matrix, rest=harmonic_force),)
    scene = FORCED_SCENE
    mirror = ("x", "v", "F0")

    @property
    def _times(self) -> tuple[float, float]:
        m, c, k, _f0, w = map(float, self.parameter_values())
        slow, fast = linear_times(c / (2 * m), k / m)
        driven = 1 / w if w else inf
        return min(slow, driven), min(fast, driven)

    @property
    def time_scale(self) -> float:
        """One radian of the force or of the free vibration, whichever is shorter."""
        return self._times[0]

    @property
    def fastest_time(self) -> float:
        return self._times[1]

    def natural_span(self) -> Number:
        """10.37 periods of the force, or of the free vibration without a force."""
        w = float(self.w)
        return 10.37 * 2 * pi * (1 / w if w else self.time_scale)

    @property
    def quantity_names(self) -> tuple[str, ...]:
        """`transmissibility`: transmitted force over F0; with a moving base, motion over the motion of the base.

        `unbalance_ratio`: m X/(m_e e); with a moving base, relative motion over the motion of the base.
        """
        if self.c == 0 and self.exact_motion.stiffness == self.w**2:
            return ("natural_frequency=natural_rate",)
        steady = ("steady_amplitude", "magnification", "phase_lag", "transmissibility", "unbalance_ratio")
        return ("natural_frequency=natural_rate", *steady)


def second_order_linear(t: Any, state: Values, parameters: Values) -> Values:
    """x'' + 2b x' + c x = h0 + h1 e^(rt) cos(pt)."""
    x, v = state
    b, c, h0, h1, r, p = parameters
    return v, h0 + h1 * exp(r * t) * cos(p * t) - 2 * b * v - c * x


def second_order_matrix(parameters: Values) -> Values:
    b, c, _h0, _h1, _r, _p = parameters
    return 0, 1, -c, -2 * b


def second_order_load(t: Any, state: Values, parameters: Values) -> Values:
    _b, _c, h0, h1, r, p = parameters
    return 0, h0 + h1 * exp(r * t) * cos(p * t)


LINEAR_SCENE = railed_point(second_order_linear, "time_force")


class SecondOrderLinearOde(Case):
    name = "second_order_linear_ode"
    title = "The linear equation of second order with constant coefficients"
    section = "6.6"
    conventions = "x'' + 2b x' + c x = h0 + h1 e^(rt) cos(pt): a constant load plus a harmonic and exponential one."
    x = Coordinate("m", 1)
    v = Coordinate("m/s", 0)
    b = Parameter("1/s", "0.3", "half the damping; negative: growth", typical(-0.2, 3))
    c = Parameter("1/s^2", 4, "stiffness over mass; negative: repulsion", typical(-2, 10))
    h0 = Parameter("m/s^2", "0.5", "constant load over mass")
    h1 = Parameter("m/s^2", 1, "amplitude of the load over mass")
    r = Parameter("1/s", "-0.1", "rate of growth of the load", typical(-2, 0.1))
    p = Parameter("rad/s", 3, "frequency of the load", typical(-5, 5))
    exact_motion = bind(lambda c: ForcedLinear(c.b, c.c, c.h0, c.h1, ZERO, c.p, c.r, *c.initial_state))
    autonomous = False
    variants = (
        Variant("overdamped", "two real rates, 1 and 3", {"b": 2, "c": 3, "r": 0}),
        Variant("critical", "one double rate", {"b": 2, "c": 4, "r": 0}),
        Variant("repulsive", "c < 0: cosh and sinh", {"b": 0, "c": -1, "r": 0, "h1": 0}, (1, "-0.5"), 10),
        Variant(
            "exponential_resonance",
            "the load decays at a rate of the free motion: t e^(-t)",
            {"b": 2, "c": 3, "r": -1, "p": 0},
        ),
        Variant(
            "double_resonance",
            "the load decays at the double rate: t^2 e^(-2t)",
            {"b": 2, "c": 4, "r": -2, "p": 0, "h0": 0},
        ),
        Variant("harmonic_resonance", "undamped, p^2 = c: t sin(2t)", {"b": 0, "r": 0, "p": 2}),
        Variant(
            "damped_resonance",
            "the load is a free vibration of the system: t e^(-t) sin(2t)",
            {"b": 1, "c": 5, "r": -1, "p": 2},
        ),
    )
    forms = (SemiLinear(second_order_linear, linear=second_order_matrix, rest=second_order_load),)
    scene = LINEAR_SCENE

    @property
    def time_scale(self) -> float:
        """The shortest time of the free motion and of the load."""
        b, c, _h0, h1, r, p = map(float, self.parameter_values())
        loads = [1 / abs(rate) for rate in (r, p) if rate and h1]
        shortest = min(linear_times(b, c)[1], *loads, inf)
        return shortest if shortest < inf else 1.0

    def natural_span(self) -> Number:
        """20.7 characteristic times; 5 if the motion or the load grows, so that it grows at most e^5 times."""
        return (5 if float(self.b) < 0 or float(self.c) < 0 or float(self.r) > 0 else 20.7) * self.time_scale


def driven_mass(t: Any, state: Values, parameters: Values) -> Values:
    """m x'' = e^(-d t) (S sin(w t) + C cos(w t))."""
    _x, v = state
    m, s, c, w, d, _off = parameters
    return v, exp(-d * t) * (s * sin(w * t) + c * cos(w * t)) / m


def coasting_mass(t: Any, state: Values, parameters: Values) -> Values:
    _x, v = state
    return v, 0


def switch_time(t: Any, state: Values, parameters: Values) -> Values:
    off = parameters[5]
    return (t - off,)


def as_before(t: Any, state: Values, parameters: Values) -> Values:
    return state


def switch_mode(t: Any, state: Values, parameters: Values) -> str:
    off = parameters[5]
    return "driven" if t < off else "coasting"


def force_until_off(t: float, state: Values, parameters: Values) -> Values:
    """The force in both modes, for a scene."""
    if t < parameters[5]:
        return driven_mass(t, state, parameters)
    return coasting_mass(t, state, parameters)


SWITCHED_SCENE = railed_point(force_until_off, token="time_force")


class TimeVaryingForce(Case):
    name = "time_varying_force"
    title = "A mass under a force that depends on time, switched off at a given time"
    section = "6.4.1"
    conventions = "m x'' = e^(-dt) (S sin wt + C cos wt) until the time `off`, an event; then uniform motion."
    x = Coordinate("m", 0)
    v = Coordinate("m/s", 0)
    m = Parameter("kg", 1, "mass", positive())
    S = Parameter("N", 2, "amplitude of the sine")
    C = Parameter("N", 0, "amplitude of the cosine; for w = 0 of the exponential")
    w = Parameter("rad/s", 3, "frequency", typical(-10, 10))
    d = Parameter("1/s", 0, "rate of decay of the force", typical(0, 2))
    off = Parameter("s", "17.3", "time at which the force ends", positive(0.5, 20))
    exact_motion = bind(
        lambda c: SwitchedOff(ForcedLinear(ZERO, ZERO, ZERO, c.C / c.m, c.S / c.m, c.w, -c.d, *c.initial_state), c.off)
    )
    autonomous = False
    variants = (
        Variant(
            "drift",
            "w = 1e6: a step that suits the slow drift F0/(m w) spans 1e5 cycles of the force",
            {"w": 10**6, "off": 10},
            span="0.6283",
        ),
        Variant(
            "exponential", "F0 e^(-t/T): a pulse without end", {"S": 0, "C": 2, "w": 0, "d": 2, "off": 100}, span=10
        ),
        Variant(
            "short_pulse",
            "a half sine of 1e-6 s in a span of 10 s: easily stepped over",
            {"S": 10**6, "w": "3141592.6", "off": "1e-6"},
            (0, 0),
            10,
        ),
        Variant("never_off", "no event within the span: the velocity's mean is not zero", {"off": 100}, span="21.7"),
    )
    scene = SWITCHED_SCENE

    @property
    def forms(self) -> tuple[Form, ...]:
        """Without modes if the force lasts beyond the span."""
        if self.off > self.span:
            return (FirstOrder(driven_mass),)
        return (
            Hybrid(
                modes=(Mode("driven", driven_mass), Mode("coasting", coasting_mass)),
                start=switch_mode,
                transitions=(Transition("off", "driven", switch_time, 1, as_before, "coasting"),),
                terminal=frozenset({"coasting"}),
            ),
        )

    @property
    def time_scale(self) -> float:
        """One radian of the force, its decay time or its duration, whichever is shortest."""
        w, d, off = (abs(float(self.parameters[name])) for name in ("w", "d", "off"))
        return min([1 / rate for rate in (w, d) if rate] + [off])

    def natural_span(self) -> Number:
        """1.25 times the duration of the force."""
        return 1.25 * float(self.off)

    def list_events(self, digits: int) -> tuple[Event, ...]:
        off = self.off
        if off > self.span:
            return ()
        there = self.exact(off, digits)
        return (Event(self.exact_motion.off_time(digits), "off", there, there),)

    def derived(self, digits: int) -> dict[str, Any]:
        """`impulse` of the force until it ends (N s). `drift`: the mean velocity v0 + S/(m w) under a steady oscillation."""
        return {
            "final_velocity": self.exact(self.off, digits)[1],
            "impulse": self.exact_motion.impulse(self.m, digits),
            "drift": None if self.d or not self.w else self.v + self.S / (self.m * self.w),
        }
