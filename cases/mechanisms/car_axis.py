"""The car axis of the Test Set for IVP Solvers: a stiff suspension over a bumpy road, two constraints, one with time."""

from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.cases.core.elimination import multipliers
from gnomon.cases.declare import *
from gnomon.reference.numerics.precision import publish, working


def right_wheel(t: Any, parameters: Values) -> Values:
    """Where the road holds the right wheel: xb, yb and their first derivatives; the left wheel is at the origin."""
    _m, _k, _l0, base, c, w, _g = parameters
    yb, rate = c * sin(w * t) / w, c * cos(w * t)
    xb = sqrt(base * base - yb * yb)
    return xb, yb, -yb * rate / xb, rate


def springs_and_weight(t: Any, place: Values, parameters: Values) -> Values:
    """Forces of the two springs and of gravity, over the mass m/2 of an end of the axis."""
    xl, yl, xr, yr = place
    m, k, l0, _base, _c, _w, g = parameters
    xb, yb, _, _ = right_wheel(t, parameters)
    ahead, above, rate = xr - xb, yr - yb, 2 * k / m
    left = rate * (l0 / sqrt(xl * xl + yl * yl) - 1)
    right = rate * (l0 / sqrt(ahead * ahead + above * above) - 1)
    return left * xl, left * yl - g, right * ahead, right * above - g


def shaft_and_axle(t: Any, place: Values, parameters: Values) -> Values:
    """The left end is on the line across the wheels' line through the left wheel; the ends keep their distance."""
    xl, yl, xr, yr = place
    xb, yb, _, _ = right_wheel(t, parameters)
    return xb * xl + yb * yl, (xl - xr) * (xl - xr) + (yl - yr) * (yl - yr)


def normals(t: Any, place: Values, parameters: Values) -> Values:
    xl, yl, xr, yr = place
    xb, yb, _, _ = right_wheel(t, parameters)
    x, y = 2 * (xl - xr), 2 * (yl - yr)
    return xb, yb, 0, 0, x, y, -x, -y


def road_rate(t: Any, place: Values, parameters: Values) -> Values:
    """The derivatives of the constraints in time at a constant place."""
    _, _, vx, vy = right_wheel(t, parameters)
    return vx * place[0] + vy * place[1], 0


def car_axis_equations(t: Any, state: Values, parameters: Values) -> Values:
    """Index 1: the multipliers solve two linear equations, in which the shaft's normal has the constant length L."""
    xl, yl, xr, yr, vxl, vyl, vxr, vyr = state
    m, k, l0, base, c, w, g = parameters
    yb, vy = (c / w) * sin(w * t), c * cos(w * t)
    xb = sqrt(base * base - yb * yb)
    vx = -yb * vy / xb
    upward = (-w * w) * yb
    along = -(vx * vx + vy * vy + yb * upward) / xb  # from xb^2 + yb^2 = L^2, differentiated twice
    ahead, above, rate = xr - xb, yr - yb, 2 * k / m
    left = (rate * l0) / sqrt(xl * xl + yl * yl) - rate
    right = (rate * l0) / sqrt(ahead * ahead + above * above) - rate
    fxl, fyl, fxr, fyr = left * xl, left * yl - g, right * ahead, right * above - g
    x, y, vx_apart, vy_apart = xl - xr, yl - yr, vxl - vxr, vyl - vyr
    first = xb * fxl + yb * fyl + along * xl + upward * yl + 2 * (vx * vxl + vy * vyl)
    second = x * (fxl - fxr) + y * (fyl - fyr) + vx_apart * vx_apart + vy_apart * vy_apart
    mixed, square = xb * x + yb * y, base * base
    axle = (square * second - mixed * first) / ((2 * square) * (x * x + y * y) - mixed * mixed)
    shaft = (first - axle * mixed) / square
    px, py = axle * x, axle * y
    return vxl, vyl, vxr, vyr, fxl - shaft * xb - px, fyl - shaft * yb - py, fxr + px, fyr + py


def squared_axle(t: Any, state: Values, parameters: Values) -> Values:
    """The square of the distance of the two ends (m^2)."""
    return (shaft_and_axle(t, state[:4], parameters)[1],)


def along_the_shaft(t: Any, state: Values, parameters: Values) -> Values:
    """The left end's distance from the shaft, times the wheel base (m^2)."""
    return (shaft_and_axle(t, state[:4], parameters)[0],)


FORM = Constrained(
    car_axis_equations,
    force=springs_and_weight,
    constraint=shaft_and_axle,
    gradient=normals,
    constraint_rate=road_rate,
)
MULTIPLIERS = multipliers(FORM)
"""Of the form, over the mass of an end; the test set's are these times -m/(2 k)."""


def _keeps_the_shaft(numbers: Mapping[str, Fraction]) -> bool:
    return numbers["xl"] == 0 and numbers["L"] * numbers["vxl"] + numbers["c"] * numbers["yl"] == 0


def _keeps_the_axle(numbers: Mapping[str, Fraction]) -> bool:
    x, y = numbers["xl"] - numbers["xr"], numbers["yl"] - numbers["yr"]
    return x * (numbers["vxl"] - numbers["vxr"]) + y * (numbers["vyl"] - numbers["vyr"]) == 0


class CarAxis(IntegratedCase):
    """An axis on two stiff springs: the left wheel on a flat road, the right wheel over bumps."""

    name = "car_axis"
    title = "Car axis on a bumpy road: two constraints, one of them with time (certified Taylor)"
    section = "11.2.1"
    conventions = (
        "[inferred] Car axis problem of the Test Set for IVP Solvers (CWI, Bari; Schneider), index 1: the multipliers are "
        "eliminated. Ends (xl, yl), (xr, yr) of mass m/2; left wheel at (0, 0), right wheel at (xb, yb), yb = (c/w) sin wt, "
        "xb^2 + yb^2 = L^2. The test set has m = 10, k = 1/eps^2, eps = 1e-2, r = c/w = 0.1. Constants of the constraints are "
        "those of the start; starts satisfy L vxl + c yl = 0, xl = 0, and the axle's length is constant. "
        "The test set ends at 3 s, this case at 2 s, as far as its integration may take steps. "
        "Quantities: the test set's multipliers at the start."
    )
    xl = Coordinate("m", 0, typical(0, 0))
    yl = Coordinate("m", "0.5", typical(0.5, 0.5))
    xr = Coordinate("m", 1, typical(0.9, 1.1))
    yr = Coordinate("m", "0.5", typical(0.5, 0.5))
    vxl = Coordinate("m/s", "-0.5", typical(-0.5, -0.5))
    vyl = Coordinate("m/s", 0, typical(-0.5, 0.5))
    vxr = Coordinate("m/s", "-0.5", typical(-0.5, -0.5))
    vyr = Coordinate("m/s", 0, typical(-0.5, 0.5))
    m = Parameter("kg", 10, "mass of the axis, half of it at each end", positive(5, 20))
    k = Parameter("N/m", 10_000, "stiffness of each spring, 1/eps^2", positive(5000, 20_000))
    l0 = Parameter("m", "0.5", "natural length of each spring", positive(0.45, 0.55))
    L = Parameter("m", 1, "distance of the wheels", positive(1, 1))
    c = Parameter("m/s", 1, "highest vertical speed of the right wheel, r w", typical(1, 1))
    w = Parameter("rad/s", 10, "angular frequency of the bumps", positive(8, 20))
    g = Parameter("m/s^2", 1, "acceleration of gravity", positive(1, 10))
    rules = (
        Rule("the start is on the shaft and moves with it (xl = 0, L vxl + c yl = 0)", _keeps_the_shaft),
        Rule("the start keeps the axle's length (the ends' relative velocity is across the axle)", _keeps_the_axle),
        Rule(
            "the bumps are lower than the distance of the wheels (|c| < L w)",
            lambda numbers: abs(numbers["c"]) < numbers["L"] * numbers["w"],
        ),
    )
    default_span = 2
    variants = (
        Variant(
            "stiff_1e6",
            "springs a hundred times as stiff (eps = 1e-3), released 1 mm stretched",
            {"k": 1_000_000, "l0": "0.499"},
            span="0.2",
        ),
        Variant("fast_road", "bumps at 45 rad/s, beside the springs' own 44.7 rad/s: resonance", {"w": 45}, span="1.2"),
        Variant("heavy", "ten times the gravity on springs a tenth as stiff: deep swings", {"k": 1000, "g": 10}),
    )
    invariants = conserved(squared_axle=squared_axle, along_the_shaft=along_the_shaft)
    forms = (FORM,)
    autonomous = False

    @property
    def time_scale(self) -> float:
        """One radian of the bumps, or of an end on its spring."""
        return min(1 / float(self.w), self.fastest_time)

    @property
    def fastest_time(self) -> float:
        """One radian of an end on its spring, or of the bumps."""
        return min(1 / float(self.w), sqrt(float(self.m) / (2 * float(self.k))))

    def derived(self, digits: int) -> dict[str, Any]:
        """At the start, the forces of shaft and axle by the multipliers of the test set, times eps^2."""
        with working(digits + 10) as mp:
            forces = rebind(MULTIPLIERS, mpmath_arithmetic(mp))
            state, values = (tuple(map(mp.mpf, numbers)) for numbers in (self.initial_state, self.parameter_values()))
            first, second = (-value * values[0] / (2 * values[1]) for value in forces(mp.mpf(0), state, values))
            return dict(zip(("multiplier_shaft", "multiplier_axle"), publish((first, second), digits), strict=True))
