"""Equations of the systems that are drawn at random (`drawn`): a function or a form for each family.

All random numbers are parameters, so that a family is compiled once. No case of the catalogue has these equations with these
numbers.
"""

from __future__ import annotations

from math import cos, sin, sqrt
from typing import Any

from gnomon.cases.core.forms import Charged, Constrained, Hybrid, Mode, NBody, RigidBody, Transition, Values

Numbers = Any
"""A sequence of scalars of any arithmetic."""


def valley(t: Any, q: Numbers, *p: Any) -> list[Any]:
    """Accelerations in the plane: V = a x^2/2 + b y^2/2 + c x^2 y + d y^3 + (e x^2 + f y^2)^2 / 4."""
    x, y = q
    a, b, c, d, e, f = p
    quartic = e * x * x + f * y * y
    return [
        -a * x - 2 * c * x * y - e * quartic * x,
        -b * y - c * x * x - 3 * d * y * y - f * quartic * y,
    ]


def deep_valley(t: Any, q: Numbers, *p: Any) -> list[Any]:
    """Accelerations in a potential of x, y, z: squares, the terms x^2 y, y^2 z, z^2 x and x y z, and a confining quartic."""
    x, y, z = q
    a, b, c, d, e, f, g, h, k, m = p
    quartic = h * x * x + k * y * y + m * z * z
    return [
        -a * x - 2 * d * x * y - f * z * z - g * y * z - h * quartic * x,
        -b * y - d * x * x - 2 * e * y * z - g * x * z - k * quartic * y,
        -c * z - e * y * y - 2 * f * z * x - g * x * y - m * quartic * z,
    ]


def network(t: Any, q: Numbers, *p: Any) -> list[Any]:
    """Accelerations in the plane of masses that springs join, each with each and each with a post of its own.

    By mass: its mass, the place of its post, the spring to it; by pair: stiffness, length at rest, cubic stiffness.
    """
    count = len(q) // 2
    masses = [p[4 * i] for i in range(count)]
    pulls = [[-p[4 * i + 3] * (q[2 * i + k] - p[4 * i + 1 + k]) for k in range(2)] for i in range(count)]
    springs = iter(p[4 * count :])
    for i in range(count):
        for j in range(i):
            stiffness, rest, cubic = next(springs), next(springs), next(springs)
            dx, dy = q[2 * j] - q[2 * i], q[2 * j + 1] - q[2 * i + 1]
            length = sqrt(dx * dx + dy * dy)
            stretch = length - rest
            force = (stiffness * stretch + cubic * stretch * stretch * stretch) / length
            for k, d in enumerate((dx, dy)):
                pulls[i][k] = pulls[i][k] + force * d
                pulls[j][k] = pulls[j][k] - force * d
    return [pulls[i][k] / masses[i] for i in range(count) for k in range(2)]


def double_pendulum(t: Any, y: Numbers, *p: Any) -> list[Any]:
    """Two masses m and n on massless rods of lengths a and b, with friction c and d in the joints; y has angles, then rates."""
    u, v, w, z = y
    m, n, a, b, c, d, g = p
    turn = sin(u - v)
    beside = cos(u - v)
    first = -n * a * b * turn * z * z - (m + n) * g * a * sin(u) - c * w - d * (w - z)
    second = n * a * b * turn * w * w - n * g * b * sin(v) - d * (z - w)
    own, cross, other = (m + n) * a * a, n * a * b * beside, n * b * b
    whole = own * other - cross * cross
    return [w, z, (other * first - cross * second) / whole, (own * second - cross * first) / whole]


def triple_pendulum(t: Any, y: Numbers, *p: Any) -> list[Any]:
    """Three rods without mass: three masses, three lengths, the friction of each joint, g."""
    angles, rates = y[:3], y[3:]
    masses, lengths, friction, g = p[:3], p[3:6], p[6:9], p[9]
    below = [masses[0] + masses[1] + masses[2], masses[1] + masses[2], masses[2]]
    matrix = [
        [below[max(i, j)] * lengths[i] * lengths[j] * cos(angles[i] - angles[j]) for j in range(3)] for i in range(3)
    ]
    loads = []
    for i in range(3):
        load = -below[i] * g * lengths[i] * sin(angles[i]) - friction[i] * (rates[i] - (rates[i - 1] if i else 0))
        if i < 2:
            load = load - friction[i + 1] * (rates[i] - rates[i + 1])
        for j in range(3):
            if j != i:
                turn = sin(angles[i] - angles[j])
                load = load - below[max(i, j)] * lengths[i] * lengths[j] * turn * rates[j] * rates[j]
        loads.append(load)
    return [*rates, *_solve_three(matrix, loads)]


def _solve_three(a: Any, b: Any) -> list[Any]:
    """The solution of three linear equations by minors."""

    def minor(i: int, j: int) -> Any:
        (r, s), (c, d) = ([k for k in range(3) if k != n] for n in (i, j))
        value = a[r][c] * a[s][d] - a[r][d] * a[s][c]
        return value if (i + j) % 2 == 0 else -value

    minors = [[minor(i, j) for j in range(3)] for i in range(3)]
    whole = a[0][0] * minors[0][0] + a[0][1] * minors[0][1] + a[0][2] * minors[0][2]
    return [(minors[0][i] * b[0] + minors[1][i] * b[1] + minors[2][i] * b[2]) / whole for i in range(3)]


def satellite(t: Any, q: Numbers, mu: Any) -> list[Any]:
    """Accelerations by the gravity mu of a fixed centre at the origin, in the plane or in space."""
    square = sum((x * x for x in q[1:]), q[0] * q[0])
    weight = -mu / (square * sqrt(square))
    return [weight * x for x in q]


def oblate(t: Any, q: Numbers, mu: Any, j2: Any) -> list[Any]:
    """Accelerations about an oblate body of radius 1, whose axis is z."""
    x, y, z = q
    square = x * x + y * y + z * z
    weight = mu / (square * sqrt(square))
    flat = 1.5 * j2 / square
    height = 5 * z * z / square
    return [
        -weight * x * (1 + flat * (1 - height)),
        -weight * y * (1 + flat * (1 - height)),
        -weight * z * (1 + flat * (3 - height)),
    ]


def _masses(p: Values) -> Values:
    return p


def _bodies(state: Values) -> tuple[Values, ...]:
    return tuple(state[k : k + 6] for k in range(0, len(state), 6))


def _state(bodies: tuple[Values, ...]) -> Values:
    return tuple(x for body in bodies for x in body)


ATTRACTING = NBody(_masses, _bodies, _state)
"""Bodies that attract each other; their G m are the parameters."""


def _inertia(p: Values) -> Values:
    return p[0], p[1], p[2]


def _weight(t: Any, state: Values, p: Values) -> Values:
    """The torque in the body of the weight and of a steady field, of force (p[6], p[7], p[8]) at the place p[3:6]."""
    a, b, c = p[3], p[4], p[5]
    r11, r12, r13, r21, r22, r23, r31, r32, r33 = state[3:]
    x = r11 * p[6] + r21 * p[7] + r31 * p[8]
    y = r12 * p[6] + r22 * p[7] + r32 * p[8]
    z = r13 * p[6] + r23 * p[7] + r33 * p[8]
    return b * z - c * y, c * x - a * z, a * y - b * x


HEAVY_TOP = RigidBody(_inertia, _weight)
"""A body that turns about a fixed point in a uniform field; parameters: inertia, centre, force."""


def _fields(t: Any, place: Values, p: Values) -> Values:
    """A confining electric field and a magnetic field that grows across itself, so that it has no sources."""
    x, y, z = place
    a, b, c, e, k, l, m, u, v, w = p  # noqa: E741
    drive = e * cos(k * t)
    return drive - a * x, -b * y, -c * z, l + u * y, m + v * z, 1 + w * x


def _charge(t: Any, state: Values, p: Values) -> Values:
    x, y, z, u, v, w = state
    ax, ay, az, wx, wy, wz = _fields(t, (x, y, z), p)
    return u, v, w, ax + v * wz - w * wy, ay + w * wx - u * wz, az + u * wy - v * wx


CHARGE = Charged(_charge, fields=_fields)


def dashpots(t: Any, y: Numbers, *p: Any) -> list[Any]:
    """Speeds of masses that dashpots join, each with each and each with walls; the first one is driven.

    By mass: the rate to the wall; by pair: the rate, and the ratio of the masses; then force and frequency. The rates of a
    pair act on the difference of two speeds, so that the slow motion is well-conditioned.
    """
    count = len(y)
    rates = [-p[i] * y[i] for i in range(count)]
    pairs = iter(p[count:-2])
    for i in range(count):
        for j in range(i):
            rate, ratio = next(pairs), next(pairs)
            slip = rate * (y[j] - y[i])
            rates[i] = rates[i] + slip
            rates[j] = rates[j] - ratio * slip
    rates[0] = rates[0] + p[-2] * cos(p[-1] * t)
    return rates


def viscous_pendulums(t: Any, y: Numbers, *p: Any) -> list[Any]:
    """Two pendulums in a thick fluid, whose drag grows with the speed, with a spring between them."""
    u, v, w, z = y
    first, second, a, b, c, d, spring, torque, frequency = p
    return [
        w,
        z,
        first * (torque * cos(frequency * t) - a * sin(u) + spring * (v - u) - (1 + c * w * w) * w),
        second * (-b * sin(v) + spring * (u - v) - (1 + d * z * z) * z),
    ]


def relaxation(t: Any, y: Numbers, rate: Any, a: Any, b: Any) -> list[Any]:
    """A mass on a spring whose damper feeds it at small displacements; fast jumps between slow parts."""
    x, v = y
    return [v, rate * ((1 - x * x) * v - a * x + b)]


def stiff_springs(t: Any, q: Numbers, *p: Any) -> list[Any]:
    """Accelerations of a chain between walls, of springs that are stiff and soft in turn; the soft ones are cubic too.

    By mass its mass; by spring its stiffness and cubic stiffness.
    """
    count = len(q)
    ends = [0 * q[0], *q, 0 * q[0]]
    springs = p[count:]
    pulls = []
    for i in range(count + 1):
        stretch = ends[i + 1] - ends[i]
        pulls.append(springs[2 * i] * stretch + springs[2 * i + 1] * stretch * stretch * stretch)
    return [(pulls[i + 1] - pulls[i]) / p[i] for i in range(count)]


def spring_pendulum(t: Any, q: Numbers, stiffness: Any, length: Any, g: Any) -> list[Any]:
    """Accelerations of a mass on a stiff spring, in space."""
    x, y, z = q
    now = sqrt(x * x + y * y + z * z)
    pull = stiffness * (length / now - 1)
    return [pull * x, pull * y, pull * z - g]


def drag(t: Any, y: Numbers, *p: Any) -> list[Any]:
    """A spinning ball in a wind that grows with height: quadratic drag, and a lift across the motion from a spin that fades."""
    _, h, _, u, v, w = y
    g, k, lift, wind, shear, decay = p
    own = u - wind - shear * h
    speed = sqrt(own * own + v * v + w * w)
    turn = lift / (1 + decay * t)
    return [
        u,
        v,
        w,
        -k * speed * own - turn * (v + w / 2),
        -g - k * speed * v + turn * own,
        -k * speed * w + turn * own / 2,
    ]


def long_oscillator(t: Any, q: Numbers, a: Any, b: Any, c: Any) -> list[Any]:
    """The acceleration in V = a x^2/2 + b x^3/3 + c x^4/4."""
    (x,) = q
    return [-x * (a + x * (b + c * x))]


def _moving(t: Any, state: Values, p: Values) -> Values:
    """Two coordinates: a driven spring and a weight."""
    x, _, u, v = state
    k, damping, force, frequency, g = p[:5]
    return u, v, force * cos(frequency * t) - k * x - damping * u, -g - damping * v


def _left(t: Any, state: Values, p: Values) -> Values:
    return (state[0] + p[5],)


def _right(t: Any, state: Values, p: Values) -> Values:
    return (p[5] - state[0],)


def _floor(t: Any, state: Values, p: Values) -> Values:
    return (state[1],)


def _from_wall(t: Any, state: Values, p: Values) -> Values:
    x, y, u, v = state
    return x, y, -p[6] * u, v


def _from_floor(t: Any, state: Values, p: Values) -> Values:
    x, y, u, v = state
    return x, y, p[8] * u, -p[7] * v


def _flies(t: Any, state: Values, p: Values) -> str:
    return "flight"


WALLS = Hybrid(
    (Mode("flight", _moving),),
    _flies,
    (
        Transition("left wall", "flight", _left, -1, _from_wall, "flight"),
        Transition("right wall", "flight", _right, -1, _from_wall, "flight"),
        Transition("floor", "flight", _floor, -1, _from_floor, "flight"),
    ),
    settle=0.0,
)
"""A ball between two walls above a floor; parameters: spring, damping, force, frequency, g, half width, restitution of walls
and floor, share of the speed along the floor that stays."""


def _push(t: Any, state: Values, p: Values) -> Any:
    """The force over the mass without friction; the speed in the state is relative to the belt."""
    k, damping, force, frequency, belt = p[:5]
    return force * cos(frequency * t) - k * state[0] - damping * (state[1] + belt)


def _slides(t: Any, state: Values, p: Values) -> Values:
    return state[1] + p[4], _push(t, state, p) - p[-1] * p[5]


def _sticks(t: Any, state: Values, p: Values) -> Values:
    return p[4] + 0 * state[0], 0 * state[1]


def _slip(t: Any, state: Values, p: Values) -> Values:
    return (state[1],)


def _stops(t: Any, state: Values, p: Values) -> Values:
    return state[0], 0 * state[1]


def _stays(t: Any, state: Values, p: Values) -> Values:
    return state


def _forwards(t: Any, state: Values, p: Values) -> Values:
    return (_push(t, state, p) - p[6],)


def _backwards(t: Any, state: Values, p: Values) -> Values:
    return (_push(t, state, p) + p[6],)


def _choose_mode(t: Any, state: Values, p: Values) -> str:
    push = _push(t, state, p)
    return "forwards" if push > p[6] else "backwards" if push < -p[6] else "sticks"


def _begins(t: Any, state: Values, p: Values) -> str:
    return "forwards" if state[1] > 0 else "backwards" if state[1] < 0 else _choose_mode(t, state, p)


STICK_SLIP = Hybrid(
    (Mode("forwards", _slides, (1.0,)), Mode("backwards", _slides, (-1.0,)), Mode("sticks", _sticks)),
    _begins,
    (
        Transition("stop", "forwards", _slip, -1, _stops, _choose_mode),
        Transition("stop", "backwards", _slip, 1, _stops, _choose_mode),
        Transition("slip forwards", "sticks", _forwards, 1, _stays, "forwards"),
        Transition("slip backwards", "sticks", _backwards, -1, _stays, "backwards"),
    ),
    settle=0.0,
)
"""A driven mass on a spring and a moving belt with dry friction; parameters: spring, damping, force, frequency, speed of the
belt, kinetic and static friction over the mass."""


def _bowl_force(t: Any, q: Values, p: Values) -> Values:
    return 0 * q[0], 0 * q[0], -p[6] + 0 * q[0]


def _bowl(t: Any, q: Values, p: Values) -> Values:
    x, y, z = q
    a, b, c, d, e, f = p[:6]
    return (a * x * x + b * y * y + c * z * z + d * x * x * x * x + e * y * y * z * z + f * x * y,)


def _bowl_gradient(t: Any, q: Values, p: Values) -> Values:
    x, y, z = q
    a, b, c, d, e, f = p[:6]
    return (
        2 * a * x + 4 * d * x * x * x + f * y,
        2 * b * y + 2 * e * y * z * z + f * x,
        2 * c * z + 2 * e * y * y * z,
    )


def _bowl_motion(t: Any, state: Values, p: Values) -> Values:
    """The motion on the surface: the second time derivative of the constraint, which is 0, gives the multiplier."""
    x, y, z, u, v, w = state
    a, b, c, d, e, f, g = p
    gx, gy, gz = _bowl_gradient(t, (x, y, z), p)
    bending = (
        (2 * a + 12 * d * x * x) * u * u
        + (2 * b + 2 * e * z * z) * v * v
        + (2 * c + 2 * e * y * y) * w * w
        + 2 * f * u * v
        + 8 * e * y * z * v * w
    )
    pull = (bending - g * gz) / (gx * gx + gy * gy + gz * gz)
    return u, v, w, -pull * gx, -pull * gy, -g - pull * gz


ON_SURFACE = Constrained(_bowl_motion, force=_bowl_force, constraint=_bowl, gradient=_bowl_gradient)
"""A heavy particle on a closed surface of fourth order; parameters: six of the surface, g."""


def _rod_force(t: Any, q: Values, p: Values) -> Values:
    """Two unit masses in a field that pulls each to the origin with its own stiffness, and a weight."""
    x, y, z, u, v, w = q
    a, b, c, d, g = p
    return -a * x, -a * y, -c * z - g, -b * u, -b * v, -d * w - g


def _rod(t: Any, q: Values, p: Values) -> Values:
    x, y, z, u, v, w = q
    return ((x - u) * (x - u) + (y - v) * (y - v) + (z - w) * (z - w),)


def _rod_gradient(t: Any, q: Values, p: Values) -> Values:
    x, y, z, u, v, w = q
    return 2 * (x - u), 2 * (y - v), 2 * (z - w), 2 * (u - x), 2 * (v - y), 2 * (w - z)


def _rod_motion(t: Any, state: Values, p: Values) -> Values:
    places, rates = state[:6], state[6:]
    force, gradient = _rod_force(t, places, p), _rod_gradient(t, places, p)
    apart = [rates[k] - rates[k + 3] for k in range(3)]
    bending = 2 * (apart[0] * apart[0] + apart[1] * apart[1] + apart[2] * apart[2])
    square = sum((g * g for g in gradient[1:]), gradient[0] * gradient[0])
    pull = (sum((gradient[k] * force[k] for k in range(1, 6)), gradient[0] * force[0]) + bending) / square
    return (*rates, *(force[k] - pull * gradient[k] for k in range(6)))


DUMBBELL = Constrained(_rod_motion, force=_rod_force, constraint=_rod, gradient=_rod_gradient)
"""Two masses on a rod in a field; parameters: two stiffnesses across, two along, g."""
