"""Drag proportional to the square of the speed: the projectile, and the vertical throw.

Cases: projectile_quadratic_drag, vertical_quadratic_drag.
"""

from gnomon.cases.declare import *
from gnomon.cases.flight.projectile_parabola import ProjectileParabola
from gnomon.cases.flight.projectile_stokes_drag import ProjectileStokesDrag
from gnomon.cases.scenes.point import UP, free_point, railed_point
from gnomon.reference.flight.quadratic_drag import QuadraticDragPlane, QuadraticDragVertical
from mpmath import mpf


def quadratic_drag_equations(t: Any, state: Values, parameters: Values) -> Values:
    """r'' = g - k |v| v."""
    _x, _y, vx, vy = state
    g, k = parameters
    drag = k * sqrt(vx * vx + vy * vy)
    return vx, vy, -drag * vx, -g - drag * vy


def drag_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy per unit mass."""
    _x, y, vx, vy = state
    g, _k = parameters
    return ((vx * vx + vy * vy) / 2 + g * y,)


def hodograph(t: Any, state: Values, parameters: Values) -> Values:
    """Bernoulli's integral 1/vx^2 + (k/g) F(q), F = q sqrt(1 + q^2) + asinh q, q = vy/|vx|."""
    _x, _y, vx, vy = state
    g, k = parameters
    q = vy / sqrt(vx * vx)
    return (1 / (vx * vx) + k / g * (q * sqrt(1 + q * q) + asinh(q)),)


PLANE_SCENE = free_point(quadratic_drag_equations, UP)


class ProjectileQuadraticDrag(Case):
    name = "projectile_quadratic_drag"
    title = "Projectile with quadratic drag: Bernoulli's hodograph"
    section = "6.5 (extension of 6.5.2)"
    conventions = "x horizontal, y upward; drag -k |v| v per unit mass; vx is not zero (see vertical_quadratic_drag)."
    x = Coordinate("m", 0)
    y = Coordinate("m", 0)
    vx = Coordinate("m/s", 20, typical(0.5, 10))
    vy = Coordinate("m/s", 15)
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    k = Parameter("1/m", "0.01", "drag over mass and squared speed", positive(0.001, 0.5))
    rules = (Rule("vx is not zero", lambda n: n["vx"] != 0),)
    exact_motion = bind(QuadraticDragPlane)
    quantity_names = ("terminal_speed", "apex_time apex_height=apex")
    variants = (
        Variant("strong", "k v0^2/g = 1e3: loses nearly all speed at once", {"k": "3.5"}, (0, 0, 20, 49), "4.1"),
        Variant("weak", "k = 1e-10: nearly the parabola", {"k": "1e-10"}, span="2.9"),
        Variant("asymptote", "falls until the path is vertical up to 1e-24", span=180),
        Variant("steep", "nearly vertical: the slope starts at 1.5e7", initial_state=(0, 0, "1e-6", 15)),
    )
    invariants = decaying(energy=drag_energy) | conserved(hodograph=hodograph)
    forms = (FirstOrder(quadratic_drag_equations),)
    scene = PLANE_SCENE

    @property
    def time_scale(self) -> float:
        """The shorter of the times in which drag slows the body and in which gravity bends its path."""
        g, k = map(float, self.parameter_values())
        speed = hypot(*map(float, self.initial_state[2:]))
        return min(1 / (k * speed), speed / g, 1 / sqrt(g * k))

    def natural_span(self) -> Number:
        """About the flight without drag, at most five times the time to the limiting speed."""
        g, k = map(float, self.parameter_values())
        speed = hypot(*map(float, self.initial_state[2:]))
        return min(1.97 * speed / g, 5 / sqrt(g * k))

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        parabola = self.level(ProjectileParabola, "no drag: the parabola")
        drag = "drag proportional to the velocity, equal at the start"
        return parabola, self.level(ProjectileStokesDrag, drag, nu=self._first_rate)

    @property
    def _first_rate(self) -> float:
        """k |v0|."""
        return float(self.k) * hypot(*map(float, self.initial_state[2:]))


def rising_or_falling(t: Any, state: Values, parameters: Values) -> Values:
    """y' = v, v' = -g - side k v^2; `side`, 1 rising and -1 falling, is a constant of the mode."""
    _y, v = state
    g, k, side = parameters
    return v, -g - side * k * v * v


def upward_velocity(t: Any, state: Values, parameters: Values) -> Values:
    _y, v = state
    return (v,)


def at_the_apex(t: Any, state: Values, parameters: Values) -> Values:
    y, _v = state
    return y, 0


def throw_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy per unit mass."""
    y, v = state
    g, _k = parameters
    return (v * v / 2 + g * y,)


def throw_mode(t: Any, state: Values, parameters: Values) -> str:
    _y, v = state
    return "rising" if v > 0 else "falling"


def signed_drag(t: Any, state: Values, parameters: Values) -> Values:
    """The same without modes, with v |v| written as v sqrt(v^2), for the force of a scene."""
    _y, v = state
    g, k = parameters
    return v, -g - k * v * sqrt(v * v)


VERTICAL_SCENE = railed_point(signed_drag)


class VerticalQuadraticDrag(Case):
    name = "vertical_quadratic_drag"
    title = "Vertical throw with quadratic drag: tan ascent, tanh descent"
    section = "6.5, 6.13.1"
    conventions = "y upward; drag -k v |v| per unit mass. Its second derivative jumps at the apex: an event."
    y = Coordinate("m", 0)
    v = Coordinate("m/s", 40, typical(-20, 40))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    k = Parameter("1/m", "0.01", "drag over mass and squared speed", positive(0.001, 1))
    exact_motion = bind(QuadraticDragVertical)
    variants = (
        Variant(
            "fast", "v0 is 1e6 times the limiting speed: stiff at the start", {"g": 10, "k": "0.1"}, (0, 10**7), 20
        ),
        Variant("long_fall", "falls for 1e4 times the time to the limiting speed: cosh overflows", span=30000),
        Variant("weak", "k = 1e-12: nearly the parabola", {"k": "1e-12"}, span="8.1"),
        Variant(
            "from_rest",
            "released at rest: the second derivative of the force jumps at the start",
            initial_state=(0, 0),
            span=10,
        ),
        Variant(
            "faster_than_the_limit", "thrown down at four times the limiting speed", initial_state=(0, -125), span=9
        ),
        Variant(
            "nasa_sphere",
            "the sphere of the check cases of NASA/TM-2015-218675, in air as dense as at sea level: falls from 9144 m at rest",
            {"g": "9.80665", "k": "7.656e-5"},
            (9144, 0),
            30,
        ),
    )
    invariants = decaying(energy=throw_energy)
    scene = VERTICAL_SCENE
    forms = (
        Hybrid(
            modes=(Mode("rising", rising_or_falling, (1.0,)), Mode("falling", rising_or_falling, (-1.0,))),
            start=throw_mode,
            transitions=(Transition("apex", "rising", upward_velocity, -1, at_the_apex, "falling"),),
            terminal=frozenset({"falling"}),
        ),
    )

    @property
    def time_scale(self) -> float:
        """vt/g, the time to the limiting speed; v0/g if that is shorter."""
        g, k = map(float, self.parameter_values())
        speed = abs(float(self.v))
        return min(1 / sqrt(g * k), speed / g or inf)

    def natural_span(self) -> Number:
        """1.3 times the flight back to the start; four times vt/g if it starts at rest or downward."""
        if self.v > 0:
            return 1.3 * float(self.exact_motion.return_time())
        return 4 / sqrt(float(self.g) * float(self.k))

    def list_events(self, digits: int) -> tuple[Event, ...]:
        """The apex of a throw upward."""
        if self.v <= 0 or self.exact_motion.apex_time(20) > self.span:
            return ()
        there = (self.exact_motion.apex_height(digits), mpf(0))
        return (Event(self.exact_motion.apex_time(digits), "apex", there, there),)

    def same_course(self, other: Case) -> bool:
        return (self.v > 0) == (other.initial_state[1] > 0)

    @property
    def quantity_names(self) -> tuple[str, ...]:
        thrown = ("apex_time", "apex_height", "return_time", "return_speed") if self.v > 0 else ()
        return ("terminal_speed", *thrown)
