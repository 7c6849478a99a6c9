"""The gyrocompass at any angle: with damping in the horizontal plane, and with its axis free to tilt.

Cases: gyrocompass_damped_nonlinear, gyrocompass_tilting.
"""

import numpy as np
from gnomon.cases.declare import *
from gnomon.cases.rigid_bodies.gyrocompass import Gyrocompass, compass_jacobi
from gnomon.cases.rigid_bodies.gyrocompass_damped import GyrocompassDamped
from gnomon.cases.scenes.hinge import hinged_point
from gnomon.reference.numerics.precision import publish, working


def damped_at_any_angle(t: Any, state: Values, parameters: Values) -> Values:
    theta, omega = state
    across, along, spin, earth, cosine, c = parameters
    rate = earth * cosine
    pull, lift = along * spin * rate / across, rate * rate
    return omega, lift * sin(theta) * cos(theta) - pull * sin(theta) - c * omega / across


def damped_jacobi(t: Any, state: Values, parameters: Values) -> Values:
    """Jacobi's integral over A; damping reduces it."""
    return compass_jacobi(t, state, parameters[:5])


def tilting_equations(t: Any, state: Values, parameters: Values) -> Values:
    """Lagrange's equations of azimuth and tilt, the spin eliminated by Routh's method.

    w1, w2, w3: rates of the frame of the spin axis along it, horizontally to its left, and along the upward normal.
    """
    theta, beta, turn, tip = state
    across, along, spin, earth, lat, weight = parameters
    north, up = earth * cos(lat), earth * sin(lat)
    s, c, sb, cb = sin(theta), cos(theta), sin(beta), cos(beta)
    w1 = turn * sb + north * cb * c + up * sb
    w2 = -tip - north * s
    w3 = turn * cb - north * sb * c + up * cb
    gyro = along * spin / across
    w3_rate = (w3 * sb * tip - gyro * cb * tip - north * w2 * c + north * w3 * sb * s - gyro * north * cb * s) / cb
    turn_rate = (w3_rate + turn * tip * sb + north * (tip * cb * c - turn * sb * s) + up * tip * sb) / cb
    tip_rate = -north * c * turn - w3 * w1 + gyro * w3 - weight * sb / across
    return turn, tip, turn_rate, tip_rate


def tilting_jacobi(t: Any, state: Values, parameters: Values) -> Values:
    """Jacobi's integral, zero with the axis horizontal and pointing north."""
    theta, beta, turn, tip = state
    across, along, spin, earth, lat, weight = parameters
    north, up = earth * cos(lat), earth * sin(lat)
    s, c, sb, cb = sin(theta), cos(theta), sin(beta), cos(beta)
    lifted = up * cb - north * sb * c
    carried = across * (north * north * s * s + lifted * lifted) / 2 + along * spin * (north * cb * c + up * sb)
    return (across * (tip * tip + turn * turn * cb * cb) / 2 - carried - weight * cb,)


def relative_spin(theta: float, beta: float, parameters: Values) -> float:
    """The rotor's axial rate relative to the Earth (rad/s)."""
    _across, _along, spin, earth, lat, _weight = parameters
    return float(spin - earth * (cos(lat) * cos(beta) * cos(theta) + sin(lat) * sin(beta)))


def tilting_scene(state: Values, parameters: Values) -> Scene:
    """The rotor in its two gimbals in the frame of the Earth; separate tokens state the Earth's rotation."""
    theta, beta, turn, tip = state
    across, along, *_ = parameters
    axial = relative_spin(theta, beta, parameters) - turn * sin(beta)
    attitude = (
        sin(theta / 2) * sin(beta / 2),
        -cos(theta / 2) * sin(beta / 2),
        sin(theta / 2) * cos(beta / 2),
        cos(theta / 2) * cos(beta / 2),
    )
    rates = (
        tip * sin(theta) + axial * cos(theta) * cos(beta),
        axial * sin(theta) * cos(beta) - tip * cos(theta),
        turn + axial * sin(beta),
    )
    rotor = Body("rotor", 1.0, (along, across, across), quaternion=attitude, angular_velocity=rates)
    return Scene((0.0, 0.0, 0.0), (rotor,))


def tilting_reading(readings: Readings, parameters: Values) -> Values:
    _, (x, y, z, w), _, (wx, wy, wz) = readings.bodies["rotor"]
    ax, ay, az = 1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)
    level = sqrt(ax * ax + ay * ay)
    theta, beta = atan2(ay, ax), atan2(az, level)
    turn = (wz - relative_spin(theta, beta, parameters) * az) / (level * level)
    return theta, beta, turn, (wx * ay - wy * ax) / level


DAMPED_SCENE = hinged_point(damped_at_any_angle)
TILTING_SCENE = SceneForm(
    tilting_scene, tilting_reading, frozenset({"ball_joint", "driven_frame", "gyroscopic"}), conservative=False
)


class GyrocompassDampedNonlinear(IntegratedCase):
    name = "gyrocompass_damped_nonlinear"
    title = "Gyrocompass with viscous damping at any angle (certified Taylor)"
    section = "11.12.3"
    conventions = "As gyrocompass, its axis held in the horizontal plane, with the damping torque -c theta'."
    theta = Coordinate("rad", 2, typical(-3, 3))
    omega = Coordinate("rad/s", 0, typical(-0.5, 0.5))
    A = Parameter("kg m^2", "0.08", "transverse moment, gimbal included", positive(0.1, 1))
    C = Parameter("kg m^2", "0.1", "axial moment", positive(0.1, 1))
    s = Parameter("rad/s", 1000, "axial spin", typical(1, 20))
    Om = Parameter("rad/s", "7.292115e-5", "rate of the Earth", typical(0.1, 3))
    coslat = Parameter("1", "0.7", "cosine of the latitude", Range(0.0, 1.0, typical=(0.1, 1.0)))
    c = Parameter("N m s", "0.004", "damping constant", nonnegative(0, 2))
    default_span = Span(23.7, "time scale")
    variants = (
        Variant("small", "small angles: almost linear", initial_state=("1e-3", 0)),
        Variant("turning", "turns all round until damping stops that", initial_state=("0.5", 2)),
        Variant(
            "slow_spin",
            "C s = A W/2: settles at 60 degrees from north",
            {"A": "0.1", "C": "0.1", "s": "0.5", "Om": 1, "coslat": 1, "c": "0.02"},
            ("0.3", 0),
        ),
        Variant("overdamped", "approaches north slowly: rates differ by a factor 5e3", {"c": "1.5"}, span="5.7"),
        Variant("unstable", "released 1e-6 rad from south: a long exponential phase", initial_state=(3.1415916535897933, 0)),
    )  # fmt: skip
    invariants = decaying(jacobi=damped_jacobi)
    forms = (FirstOrder(damped_at_any_angle),)
    scene = DAMPED_SCENE

    @property
    def time_scale(self) -> float:
        """The time of a small swing without damping, or of a radian at the initial rate."""
        across, along, spin, earth, cosine, _c = map(float, self.parameter_values())
        rate = earth * cosine
        return 1 / max(sqrt(abs(along * spin * rate) / across + rate * rate), abs(float(self.omega)), 1e-3)

    @property
    def fastest_time(self) -> float:
        damping = float(self.c / self.A)
        return min(self.time_scale, 1 / damping) if damping else self.time_scale

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        if not GyrocompassDamped.domain.admits(self.numbers):
            return ()
        undamped = "any angle and the square of the Earth's rate, undamped"
        return self.level(GyrocompassDamped, "small angles, damped"), self.level(Gyrocompass, undamped)


class GyrocompassTilting(IntegratedCase):
    name = "gyrocompass_tilting"
    title = "Gyrocompass whose axis is free to tilt, with a weight that levels it (certified Taylor)"
    section = "11.12.3"
    conventions = (
        "[inferred] theta from true north to the spin axis, positive to the west, beta its tilt above the horizontal; the "
        "gimbals have no mass except a weight below the axis, with torque -K sin(beta). s is the conserved total axial "
        "spin; A the transverse moment."
    )
    theta = Coordinate("rad", "0.5", typical(-1, 1))
    beta = Coordinate("rad", 0, Range(-pi / 2, pi / 2, True, True, (-0.3, 0.3)))
    turn = Coordinate("rad/s", 0, typical(-0.2, 0.2))
    tip = Coordinate("rad/s", 0, typical(-0.2, 0.2))
    A = Parameter("kg m^2", "0.08", "transverse moment", positive(0.05, 0.2))
    C = Parameter("kg m^2", "0.1", "axial moment", positive(0.05, 0.2))
    s = Parameter("rad/s", 6, "axial spin", typical(4, 8))
    Om = Parameter("rad/s", "0.5", "rate of the Earth, or of a turntable", typical(0.1, 1))
    lat = Parameter("rad", "0.8", "latitude", Range(-pi / 2, pi / 2, typical=(-1.0, 1.0)))
    K = Parameter("N m", 1, "weight times its distance below the axis", nonnegative(0.5, 2))
    default_span = Span(94.7, "time scale")
    variants = (
        Variant(
            "held", "K = 400 N m: hardly tilts, almost the compass in the horizontal plane", {"K": 400}, span="1.3"
        ),
        Variant("fast_spin", "nutation 246 times faster than the swing about north", {"s": 100}, span="0.93"),
        Variant("no_weight", "K = 0: the axis keeps its direction in space", {"K": 0}),
        Variant("high", "released 1 rad above the horizontal", initial_state=("0.5", 1, 0, 0)),
    )
    invariants = conserved(jacobi=tilting_jacobi)
    forms = (FirstOrder(tilting_equations),)
    scene = TILTING_SCENE
    reversal = ("turn", "tip", "s", "Om")

    @property
    def time_scale(self) -> float:
        """The time of a radian of the nutation, whose rate is C s/A, or of the tilt due to the weight."""
        across, along, spin, earth, _lat, weight = map(float, self.parameter_values())
        return 1 / (abs(along * spin) / across + sqrt(weight / across) + abs(earth) + 1e-3)

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """`level_tilt`: the tilt of the axis in equilibrium, pointing north (rad). It solves

        C s Om sin(lat - beta) = K sin(beta) + A Om^2 sin(lat - beta) cos(lat - beta).
        """
        with working(digits + 10) as mp:
            across, along, spin, earth, lat, weight = map(mp.mpf, self.parameter_values())

            def torque(beta: Any) -> Any:
                off = lat - beta
                return earth * mp.sin(off) * (along * spin - across * earth * mp.cos(off)) - weight * mp.sin(beta)

            quantities = {"nutation_rate": along * abs(spin) / across}
            if torque(mp.zero) * torque(lat) < 0:
                quantities["level_tilt"] = mp.findroot(torque, (mp.zero, lat), solver="illinois")
            return dict(zip(quantities, publish(quantities.values(), digits), strict=True))

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        """The compass in the horizontal plane, with the double nearest to the cosine of the latitude."""
        theta, _beta, turn, _tip = self.initial_state
        numbers: dict[str, Any] = {name: self.parameters[name] for name in ("A", "C", "s", "Om")}
        plane = Gyrocompass(initial_state=(theta, turn), span=self.span, coslat=cos(float(self.lat)), **numbers)

        def level(states: Floats) -> Floats:
            nothing = np.zeros(len(states))
            return np.stack([states[:, 0], nothing, states[:, 1], nothing], axis=1)

        def raised(planar: Level) -> Level:
            return Level(planar.case, lambda states: level(planar.project(states)), planar.effect)

        return (*map(raised, plane.hierarchy), Level(plane, level, "the axis held in the horizontal plane"))
