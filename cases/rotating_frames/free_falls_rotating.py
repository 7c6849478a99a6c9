"""Free motion in a rotating frame: falls on the rotating Earth, and uniform straight motion in the inertial frame.

Cases: free_fall_rotating_earth, free_fall_rotating_frame_centrifugal, free_fall_first_order, inertial_straight_line.
"""

from typing import ClassVar

from gnomon.cases.declare import *
from gnomon.cases.scenes.point import SPACE, free_point
from gnomon.reference.flight.gyration import RotatingFall
from gnomon.reference.rotating_frames.inertial_straight_line import FirstOrderFall, StraightLine

EARTH = "7.292115e-5"
LATITUDE = "0.8901179185171081"
"""51 degrees."""


def coriolis_fall(t: Any, state: Values, parameters: Values) -> Values:
    """r'' = g - 2 Om x r'."""
    _x, _y, _z, vx, vy, vz = state
    g, rate, lat = parameters
    oy, oz = rate * cos(lat), rate * sin(lat)
    return vx, vy, vz, 2 * (oz * vy - oy * vz), -2 * oz * vx, 2 * oy * vx - g


def centrifugal_fall(t: Any, state: Values, parameters: Values) -> Values:
    """r'' = g - 2 Om x r' - Om x (Om x r)."""
    x, y, z, vx, vy, vz = state
    g, rate, lat = parameters
    oy, oz = rate * cos(lat), rate * sin(lat)
    square, along = rate * rate, oy * y + oz * z
    return (
        vx,
        vy,
        vz,
        2 * (oz * vy - oy * vz) + square * x,
        -2 * oz * vx + square * y - oy * along,
        2 * oy * vx - g + square * z - oz * along,
    )


def fall_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy per unit mass: the Coriolis force does no work."""
    _x, _y, z, vx, vy, vz = state
    g, _rate, _lat = parameters
    return ((vx * vx + vy * vy + vz * vz) / 2 + g * z,)


def east_momentum(t: Any, state: Values, parameters: Values) -> Values:
    """vx + 2 (Om x r)_x, constant: the eastward velocity that the fall gains."""
    _x, y, z, vx, _vy, _vz = state
    _g, rate, lat = parameters
    return (vx - 2 * (rate * sin(lat) * y - rate * cos(lat) * z),)


def jacobi_integral(t: Any, state: Values, parameters: Values) -> Values:
    """v^2/2 + g z - |Om x r|^2/2."""
    x, y, z, vx, vy, vz = state
    g, rate, lat = parameters
    along = cos(lat) * y + sin(lat) * z
    return ((vx * vx + vy * vy + vz * vz - rate * rate * (x * x + y * y + z * z - along * along)) / 2 + g * z,)


def axial_momentum(t: Any, state: Values, parameters: Values) -> Values:
    """Velocity along the axis, less the part due to gravity."""
    _x, _y, _z, _vx, vy, vz = state
    g, _rate, lat = parameters
    return (cos(lat) * vy + sin(lat) * vz + g * sin(lat) * t,)


def earth_fields(t: Any, place: Values, parameters: Values) -> Values:
    """g, and twice the Earth's rate: v x 2 Om is the Coriolis acceleration."""
    g, rate, lat = parameters
    return 0 * g, 0 * g, -g, 0 * g, 2 * rate * cos(lat), 2 * rate * sin(lat)


def centrifugal_fields(t: Any, place: Values, parameters: Values) -> Values:
    """g - Om x (Om x r), and twice the rate."""
    x, y, z = place
    g, rate, lat = parameters
    oy, oz = rate * cos(lat), rate * sin(lat)
    square, along = rate * rate, oy * y + oz * z
    return square * x, square * y - oy * along, square * z - oz * along - g, 0 * g, 2 * oy, 2 * oz


def north_momentum(t: Any, state: Values, parameters: Values) -> Values:
    """vy + 2 (Om x r)_y."""
    x, _y, _z, _vx, vy, _vz = state
    _g, rate, lat = parameters
    return (vy + 2 * rate * sin(lat) * x,)


def upward_momentum(t: Any, state: Values, parameters: Values) -> Values:
    """vz + 2 (Om x r)_z + g t."""
    x, _y, _z, _vx, _vy, vz = state
    g, rate, lat = parameters
    return (vz - 2 * rate * cos(lat) * x + g * t,)


EARTH_SCENE = free_point(coriolis_fall, SPACE)
CENTRIFUGAL_SCENE = free_point(centrifugal_fall, SPACE)


class FreeFallRotatingEarth(Case):
    name = "free_fall_rotating_earth"
    title = "Free fall and projectile relative to the rotating Earth"
    section = "6.15, 6.16, 6.18"
    conventions = (
        "x east, y north, z up; the constant g includes the centrifugal acceleration. The eastward coordinate, the small "
        "deflection of a fall, has its own scale."
    )
    x = Coordinate("m", 0, group="eastward")
    y = Coordinate("m", 0)
    z = Coordinate("m", "158.5")
    vx = Coordinate("m/s", 0, group="eastward velocity")
    vy = Coordinate("m/s", 0)
    vz = Coordinate("m/s", 0)
    g = Parameter("m/s^2", "9.81", "apparent gravity", nonnegative(0.1, 10))
    Om = Parameter("rad/s", EARTH, "rate of rotation of the Earth", typical(-3, 3))
    lat = Parameter("rad", LATITUDE, "latitude", Range(-pi / 2, pi / 2, typical=(-1.5, 1.5)))
    exact_motion = bind(lambda c: RotatingFall((c.x, c.y, c.z), (c.vx, c.vy, c.vz), c.g, c.Om, c.lat, c._centrifugal))
    variants: ClassVar[tuple[Variant, ...]] = (
        Variant(
            "day", "thrown upward for 24 h: the velocity turns twice in the frame", {}, (0, 0, 0, 100, 200, 300), 86400
        ),
        Variant("fast", "a turntable at 10 rad/s: gyration and drift instead of a fall", {"Om": 10}, span=11),
        Variant("slow", "1e-12 rad/s: a deflection of 4e-10 m beside a fall of 158 m", {"Om": "1e-12"}),
        Variant(
            "south",
            "thrown in the southern hemisphere: deflected to the left",
            {"lat": "-0.9"},
            (0, 0, 0, 0, 300, 300),
            60,
        ),
        Variant("equator", "no northward deflection: a component that stays exactly zero", {"lat": 0}),
    )
    invariants = conserved(
        energy=fall_energy, east_momentum=east_momentum, north_momentum=north_momentum, upward_momentum=upward_momentum
    )
    forms = (Charged(coriolis_fall, fields=earth_fields),)
    """A charge in crossed fields has these equations."""
    scene = EARTH_SCENE
    reversal = ("vx", "vy", "vz", "Om")

    _centrifugal: ClassVar[bool] = False

    @property
    def time_scale(self) -> float:
        """The time of the fall or of the throw, or of half a radian of the frame's rotation if that is shorter."""
        rate = abs(float(self.Om))
        return min(self._fall_time(), 1 / (2 * rate) if rate else inf)

    def _fall_time(self) -> float:
        """The longer of sqrt(2 z/g) and v/g; 1 s if both are zero."""
        g = float(self.g)
        z, speed = abs(float(self.z)), hypot(*map(float, self.initial_state[3:]))
        return max(sqrt(2 * z / g), speed / g) or 1.0 if g else 1.0

    def natural_span(self) -> Number:
        """The time of the fall, or of ten turns of the velocity if that is shorter."""
        return min(self._fall_time(), 10.37 * 2 * pi * self.time_scale)

    def derived(self, digits: int) -> dict[str, Any]:
        """For a drop from rest: when and where it reaches z = 0; to first order g Om cos(lat) t^3/3 east."""
        if any(self.initial_state[3:]) or self.z <= 0 or not self.g:
            return {}
        names = ("fall_time", "east_deflection", "north_deflection")
        quantities = dict(zip(names, self.exact_motion.strike(self._fall_time(), digits), strict=True))
        return quantities | {"first_order_deflection": self.exact_motion.first_order_deflection(digits)}

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        x, y, z, *thrown = self.initial_state
        still = self.with_numbers(self.initial_state, self.parameters | {"Om": Fraction(0)})
        numbers: dict[str, Any] = self.parameters | dict(zip(("ux", "uy", "uz"), thrown, strict=True))
        first = FreeFallFirstOrder(initial_state=(x, y, z, *thrown), span=self.span, **numbers)
        return (
            Level(still, same, "gravity on an Earth at rest"),
            Level(first, same, "the Coriolis force of the unperturbed velocity"),
        )


class FreeFallCentrifugal(FreeFallRotatingEarth):
    name = "free_fall_rotating_frame_centrifugal"
    title = "Uniform gravity fixed in a uniformly rotating frame, with the centrifugal force"
    section = "5.14-5.17, 6.15, 6.18"
    conventions = "As free_fall_rotating_earth, the origin on the axis: the centrifugal force varies with position."
    variants: ClassVar[tuple[Variant, ...]] = (
        Variant("fast", "a turntable at 10 rad/s: thrown outward in a spiral", {"Om": 10}, span="5.3"),
        Variant("slow", "1e-12 rad/s: the textbook formula loses 46 digits", {"Om": "1e-12"}),
        Variant("day", "thrown upward for 24 h", {}, (0, 0, 0, 100, 200, 300), 86400),
        Variant("thrown", "thrown north at 424 m/s", {}, (0, 0, 0, 0, 300, 300), 60),
    )
    invariants = conserved(jacobi=jacobi_integral, axial_momentum=axial_momentum)
    forms = (Charged(centrifugal_fall, fields=centrifugal_fields),)
    scene = CENTRIFUGAL_SCENE

    _centrifugal = True

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        earth = self.level(FreeFallRotatingEarth, "the Coriolis force, exactly")
        return (*earth.case.hierarchy, earth)


def first_order_fall(t: Any, q: Values, parameters: Values) -> Values:
    """r'' = g - 2 Om x (u + g t)."""
    g, rate, lat, ux, uy, uz = parameters
    oy, oz = rate * cos(lat), rate * sin(lat)
    return 2 * (oz * uy - oy * (uz - g * t)), -2 * oz * ux, 2 * oy * ux - g


def first_order_motion(t: Any, state: Values, parameters: Values) -> Values:
    return (*state[3:], *first_order_fall(t, state[:3], parameters))


FIRST_ORDER_SCENE = free_point(first_order_motion, SPACE, token="time_force")


class FreeFallFirstOrder(Case):
    name = "free_fall_first_order"
    title = "Fall on the rotating Earth, Coriolis force of the unperturbed velocity"
    section = "6.18"
    conventions = "As free_fall_rotating_earth, with the Coriolis force of u + g t; to first order in Om u = v(0)."
    x = Coordinate("m", 0, group="eastward")
    y = Coordinate("m", 0)
    z = Coordinate("m", "158.5")
    vx = Coordinate("m/s", 0, group="eastward velocity")
    vy = Coordinate("m/s", 0)
    vz = Coordinate("m/s", 0)
    g = Parameter("m/s^2", "9.81", "apparent gravity", nonnegative(0.1, 10))
    Om = Parameter("rad/s", EARTH, "rate of rotation of the Earth", typical(-3, 3))
    lat = Parameter("rad", LATITUDE, "latitude", Range(-pi / 2, pi / 2, typical=(-1.5, 1.5)))
    ux = Parameter("m/s", 0, "unperturbed starting velocity along x")
    uy = Parameter("m/s", 0, "unperturbed starting velocity along y")
    uz = Parameter("m/s", 0, "unperturbed starting velocity along z")
    exact_motion = bind(FirstOrderFall, thrown="ux uy uz", position="x y z", velocity="vx vy vz")
    default_span = Span(1, "time scale")
    autonomous = False
    forms = (SecondOrder(first_order_fall),)
    scene = FIRST_ORDER_SCENE

    @property
    def time_scale(self) -> float:
        g, z = float(self.g), abs(float(self.z))
        return sqrt(2 * z / g) if g * z else 1.0


def turning_line(t: Any, state: Values, parameters: Values) -> Values:
    """r'' = -2 Om x r' - Om x (Om x r) in the plane."""
    x, y, vx, vy = state
    (rate,) = parameters
    return vx, vy, 2 * rate * vy + rate * rate * x, -2 * rate * vx + rate * rate * y


def turning_line_matrix(parameters: Values) -> Values:
    (rate,) = parameters
    square = rate * rate
    return 0, 0, 1, 0, 0, 0, 0, 1, square, 0, 0, 2 * rate, 0, square, -2 * rate, 0


def no_force(t: Any, state: Values, parameters: Values) -> Values:
    return 0, 0, 0, 0


def line_jacobi(t: Any, state: Values, parameters: Values) -> Values:
    """(v^2 - |Om x r|^2)/2."""
    x, y, vx, vy = state
    (rate,) = parameters
    return ((vx * vx + vy * vy - rate * rate * (x * x + y * y)) / 2,)


def inertial_moment(t: Any, state: Values, parameters: Values) -> Values:
    """Moment of momentum about the axis in the inertial frame, over the mass."""
    x, y, vx, vy = state
    (rate,) = parameters
    return (x * vy - y * vx + rate * (x * x + y * y),)


LINE_SCENE = free_point(turning_line, (0, 1))


class InertialStraightLine(Case):
    name = "inertial_straight_line"
    title = "Uniform straight motion seen from a rotating frame"
    section = "5.5.2, 5.13"
    conventions = "The axes x, y rotate at Om about the origin; no force acts in the inertial frame."
    x = Coordinate("m", 1)
    y = Coordinate("m", 0)
    vx = Coordinate("m/s", "0.5")
    vy = Coordinate("m/s", 0)
    Om = Parameter("rad/s", 2, "rate of rotation of the frame", typical(-5, 5))
    exact_motion = bind(StraightLine)
    default_span = Span(10.37, "turn")
    quantity_names = ("closest_distance",)
    variants = (
        Variant(
            "turns_1e5",
            "100,000 turns: centrifugal and Coriolis force cancel to a straight line in space",
            span="314172.1",
        ),
        Variant("at_rest", "at rest in space: a circle in the frame, no secular growth", initial_state=(1, 0, 0, -2)),
        Variant("slow_frame", "Om = 1e-9: nearly an inertial frame", {"Om": "1e-9"}, span=10),
    )
    invariants = conserved(jacobi=line_jacobi, inertial_moment=inertial_moment)
    forms = (SemiLinear(turning_line, linear=turning_line_matrix, rest=no_force),)
    scene = LINE_SCENE
    reversal = ("vx", "vy", "Om")

    @property
    def time_scale(self) -> float:
        """One radian of the frame's rotation."""
        rate = abs(float(self.Om))
        return 1 / rate if rate else 1.0
