"""The pendulum in Cartesian coordinates: a holonomic constraint with its multiplier."""

from gnomon.cases.core.consistent import violation
from gnomon.cases.declare import *
from gnomon.cases.flight.projectile_parabola import projectile_energy
from gnomon.reference.pendulums.holonomic_constraint_dae import CartesianPendulum


def cartesian_pendulum_equations(t: Any, state: Values, parameters: Values) -> Values:
    """r'' = g - lam r, with lam such that the second derivative of the constraint vanishes."""
    x, y, vx, vy = state
    (g,) = parameters
    lam = (vx * vx + vy * vy - g * y) / (x * x + y * y)
    return vx, vy, -lam * x, -lam * y - g


def gravity_in_the_plane(t: Any, place: Values, parameters: Values) -> Values:
    (g,) = parameters
    return 0, -g


def circle(t: Any, place: Values, parameters: Values) -> Values:
    x, y = place
    return (x * x + y * y,)


def circle_gradient(t: Any, place: Values, parameters: Values) -> Values:
    x, y = place
    return 2 * x, 2 * y


def squared_length(t: Any, state: Values, parameters: Values) -> Values:
    """The constraint itself: x^2 + y^2."""
    x, y, _vx, _vy = state
    return (x * x + y * y,)


def radial_velocity(t: Any, state: Values, parameters: Values) -> Values:
    """The constraint on velocities, x vx + y vy = 0."""
    x, y, vx, vy = state
    return (x * vx + y * vy,)


def on_a_rod(state: Values, parameters: Values) -> Scene:
    """A free point on a rod, whose length is the distance of the start from the pivot (token `rod`)."""
    x, y, vx, vy = state
    bob = Body("bob", 1.0, (0.0, 0.0, 0.0), (x, 0.0, y), velocity=(vx, 0.0, vy))
    return Scene((0.0, 0.0, -parameters[0]), (bob,))


def rod_end(readings: Readings, parameters: Values) -> Values:
    place, _, velocity, _ = readings.bodies["bob"]
    return place[0], place[2], velocity[0], velocity[2]


SCENE = SceneForm(on_a_rod, rod_end, frozenset({"rod"}), conservative=False)


FORM = Constrained(
    cartesian_pendulum_equations, force=gravity_in_the_plane, constraint=circle, gradient=circle_gradient
)


def _departure(numbers: Mapping[str, Fraction]) -> str | None:
    return violation(FORM, 0.0, [numbers[name] for name in ("x", "y", "vx", "vy")], [numbers["g"]])


def _consistent(numbers: Mapping[str, Fraction]) -> bool:
    return numbers["x"] * numbers["vx"] + numbers["y"] * numbers["vy"] == 0


class HolonomicConstraintDae(Case):
    """A mass on a rod: a constraint of index 3, stated with reduced index and the multiplier eliminated."""

    name = "holonomic_constraint_dae"
    title = "Pendulum in Cartesian coordinates with a multiplier"
    section = "11.2.1"
    conventions = (
        "x right and y up from the pivot; the rod's length is the start's distance from it. The index is reduced: the "
        "departure from the constraint x^2 + y^2 = L^2 grows linearly in time, as the drift of `squared_length` shows. "
        "Starts are consistent: x vx + y vy = 0 exactly, as on triangles 3-4-5."
    )
    x = Coordinate("m", "0.75", typical(-2, 2))
    y = Coordinate("m", "-1", typical(-2, 2))
    vx = Coordinate("m/s", "2", typical(0, 0))
    vy = Coordinate("m/s", "1.5", typical(0, 0))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    rules = (
        Rule("the rod's length is not zero (x, y not both 0)", lambda numbers: numbers["x"] != 0 or numbers["y"] != 0),
        Rule("the velocity is along the circle (x vx + y vy = 0)", _consistent, _departure),
    )
    exact_motion = bind(CartesianPendulum)
    default_span = Span(
        10.37, lambda motion: None if motion.on_separatrix or motion.rests else motion.period(), otherwise=9
    )
    variants = (
        Variant(
            "released", "released at rest above the pivot: the multiplier changes sign", initial_state=(4, 3, 0, 0)
        ),
        Variant("rotation", "turns over the top: the constraint force always acts", initial_state=(3, -4, 16, 12)),
        Variant(
            "upright",
            "released 1e-6 rad from the top: the rod pushes for a long time",
            initial_state=("1e-6", 1, 0, 0),
            periods=0.9,
        ),
        Variant("long_1e3", "1000 periods: departures from the constraint add up", periods=1000.37),
    )
    invariants = conserved(energy=projectile_energy, squared_length=squared_length, radial_velocity=radial_velocity)
    forms = (FORM,)
    scene = SCENE
    mirror = ("x", "vx")

    @property
    def time_scale(self) -> float:
        """sqrt(L/g), the time of a small swing; in fast rotation the time of a radian."""
        small = sqrt(sqrt(float(self.exact_motion.radius_squared)) / float(self.g))
        return small if self.exact_motion.on_separatrix else min(small, float(self.exact_motion.period()) / (2 * pi))

    @property
    def quantity_names(self) -> tuple[str, ...]:
        """`multiplier`: its value at the start, the rod's tension over mass and length (1/s^2)."""
        return ("multiplier",) if self.exact_motion.on_separatrix else ("multiplier", "period")
