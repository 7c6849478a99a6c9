"""Attraction by the inverse fifth power of the distance: circles through the centre, unstable circles about it."""

from gnomon.cases.core.numbers import show
from gnomon.cases.declare import *
from gnomon.cases.orbits.kepler_orbit import angular_momentum
from gnomon.cases.scenes.point import free_point
from gnomon.reference.numerics.precision import exact
from gnomon.reference.orbits.central_force_fifth_power import collision_time


def fifth_power_acceleration(t: Any, q: Values, parameters: Values) -> Values:
    """r'' = -k r/|r|^6."""
    x, y = q
    (k,) = parameters
    square = x * x + y * y
    pull = -k / (square * square * square)
    return pull * x, pull * y


def fifth_power_potential(t: Any, q: Values, parameters: Values) -> Values:
    x, y = q
    (k,) = parameters
    square = x * x + y * y
    return (-k / (4 * square * square),)


def fifth_power_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy per unit mass."""
    x, y, vx, vy = state
    (k,) = parameters
    square = x * x + y * y
    return ((vx * vx + vy * vy) / 2 - k / (4 * square * square),)


def fifth_power_motion(t: Any, state: Values, parameters: Values) -> Values:
    x, y, vx, vy = state
    (k,) = parameters
    square = x * x + y * y
    pull = -k / (square * square * square)
    return vx, vy, pull * x, pull * y


BEFORE = 1 - Fraction(1, 2**19)
"""The part of a fall that a span may have: sample times may end 2**-20 of the span after it."""

SCENE = free_point(fifth_power_motion, (0, 1), token="position_force")


def _off_centre(n: Mapping[str, Fraction]) -> bool:
    return n["x"] != 0 or n["y"] != 0


class CentralForceFifthPower(IntegratedCase):
    name = "central_force_fifth_power"
    title = "Central force k/r^5: a circle through the centre of force"
    section = "7.8"
    conventions = (
        "The centre is the origin. With k = 2 r^4 v^2 and v perpendicular to r the energy is zero and the orbit a circle of "
        "diameter r through the centre, which it reaches after pi r/(4 v). A span ends at most at 1 - 2^-19 of the "
        "time of a fall into the centre."
    )
    x = Coordinate("m", 1, typical(1, 2))
    y = Coordinate("m", 0, typical(-0.2, 0.2))
    vx = Coordinate("m/s", 0, typical(-0.2, 0.2))
    vy = Coordinate("m/s", 1, typical(0.7, 1.2))
    k = Parameter("m^6/s^2", 2, "attraction times the fifth power of the distance, per unit mass", positive(0.5, 1))
    rules = (Rule("x^2 + y^2 > 0 (the start is not at the centre)", _off_centre),)
    default_span = "0.78"
    variants = (
        Variant("near_centre", "until 4e-4 s before the centre: r = 0.1, 90 times the initial speed", span="0.785"),
        Variant("circle", "k = r^4 v^2, exactly the circle about the centre: unstable, errors grow", {"k": 1}, span=6),
        Variant("spirals_out", "1e-4 faster than on the circle: spirals outward", {"k": 1}, (1, 0, 0, "1.0001"), 9),
        Variant(
            "spirals_in", "1e-4 slower than on the circle: falls into the centre", {"k": 1}, (1, 0, 0, "0.9999"), "5.4"
        ),
        Variant(
            "flyby",
            "arrives with little more than the momentum of capture, and turns round the centre",
            {"k": 1},
            (-6, "1.2", 1, 0),
            13,
        ),
    )
    invariants = conserved(energy=fifth_power_energy, angular_momentum=angular_momentum)
    forms = (Separable(fifth_power_acceleration, fifth_power_potential),)
    scene = SCENE

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        collision = collision_time(self.k, self.initial_state)
        if collision is not None and self.span > exact(collision) * BEFORE:
            with self._within_reach():
                raise ArithmeticError(
                    f"span = {show(self.span)} s: it falls into the centre at {float(collision):.10g} s; give at most "
                    f"{float(exact(collision) * BEFORE):.10g} s"
                )

    @property
    def time_scale(self) -> float:
        """The distance over the speed, or r^3/sqrt(k) if that is shorter."""
        x, y, vx, vy = map(float, self.initial_state)
        r, speed = hypot(x, y), hypot(vx, vy)
        fall = r**3 / sqrt(float(self.k))
        return min(fall, r / speed) if speed else fall

    def natural_span(self) -> Number:
        """0.3 of the time scale if start or k are not the defaults: no collision is earlier."""
        own = self.initial_state != tuple(map(Fraction, (1, 0, 0, 1))) or self.k != 2
        return 0.3 * self.time_scale if own else self.default_span

    def derived(self, digits: int) -> dict[str, Any]:
        """`circle_speed` at the initial distance; `collision_time` of a fall; `diameter` of the circle through the centre."""
        x, y, vx, vy = self.initial_state
        square, speed = x * x + y * y, vx * vx + vy * vy
        circle = x * vx + y * vy == 0 and self.k == 2 * square**2 * speed
        return {
            "circle_speed": lambda mp: mp.sqrt(mp.mpf(self.k)) / mp.mpf(square),
            "diameter": (lambda mp: mp.sqrt(mp.mpf(square))) if circle else None,
            "collision_time": collision_time(self.k, self.initial_state, digits),
        }
