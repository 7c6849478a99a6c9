"""A fall from a tower on a rotating planet: the fullest model in the hierarchy of falls."""

from gnomon.cases.declare import *
from gnomon.cases.rotating_frames.free_falls_rotating import (
    EARTH,
    LATITUDE,
    FreeFallCentrifugal,
    FreeFallFirstOrder,
    FreeFallRotatingEarth,
)
from gnomon.cases.scenes.point import SPACE, free_point
from gnomon.reference.flight.gyration import strike
from gnomon.reference.rotating_frames.tower_drop import TowerDrop


def tower_fields(t: Any, place: Values, parameters: Values) -> Values:
    """Gravitation and centrifugal acceleration, and twice the rate: v x 2 Om is the Coriolis acceleration."""
    x, y, z = place
    g, radius, rate, lat = parameters
    oy, oz = rate * cos(lat), rate * sin(lat)
    up = radius + z
    square = x * x + y * y + up * up
    pull = rate * rate - g * radius * radius / (square * sqrt(square))
    along = oy * y + oz * up
    return pull * x, pull * y - oy * along, pull * up - oz * along, 0 * g, 2 * oy, 2 * oz


def tower_equations(t: Any, state: Values, parameters: Values) -> Values:
    """r'' = -g R^2 P/|P|^3 - 2 Om x r' - Om x (Om x P), P = r + R up."""
    x, y, z, vx, vy, vz = state
    ax, ay, az, _wx, wy, wz = tower_fields(t, (x, y, z), parameters)
    return vx, vy, vz, ax + vy * wz - vz * wy, ay - vx * wz, az + vx * wy


def to_inertial_frame(state: Values, parameters: Values) -> Values:
    """Position from the planet's centre and velocity relative to the fixed stars, along the present x, y and z."""
    x, y, z, vx, vy, vz = state
    _g, radius, rate, lat = parameters
    oy, oz = rate * cos(lat), rate * sin(lat)
    up = radius + z
    return x, y, up, vx + oy * up - oz * y, vy + oz * x, vz - oy * x


def orbit_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy in the inertial frame, per unit mass."""
    x, y, up, vx, vy, vz = to_inertial_frame(state, parameters)
    g, radius, _rate, _lat = parameters
    return ((vx * vx + vy * vy + vz * vz) / 2 - g * radius * radius / sqrt(x * x + y * y + up * up),)


def orbit_momentum(t: Any, state: Values, parameters: Values) -> Values:
    """Square of the angular momentum per unit mass about the centre, in the inertial frame."""
    x, y, up, vx, vy, vz = to_inertial_frame(state, parameters)
    east, north, upward = y * vz - up * vy, up * vx - x * vz, x * vy - y * vx
    return (east * east + north * north + upward * upward,)


def orbit_axial_momentum(t: Any, state: Values, parameters: Values) -> Values:
    """Angular momentum per unit mass about the planet's axis, in the inertial frame."""
    x, y, up, vx, vy, vz = to_inertial_frame(state, parameters)
    lat = parameters[3]
    return (cos(lat) * (up * vx - x * vz) + sin(lat) * (x * vy - y * vx),)


def _bound(n: Mapping[str, Fraction]) -> bool:
    return bool(n["z"] > -n["R"] and TowerFall.motion_of(n).bound)


SCENE = free_point(tower_equations, SPACE)


class TowerFall(Case):
    name = "tower_drop"
    title = "Fall from a tower on a rotating planet, inverse-square gravitation"
    section = "6.16"
    conventions = (
        "x east, y north, z up from the tower's foot, at R from the centre of a spherical planet; g is gravitation alone, at "
        "the foot. The eastward coordinate has its own scale. The ground is not part of the motion."
    )
    x = Coordinate("m", 0, typical(-2, 2), group="eastward")
    y = Coordinate("m", 0, typical(-2, 2))
    z = Coordinate("m", "158.5", typical(0.5, 3))
    vx = Coordinate("m/s", 0, typical(-2, 2), group="eastward velocity")
    vy = Coordinate("m/s", 0, typical(-2, 2))
    vz = Coordinate("m/s", 0, typical(-2, 2))
    g = Parameter("m/s^2", "9.825", "gravitation at the foot", positive(1, 10))
    R = Parameter("m", 6_371_000, "distance of the foot from the centre", positive(10, 100))
    Om = Parameter("rad/s", EARTH, "rate of rotation of the planet", typical(0.01, 0.2))
    lat = Parameter("rad", LATITUDE, "latitude", Range(-pi / 2, pi / 2, typical=(-1.5, 1.5)))
    rules = (Rule("the start is above the centre, its speed below the escape speed", _bound),)
    exact_motion = bind(TowerDrop, position="x y z", velocity="vx vy vz")
    default_span = Span(1, "time scale")
    variants = (
        Variant(
            "high", "from 1000 km: gravity changes by a third during the fall", initial_state=(0, 0, 10**6, 0, 0, 0)
        ),
        Variant(
            "elevator",
            "released at 30,000 km above the equator: an orbit that does not meet the planet",
            {"lat": 0},
            (0, 0, 3 * 10**7, 0, 0, 0),
            86400,
        ),
        Variant("thrown", "thrown north at 2 km/s", initial_state=(0, 0, 0, 0, 1500, 1500)),
        Variant("still_planet", "Om = 0: straight down, two components that stay exactly zero", {"Om": 0}),
        Variant("small_drop", "from 1 mm: a deflection of 4e-10 m", initial_state=(0, 0, "1e-3", 0, 0, 0)),
    )
    invariants = conserved(energy=orbit_energy, momentum_squared=orbit_momentum, axial_momentum=orbit_axial_momentum)
    forms = (Charged(tower_equations, fields=tower_fields),)
    scene = SCENE
    reversal = ("vx", "vy", "vz", "Om")

    @property
    def time_scale(self) -> float:
        """The time of the fall or of the throw, at most the time of a radian of the orbit or of the rotation."""
        g, radius, rate, _lat = map(float, self.parameter_values())
        z, speed = abs(float(self.z)), hypot(*map(float, self.initial_state[3:]))
        return min(max(sqrt(2 * z / g), speed / g) or 1.0, sqrt(radius / g), 1 / abs(rate or 1e-300))

    def derived(self, digits: int) -> dict[str, Any]:
        """For a drop from rest: the time and place at which it reaches z = 0."""
        g, radius, _rate, _lat = map(float, self.parameter_values())
        z = float(self.z)
        if any(self.initial_state[3:]) or not 0 < z < radius / 5:
            return {}
        numbers = strike(self.exact_motion, sqrt(2 * z / g) * (1 + z / radius), digits)
        return dict(zip(("fall_time", "east_deflection", "north_deflection"), numbers, strict=True))

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        """Levels without the centrifugal force have the apparent gravity at the foot, without its small southward part."""
        g, radius, rate, lat = self.parameter_values()
        x, y, z, *thrown = self.initial_state
        weight = float(g) - float(rate) ** 2 * float(radius) * cos(float(lat)) ** 2
        turning: dict[str, Any] = {"initial_state": self.initial_state, "span": self.span, "g": weight, "lat": lat}
        drift: dict[str, Any] = dict(zip(("ux", "uy", "uz"), thrown, strict=True))
        lifted: dict[str, Any] = {"initial_state": (x, y, z + radius, *thrown), "span": self.span}

        def lowered(states: Floats) -> Floats:
            return states - [0.0, 0.0, float(radius), 0.0, 0.0, 0.0]  # from the centre to the foot of the tower

        return (
            Level(FreeFallRotatingEarth(Om=0, **turning), same, "gravity on a planet at rest"),
            Level(
                FreeFallFirstOrder(Om=rate, **turning, **drift),
                same,
                "the Coriolis force of the unperturbed velocity",
            ),
            Level(FreeFallRotatingEarth(Om=rate, **turning), same, "the Coriolis force, exactly"),
            Level(
                FreeFallCentrifugal(g=g, Om=rate, lat=lat, **lifted),
                lowered,
                "the centrifugal force, which varies with position",
            ),
        )
