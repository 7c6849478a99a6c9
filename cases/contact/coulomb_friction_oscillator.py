"""A mass on a spring with dry friction."""

from dataclasses import replace

from gnomon.cases.declare import *
from gnomon.cases.oscillators.harmonic_oscillator import HarmonicOscillator
from gnomon.cases.scenes.box import flat_box
from gnomon.reference.contact.coulomb_friction_oscillator import CoulombOscillator
from gnomon.reference.numerics.precision import exact
from mpmath import mpf


def sliding_on_a_spring(t: Any, state: Values, parameters: Values) -> Values:
    """v' = -(k/m) x - side mu_k g; `side`, the sign of v, is a constant of the mode."""
    x, v = state
    m, k, g, mu_k, _mu_s, side = parameters
    return v, -(k / m) * x - side * mu_k * g


def level_friction(t: Any, state: Values, parameters: Values) -> Values:
    _m, _k, g, mu_k, mu_s = parameters
    return mu_k * g, mu_s * g


def held_on_a_spring(t: Any, state: Values, parameters: Values) -> Values:
    return 0, 0


def spring_speed(t: Any, state: Values, parameters: Values) -> Values:
    _x, v = state
    return (v,)


def standing(t: Any, state: Values, parameters: Values) -> Values:
    x, _v = state
    return x, 0


def friction_energy(t: Any, state: Values, parameters: Values) -> Values:
    x, v = state
    m, k, _g, _mu_k, _mu_s = parameters
    return ((m * v * v + k * x * x) / 2,)


def mode_after_turn(t: Any, state: Values, parameters: Values) -> str:
    """The mass stays if |k x| <= mu_s m g, decided exactly for the given numbers; else the spring pulls it back."""
    x = exact(state[0])
    m, k, g, _mu_k, mu_s = map(exact, parameters[:5])
    if abs(k * x) <= mu_s * m * g:
        return "stick"
    return "left" if x > 0 else "right"


def oscillator_mode(t: Any, state: Values, parameters: Values) -> str:
    _x, v = state
    if v == 0:
        return mode_after_turn(t, state, parameters)
    return "right" if v > 0 else "left"


def level_gravity(parameters: tuple[float, ...]) -> Vector:
    return 0.0, 0.0, -parameters[2]


def spring_pull(t: float, x: float, parameters: tuple[float, ...]) -> Vector:
    return -parameters[1] * x, 0.0, 0.0


ONE_FRICTION, TWO_FRICTIONS = (
    flat_box(
        level_gravity, lambda parameters: parameters[3], *more, mass=lambda parameters: parameters[0], push=spring_pull
    )
    for more in ((), ("static_friction",))
)


SHOWN = 5
"""The number of half cycles whose energies `quantities` lists."""


class CoulombFrictionOscillator(Case):
    name = "coulomb_friction_oscillator"
    title = "Mass and spring with dry friction: half cycles until it stops"
    section = "5.11, 5.12.2, 6.7"
    conventions = "x from the position of the unstretched spring, horizontal; at v = 0 it stays if |k x| <= mu_s m g."
    x = Coordinate("m", "0.5", typical(-5, 5))
    v = Coordinate("m/s", 0, typical(-5, 5))
    m = Parameter("kg", 1, "mass", positive())
    k = Parameter("N/m", 20, "stiffness of the spring", positive(1, 20))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    mu_k = Parameter("1", "0.05", "coefficient of kinetic friction", nonnegative(0.01, 0.5))
    mu_s = Parameter("1", "0.07", "coefficient of static friction", nonnegative(0.01, 0.8))
    rules = (Rule("mu_k <= mu_s (friction does not grow when sliding begins)", lambda n: n["mu_k"] <= n["mu_s"]),)
    exact_motion = bind(CoulombOscillator, mass="m", stiffness="k")
    variants = (
        Variant(
            "at_the_limit",
            "stops exactly at the limit of sticking, after three half cycles",
            {"k": 4, "g": 10, "mu_k": "0.25", "mu_s": "0.5"},
            (5, 0),
        ),
        Variant("many", "10,000 half cycles before it stops", {"mu_k": "1.0194e-4", "mu_s": "1.1e-4"}, (1, 0)),
        Variant("weak", "mu = 1e-10: nearly harmonic", {"mu_k": "1e-10", "mu_s": "1e-10"}, span="14.57"),
        Variant("frictionless", "mu = 0: half cycles without loss", {"mu_k": 0, "mu_s": 0}, span="14.57"),
        Variant("held", "starts at rest where friction holds it: must not creep", initial_state=("0.03", 0), span=10),
        Variant("thrown", "starts with speed: the first arc is not a half cycle", initial_state=("0.1", 2)),
    )
    invariants = decaying(energy=friction_energy)
    forms = (
        Friction(
            modes=(
                Mode("right", sliding_on_a_spring, (1.0,)),
                Mode("left", sliding_on_a_spring, (-1.0,)),
                Mode("stick", held_on_a_spring),
            ),
            start=oscillator_mode,
            transitions=(
                Transition("turn_right", "right", spring_speed, -1, standing, mode_after_turn),
                Transition("turn_left", "left", spring_speed, 1, standing, mode_after_turn),
            ),
            terminal=frozenset({"stick"}),
            sliding=sliding_on_a_spring,
            bounds=level_friction,
        ),
    )

    @property
    def scene(self) -> SceneForm:
        """It needs a separate static coefficient only if that decides where the mass stays."""
        motion = self.exact_motion
        slippery = replace(motion, mu_s=motion.mu_k)
        alike = (motion.side, motion.turns) == (slippery.side, slippery.turns)
        return ONE_FRICTION if alike else TWO_FRICTIONS

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        return (self.level(HarmonicOscillator, "no friction: harmonic"),)

    @property
    def time_scale(self) -> float:
        """sqrt(m/k)."""
        return sqrt(float(self.m / self.k))

    def natural_span(self) -> Number:
        """1.13 times the time until it stays; 10.37 periods if that is late or never."""
        turns = self.exact_motion.turns
        periods = 10.37 * 2 * pi * self.time_scale
        if not turns or (turns > 100 and self.variant != "many"):
            return periods
        return 1.13 * float(self.exact_motion.turn_time(turns))

    def list_events(self, digits: int) -> tuple[Event, ...]:
        """`turn_right` ends a motion to the right, `turn_left` one to the left; after the last one the mass stays."""
        motion, events, turn = self.exact_motion, list[Event](), 1
        while motion.turns is None or turn <= motion.turns:
            time = motion.turn_time(turn, digits)
            if time > self.span:
                break
            there = (motion.turn_position(turn, digits), mpf(0))
            rightward = motion.side * (-1) ** (turn - 1) > 0
            events.append(Event(time, "turn_right" if rightward else "turn_left", there, there))
            turn += 1
        return tuple(events)

    def same_course(self, other: Case) -> bool:
        theirs = CoulombOscillator(*other.parameter_values(), *other.initial_state)
        return (theirs.side, theirs.turns) == (self.exact_motion.side, self.exact_motion.turns)

    def scales(self) -> dict[str, float]:
        """In closed form: x is largest at the start or the first turn, v at the start or the first passage of a centre."""
        motion = self.exact_motion
        first = abs(float(motion.turn_position(1))) if motion.side else 0.0
        return {
            "length": max(abs(float(self.x)), first) or 1.0,
            "velocity": float(motion.fastest()) or 1.0,
        }

    def derived(self, digits: int) -> dict[str, Any]:
        """`half_cycles`: how often the mass comes to rest; infinite if it never stays.

        `energy_1`, `energy_2` ...: the spring's energy after each of the first half cycles (J).
        """
        motion, turns = self.exact_motion, self.exact_motion.turns
        quantities = {"period": motion.period(digits), "half_cycles": mpf("inf") if turns is None else turns}
        if turns:
            quantities |= {
                "stop_time": motion.turn_time(turns, digits),
                "stop_position": motion.turn_position(turns, digits),
                "dissipated": motion.dissipated(digits),
            }
        steps = 0 if motion.side == 0 else SHOWN if turns is None else min(turns, SHOWN)
        return quantities | {f"energy_{n}": motion.energy_after(n, digits) for n in range(1, steps + 1)}
