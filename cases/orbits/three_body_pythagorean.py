"""Burrau's problem: three bodies of masses 3, 4, 5 fall from rest at the corners of a 3-4-5 triangle."""

from itertools import combinations

from gnomon.cases.core import accuracy
from gnomon.cases.declare import *
from gnomon.cases.scenes.two_masses import attracting


def plane_attraction(t: Any, q: Values, parameters: Values) -> Values:
    """r1'' = G m2 (r2 - r1)/|r2 - r1|^3 + G m3 (r3 - r1)/|r3 - r1|^3, and so on, in the plane."""
    x1, y1, x2, y2, x3, y3 = q
    G, m1, m2, m3 = parameters
    ax, ay = x2 - x1, y2 - y1
    bx, by = x3 - x2, y3 - y2
    cx, cy = x1 - x3, y1 - y3
    aa, bb, cc = ax * ax + ay * ay, bx * bx + by * by, cx * cx + cy * cy
    a, b, c = G / (aa * sqrt(aa)), G / (bb * sqrt(bb)), G / (cc * sqrt(cc))
    return (
        a * m2 * ax - c * m3 * cx,
        a * m2 * ay - c * m3 * cy,
        b * m3 * bx - a * m1 * ax,
        b * m3 * by - a * m1 * ay,
        c * m1 * cx - b * m2 * bx,
        c * m1 * cy - b * m2 * by,
    )


def plane_energy(t: Any, state: Values, parameters: Values) -> Values:
    x1, y1, x2, y2, x3, y3, u1, v1, u2, v2, u3, v3 = state
    G, m1, m2, m3 = parameters
    a = sqrt((x2 - x1) * (x2 - x1) + (y2 - y1) * (y2 - y1))
    b = sqrt((x3 - x2) * (x3 - x2) + (y3 - y2) * (y3 - y2))
    c = sqrt((x1 - x3) * (x1 - x3) + (y1 - y3) * (y1 - y3))
    kinetic = (m1 * (u1 * u1 + v1 * v1) + m2 * (u2 * u2 + v2 * v2) + m3 * (u3 * u3 + v3 * v3)) / 2
    return (kinetic - G * (m1 * m2 / a + m2 * m3 / b + m3 * m1 / c),)


def plane_momentum_x(t: Any, state: Values, parameters: Values) -> Values:
    _, m1, m2, m3 = parameters
    return (m1 * state[6] + m2 * state[8] + m3 * state[10],)


def plane_momentum_y(t: Any, state: Values, parameters: Values) -> Values:
    _, m1, m2, m3 = parameters
    return (m1 * state[7] + m2 * state[9] + m3 * state[11],)


def plane_spin(t: Any, state: Values, parameters: Values) -> Values:
    """Angular momentum about the origin."""
    x1, y1, x2, y2, x3, y3, u1, v1, u2, v2, u3, v3 = state
    _, m1, m2, m3 = parameters
    return (m1 * (x1 * v1 - y1 * u1) + m2 * (x2 * v2 - y2 * u2) + m3 * (x3 * v3 - y3 * u3),)


def plane_masses(parameters: Values) -> Values:
    G, m1, m2, m3 = parameters
    return G * m1, G * m2, G * m3


def plane_bodies(state: Values) -> tuple[Values, ...]:
    return (*((*state[i : i + 2], 0, *state[i + 6 : i + 8], 0) for i in (0, 2, 4)),)


def plane_states(found: tuple[Values, ...]) -> Values:
    one, two, three = found
    return (*one[:2], *two[:2], *three[:2], *one[3:5], *two[3:5], *three[3:5])


def _apart(n: Any) -> bool:
    corners = [[n[f"{axis}{body}"] for axis in "xy"] for body in (1, 2, 3)]
    return all(a != b for a, b in combinations(corners, 2))


SCENE = attracting(lambda p: p[1:], lambda r, p: p[0] / r**3, (0, 1))


class ThreeBodyPythagorean(IntegratedCase):
    """Three bodies in a plane that fall together from rest, pass each other closely again and again, and part."""

    name = "three_body_pythagorean"
    title = "Pythagorean three-body problem: close encounters (no closed form; certified Taylor)"
    section = "8.9.2"
    conventions = (
        "[inferred] Not in the book: C. Burrau, Astronomische Nachrichten 195 (1913) 113; V. Szebehely, C. F. Peters, The "
        "Astronomical Journal 72 (1967) 876. Each mass is opposite to the side of its length; at rest, the centre of mass at "
        "the origin, G = 1. Errors of each body's position and velocity are relative to their own size."
    )
    x1 = Coordinate("m", 1, typical(0.9, 1.1), group="length of body 1")
    y1 = Coordinate("m", 3, typical(2.9, 3.1), group="length of body 1")
    x2 = Coordinate("m", -2, typical(-2.1, -1.9), group="length of body 2")
    y2 = Coordinate("m", -1, typical(-1.1, -0.9), group="length of body 2")
    x3 = Coordinate("m", 1, typical(0.9, 1.1), group="length of body 3")
    y3 = Coordinate("m", -1, typical(-1.1, -0.9), group="length of body 3")
    vx1 = Coordinate("m/s", 0, typical(-0.2, 0.2), group="velocity of body 1")
    vy1 = Coordinate("m/s", 0, typical(-0.2, 0.2), group="velocity of body 1")
    vx2 = Coordinate("m/s", 0, typical(-0.2, 0.2), group="velocity of body 2")
    vy2 = Coordinate("m/s", 0, typical(-0.2, 0.2), group="velocity of body 2")
    vx3 = Coordinate("m/s", 0, typical(-0.2, 0.2), group="velocity of body 3")
    vy3 = Coordinate("m/s", 0, typical(-0.2, 0.2), group="velocity of body 3")
    G = Parameter("m^3/(kg s^2)", 1, "constant of gravitation", positive(0.8, 1.25))
    m1 = Parameter("kg", 3, "mass of body 1", positive(2.5, 3.5))
    m2 = Parameter("kg", 4, "mass of body 2", positive(3.5, 4.5))
    m3 = Parameter("kg", 5, "mass of body 3", positive(4.5, 5.5))
    rules = (Rule("no two bodies are at the same position", _apart),)
    default_span = "4.3"
    variants = (
        Variant(
            "third_encounter", "bodies 2 and 3 pass at 0.0085 m, from 3 m: two hundred times faster there", span="9.3"
        ),
    )
    invariants = conserved(
        energy=plane_energy, momentum_x=plane_momentum_x, momentum_y=plane_momentum_y, spin=plane_spin
    )
    forms = (
        SecondOrder(plane_attraction),
        NBody(plane_masses, plane_bodies, plane_states),
    )
    scene = SCENE
    alike = tuple(tuple(f"{name}{k}" for name in ("x", "y", "vx", "vy", "m")) for k in (1, 2, 3))
    mirror = ("x1", "x2", "x3", "vx1", "vx2", "vx3")

    def scales(self) -> dict[str, float]:
        """At the samples: the speeds have peaks at close encounters, far narrower than a grid spacing."""
        return accuracy.grid_scales(self, samples_alone=True)

    @property
    def time_scale(self) -> float:
        """Half of sqrt(s^3/GM), s the shortest side at the start: the bodies come closer as they fall."""
        G, *masses = map(float, self.parameter_values())
        corners = [tuple(map(float, self.initial_state[i : i + 2])) for i in (0, 2, 4)]
        side = min(hypot(a[0] - b[0], a[1] - b[1]) for a, b in combinations(corners, 2))
        return sqrt(side**3 / (G * sum(masses))) / 2
