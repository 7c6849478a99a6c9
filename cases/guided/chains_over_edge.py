"""Chains that slide over an edge by their own weight: off a table, with or without friction, or over a small pulley.

Cases: chain_off_table, chain_over_pulley.
"""

from gnomon.cases.declare import *
from gnomon.cases.scenes.point import railed
from gnomon.reference.guided.chains_over_edge import SlidingChain
from mpmath import mpf


def sliding_off(t: Any, state: Values, parameters: Values) -> Values:
    """s'' = (g/L) ((1 + mu) s - mu L)."""
    s, v = state
    g, length, mu = parameters
    return v, (g / length) * ((1 + mu) * s - mu * length)


def over_pulley(t: Any, state: Values, parameters: Values) -> Values:
    """s'' = (2 g/L) s."""
    s, v = state
    g, length = parameters
    return v, (2 * g / length) * s


def free_fall(t: Any, state: Values, parameters: Values) -> Values:
    _, v = state
    return v, parameters[0]


def to_table_end(t: Any, state: Values, parameters: Values) -> Values:
    return (state[0] - parameters[1],)


def to_pulley_end(t: Any, state: Values, parameters: Values) -> Values:
    return (state[0] - parameters[1] / 2,)


def goes_on(t: Any, state: Values, parameters: Values) -> Values:
    """Nothing jumps."""
    s, v = state
    return s, v


def table_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass, zero if all of it is on the table; min(s, L) without a branch. It decays by friction."""
    s, v = state
    g, length, _mu = parameters
    hangs = (s + length - sqrt((s - length) * (s - length))) / 2
    return (v * v / 2 - g * (hangs * hangs / (2 * length) + s - hangs),)


def pulley_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass, zero in equilibrium."""
    s, v = state
    g, length = parameters
    over = (s + length / 2 - sqrt((s - length / 2) * (s - length / 2))) / 2
    return (v * v / 2 - g * (over * over / length + s - over),)


def table_mode(t: Any, state: Values, parameters: Values) -> str:
    return "sliding" if state[0] < parameters[1] else "falling"


def pulley_mode(t: Any, state: Values, parameters: Values) -> str:
    return "sliding" if state[0] < parameters[1] / 2 else "falling"


def table_force(t: float, s: float, parameters: Values) -> Any:
    """The force over the mass, on the table and off it."""
    if s < parameters[1]:
        return sliding_off(t, (s, 0.0), parameters)[1]
    return free_fall(t, (s, 0.0), parameters)[1]


def pulley_force(t: float, s: float, parameters: Values) -> Any:
    if s < parameters[1] / 2:
        return over_pulley(t, (s, 0.0), parameters)[1]
    return free_fall(t, (s, 0.0), parameters)[1]


def until_it_leaves(sliding: Equations, end: Equations, start: Any) -> Hybrid:
    """The chain slides until `end` crosses zero, then it falls freely."""
    return Hybrid(
        modes=(Mode("sliding", sliding), Mode("falling", free_fall)),
        start=start,
        transitions=(Transition("leaves", "sliding", end, 1, goes_on, "falling"),),
        terminal=frozenset({"falling"}),
    )


class _ChainOverEdge(Case):
    """A chain that leaves its support at one event, `leaves`, and then falls freely."""

    exact_motion: SlidingChain

    @property
    def time_scale(self) -> float:
        """The time in which the chain's motion grows by e."""
        return 1 / sqrt(float(self.exact_motion.square))

    def natural_span(self) -> Number:
        """Until well after the event; ten time scales in equilibrium."""
        if self.exact_motion.rests:
            return 10 * self.time_scale
        return 1.15 * float(self.exact_motion.end_time()) + 0.1 * self.time_scale

    def list_events(self, digits: int) -> tuple[Event, ...]:
        motion = self.exact_motion
        if motion.rests or motion.s0 >= motion.end or motion.end_time(20) > self.span:
            return ()
        with_end = (motion._quantity(digits, lambda mp: mp.mpf(motion.end)), motion.end_speed(digits))
        return (Event(motion.end_time(digits), "leaves", with_end, with_end),)

    def same_course(self, other: Case) -> bool:
        """A chain that is not exactly in equilibrium runs off."""
        return isinstance(other, _ChainOverEdge) and other.exact_motion.rests == self.exact_motion.rests

    def derived(self, digits: int) -> dict[str, Any]:
        motion = self.exact_motion
        if motion.rests:
            return {"leaving_time": mpf("inf")}
        return {"leaving_time": motion.end_time(digits), "leaving_speed": motion.end_speed(digits)}


def _reach(n: Mapping[str, Fraction]) -> bool:
    return n["s"] * (1 + n["mu"]) >= n["mu"] * n["L"] and n["v"] >= 0


class ChainOffTable(_ChainOverEdge):
    """A uniform chain that slides off a table, guided at the edge, until its end leaves it."""

    name = "chain_off_table"
    title = "Chain sliding off a smooth table edge"
    section = "8.12"
    conventions = (
        "s is the overhanging length; the chain is inextensible and guided at the edge; the friction mu acts on the part "
        "on the table. From s = L the whole chain falls freely and s is the depth of its lower end."
    )
    s = Coordinate("m", "0.3", nonnegative(0, 1))
    v = Coordinate("m/s", 0, nonnegative(0, 3))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    L = Parameter("m", 1, "length of the chain", positive(1, 5))
    mu = Parameter("1", 0, "coefficient of friction on the table", nonnegative(0, 0.5))
    rules = (
        Rule("s <= L (the chain is on the table)", lambda n: n["s"] <= n["L"]),
        Rule("s >= mu L/(1 + mu) and v >= 0 (else friction holds the chain)", _reach),
    )
    exact_motion = bind(
        lambda c: SlidingChain(c.g * (1 + c.mu) / c.L, c.mu * c.L / (1 + c.mu), c.L, c.g, *c.initial_state)
    )
    variants = (
        Variant("hair", "an overhang of 1e-12 m: leaves after 28 e-foldings", initial_state=("1e-12", 0)),
        Variant("pushed", "starts with speed and nothing over the edge", initial_state=(0, "0.5")),
        Variant("friction", "mu = 0.3", {"mu": "0.3"}),
        Variant(
            "friction_limit", "exactly the largest overhang that friction holds: must not creep", {"mu": 1}, ("0.5", 0)
        ),
        Variant(
            "friction_limit_above",
            "one double more than friction holds: leaves after 37 e-foldings",
            {"mu": 1},
            (0.5000000000000001, 0),
        ),
    )
    invariants = decaying(energy=table_energy)
    forms = (until_it_leaves(sliding_off, to_table_end, table_mode),)
    scene = railed(table_force)

    def derived(self, digits: int) -> dict[str, Any]:
        """Tension at the edge over the mass per length, (1 + mu) (L - s) g s/L (m^2/s^2), at the start and its maximum.

        The maximum is where half of the chain hangs, or at the start if more than half hangs there.
        """
        most = self.s if self.exact_motion.rests else max(self.s, self.L / 2)
        first, largest = ((1 + self.mu) * (self.L - x) * self.g * x / self.L for x in (self.s, most))
        return super().derived(digits) | {"edge_tension": first, "largest_edge_tension": largest}


class ChainOverPulley(_ChainOverEdge):
    """A uniform chain that hangs over a small smooth pulley and runs off it."""

    name = "chain_over_pulley"
    title = "Chain running off a small smooth pulley"
    section = "8.12"
    conventions = (
        "s is the displacement from equilibrium, in which L/2 hangs on either side; the pulley is a point, and the chain "
        "stays on it. From s = L/2 the whole chain falls freely."
    )
    s = Coordinate("m", "0.1", nonnegative(0, 1))
    v = Coordinate("m/s", 0, nonnegative(0, 3))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    L = Parameter("m", 2, "length of the chain", positive(2, 5))
    rules = (Rule("s <= L/2 (the chain lies over the pulley)", lambda n: 2 * n["s"] <= n["L"]),)
    exact_motion = bind(lambda c: SlidingChain(2 * c.g / c.L, Fraction(0), c.L / 2, c.g, *c.initial_state))
    variants = (
        Variant("balanced", "exactly in equilibrium: must not move", initial_state=(0, 0)),
        Variant("hair", "1e-12 m from equilibrium: runs off after 28 e-foldings", initial_state=("1e-12", 0)),
    )
    invariants = conserved(energy=pulley_energy)
    forms = (until_it_leaves(over_pulley, to_pulley_end, pulley_mode),)
    scene = railed(pulley_force)
