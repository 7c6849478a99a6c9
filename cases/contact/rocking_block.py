"""A rigid block that rocks on its two lower edges and loses a share of its rate at each change of edge."""

from math import atanh, log

from gnomon.cases.core.impacts import ImpactCase
from gnomon.cases.declare import *
from gnomon.reference.contact.rocking_block import RockingBlock as Motion
from mpmath import mpf


def rocking(t: Any, state: Values, parameters: Values) -> Values:
    """theta'' = p^2 (theta - alpha side)."""
    theta, rate = state
    p, alpha, _r, side = parameters
    return rate, p * p * (theta - alpha * side)


def tilt(t: Any, state: Values, parameters: Values) -> Values:
    return (state[0],)


def change_edge(t: Any, state: Values, parameters: Values) -> Values:
    """theta' -> r theta'."""
    return 0, parameters[2] * state[1]


def upright(t: Any, state: Values, parameters: Values) -> Values:
    return 0, state[1]


def first_edge(t: Any, state: Values, parameters: Values) -> str:
    return "right" if state[0] > 0 else "left"


class RockingBlock(ImpactCase):
    name = "rocking_block"
    title = "Rocking block: two edges, impacts that accumulate"
    section = "6.6, 7.2.1"
    conventions = (
        "[inferred] theta'' = p^2 (theta - alpha sgn theta): the linearised rocking of a slender block (Housner 1963); at "
        "theta = 0 the rate is multiplied by r, a parameter. The motion ends before its impacts accumulate. The numbers are ours."
    )
    theta = Coordinate("rad", "0.2", typical(-0.1, 0.1))
    rate = Coordinate("rad/s", 0, typical(-0.1, 0.1))
    p = Parameter("rad/s", "2.2", "sqrt(m g R/I)", positive(1, 4))
    alpha = Parameter("rad", "0.25", "angle at which the block overturns", positive(0.2, 0.4))
    r = Parameter(
        "1", "0.9", "ratio of the rates after and before an impact", Range(0.0, 1.0, True, True, typical=(0.3, 0.97))
    )
    rules = (
        Rule("theta != 0 (the block starts on one edge)", lambda n: n["theta"] != 0),
        Rule(
            "|theta'| < p (alpha - |theta|) (the block does not overturn)",
            lambda n: abs(n["rate"]) < n["p"] * (n["alpha"] - abs(n["theta"])),
        ),
    )
    exact_motion = bind(Motion, z0="theta", u0="rate")
    variants = (
        Variant("near_overturning", "starts 1e-9 of alpha before it overturns", {}, ("0.24999999975", 0)),
        Variant("many_impacts", "r = 0.97: 57 impacts", {"r": "0.97"}, span=30),
        Variant("soft", "r = 0.3: each rate is 0.3 of the one before", {"r": "0.3"}),
        Variant("slender", "alpha = 0.01", {"alpha": "0.01"}, ("0.008", 0)),
    )
    forms = (
        Hybrid(
            modes=(Mode("right", rocking, (1.0,)), Mode("left", rocking, (-1.0,))),
            start=first_edge,
            transitions=(
                Transition("impact", "right", tilt, -1, change_edge, "left", upright),
                Transition("impact", "left", tilt, 1, change_edge, "right", upright),
            ),
        ),
    )

    @property
    def time_scale(self) -> float:
        """1/p."""
        return 1 / float(self.p)

    def natural_span(self) -> Number:
        """Until the middle of the flight after the sixth impact."""
        p, alpha = float(self.p), float(self.alpha)
        w = float(self.alpha - abs(self.theta))
        rate = -float(self.rate) / p * (1 if self.theta > 0 else -1)
        fall = sqrt(alpha * alpha - w * w + rate * rate)
        flights = [2 * atanh(fall / alpha * float(self.r) ** n) / p for n in range(1, 7)]
        return log((alpha + fall) / (w + rate)) / p + sum(flights[:-1]) + flights[-1] / 2

    def list_events(self, digits: int) -> tuple[Event, ...]:
        zero = mpf(0)
        return tuple(
            Event(time, "impact", (zero, before), (zero, after)) for time, before, after in self.impacts(digits)
        )

    def derived(self, digits: int) -> dict[str, Any]:
        """`impacts`: within the span; the time of the first."""
        first = next(self.impacts(digits), None)
        return {"impacts": self.count, "first_impact": first[0] if first else None}
