"""A thin disc that rolls without slip on a rough horizontal plane."""

from gnomon.cases.declare import *
from gnomon.cases.scenes.attitude import in_body, matrix, quaternion
from gnomon.reference.numerics.precision import publish, working


def disc_equations(t: Any, state: Values, parameters: Values) -> Values:
    """Euler's equations about the point of contact, along the horizontal tangent, the steepest radius and the axle.

    5 theta'' = w2^2 cot(theta) - 6 w2 w3 - 4 (g/a) cos(theta), w2' = theta' (2 w3 - w2 cot(theta)),
    w3' = (2/3) theta' w2; the point of contact moves along the tangent at -a psi', psi' = w3 - w2 cot(theta).
    """
    _x, _y, theta, phi, _psi, w1, w2, w3 = state
    g, a = parameters
    sine, cosine = sin(theta), cos(theta)
    turned = w2 * cosine / sine
    roll = w3 - turned
    return (
        -a * roll * cos(phi),
        -a * roll * sin(phi),
        w1,
        w2 / sine,
        roll,
        (w2 * turned - 6 * w2 * w3 - 4 * g / a * cosine) / 5,
        w1 * (2 * w3 - turned),
        2 * w1 * w2 / 3,
    )


def disc_energy(t: Any, state: Values, parameters: Values) -> Values:
    """Energy over the mass and the squared radius: (5 theta'^2 + w2^2 + 6 w3^2)/8 + (g/a) sin(theta)."""
    _x, _y, theta, _phi, _psi, w1, w2, w3 = state
    g, a = parameters
    return ((5 * w1 * w1 + w2 * w2 + 6 * w3 * w3) / 8 + g / a * sin(theta),)


def _is_kept_off_the_plane(n: Mapping[str, Fraction]) -> bool:
    return n["w2"] != 0 or n["w3"] != 0


def disc_scene(state: Values, parameters: Values) -> Scene:
    """The rim of a thin disc on a plane on which it cannot slip.

    The disc's axes: along the tangent, the steepest radius and the axle, rotated by the roll psi about the axle.
    """
    x, y, theta, phi, psi, w1, w2, w3 = state
    g, a = parameters
    ct, st, cf, sf, cp, sp = cos(theta), sin(theta), cos(phi), sin(phi), cos(psi), sin(psi)
    tangent, radius, axle = (cf, sf, 0.0), (-ct * sf, ct * cf, st), (st * sf, -st * cf, ct)
    spin = tuple(w1 * t + w2 * r + w3 * n for t, r, n in zip(tangent, radius, axle, strict=True))
    # The centre is at a up the steepest radius from the point of contact, which has velocity zero: v = w x a r.
    arm = tuple(a * r for r in radius)
    velocity = (
        spin[1] * arm[2] - spin[2] * arm[1],
        spin[2] * arm[0] - spin[0] * arm[2],
        spin[0] * arm[1] - spin[1] * arm[0],
    )
    first = tuple(cp * t + sp * r for t, r in zip(tangent, radius, strict=True))
    second = tuple(cp * r - sp * t for t, r in zip(tangent, radius, strict=True))
    r = tuple(v for row in zip(first, second, axle, strict=True) for v in row)
    moment = a * a / 4
    disc = Body(
        "disc",
        1.0,
        (moment, moment, 2 * moment),
        (x + arm[0], y + arm[1], arm[2]),
        quaternion(r),
        velocity,
        (spin[0], spin[1], spin[2]),
    )
    return Scene((0.0, 0.0, -g), (disc,), contacts=(Contact("disc", (0.0, 0.0, 1.0)),))


def disc_reading(readings: Readings, parameters: Values) -> Values:
    (x, y, _), attitude, _, spin = readings.bodies["disc"]
    r = matrix(attitude)
    a = parameters[1]
    theta, phi, psi = acos(max(-1.0, min(1.0, r[8]))), atan2(r[2], -r[5]), atan2(r[6], r[7])
    w1, w2, w3 = in_body(r, spin)
    c, s = cos(psi), sin(psi)
    ahead = a * cos(theta)
    return x + ahead * sin(phi), y - ahead * cos(phi), theta, phi, psi, w1 * c - w2 * s, w1 * s + w2 * c, w3


SCENE = SceneForm(disc_scene, disc_reading, frozenset({"disc_contact", "rolling_without_slip"}), conservative=False)


class RollingDisc(IntegratedCase):
    """A disc such as a coin: upright, tilted, rolling in a circle, or spinning about a diameter."""

    name = "rolling_disc"
    title = "Disc that rolls without slip (nonholonomic; certified Taylor)"
    section = "11.2.2"
    conventions = (
        "A uniform thin disc of radius a. theta is the inclination of its plane: pi/2 upright, 0 flat on the ground; phi "
        "the direction of the horizontal tangent, psi the roll. w1 = theta', w2 = phi' sin(theta) and w3 = psi' + "
        "phi' cos(theta) are the angular velocity along the tangent, the steepest radius and the axle; (x, y) is the "
        "point of contact. Energy is constant; phase volume need not be."
    )
    x = Coordinate("m", 0, typical(-2, 2))
    y = Coordinate("m", 0, typical(-2, 2))
    theta = Coordinate("rad", "1.2", Range(low=0.0, high=pi, low_open=True, high_open=True, typical=(0.9, 2.2)))
    phi = Coordinate("rad", 0, typical(-2, 2))
    psi = Coordinate("rad", 0, typical(-2, 2))
    w1 = Coordinate("rad/s", 0, typical(-0.5, 0.5))
    w2 = Coordinate("rad/s", "-1.5", typical(0.5, 3))
    w3 = Coordinate("rad/s", 6, typical(-8, 8))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(5, 15))
    a = Parameter("m", "0.25", "radius of the disc", positive(0.2, 1))
    rules = (
        Rule(
            "the disc rotates or rolls (w2 or w3 is not zero), else it falls flat",
            _is_kept_off_the_plane,
        ),
    )
    variants = (
        Variant(
            "straight_stable",
            "rolls straight, tilted by 1e-6, 1 % above the limit w3^2 = g/(3 a): wobbles slowly, stays upright",
            initial_state=(0, 0, "1.570795", 0, 0, 0, "1e-9", "3.653"),
            span="12.3",
        ),
        Variant(
            "straight_unstable",
            "the same 1 % below the limit: the tilt grows",
            initial_state=(0, 0, "1.570795", 0, 0, 0, "1e-9", "3.581"),
            span="12.3",
        ),
        Variant(
            "straight_slow",
            "rolls straight at half the limit: wobbles to 65 degrees and back",
            initial_state=(0, 0, "1.57", 0, 0, 0, "1e-3", "1.8"),
        ),
        Variant(
            "spinning_stable",
            "spins about a diameter, tilted by 1e-6, 1 % above the limit w2^2 = 4 g/(5 a)",
            initial_state=(0, 0, "1.570795", 0, 0, 0, "5.659", 0),
            span="12.3",
        ),
        Variant(
            "spinning_unstable",
            "spins 1 % below that limit: the tilt grows",
            initial_state=(0, 0, "1.570795", 0, 0, 0, "5.547", 0),
            span="12.3",
        ),
        Variant(
            "circle",
            "a steady circle up to rounding: theta and the rates must not change",
            {"g": 10},
            (0, 0, 1, 0, 0, 0, 2, -6.98999987293042),
        ),
        Variant(
            "nearly_flat",
            "spins 0.02 rad above the ground: a coin shortly before it comes to rest, but without friction",
            initial_state=(0, 0, "0.02", 0, 0, 0, "0.9", "0.01"),
            span="0.23",
        ),
        Variant(
            "grazing",
            "falls with little spin: turns back 0.01 rad above the ground within milliseconds",
            initial_state=(0, 0, "1.2", 0, 0, 0, "0.1", "0.01"),
            span="0.61",
        ),
    )
    invariants = conserved(energy=disc_energy)
    forms = (FirstOrder(disc_equations),)
    scene = SCENE
    reversal = ("w1", "w2", "w3")

    @property
    def time_scale(self) -> float:
        """sqrt(a/g), or the time of a radian of the fastest initial rotation if that is shorter."""
        g, a = map(float, self.parameter_values())
        _x, _y, theta, _phi, _psi, w1, w2, w3 = map(float, self.initial_state)
        heading = w2 / sin(theta)
        return 1 / max(sqrt(g / a), abs(w1), abs(heading), abs(w3 - heading * cos(theta)))

    def natural_span(self) -> Number:
        """3.37 times 2 pi sqrt(a/g): the integration is expensive."""
        return 3.37 * tau * sqrt(float(self.a) / float(self.g))

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """Limits of stability of an upright disc: `rolling_limit` of w3, `spinning_limit` of w2 (rad/s).

        `circle_spin`: the w3 with which the disc, tilted and turning as at the start, would roll in a circle (rad/s).
        """
        with working(digits + 10) as mp:
            g, a = map(mp.mpf, self.parameter_values())
            theta, w2 = mp.mpf(self.theta), mp.mpf(self.w2)
            quantities = {"rolling_limit": mp.sqrt(g / (3 * a)), "spinning_limit": mp.sqrt(4 * g / (5 * a))}
            if w2:
                quantities["circle_spin"] = (w2 * mp.cot(theta) - 4 * g / a * mp.cos(theta) / w2) / 6
            return dict(zip(quantities, publish(quantities.values(), digits), strict=True))
