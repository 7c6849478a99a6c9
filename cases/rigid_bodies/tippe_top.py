"""The tippe top: an eccentric sphere that glides on a plane with friction, and turns upside down if it spins fast."""

from gnomon.cases.declare import *
from gnomon.reference.numerics.precision import publish, working

Vector3 = tuple[Any, Any, Any]


def turned_axis(state: Values) -> Vector3:
    """e' = w x e."""
    wx, wy, wz, ex, ey, ez, _vx, _vy = state
    return wy * ez - wz * ey, wz * ex - wx * ez, wx * ey - wy * ex


def excess_spin(state: Values, parameters: Values) -> Any:
    """s = (I3/I1 - 1) (w.e)/(e.e): the angular momentum is I1 (w + s e)."""
    wx, wy, wz, ex, ey, ez, _vx, _vy = state
    _m, _R, I1, I3, _mu, _g = parameters
    return (I3 / I1 - 1) * (wx * ex + wy * ey + wz * ez) / (ex * ex + ey * ey + ez * ez)


def glide(state: Values, turned: Vector3, parameters: Values) -> tuple[Any, Any]:
    """The horizontal velocity of the point of contact, which is at R (e - z) from the centre of mass."""
    wx, wy, _wz, _ex, _ey, _ez, vx, vy = state
    R = parameters[1]
    return vx + R * (turned[0] - wy), vy + R * (turned[1] + wx)


def tippe_equations(t: Any, state: Values, parameters: Values) -> Values:
    """The plane presses with m n and drags with -mu m n times the velocity of gliding; `lift` is its torque over m n R.

    n follows from the height R (1 - e_z) of the centre of mass: n = g - R e_z''.
    """
    wx, wy, _wz, ex, ey, ez, _vx, _vy = state
    m, R, I1, I3, mu, g = parameters
    ax, ay, az = turned = turned_axis(state)
    spin = excess_spin(state, parameters)
    gx, gy = glide(state, turned, parameters)
    dx, dy, h = mu * gx, mu * gy, ez - 1
    lx, ly, lz = ey + h * dy, -ex - h * dx, ey * dx - ex * dy
    arm = m * R / I1
    press = g - R * ((wx + spin * ex) * ay - (wy + spin * ey) * ax)
    n = press / (1 + (arm * R) * (lx * ey - ly * ex))
    push = arm * n
    # along the axis the torque is lz, with the moment I3: (w.e)' = push (I1/I3) lz
    axial = (1 - I1 / I3) * lz / (ex * ex + ey * ey + ez * ez)
    return (
        push * (lx - axial * ex) - spin * ax,
        push * (ly - axial * ey) - spin * ay,
        push * (lz - axial * ez) - spin * az,
        ax,
        ay,
        az,
        -n * dx,
        -n * dy,
    )


def tippe_energy(t: Any, state: Values, parameters: Values) -> Values:
    wx, wy, wz, ex, ey, ez, vx, vy = state
    m, R, I1, _I3, _mu, g = parameters
    climb = R * turned_axis(state)[2]
    spin = excess_spin(state, parameters)
    rotation = I1 * (wx * wx + wy * wy + wz * wz + spin * (wx * ex + wy * ey + wz * ez))
    return ((m * (vx * vx + vy * vy + climb * climb) + rotation) / 2 + m * g * R * (1 - ez),)


def jellett(t: Any, state: Values, parameters: Values) -> Values:
    """-H.r, r from the centre of mass to the point of contact: constant whatever the friction."""
    wx, wy, wz, ex, ey, ez, _vx, _vy = state
    _m, R, I1, I3, _mu, _g = parameters
    along = wx * ex + wy * ey + wz * ez
    return (R * (I1 * (wz + excess_spin(state, parameters) * ez) - I3 * along),)


def squared_eccentricity(t: Any, state: Values, parameters: Values) -> Values:
    """The square of alpha, the distance of the two centres over the radius."""
    _wx, _wy, _wz, ex, ey, ez, _vx, _vy = state
    return (ex * ex + ey * ey + ez * ez,)


def _is_inside(numbers: Mapping[str, Fraction]) -> bool:
    return 0 < sum(numbers[name] ** 2 for name in ("ex", "ey", "ez")) < 1


def tilted(spin: int) -> tuple[Number, ...]:
    """Spun about the vertical with its axis tilted by 0.0759 rad, alpha = 0.3."""
    return 0, 0, spin, "0.022752", 0, "0.299136", 0, 0


START = tilted(155)


class TippeTop(IntegratedCase):
    """A sphere whose centre of mass is off its centre, spun on a rough plane: it turns its heavy side up."""

    name = "tippe_top"
    title = "Tippe top: an eccentric sphere gliding with friction turns over (certified Taylor)"
    section = "11.2.2"
    conventions = (
        "[inferred] Not in the book: N. Rutstam, SIGMA 8 (2012) 019; S. Rauch-Wojciechowski, N. Rutstam, SIGMA 10 (2014) 017. "
        "A sphere of radius R stays on a horizontal plane; its centre is at R e from its centre of mass, and the axis of its "
        "moments (I3 along it, I1 across) is along e, |e| = alpha. The force of the plane at the point of contact is "
        "N (z - mu v), v its velocity of gliding, N the force that keeps it on the plane, either way. w is the angular "
        "velocity and (vx, vy) the horizontal velocity of the centre of mass, all in the frame of the plane. The numbers are "
        "those of a toy, not published ones. Quantities: the limit of Jellett's integral above which only the inverted spin is "
        "stable, and the start's integral over it (if 1 - alpha < I1/I3 < 1)."
    )
    wx = Coordinate("rad/s", START[0], typical(-20, 20), group="angular velocity")
    wy = Coordinate("rad/s", START[1], typical(-20, 20), group="angular velocity")
    wz = Coordinate("rad/s", START[2], typical(-60, 60), group="angular velocity")
    ex = Coordinate("1", START[3], typical(-0.3, 0.3), group="eccentricity")
    ey = Coordinate("1", START[4], typical(-0.3, 0.3), group="eccentricity")
    ez = Coordinate("1", START[5], typical(0.1, 0.4), group="eccentricity")
    vx = Coordinate("m/s", START[6], typical(-0.2, 0.2), group="velocity")
    vy = Coordinate("m/s", START[7], typical(-0.2, 0.2), group="velocity")
    m = Parameter("kg", "0.02", "mass", positive(0.015, 0.03))
    R = Parameter("m", "0.02", "radius of the sphere", positive(0.015, 0.03))
    I1 = Parameter(
        "kg m^2", "3e-6", "moment of inertia across the axis, about the centre of mass", positive(2e-6, 6e-6)
    )
    I3 = Parameter("kg m^2", "3.2e-6", "moment of inertia about the axis", positive(2e-6, 4e-6))
    mu = Parameter("s/m", 1, "friction over normal force and speed of gliding", nonnegative(0, 2))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(5, 15))
    rules = (
        Rule("the centre of mass is inside the sphere, not at its centre (0 < |e| < 1)", _is_inside),
        Rule("no moment is more than the sum of the two others (I3 <= 2 I1)", lambda n: n["I3"] <= 2 * n["I1"]),
    )
    default_span = "1.2"
    variants = (
        Variant("slow_spin", "below the spin that turns it over: it rights itself", initial_state=tilted(20)),
        Variant(
            "strong_friction",
            "friction thirty times stronger: stiff, gliding decays in 1 ms",
            {"mu": 30},
            span="0.5",
        ),
        Variant(
            "nearly_upright",
            "starts 1e-6 rad from the vertical: that tilt grows two million times until it turns over",
            {"mu": 6},
            (0, 0, 155, "3e-7", 0, "0.3", 0, 0),
            span="1.2",
        ),
        Variant("frictionless", "mu = 0: glides for ever, energy is constant", {"mu": 0}, span=1),
    )
    invariants = conserved(jellett=jellett, squared_eccentricity=squared_eccentricity) | decaying(energy=tippe_energy)
    forms = (FirstOrder(tippe_equations),)
    mirror = ("wx", "wz", "ey", "vy")

    @property
    def time_scale(self) -> float:
        """The time of a radian of the fastest rotation, of a radian on the curved bottom, or in which gliding decays."""
        m, R, I1, I3, mu, g = map(float, self.parameter_values())
        wx, wy, wz, ex, ey, ez, _vx, _vy = map(float, self.initial_state)
        spin, lever = max(1, I3 / I1) * hypot(wx, wy, wz), m * R * R / I1
        return 1 / max(spin, sqrt(m * g * R * hypot(ex, ey, ez) / I1), mu * g * (1 + lever))

    @property
    def reversal(self) -> tuple[str, ...] | None:
        """Friction has a direction of time."""
        return None if self.mu else ("wx", "wy", "wz", "vx", "vy")

    @property
    def hierarchy(self) -> tuple[Level, ...]:
        return (self.level(TippeTop, "no friction: the axis nutates and stays up", mu=0),) if self.mu else ()

    def derived(self, digits: int) -> dict[str, Any]:
        """`jellett_limit`: sqrt(m g R^3 I3 alpha) (1 + alpha)^2 / sqrt(1 + alpha - I1/I3), and the start's integral over it."""
        with working(digits + 10) as mp:
            m, R, I1, I3, _mu, g = map(mp.mpf, self.parameter_values())
            state = tuple(map(mp.mpf, self.initial_state))
            alpha = mp.sqrt(sum(x * x for x in state[3:6]))
            if not 1 - alpha < I1 / I3 < 1:
                return {}
            limit = mp.sqrt(m * g * R**3 * I3 * alpha / (1 + alpha - I1 / I3)) * (1 + alpha) ** 2
            ratio = abs(jellett(0, state, (m, R, I1, I3, 0, g))[0]) / limit
            return dict(zip(("jellett_limit", "jellett_ratio"), publish((limit, ratio), digits), strict=True))
