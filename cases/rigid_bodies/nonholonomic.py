"""A sleigh and a skate on a knife edge: nonholonomic constraints.

Cases: chaplygin_sleigh, knife_edge_incline.
"""

from gnomon.cases.declare import *
from gnomon.reference.rigid_bodies.nonholonomic import ChaplyginSleigh, KnifeEdge


def sleigh_equations(t: Any, state: Values, parameters: Values) -> Values:
    v, w, _theta = state
    m, inertia, a = parameters
    return a * w * w, -m * a * v * w / (inertia + m * a * a), w


def sleigh_energy(t: Any, state: Values, parameters: Values) -> Values:
    v, w, _theta = state
    m, inertia, a = parameters
    return ((m * v * v + (inertia + m * a * a) * w * w) / 2,)


def sleigh_turn(t: Any, state: Values, parameters: Values) -> Values:
    """theta - (q/a) atan(v/(q w)), constant, q^2 = I/m + a^2; it determines the final direction."""
    v, w, theta = state
    m, inertia, a = parameters
    q = sqrt(inertia / m + a * a)
    return (theta - q / a * atan2(v * w, q * w * w),)


def skate_equations(t: Any, state: Values, parameters: Values) -> Values:
    _x, _y, th, v = state
    w, gs = parameters
    return v * cos(th), v * sin(th), w, gs * cos(th)


def skate_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Per unit mass; the edge does no work."""
    x, _y, _th, v = state
    _w, gs = parameters
    return (v * v / 2 - gs * x,)


def skate_speed(t: Any, state: Values, parameters: Values) -> Values:
    """w v - gs sin(theta)."""
    _x, _y, th, v = state
    w, gs = parameters
    return (w * v - gs * sin(th),)


def skate_turn(t: Any, state: Values, parameters: Values) -> Values:
    return (state[2] - parameters[0] * t,)


def on_edge(x: float, y: float, angle: float, speed: float, turn: float, body: tuple[float, float]) -> Body:
    """A body on a vertical knife edge at (x, y); `body` is its mass and its moment about the vertical."""
    mass, moment = body
    velocity = (speed * cos(angle), speed * sin(angle), 0.0)
    attitude = (0.0, 0.0, sin(angle / 2), cos(angle / 2))
    return Body("edge", mass, (moment, moment, moment), (x, y, 0.0), attitude, velocity, (0.0, 0.0, turn))


def read_edge(readings: Readings) -> tuple[float, float, float, float, float]:
    """x, y, angle, forward speed, rate of turn."""
    (x, y, _), (_, _, qz, qw), (vx, vy, _), (_, _, turn) = readings.bodies["edge"]
    angle = 2 * atan2(qz, qw)
    return x, y, angle, vx * cos(angle) + vy * sin(angle), turn


def sleigh_scene(state: Values, parameters: Values) -> Scene:
    """The edge is at the origin; the moment accounts for the centre of mass at a ahead of it."""
    v, w, theta = state
    m, inertia, a = parameters
    return Scene((0.0, 0.0, 0.0), (on_edge(0.0, 0.0, theta, v, w, (m, inertia + m * a * a)),))


def sleigh_reading(readings: Readings, parameters: Values) -> Values:
    _, _, angle, speed, turn = read_edge(readings)
    return speed, turn, angle


def skate_scene(state: Values, parameters: Values) -> Scene:
    x, y, th, v = state
    w, gs = parameters
    return Scene((gs, 0.0, 0.0), (on_edge(x, y, th, v, w, (1.0, 1.0)),))


def skate_reading(readings: Readings, parameters: Values) -> Values:
    return read_edge(readings)[:4]


EDGE = frozenset({"knife_edge"})
SLEIGH_SCENE = SceneForm(sleigh_scene, sleigh_reading, EDGE, conservative=False)
SKATE_SCENE = SceneForm(skate_scene, skate_reading, EDGE, conservative=False)


class ChaplyginSleighCase(Case):
    name = "chaplygin_sleigh"
    title = "Chaplygin sleigh (nonholonomic knife edge)"
    section = "11.2.2"
    conventions = (
        "v is the forward speed of the edge, with the centre of mass at a ahead of it. Energy is constant, but phase volume "
        "is not: every motion tends to straight ahead (v = V). The path of the edge follows from the state: "
        "x' = v cos(theta), y' = v sin(theta)."
    )
    v = Coordinate("m/s", "-1.5", typical(-5, 5))
    w = Coordinate("rad/s", "0.4", typical(-5, 5))
    theta = Coordinate("rad", 0, typical(-5, 5))
    m = Parameter("kg", 2, "mass", positive())
    I = Parameter("kg m^2", "0.5", "moment of inertia about the centre of mass", positive())
    a = Parameter("m", "0.3", "from the edge to the centre of mass", positive())
    exact_motion = bind(ChaplyginSleigh, inertia="I")
    quantity_names = ("final_speed=speed", "whole_turn")
    variants = (
        Variant(
            "backward",
            "starts straight backward up to 1e-12: an unstable motion, then a sudden turn",
            initial_state=(-1, "1e-12", 0),
        ),
        Variant("spin", "starts with a fast rotation and no speed", initial_state=(0, 20, 0)),
        Variant("straight", "exactly straight backward: stays so, though unstable", initial_state=(-1, 0, 0), span=100),
        Variant("slow", "the centre of mass almost at the edge: a slow turn", {"a": "1e-4"}),
    )
    invariants = conserved(energy=sleigh_energy, turn=sleigh_turn)
    forms = (FirstOrder(sleigh_equations),)
    scene = SLEIGH_SCENE
    reversal = ("v", "w")

    @property
    def time_scale(self) -> float:
        """q/(a V), the decay time of the rotation, or the time of a radian of it if that is shorter."""
        m, inertia, a = map(float, self.parameter_values())
        square = inertia / m + a * a
        speed = float(self.exact_motion.speed())
        return min(square / (a * speed), sqrt(square) / speed) if speed else 1.0

    def natural_span(self) -> Number:
        """The time of the turn, and 5 decay times more."""
        m, inertia, a = map(float, self.parameter_values())
        speed, w = float(self.exact_motion.speed()), abs(float(self.w))
        if not speed or not w:
            return 10 * self.time_scale
        square = inertia / m + a * a
        until = max(0.0, -asinh(float(self.v) / (sqrt(square) * w)))
        return (until + 5) * square / (a * speed)

    def derived(self, digits: int) -> dict[str, Any]:
        """`edge_x` and `edge_y`: the position of the edge at the end of the span, relative to its start (m)."""
        return dict(zip(("edge_x", "edge_y"), self.exact_motion.path(self.span, digits), strict=True))


class KnifeEdgeIncline(Case):
    name = "knife_edge_incline"
    title = "Knife edge (skate) on an incline, constant turn rate"
    section = "11.2.2"
    conventions = "x down the slope, y across, gs = g sin(alpha); a turning skate drifts across the slope, not down."
    x = Coordinate("m", 0, typical(-5, 5))
    y = Coordinate("m", 0, typical(-5, 5))
    th = Coordinate("rad", 0, typical(-5, 5))
    v = Coordinate("m/s", 0, typical(-5, 5))
    w = Parameter("rad/s", "0.7", "rate of turn", typical(-5, 5))
    gs = Parameter("m/s^2", "1.7", "g sin(alpha)", nonnegative(0, 9))
    exact_motion = bind(KnifeEdge)
    quantity_names = ("drift",)
    """The mean velocity across the slope, if started at rest (m/s)."""
    variants = (
        Variant("long_1e4", "10,000 turns: the distance across grows, that down the slope must not", span="89763.5"),
        Variant("slow_turn", "w = 1e-8: formulas divide by w^2", {"w": "1e-8"}, span=20),
        Variant("straight", "w = 0: down the slope", {"w": 0}, (0, 0, "0.3", 0), span=20),
        Variant("launched", "starts with speed", initial_state=(0, 0, 1, 3)),
    )
    invariants = conserved(energy=skate_energy, speed=skate_speed, turn=skate_turn)
    forms = (FirstOrder(skate_equations),)
    scene = SKATE_SCENE
    reversal = ("v", "w")

    @property
    def time_scale(self) -> float:
        """The time of a radian of the turn."""
        w = abs(float(self.w))
        return 1 / w if w > 0.01 else 1.0

    def natural_span(self) -> Number:
        """10.37 turns; 10 s if it does not turn."""
        w = abs(float(self.w))
        return 10.37 * 2 * pi / w if w > 0.01 else 10.0
