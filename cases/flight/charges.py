"""A charge in uniform electric and magnetic fields, slow and relativistic.

Cases: charge_in_E_and_B, relativistic_charge.
"""

from dataclasses import replace

from gnomon.cases.declare import *
from gnomon.cases.scenes.point import SPACE, free_point
from gnomon.reference.flight.gyration import Charge
from gnomon.reference.flight.relativistic_charge import RelativisticCharge

TURNS = 10.37 * 2 * pi


def uniform_fields(t: Any, place: Values, parameters: Values) -> Values:
    """(q/m) E and (q/m) B, constant in space and time."""
    q_m, ex, ey, ez, bx, by, bz = parameters
    return q_m * ex, q_m * ey, q_m * ez, q_m * bx, q_m * by, q_m * bz


def lorentz_equations(t: Any, state: Values, parameters: Values) -> Values:
    """r'' = (q/m) (E + v x B)."""
    _x, _y, _z, vx, vy, vz = state
    q_m, ex, ey, ez, bx, by, bz = parameters
    return (
        vx,
        vy,
        vz,
        q_m * (ex + vy * bz - vz * by),
        q_m * (ey + vz * bx - vx * bz),
        q_m * (ez + vx * by - vy * bx),
    )


def charge_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Kinetic and potential energy over the mass."""
    x, y, z, vx, vy, vz = state
    q_m, ex, ey, ez, _bx, _by, _bz = parameters
    return ((vx * vx + vy * vy + vz * vz) / 2 - q_m * (ex * x + ey * y + ez * z),)


def parallel_momentum(t: Any, state: Values, parameters: Values) -> Values:
    """v.B - (q/m) E.B t, constant: along the magnetic field only E acts."""
    _x, _y, _z, vx, vy, vz = state
    q_m, ex, ey, ez, bx, by, bz = parameters
    return (vx * bx + vy * by + vz * bz - q_m * (ex * bx + ey * by + ez * bz) * t,)


def centre_x(t: Any, state: Values, parameters: Values) -> Values:
    """x-component of v - (q/m) (r x B + E t), from which the guiding centre follows."""
    _x, y, z, vx, _vy, _vz = state
    q_m, ex, _ey, _ez, _bx, by, bz = parameters
    return (vx - q_m * (y * bz - z * by + ex * t),)


def centre_y(t: Any, state: Values, parameters: Values) -> Values:
    x, _y, z, _vx, vy, _vz = state
    q_m, _ex, ey, _ez, bx, _by, bz = parameters
    return (vy - q_m * (z * bx - x * bz + ey * t),)


def centre_z(t: Any, state: Values, parameters: Values) -> Values:
    x, y, _z, _vx, _vy, vz = state
    q_m, _ex, _ey, ez, bx, by, _bz = parameters
    return (vz - q_m * (x * by - y * bx + ez * t),)


def gyration_matrix(parameters: Values) -> Values:
    q_m, _ex, _ey, _ez, bx, by, bz = parameters
    return turning_matrix(q_m * bx, q_m * by, q_m * bz)


def turning_matrix(wx: Any, wy: Any, wz: Any) -> Values:
    """The matrix of r' = v, v' = v x w, row by row."""
    return (
        *(0, 0, 0, 1, 0, 0),
        *(0, 0, 0, 0, 1, 0),
        *(0, 0, 0, 0, 0, 1),
        *(0, 0, 0, 0, wz, -wy),
        *(0, 0, 0, -wz, 0, wx),
        *(0, 0, 0, wy, -wx, 0),
    )


def electric_push(t: Any, state: Values, parameters: Values) -> Values:
    q_m, ex, ey, ez, _bx, _by, _bz = parameters
    return 0, 0, 0, q_m * ex, q_m * ey, q_m * ez


SCENE = free_point(lorentz_equations, SPACE, fields=uniform_fields)


class ChargeInFields(Case):
    name = "charge_in_E_and_B"
    title = "Charge in uniform E and B: gyration, E x B drift, acceleration along B"
    section = "6.3.3, 6.8"
    conventions = "q_m = q/m; speeds far below the speed of light."
    x = Coordinate("m", 0)
    y = Coordinate("m", 0)
    z = Coordinate("m", 0)
    vx = Coordinate("m/s", 1, typical(-3, 3))
    vy = Coordinate("m/s", 0, typical(-3, 3))
    vz = Coordinate("m/s", "0.5", typical(-3, 3))
    q_m = Parameter("C/kg", 1, "charge over mass", typical(-3, 3))
    Ex = Parameter("V/m", 1, "electric field along x", typical(-3, 3))
    Ey = Parameter("V/m", 0, "electric field along y", typical(-3, 3))
    Ez = Parameter("V/m", "0.2", "electric field along z", typical(-3, 3))
    Bx = Parameter("T", 0, "magnetic field along x", typical(-3, 3))
    By = Parameter("T", 0, "magnetic field along y", typical(-3, 3))
    Bz = Parameter("T", 5, "magnetic field along z", typical(-3, 3))
    exact_motion = bind(Charge, position="x y z", velocity="vx vy vz", electric="Ex Ey Ez", magnetic="Bx By Bz")
    variants = (
        Variant(
            "oblique", "fields and velocity not in one plane", {"Ey": 2, "Bx": 1, "By": -3}, (1, 2, 3, 1, "0.3", -1)
        ),
        Variant(
            "strong_field",
            "B = 1e5 T: a step that suits the drift spans thousands of gyrations",
            {"Bz": 10**5},
            span="0.6317",
        ),
        Variant("weak_drift", "the drift is 1e-5 of the gyration", {"Ex": "5e-5", "Ez": 0}, span="125.7"),
        Variant("weak_field", "B = 1e-9 T: nearly a parabola, the textbook formula cancels", {"Bz": "1e-9"}, span=10),
        Variant("no_field", "B = 0: exactly a parabola", {"Bz": 0}, span=10),
        Variant("long_1e5", "100,000 gyrations: phase error", {"Ez": 0}, span="125664.37"),
        Variant("engines", "the parameters of engine tests, 5 s", span=5),
    )
    invariants = conserved(
        energy=charge_energy,
        parallel_momentum=parallel_momentum,
        centre_x=centre_x,
        centre_y=centre_y,
        centre_z=centre_z,
    )
    forms = (
        Charged(lorentz_equations, fields=uniform_fields),
        SemiLinear(lorentz_equations, linear=gyration_matrix, rest=electric_push),
    )
    scene = SCENE
    reversal = ("vx", "vy", "vz", "Bx", "By", "Bz")
    mirror = ("x", "y", "z", "vx", "vy", "vz", "Ex", "Ey", "Ez")
    alike = tuple((axis, f"v{axis}", f"E{axis}", f"B{axis}") for axis in "xyz")

    @property
    def time_scale(self) -> float:
        """One radian of the gyration, or the time in which E changes the velocity if that is shorter."""
        q_m, ex, ey, ez, *_ = map(float, self.parameter_values())
        force = abs(q_m) * hypot(ex, ey, ez)
        speed = hypot(*map(float, self.initial_state[3:]))
        times = [1 / float(self.exact_motion.gyration_rate())] if self.exact_motion.gyration_rate() else []
        return min(times + ([speed / force] if speed and force else [])) if times or (force and speed) else 1.0

    def natural_span(self) -> Number:
        """10.37 gyrations; ten time scales without a magnetic field."""
        rate = float(self.exact_motion.gyration_rate())
        return TURNS / rate if rate else 10 * self.time_scale

    @property
    def quantity_names(self) -> tuple[str, ...]:
        gyrates = bool(self.exact_motion.gyration_rate())
        return (
            "gyration_rate",
            *(("gyration_period", "gyroradius", "drift_x drift_y drift_z=drift") if gyrates else ()),
        )


def relativistic_fields(t: Any, place: Values, parameters: Values) -> Values:
    """(q/m) E and (q/m) B, q over the rest mass."""
    q_m, _c, ex, ey, ez, bx, by, bz = parameters
    return q_m * ex, q_m * ey, q_m * ez, q_m * bx, q_m * by, q_m * bz


def speed_of_light(parameters: Values) -> Values:
    return (parameters[1],)


def relativistic_equations(t: Any, state: Values, parameters: Values) -> Values:
    """r' = u/gamma, u' = (q/m) (E + u x B/gamma), gamma = sqrt(1 + u^2/c^2)."""
    _x, _y, _z, ux, uy, uz = state
    q_m, c, ex, ey, ez, bx, by, bz = parameters
    gamma = sqrt(1 + (ux * ux + uy * uy + uz * uz) / (c * c))
    vx, vy, vz = ux / gamma, uy / gamma, uz / gamma
    return (
        vx,
        vy,
        vz,
        q_m * (ex + vy * bz - vz * by),
        q_m * (ey + vz * bx - vx * bz),
        q_m * (ez + vx * by - vy * bx),
    )


def relativistic_energy(t: Any, state: Values, parameters: Values) -> Values:
    """gamma c^2 - (q/m) E.r: energy over the mass."""
    x, y, z, ux, uy, uz = state
    q_m, c, ex, ey, ez, _bx, _by, _bz = parameters
    return (c * sqrt(c * c + ux * ux + uy * uy + uz * uz) - q_m * (ex * x + ey * y + ez * z),)


def relativistic_centre_x(t: Any, state: Values, parameters: Values) -> Values:
    """x-component of u - (q/m) (r x B + E t)."""
    _x, y, z, ux, _uy, _uz = state
    q_m, _c, ex, _ey, _ez, _bx, by, bz = parameters
    return (ux - q_m * (y * bz - z * by + ex * t),)


def relativistic_centre_y(t: Any, state: Values, parameters: Values) -> Values:
    x, _y, z, _ux, uy, _uz = state
    q_m, _c, _ex, ey, _ez, bx, _by, bz = parameters
    return (uy - q_m * (z * bx - x * bz + ey * t),)


def relativistic_centre_z(t: Any, state: Values, parameters: Values) -> Values:
    x, y, _z, _ux, _uy, uz = state
    q_m, _c, _ex, _ey, ez, bx, by, _bz = parameters
    return (uz - q_m * (x * by - y * bx + ez * t),)


def newtonian_push(t: float, state: Values, parameters: Values) -> Values:
    """The same as an acceleration from position and velocity: v' = (q/m) (E + v x B - v (v.E)/c^2)/gamma."""
    _x, _y, _z, vx, vy, vz = state
    q_m, c, ex, ey, ez, bx, by, bz = parameters
    share = q_m * sqrt(1 - (vx * vx + vy * vy + vz * vz) / (c * c))
    power = (vx * ex + vy * ey + vz * ez) / (c * c)
    return (
        vx,
        vy,
        vz,
        share * (ex + vy * bz - vz * by - vx * power),
        share * (ey + vz * bx - vx * bz - vy * power),
        share * (ez + vx * by - vy * bx - vz * power),
    )


def newtonian_scene() -> SceneForm:
    """A Newtonian point, as engines have it, under a force with which it moves like the relativistic charge."""
    plain = free_point(newtonian_push, SPACE)

    def build(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
        gamma = sqrt(1 + sum(u * u for u in state[3:]) / parameters[1] ** 2)
        return plain.build((*state[:3], *(u / gamma for u in state[3:])), parameters)

    def observe(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
        x, y, z, vx, vy, vz = plain.observe(readings, parameters)
        gamma = 1 / sqrt(1 - (vx * vx + vy * vy + vz * vz) / parameters[1] ** 2)
        return x, y, z, gamma * vx, gamma * vy, gamma * vz

    return replace(plain, build=build, observe=observe)


SLOW_SCENE, FAST_SCENE = newtonian_scene(), free_point(relativistic_equations, SPACE, "relativistic_mass")
"""The second uses proper velocities: close to the speed of light the velocity does not determine the momentum well."""
NEWTONIAN_GAMMA = 2.0
LIGHT = 299792458


class RelativisticChargeCase(Case):
    name = "relativistic_charge"
    title = "Relativistic charge in uniform E and B of any directions, by proper time"
    section = "6.3.2, 6.3.3, 6.8"
    conventions = "u = gamma v is the proper velocity; q_m = q/m, m the rest mass; no radiation."
    x = Coordinate("m", 0, typical(-3, 3))
    y = Coordinate("m", 0, typical(-3, 3))
    z = Coordinate("m", 0, typical(-3, 3))
    ux = Coordinate("m/s", LIGHT, typical(-3, 3))
    uy = Coordinate("m/s", 0, typical(-3, 3))
    uz = Coordinate("m/s", LIGHT // 2, typical(-3, 3))
    q_m = Parameter("C/kg", "1.7588e11", "charge over rest mass: an electron's, positive", typical(-2, 2))
    c = Parameter("m/s", LIGHT, "speed of light", positive(0.5, 5))
    Ex = Parameter("V/m", 100000, "electric field along x", typical(-2, 2))
    Ey = Parameter("V/m", 0, "electric field along y", typical(-2, 2))
    Ez = Parameter("V/m", 20000, "electric field along z", typical(-2, 2))
    Bx = Parameter("T", 0, "magnetic field along x", typical(-2, 2))
    By = Parameter("T", 0, "magnetic field along y", typical(-2, 2))
    Bz = Parameter("T", "0.01", "magnetic field along z", typical(-2, 2))
    exact_motion = bind(
        RelativisticCharge, electric="Ex Ey Ez", magnetic="Bx By Bz", position="x y z", proper="ux uy uz"
    )
    variants = (
        Variant("gamma_1e6", "gamma = 1e6: speed and c differ in the 13th digit", {}, (0, 0, 0, LIGHT * 10**6, 0, 0)),
        Variant(
            "null_field",
            "exactly E = cB, perpendicular: neither drift nor hyperbola, but powers of proper time",
            {"Ex": 0, "Ey": Fraction(LIGHT, 128), "Ez": 0, "Bz": Fraction(1, 128)},
            (0, 0, 0, 0, 0, 0),
            "2e-7",
        ),
        Variant(
            "runaway",
            "E > cB: the energy grows without bound",
            {"Ex": 10**7, "Bz": "0.001"},
            (0, 0, 0, 0, 0, 0),
            "1e-6",
        ),
        Variant("electric", "no magnetic field: hyperbolic motion", {"Bz": 0}, span="1e-6"),
        Variant("magnetic", "no electric field: gyration at qB/(gamma m)", {"Ex": 0, "Ez": 0}),
        Variant(
            "slow",
            "far below the speed of light: gamma - 1 = 5e-13",
            {"Ex": 1, "Ez": 0},
            (0, 0, 0, 300, 0, 0),
        ),
        Variant("oblique", "fields and velocity not in one plane", {"Ey": 10**6, "Bx": "0.02", "By": "-0.01"}),
    )
    invariants = conserved(
        energy=relativistic_energy,
        centre_x=relativistic_centre_x,
        centre_y=relativistic_centre_y,
        centre_z=relativistic_centre_z,
    )
    forms = (Charged(relativistic_equations, fields=relativistic_fields, light=speed_of_light),)
    reversal = ("ux", "uy", "uz", "Bx", "By", "Bz")

    @property
    def scene(self) -> SceneForm:
        return SLOW_SCENE if float(self.exact_motion.largest_gamma(self.span)) < NEWTONIAN_GAMMA else FAST_SCENE

    @property
    def time_scale(self) -> float:
        """gamma over (q/m) (|B| + |E|/c): the time in which the fields change the velocity."""
        q_m, c, ex, ey, ez, bx, by, bz = map(float, self.parameter_values())
        rate = abs(q_m) * (hypot(bx, by, bz) + hypot(ex, ey, ez) / c)
        return float(self.exact_motion.gamma()) / rate if rate else 1.0

    def natural_span(self) -> Number:
        """10.37 gyrations if B is larger than E/c, else ten time scales."""
        _q_m, c, ex, ey, ez, bx, by, bz = map(float, self.parameter_values())
        weak = 2 * hypot(ex, ey, ez) < c * hypot(bx, by, bz)
        return (TURNS if weak else 10) * self.time_scale

    def derived(self, digits: int) -> dict[str, Any]:
        """`proper_time`: the time of the charge's own clock at the end of the span (s).

        At the start, if it moves: the tangential acceleration F_t/(m gamma^3), the radius of curvature gamma m v^2/F_n.
        `field_square` E^2 - c^2 B^2 and `field_product` E.B are the same in every frame.
        """
        motion, moves = self.exact_motion, any(self.exact_motion.proper)
        square, product = motion.field_invariants()
        return {
            "gamma": motion.gamma(digits),
            "proper_time": motion.proper_time(self.span, digits),
            "field_square": square,
            "field_product": product,
            "tangential_acceleration": motion.tangential_acceleration(digits) if moves else None,
            "curvature_radius": motion.curvature_radius(digits) if moves else None,
        }
