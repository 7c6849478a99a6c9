"""Two blocks and a wall: an exact count of elastic impacts."""

from gnomon.cases.declare import *
from gnomon.cases.scenes.impact import ball_line
from gnomon.reference.contact.restitution_impact_1d_2d import TwoBlocks
from mpmath import mpf


def uniform_motion(t: Any, state: Values, parameters: Values) -> Values:
    _, _, v1, v2 = state
    return v1, v2, 0, 0


def gap(t: Any, state: Values, parameters: Values) -> Values:
    return (state[1] - state[0],)


def distance_to_wall(t: Any, state: Values, parameters: Values) -> Values:
    return (state[0],)


def blocks_collide(t: Any, state: Values, parameters: Values) -> Values:
    """v -> 2 v_C - v for both blocks."""
    x1, x2, v1, v2 = state
    m1, m2 = parameters
    mean = (m1 * v1 + m2 * v2) / (m1 + m2)
    return x1, x2, 2 * mean - v1, 2 * mean - v2


def wall_returns(t: Any, state: Values, parameters: Values) -> Values:
    x1, x2, v1, v2 = state
    return x1, x2, -v1, v2


def onto_each_other(t: Any, state: Values, parameters: Values) -> Values:
    x1, x2, v1, v2 = state
    return (x1 + x2) / 2, (x1 + x2) / 2, v1, v2


def onto_wall(t: Any, state: Values, parameters: Values) -> Values:
    _, x2, v1, v2 = state
    return 0, x2, v1, v2


def blocks_kinetic(t: Any, state: Values, parameters: Values) -> Values:
    _, _, v1, v2 = state
    m1, m2 = parameters
    return ((m1 * v1 * v1 + m2 * v2 * v2) / 2,)


def blocks_mode(t: Any, state: Values, parameters: Values) -> str:
    return "free"


def _one_after_the_other(n: Mapping[str, Fraction]) -> bool:
    return n["x2"] * n["v1"] != n["x1"] * n["v2"] or n["v2"] >= 0


SCENE = ball_line(lambda parameters: parameters, lambda parameters: 1.0, wall=True)


class RestitutionImpact(Case):
    """A block moves towards a second one, which rests in front of a wall; all impacts are elastic."""

    name = "restitution_impact_1d_2d"
    title = "Two blocks and a wall: exact count of elastic impacts"
    section = "8.13"
    conventions = (
        "The wall is at x = 0, 0 < x1 < x2; the blocks are points; the coefficient of restitution is always 1."
    )
    x1 = Coordinate("m", 1, positive(0.5, 1))
    x2 = Coordinate("m", 2, positive(1.1, 3))
    v1 = Coordinate("m/s", 0, typical(-1, 1), group="velocity of block 1")
    v2 = Coordinate("m/s", -1, typical(-2, -0.5), group="velocity of block 2")
    m1 = Parameter("kg", 1, "mass of the block next to the wall", positive(0.5, 2))
    m2 = Parameter("kg", 100, "mass of the other block", positive(0.5, 100))
    rules = (
        Rule("x1 < x2 (block 1 is between the wall and block 2)", lambda n: n["x1"] < n["x2"]),
        Rule("the blocks do not reach the wall at the same time", _one_after_the_other),
        Rule("m2 <= 1e7 m1 (at most 10,000 impacts)", lambda n: n["m2"] <= 10**7 * n["m1"]),
    )
    exact_motion = bind(TwoBlocks)
    variants = (
        Variant("equal", "equal masses: 3 impacts, in which the blocks exchange their velocities", {"m2": 1}),
        Variant("ratio_1e4", "m2/m1 = 1e4: exactly 314 impacts, digits of pi", {"m2": 10**4}),
        Variant("ratio_1e6", "m2/m1 = 1e6: 3141 impacts, at the wall 1e-6 s apart", {"m2": 10**6}),
    )

    invariants = conserved(energy=blocks_kinetic)
    scene = SCENE
    forms = (
        Hybrid(
            modes=(Mode("free", uniform_motion),),
            start=blocks_mode,
            transitions=(
                Transition("blocks", "free", gap, -1, blocks_collide, "free", onto_each_other),
                Transition("wall", "free", distance_to_wall, -1, wall_returns, "free", onto_wall),
            ),
        ),
    )

    @property
    def time_scale(self) -> float:
        """The distance of block 2 from the wall over its speed; 1 s if it is at rest."""
        speed = max(abs(float(v)) for v in self.initial_state[2:])
        return float(self.x2) / speed if speed else 1.0

    def natural_span(self) -> Number:
        """A third longer than the time until the last impact."""
        return (
            float(self.exact_motion.impact_time(self.exact_motion.impacts)) * 4 / 3
            if self.exact_motion.impacts
            else self.time_scale
        )

    def list_events(self, digits: int) -> tuple[Event, ...]:
        """`blocks` and `wall`, sorted by time."""
        events = []
        for n in range(1, self.exact_motion.passed(self.span) + 1):
            impact = self.exact_motion.impact(n, digits)
            places = impact.places
            events.append(Event(impact.time, impact.name, places + impact.before, places + impact.after))
        return tuple(events)

    def event_time(self, n: int, digits: int = 15) -> Any:
        """Computed without the earlier events."""
        return self.exact_motion.impact_time(n, digits) if n <= self.exact_motion.passed(self.span) else mpf("inf")

    def same_course(self, other: Case) -> bool:
        return isinstance(other, RestitutionImpact) and other.exact_motion.passed(
            self.span
        ) == self.exact_motion.passed(self.span)

    def derived(self, digits: int) -> dict[str, Any]:
        """`impacts`: the number of all impacts, also after the span."""
        count = self.exact_motion.impacts
        return {"impacts": count, "last_impact": self.exact_motion.impact_time(count, digits) if count else None}
