"""A forced oscillator that strikes a rigid stop: periodic, grazing or chaotic."""

from gnomon.cases.core.impacts import ImpactCase
from gnomon.cases.declare import *
from gnomon.reference.contact.impact_oscillator import StoppedOscillator
from gnomon.reference.numerics.precision import quantity


def before_the_stop(t: Any, state: Values, parameters: Values) -> Values:
    """m v' = F cos(w t) - c v - k x."""
    x, v = state
    m, c, k, F, w, _s, _e = parameters
    return v, (F * cos(w * t) - c * v - k * x) / m


def way_past_the_stop(t: Any, state: Values, parameters: Values) -> Values:
    return (state[0] - parameters[5],)


def off_the_stop(t: Any, state: Values, parameters: Values) -> Values:
    """v -> -e v."""
    return parameters[5], -parameters[6] * state[1]


def onto_the_stop(t: Any, state: Values, parameters: Values) -> Values:
    return parameters[5], state[1]


def stop_mode(t: Any, state: Values, parameters: Values) -> str:
    return "flight"


class ImpactOscillator(ImpactCase):
    name = "impact_oscillator"
    title = "Forced oscillator before a rigid stop (impacts by certified root finding)"
    section = "6.6, 7.2.1"
    conventions = (
        "[inferred] m x'' + c x' + k x = F cos(w t) for x < s; at the stop x = s the velocity changes from v to -e v. The "
        "motion ends before an accumulation of impacts, and is not computed on through it. No source: the numbers are ours."
    )
    x = Coordinate("m", "-0.5", typical(-2, -0.1))
    v = Coordinate("m/s", 0, typical(-1, 1))
    m = Parameter("kg", 1, "mass", positive(0.5, 2))
    c = Parameter("N s/m", "0.1", "viscous damping", nonnegative(0, 0.5))
    k = Parameter("N/m", 1, "stiffness of the spring", positive(0.5, 2))
    F = Parameter("N", 1, "amplitude of the force", typical(0.2, 2))
    w = Parameter("rad/s", 2, "frequency of the force", positive(1.5, 4))
    s = Parameter("m", 0, "position of the stop", typical(0, 1))
    e = Parameter("1", "0.8", "coefficient of restitution", Range(0.01, 1.0, typical=(0.7, 1.0)))
    rules = (
        Rule("c^2 < 4 m k (the free oscillator vibrates)", lambda n: n["c"] ** 2 < 4 * n["m"] * n["k"]),
        Rule(
            "c > 0 or m w^2 != k (no resonance without damping)", lambda n: n["c"] > 0 or n["m"] * n["w"] ** 2 != n["k"]
        ),
        Rule("x < s (the mass starts before the stop)", lambda n: n["x"] < n["s"]),
    )
    exact_motion = bind(
        StoppedOscillator, mass="m", damping="c", stiffness="k", force="F", frequency="w", stop="s", z0="x", u0="v"
    )
    default_span = "31.3"
    variants = (
        Variant(
            "grazing", "the second arc reaches the stop 1e-10 m below its peak, at 1e-5 m/s: two roots of the gap 2e-5 s apart",
            {"s": "0.5176615349468469"}, (-1, 0), "20.1",
        ),
        Variant(
            "missed", "just beyond the grazing bifurcation: the second arc misses the stop by 1e-10 m, there is no impact",
            {"s": "0.5176615351468469"}, (-1, 0), "20.1",
        ),
        Variant(
            "chaotic", "w between the resonances: errors grow 1.5e8-fold over 36 impacts",
            {"c": "0.02", "w": "2.7", "s": "0.1"}, span=80,
        ),
        Variant("undamped", "no damping and e = 1: nothing forgets an error", {"c": 0, "e": 1}, span="31.3"),
        Variant(
            "chatter", "e = 0.5 on a slow force: impacts that accumulate at 3.14874 s; ends 4e-5 s before",
            {"w": "0.3", "e": "0.5"}, span="3.1487",
        ),
        Variant("fast_force", "a force of 1000 rad/s, whose phase at an impact depends on 1e-3 s", {"w": 1000, "F": 100}, span="21.3"),
    )  # fmt: skip
    autonomous = False
    forms = (
        Hybrid(
            modes=(Mode("flight", before_the_stop),),
            start=stop_mode,
            transitions=(
                Transition("impact", "flight", way_past_the_stop, 1, off_the_stop, "flight", onto_the_stop),
            ),
        ),
    )  # fmt: skip

    @property
    def time_scale(self) -> float:
        """One radian of the force or of the free vibration, whichever is shorter."""
        return min(sqrt(float(self.m / self.k)), 1 / float(self.w))

    def natural_span(self) -> Number:
        """1.6 periods of the free vibration unless the numbers are the default's: few impacts for any restitution."""
        if [self.e, self.w, self.s, self.F] == [Fraction("0.8"), 2, 0, 1]:
            return super().natural_span()
        return 1.6 * 2 * pi * sqrt(float(self.m / self.k))

    def list_events(self, digits: int) -> tuple[Event, ...]:
        stop = quantity(digits, lambda mp: mp.mpf(self.s))
        return tuple(
            Event(time, "impact", (stop, before), (stop, after)) for time, before, after in self.impacts(digits)
        )

    def derived(self, digits: int) -> dict[str, Any]:
        """`impacts`: within the span; the time of the first."""
        first = next(self.impacts(digits), None)
        return {"impacts": self.count, "first_impact": first[0] if first else None}
