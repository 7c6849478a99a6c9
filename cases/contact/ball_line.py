"""Balls that collide on one line: three balls of any masses, and Newton's cradle.

Cases: three_ball_chain, newtons_cradle.
"""

import itertools

from gnomon.cases.declare import *
from gnomon.cases.scenes.impact import ball_line
from gnomon.reference.contact.impacts import BallLine
from gnomon.reference.numerics.precision import publish, working


def three_uniform(t: Any, state: Values, parameters: Values) -> Values:
    _, _, _, v1, v2, v3 = state
    return v1, v2, v3, 0, 0, 0


def gap_12(t: Any, state: Values, parameters: Values) -> Values:
    return (state[1] - state[0],)


def gap_23(t: Any, state: Values, parameters: Values) -> Values:
    return (state[2] - state[1],)


def impact_12(t: Any, state: Values, parameters: Values) -> Values:
    """v1' = ((m1 - e m2) v1 + (1 + e) m2 v2)/(m1 + m2), and v2' likewise."""
    x1, x2, x3, v1, v2, v3 = state
    m1, m2, _m3, e = parameters
    total = m1 + m2
    after1 = ((m1 - e * m2) * v1 + (1 + e) * m2 * v2) / total
    after2 = ((m2 - e * m1) * v2 + (1 + e) * m1 * v1) / total
    return x1, x2, x3, after1, after2, v3


def impact_23(t: Any, state: Values, parameters: Values) -> Values:
    x1, x2, x3, v1, v2, v3 = state
    _m1, m2, m3, e = parameters
    total = m2 + m3
    after2 = ((m2 - e * m3) * v2 + (1 + e) * m3 * v3) / total
    after3 = ((m3 - e * m2) * v3 + (1 + e) * m2 * v2) / total
    return x1, x2, x3, v1, after2, after3


def touching_12(t: Any, state: Values, parameters: Values) -> Values:
    x1, x2, x3, v1, v2, v3 = state
    return (x1 + x2) / 2, (x1 + x2) / 2, x3, v1, v2, v3


def touching_23(t: Any, state: Values, parameters: Values) -> Values:
    x1, x2, x3, v1, v2, v3 = state
    return x1, (x2 + x3) / 2, (x2 + x3) / 2, v1, v2, v3


def chain_kinetic(t: Any, state: Values, parameters: Values) -> Values:
    _, _, _, v1, v2, v3 = state
    m1, m2, m3, _ = parameters
    return ((m1 * v1 * v1 + m2 * v2 * v2 + m3 * v3 * v3) / 2,)


def chain_momentum(t: Any, state: Values, parameters: Values) -> Values:
    _, _, _, v1, v2, v3 = state
    m1, m2, m3, _ = parameters
    return (m1 * v1 + m2 * v2 + m3 * v3,)


def five_uniform(t: Any, state: Values, parameters: Values) -> Values:
    _, _, _, _, _, v1, v2, v3, v4, v5 = state
    return v1, v2, v3, v4, v5, 0, 0, 0, 0, 0


def cradle_gap_1(t: Any, state: Values, parameters: Values) -> Values:
    return (state[1] - state[0],)


def cradle_gap_2(t: Any, state: Values, parameters: Values) -> Values:
    return (state[2] - state[1],)


def cradle_gap_3(t: Any, state: Values, parameters: Values) -> Values:
    return (state[3] - state[2],)


def cradle_gap_4(t: Any, state: Values, parameters: Values) -> Values:
    return (state[4] - state[3],)


def cradle_hit_1(t: Any, state: Values, parameters: Values) -> Values:
    """For equal masses: the mean velocity, minus and plus e times half the difference."""
    x1, x2, x3, x4, x5, v1, v2, v3, v4, v5 = state
    mean, part = (v1 + v2) / 2, parameters[0] * (v1 - v2) / 2
    return x1, x2, x3, x4, x5, mean - part, mean + part, v3, v4, v5


def cradle_hit_2(t: Any, state: Values, parameters: Values) -> Values:
    x1, x2, x3, x4, x5, v1, v2, v3, v4, v5 = state
    mean, part = (v2 + v3) / 2, parameters[0] * (v2 - v3) / 2
    return x1, x2, x3, x4, x5, v1, mean - part, mean + part, v4, v5


def cradle_hit_3(t: Any, state: Values, parameters: Values) -> Values:
    x1, x2, x3, x4, x5, v1, v2, v3, v4, v5 = state
    mean, part = (v3 + v4) / 2, parameters[0] * (v3 - v4) / 2
    return x1, x2, x3, x4, x5, v1, v2, mean - part, mean + part, v5


def cradle_hit_4(t: Any, state: Values, parameters: Values) -> Values:
    x1, x2, x3, x4, x5, v1, v2, v3, v4, v5 = state
    mean, part = (v4 + v5) / 2, parameters[0] * (v4 - v5) / 2
    return x1, x2, x3, x4, x5, v1, v2, v3, mean - part, mean + part


def cradle_touch_1(t: Any, state: Values, parameters: Values) -> Values:
    x1, x2, x3, x4, x5, v1, v2, v3, v4, v5 = state
    return (x1 + x2) / 2, (x1 + x2) / 2, x3, x4, x5, v1, v2, v3, v4, v5


def cradle_touch_2(t: Any, state: Values, parameters: Values) -> Values:
    x1, x2, x3, x4, x5, v1, v2, v3, v4, v5 = state
    return x1, (x2 + x3) / 2, (x2 + x3) / 2, x4, x5, v1, v2, v3, v4, v5


def cradle_touch_3(t: Any, state: Values, parameters: Values) -> Values:
    x1, x2, x3, x4, x5, v1, v2, v3, v4, v5 = state
    return x1, x2, (x3 + x4) / 2, (x3 + x4) / 2, x5, v1, v2, v3, v4, v5


def cradle_touch_4(t: Any, state: Values, parameters: Values) -> Values:
    x1, x2, x3, x4, x5, v1, v2, v3, v4, v5 = state
    return x1, x2, x3, (x4 + x5) / 2, (x4 + x5) / 2, v1, v2, v3, v4, v5


def cradle_kinetic(t: Any, state: Values, parameters: Values) -> Values:
    """Over the mass."""
    _, _, _, _, _, v1, v2, v3, v4, v5 = state
    return ((v1 * v1 + v2 * v2 + v3 * v3 + v4 * v4 + v5 * v5) / 2,)


def cradle_momentum(t: Any, state: Values, parameters: Values) -> Values:
    """Over the mass."""
    _, _, _, _, _, v1, v2, v3, v4, v5 = state
    return (v1 + v2 + v3 + v4 + v5,)


def balls_mode(t: Any, state: Values, parameters: Values) -> str:
    return "free"


def impacts_of(free: Equations, *pairs: tuple[Equations, Equations, Equations]) -> Hybrid:
    """Uniform motion between impacts. `pairs`: guard, reset and nearest state on the guard of each pair of neighbours."""
    return Hybrid(
        modes=(Mode("free", free),),
        start=balls_mode,
        transitions=tuple(
            Transition(f"impact_{i}{i + 1}", "free", guard, -1, reset, "free", onto)
            for i, (guard, reset, onto) in enumerate(pairs, start=1)
        ),
    )


def published(values: tuple[Fraction, ...], digits: int) -> tuple[Any, ...]:
    with working(digits + 5) as mp:
        return publish(map(mp.mpf, values), digits)


class _BallLineCase(Case):
    exact_motion: BallLine

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        with self._within_reach():
            _ = self.exact_motion.legs  # raises if three balls meet at the same time

    @property
    def time_scale(self) -> float:
        """The length of the line over the largest speed; 1 s if all balls are at rest."""
        count = len(self.state) // 2
        places, speeds = self.initial_state[:count], self.initial_state[count:]
        fastest = max(map(abs, speeds))
        return float((places[-1] - places[0]) / fastest) if fastest else 1.0

    def natural_span(self) -> Number:
        """A third longer than the time until the last impact."""
        return float(self.exact_motion.legs[-1].time) * 4 / 3 or self.time_scale

    def list_events(self, digits: int) -> tuple[Event, ...]:
        """One for each impact, named by the balls."""
        events, legs = [], self.exact_motion.legs
        for before, after in itertools.pairwise(legs):
            if after.time > self.span:
                break
            assert after.pair is not None
            places = published(after.places, digits)
            there = places + published(before.velocities, digits), places + published(after.velocities, digits)
            name = f"impact_{after.pair + 1}{after.pair + 2}"
            events.append(Event(published((after.time,), digits)[0], name, *there))
        return tuple(events)

    def same_course(self, other: Case) -> bool:
        return [event.name for event in other.events()] == [event.name for event in self.events()]

    def derived(self, digits: int) -> dict[str, Any]:
        motion, legs = self.exact_motion, self.exact_motion.legs
        lost = sum((motion.energy_lost(n) for n in range(1, len(legs))), Fraction(0))
        return {"impacts": len(legs) - 1, "energy_lost": lost, "last_speed": legs[-1].velocities[-1]}


def _ordered(count: int) -> Rule:
    def holds(n: Mapping[str, Fraction]) -> bool:
        return all(n[f"x{i}"] < n[f"x{i + 1}"] for i in range(1, count))

    return Rule("the balls are apart and numbered from left to right: x1 < x2 < ...", holds)


def _at_most_100_impacts(n: Mapping[str, Fraction]) -> bool:
    """Whether a light ball between heavy ones collides at most 100 times.

    Two impacts rotate the vector of the relative velocities by an angle a; 4 e cos^2(a/2) is the left-hand side of the
    rule over the masses on its right. Above 4 e the velocities only decay, and the impacts never end.
    """
    return 1000 * (1 + n["e"]) ** 2 * n["m1"] * n["m3"] <= 3996 * n["e"] * (n["m1"] + n["m2"]) * (n["m2"] + n["m3"])


class ThreeBallChain(_BallLineCase):
    name = "three_ball_chain"
    title = "A ball strikes a second ball, which strikes a third"
    section = "8.13"
    conventions = (
        "Coordinates are shifted so that touching neighbours have equal ones. The third ball leaves fastest if "
        "m2 = sqrt(m1 m3); each impact loses (1 - e^2)/2 of the reduced mass times the squared speed of approach."
    )
    x1 = Coordinate("m", 0, typical(-0.5, 0.2))
    x2 = Coordinate("m", 1, typical(0.5, 1))
    x3 = Coordinate("m", 2, typical(1.5, 2))
    v1 = Coordinate("m/s", 1, typical(0.5, 2))
    v2 = Coordinate("m/s", 0, typical(-0.3, 0.3))
    v3 = Coordinate("m/s", 0, typical(-0.3, 0.3))
    m1 = Parameter("kg", 4, "mass of the striking ball", positive(0.5, 4))
    m2 = Parameter("kg", 2, "mass of the middle ball", positive(0.5, 4))
    m3 = Parameter("kg", 1, "mass of the last ball", positive(0.5, 4))
    e = Parameter("1", "0.8", "coefficient of restitution", Range(low=0.2, high=1.0, typical=(0.5, 1.0)))
    rules = (
        _ordered(3),
        Rule(
            "(1 + e)^2 m1 m3 <= 3.996 e (m1 + m2)(m2 + m3) (at most 100 impacts; from 4 e on infinitely many)",
            _at_most_100_impacts,
        ),
    )
    exact_motion = bind(BallLine, masses="m1 m2 m3", places="x1 x2 x3", velocities="v1 v2 v3")
    variants = (
        Variant("elastic", "e = 1: energy is constant through both impacts", {"e": 1}),
        Variant(
            "heavy_last",
            "light balls before a heavy one: the middle ball moves back and forth",
            {"m1": 1, "m2": "0.01"},
        ),
        Variant("close", "1e-9 m between the last two: impacts 1e-9 s apart", {}, (0, 1, 1.000000001, 1, 0, 0)),
        Variant("light_last", "m3 = 1e-9 kg: leaves at nearly (1 + e)^2 m1/(m1 + m2) v1", {"m3": "1e-9"}),
    )
    invariants = decaying(energy=chain_kinetic) | conserved(momentum=chain_momentum)
    scene = ball_line(lambda parameters: parameters[:3], lambda parameters: parameters[3])
    forms = (impacts_of(three_uniform, (gap_12, impact_12, touching_12), (gap_23, impact_23, touching_23)),)

    def derived(self, digits: int) -> dict[str, Any]:
        """`best_m2`: the middle mass with which the last ball is fastest, for one impact of each pair (kg)."""
        return super().derived(digits) | {"best_m2": lambda mp: mp.sqrt(mp.mpf(self.m1 * self.m3))}


class NewtonsCradle(_BallLineCase):
    name = "newtons_cradle"
    title = "Newton's cradle: equal balls in a row"
    section = "8.13"
    conventions = (
        "One stroke of the cradle, along the line at the lowest point: five equal balls, a little apart. Coordinates are "
        "shifted so that touching neighbours have equal ones. If e = 1, as many balls leave as arrive."
    )
    x1 = Coordinate("m", 0, typical(0.7, 1.3))
    x2 = Coordinate("m", "0.5", typical(1.7, 2.3))
    x3 = Coordinate("m", "0.75", typical(2.7, 3.3))
    x4 = Coordinate("m", 1, typical(3.7, 4.3))
    x5 = Coordinate("m", "1.125", typical(4.7, 5.3))
    v1 = Coordinate("m/s", 1, typical(0.5, 2))
    v2 = Coordinate("m/s", 0, typical(-0.2, 0.2))
    v3 = Coordinate("m/s", 0, typical(-0.2, 0.2))
    v4 = Coordinate("m/s", 0, typical(-0.2, 0.2))
    v5 = Coordinate("m/s", 0, typical(-0.2, 0.2))
    e = Parameter("1", 1, "coefficient of restitution", Range(low=0.2, high=1.0, typical=(0.8, 1.0)))
    rules = (_ordered(5),)
    exact_motion = bind(lambda c: BallLine((Fraction(1),) * 5, c.e, c.initial_state[:5], c.initial_state[5:]))
    variants = (
        Variant("two_balls", "two arrive, two leave: 6 impacts", {}, (0, "0.25", 1, "1.5", 2, 1, 1, 0, 0, 0)),
        Variant(
            "nearly_touching",
            "1e-9 m apart: four successive impacts within 3e-9 s",
            {},
            (0, 1, 1 + 2.0**-30, 1 + 2.0**-29, 1 + 3 * 2.0**-30, 1, 0, 0, 0, 0),
        ),
        Variant("lossy", "e = 0.75: many impacts, in the end all balls move", {"e": "0.75"}),
        Variant("both_sides", "one from each end: they meet in the middle", {}, (0, 1, 2, 3, "3.75", 1, 0, 0, 0, -1)),
    )
    invariants = decaying(energy=cradle_kinetic) | conserved(momentum=cradle_momentum)
    scene = ball_line(lambda parameters: (1.0,) * 5, lambda parameters: parameters[0])
    forms = (
        impacts_of(
            five_uniform,
            (cradle_gap_1, cradle_hit_1, cradle_touch_1),
            (cradle_gap_2, cradle_hit_2, cradle_touch_2),
            (cradle_gap_3, cradle_hit_3, cradle_touch_3),
            (cradle_gap_4, cradle_hit_4, cradle_touch_4),
        ),
    )
