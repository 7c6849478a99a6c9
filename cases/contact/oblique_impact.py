"""Two smooth discs that collide obliquely."""

from gnomon.cases.declare import *
from gnomon.cases.scenes.impact import DISCS
from gnomon.reference.contact.impacts import DiscImpact
from mpmath import mpf


def discs_coast(t: Any, state: Values, parameters: Values) -> Values:
    _, _, _, _, vx1, vy1, vx2, vy2 = state
    return vx1, vy1, vx2, vy2, 0, 0, 0, 0


def disc_gap(t: Any, state: Values, parameters: Values) -> Values:
    """|r2 - r1|^2/R - R."""
    x, y, R = state[2] - state[0], state[3] - state[1], parameters[2]
    return ((x * x + y * y) / R - R,)


def discs_strike(t: Any, state: Values, parameters: Values) -> Values:
    """The normal relative velocity is reversed and multiplied by e; no force acts across the line of centres."""
    x1, y1, x2, y2, vx1, vy1, vx2, vy2 = state
    m1, m2, _R, e = parameters
    x, y = x2 - x1, y2 - y1
    push = (1 + e) * (x * (vx2 - vx1) + y * (vy2 - vy1)) / ((x * x + y * y) * (m1 + m2))
    px, py = push * x, push * y
    return x1, y1, x2, y2, vx1 + m2 * px, vy1 + m2 * py, vx2 - m1 * px, vy2 - m1 * py


def discs_touching(t: Any, state: Values, parameters: Values) -> Values:
    """Both discs moved along the line of centres until they touch, their centre of mass fixed."""
    x1, y1, x2, y2, vx1, vy1, vx2, vy2 = state
    m1, m2, R, _e = parameters
    x, y = x2 - x1, y2 - y1
    excess = (1 - R / sqrt(x * x + y * y)) / (m1 + m2)
    sx, sy = excess * x, excess * y
    return x1 + m2 * sx, y1 + m2 * sy, x2 - m1 * sx, y2 - m1 * sy, vx1, vy1, vx2, vy2


def discs_kinetic(t: Any, state: Values, parameters: Values) -> Values:
    _, _, _, _, vx1, vy1, vx2, vy2 = state
    m1, m2, _, _ = parameters
    return ((m1 * (vx1 * vx1 + vy1 * vy1) + m2 * (vx2 * vx2 + vy2 * vy2)) / 2,)


def discs_momentum_x(t: Any, state: Values, parameters: Values) -> Values:
    return (parameters[0] * state[4] + parameters[1] * state[6],)


def discs_momentum_y(t: Any, state: Values, parameters: Values) -> Values:
    return (parameters[0] * state[5] + parameters[1] * state[7],)


def discs_angular_momentum(t: Any, state: Values, parameters: Values) -> Values:
    """Angular momentum about the origin."""
    x1, y1, x2, y2, vx1, vy1, vx2, vy2 = state
    m1, m2, _, _ = parameters
    return (m1 * (x1 * vy1 - y1 * vx1) + m2 * (x2 * vy2 - y2 * vx2),)


def discs_mode(t: Any, state: Values, parameters: Values) -> str:
    return "before"


def _apart(n: Mapping[str, Fraction]) -> bool:
    return (n["x2"] - n["x1"]) ** 2 + (n["y2"] - n["y1"]) ** 2 > n["R"] ** 2


class ObliqueImpact(Case):
    name = "oblique_impact"
    title = "Oblique impact of two smooth discs"
    section = "8.13"
    conventions = (
        "In a plane without gravity; R is the sum of the radii; the discs are smooth, so their spin is irrelevant."
    )
    x1 = Coordinate("m", -2, typical(-3, -2))
    y1 = Coordinate("m", "0.3", typical(-0.3, 0.3))
    x2 = Coordinate("m", 0, typical(-0.3, 0.3))
    y2 = Coordinate("m", 0, typical(-0.3, 0.3))
    vx1 = Coordinate("m/s", 3, typical(2, 4))
    vy1 = Coordinate("m/s", "0.2", typical(-0.3, 0.3))
    vx2 = Coordinate("m/s", "-0.5", typical(-0.3, 0.3))
    vy2 = Coordinate("m/s", "0.1", typical(-0.3, 0.3))
    m1 = Parameter("kg", 1, "mass of disc 1", positive(0.5, 2))
    m2 = Parameter("kg", 2, "mass of disc 2", positive(0.5, 2))
    R = Parameter("m", "0.5", "sum of the radii", positive(0.5, 1))
    e = Parameter("1", "0.7", "coefficient of restitution", Range(low=0.0, high=1.0, typical=(0.0, 1.0)))
    rules = (Rule("the discs are apart: |r2 - r1| > R", _apart),)
    exact_motion = bind(DiscImpact, places="x1 y1 x2 y2", velocities="vx1 vy1 vx2 vy2")
    variants = (
        Variant("head_on", "along the line of centres", {}, (-2, 0, 0, 0, 3, 0, -1, 0)),
        Variant(
            "elastic",
            "equal masses, e = 1, one at rest: they leave at a right angle",
            {"m2": 1, "e": 1},
            (-2, "0.3", 0, 0, 3, 0, 0, 0),
        ),
        Variant("plastic", "e = 0: they slide along each other", {"e": 0}),
        Variant(
            "graze",
            "1e-9 of R inside the tangent path: contact 4e-5 rad from it",
            {},
            (-2, 0.5 * (1 - 1e-9), 0, 0, 3, 0, 0, 0),
        ),
        Variant(
            "miss",
            "1e-9 of R outside the tangent path: no impact",
            {},
            (-2, 0.5 * (1 + 1e-9), 0, 0, 3, 0, 0, 0),
            span="1.3",
        ),
        Variant("wall", "m2 = 1e9 kg: as from a wall", {"m2": 10**9}, (-2, "0.3", 0, 0, 3, "0.2", 0, 0)),
    )
    invariants = decaying(energy=discs_kinetic) | conserved(
        momentum_x=discs_momentum_x, momentum_y=discs_momentum_y, angular_momentum=discs_angular_momentum
    )
    scene = DISCS
    forms = (
        Hybrid(
            modes=(Mode("before", discs_coast), Mode("after", discs_coast)),
            start=discs_mode,
            transitions=(Transition("impact", "before", disc_gap, -1, discs_strike, "after", discs_touching),),
            terminal=frozenset({"after"}),
        ),
    )

    @property
    def time_scale(self) -> float:
        """The distance over the relative speed; 1 s without relative motion."""
        x1, y1, x2, y2, u1, w1, u2, w2 = map(float, self.initial_state)
        speed = hypot(u2 - u1, w2 - w1)
        return hypot(x2 - x1, y2 - y1) / speed if speed else 1.0

    def natural_span(self) -> Number:
        """1.87 times the time to the impact; 2 time scales if there is none."""
        return 1.87 * float(self.exact_motion.impact_time()) if self.exact_motion.touches else 2 * self.time_scale

    def list_events(self, digits: int) -> tuple[Event, ...]:
        motion = self.exact_motion
        if not motion.touches or motion.impact_time(20) > self.span:
            return ()
        time, before, after = motion.impact(digits)
        return (Event(time, "impact", before, after),)

    def same_course(self, other: Case) -> bool:
        return isinstance(other, ObliqueImpact) and other.exact_motion.touches == self.exact_motion.touches

    def derived(self, digits: int) -> dict[str, Any]:
        motion = self.exact_motion
        time = motion.impact_time(digits) if motion.touches else mpf("inf")
        return {"impact_time": time, "energy_lost": motion.energy_lost}
