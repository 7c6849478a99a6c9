"""Three bodies under mutual attraction: Lagrange's equilateral triangle, and starts that are close to one."""

from collections.abc import Sequence
from functools import cached_property
from itertools import combinations

import numpy as np
from gnomon.cases.core import accuracy
from gnomon.cases.core.integrated import integrate
from gnomon.cases.declare import *
from gnomon.cases.scenes.two_masses import attracting
from gnomon.reference.numerics.precision import quantity
from gnomon.reference.orbits.equilateral_three_body import Homographic, keeps_its_shape


def triple_attraction(t: Any, q: Values, parameters: Values) -> Values:
    """r1'' = G m2 (r2 - r1)/|r2 - r1|^3 + G m3 (r3 - r1)/|r3 - r1|^3, and so on round the triangle."""
    x1, y1, z1, x2, y2, z2, x3, y3, z3 = q
    G, m1, m2, m3 = parameters
    ax, ay, az = x2 - x1, y2 - y1, z2 - z1
    bx, by, bz = x3 - x2, y3 - y2, z3 - z2
    cx, cy, cz = x1 - x3, y1 - y3, z1 - z3
    aa, bb, cc = ax * ax + ay * ay + az * az, bx * bx + by * by + bz * bz, cx * cx + cy * cy + cz * cz
    a, b, c = G / (aa * sqrt(aa)), G / (bb * sqrt(bb)), G / (cc * sqrt(cc))
    return (
        a * m2 * ax - c * m3 * cx,
        a * m2 * ay - c * m3 * cy,
        a * m2 * az - c * m3 * cz,
        b * m3 * bx - a * m1 * ax,
        b * m3 * by - a * m1 * ay,
        b * m3 * bz - a * m1 * az,
        c * m1 * cx - b * m2 * bx,
        c * m1 * cy - b * m2 * by,
        c * m1 * cz - b * m2 * bz,
    )


def triple_energy(t: Any, state: Values, parameters: Values) -> Values:
    x1, y1, z1, x2, y2, z2, x3, y3, z3, u1, v1, w1, u2, v2, w2, u3, v3, w3 = state
    G, m1, m2, m3 = parameters
    a = sqrt((x2 - x1) * (x2 - x1) + (y2 - y1) * (y2 - y1) + (z2 - z1) * (z2 - z1))
    b = sqrt((x3 - x2) * (x3 - x2) + (y3 - y2) * (y3 - y2) + (z3 - z2) * (z3 - z2))
    c = sqrt((x1 - x3) * (x1 - x3) + (y1 - y3) * (y1 - y3) + (z1 - z3) * (z1 - z3))
    kinetic = (
        m1 * (u1 * u1 + v1 * v1 + w1 * w1) + m2 * (u2 * u2 + v2 * v2 + w2 * w2) + m3 * (u3 * u3 + v3 * v3 + w3 * w3)
    ) / 2
    return (kinetic - G * (m1 * m2 / a + m2 * m3 / b + m3 * m1 / c),)


def triple_momentum_x(t: Any, state: Values, parameters: Values) -> Values:
    _, m1, m2, m3 = parameters
    return (m1 * state[9] + m2 * state[12] + m3 * state[15],)


def triple_momentum_y(t: Any, state: Values, parameters: Values) -> Values:
    _, m1, m2, m3 = parameters
    return (m1 * state[10] + m2 * state[13] + m3 * state[16],)


def triple_momentum_z(t: Any, state: Values, parameters: Values) -> Values:
    _, m1, m2, m3 = parameters
    return (m1 * state[11] + m2 * state[14] + m3 * state[17],)


def triple_spin_x(t: Any, state: Values, parameters: Values) -> Values:
    """Angular momentum about the x axis."""
    _, y1, z1, _, y2, z2, _, y3, z3, _, v1, w1, _, v2, w2, _, v3, w3 = state
    _, m1, m2, m3 = parameters
    return (m1 * (y1 * w1 - z1 * v1) + m2 * (y2 * w2 - z2 * v2) + m3 * (y3 * w3 - z3 * v3),)


def triple_spin_y(t: Any, state: Values, parameters: Values) -> Values:
    """Angular momentum about the y axis."""
    x1, _, z1, x2, _, z2, x3, _, z3, u1, _, w1, u2, _, w2, u3, _, w3 = state
    _, m1, m2, m3 = parameters
    return (m1 * (z1 * u1 - x1 * w1) + m2 * (z2 * u2 - x2 * w2) + m3 * (z3 * u3 - x3 * w3),)


def triple_spin_z(t: Any, state: Values, parameters: Values) -> Values:
    """Angular momentum about the z axis."""
    x1, y1, _, x2, y2, _, x3, y3, _, u1, v1, _, u2, v2, _, u3, v3, _ = state
    _, m1, m2, m3 = parameters
    return (m1 * (x1 * v1 - y1 * u1) + m2 * (x2 * v2 - y2 * u2) + m3 * (x3 * v3 - y3 * u3),)


def three_masses(parameters: Values) -> Values:
    G, m1, m2, m3 = parameters
    return G * m1, G * m2, G * m3


def three_bodies(state: Values) -> tuple[Values, ...]:
    return (*(state[i : i + 3] + state[i + 9 : i + 12] for i in (0, 3, 6)),)


def three_states(bodies: tuple[Values, ...]) -> Values:
    first, second, third = bodies
    return (*first[:3], *second[:3], *third[:3], *first[3:], *second[3:], *third[3:])


def turning_triangle(turn: Number, centre: Sequence[Number] = (0, 0, 0), growth: Number = 0) -> tuple[Fraction, ...]:
    """Corners (1, 0, 0), (0, 1, 0), (0, 0, 1) less `centre`; each moves at turn (1, 1, 1) x r + growth r.

    Each number is rounded to 20 binary places, so that products are exact in binary64.
    """
    rate, wide, *middle = (Fraction(round(Fraction(value) * 2**20), 2**20) for value in (turn, growth, *centre))
    places = [[Fraction(int(i == j)) - middle[j] for j in range(3)] for i in range(3)]
    speeds = [(rate * (z - y) + wide * x, rate * (x - z) + wide * y, rate * (y - x) + wide * z) for x, y, z in places]
    return (*(x for place in places for x in place), *(v for speed in speeds for v in speed))


def _apart(n: Any) -> bool:
    corners = [[n[f"{axis}{body}"] for axis in "xyz"] for body in (1, 2, 3)]
    return all(a != b for a, b in combinations(corners, 2))


SCENE = attracting(lambda p: p[1:], lambda r, p: p[0] / r**3, (0, 1, 2))


class EquilateralThreeBody(IntegratedCase):
    """Lagrange's motion: three bodies on three ellipses, an equilateral triangle at every moment."""

    name = "equilateral_three_body"
    title = "Three bodies in Lagrange's equilateral triangle"
    section = "8.9.2"
    conventions = (
        "In space, because there a triangle with exactly equal sides has rational corners: (1, 0, 0), (0, 1, 0), (0, 0, 1), "
        "shifted. A start that is exactly such a triangle has a closed form; any other, such as those for the conditioning, "
        "is integrated. Errors of each body's position and velocity are relative to their own size."
    )
    x1 = Coordinate("m", 0, typical(0.8, 1.2), group="length of body 1")
    y1 = Coordinate("m", 0, typical(-0.2, 0.2), group="length of body 1")
    z1 = Coordinate("m", 0, typical(-0.2, 0.2), group="length of body 1")
    x2 = Coordinate("m", 0, typical(-0.2, 0.2), group="length of body 2")
    y2 = Coordinate("m", 0, typical(0.8, 1.2), group="length of body 2")
    z2 = Coordinate("m", 0, typical(-0.2, 0.2), group="length of body 2")
    x3 = Coordinate("m", 0, typical(-0.2, 0.2), group="length of body 3")
    y3 = Coordinate("m", 0, typical(-0.2, 0.2), group="length of body 3")
    z3 = Coordinate("m", 0, typical(0.8, 1.2), group="length of body 3")
    vx1 = Coordinate("m/s", 0, typical(-0.3, 0.3), group="velocity of body 1")
    vy1 = Coordinate("m/s", 0, typical(-0.3, 0.3), group="velocity of body 1")
    vz1 = Coordinate("m/s", 0, typical(-0.3, 0.3), group="velocity of body 1")
    vx2 = Coordinate("m/s", 0, typical(-0.3, 0.3), group="velocity of body 2")
    vy2 = Coordinate("m/s", 0, typical(-0.3, 0.3), group="velocity of body 2")
    vz2 = Coordinate("m/s", 0, typical(-0.3, 0.3), group="velocity of body 2")
    vx3 = Coordinate("m/s", 0, typical(-0.3, 0.3), group="velocity of body 3")
    vy3 = Coordinate("m/s", 0, typical(-0.3, 0.3), group="velocity of body 3")
    vz3 = Coordinate("m/s", 0, typical(-0.3, 0.3), group="velocity of body 3")
    default_state = turning_triangle("0.40625", ("0.5", "0.3125", "0.1875"))
    G = Parameter("m^3/(kg s^2)", 1, "constant of gravitation", positive(0.5, 2))
    m1 = Parameter("kg", 1, "mass of body 1", positive(0.5, 2))
    m2 = Parameter("kg", "0.625", "mass of body 2", positive(0.5, 2))
    m3 = Parameter("kg", "0.375", "mass of body 3", nonnegative(0, 2))
    rules = (Rule("no two bodies are at the same position", _apart),)
    exact_motion = bind(lambda c: c.triangle or integrate(c))
    default_span = Span(2.37, "turn of the triangle")
    variants = (
        Variant(
            "equal",
            "equal masses on nearly one circle: errors grow 85-fold in each turn",
            {"m1": 1, "m2": 1, "m3": 1},
            turning_triangle("0.594604", ("0.3333333", "0.3333333", "0.3333333")),
        ),
        Variant(
            "e09",
            "e = 0.9: the triangle shrinks 19 times and back, and is unstable",
            initial_state=turning_triangle("0.1533203125", ("0.5", "0.3125", "0.1875")),
            periods=1.63,
        ),
        Variant(
            "routh_stable",
            "a heavy body and two light ones, within Routh's limit: only phase errors grow",
            {"m2": "0.0009765625", "m3": "0.00000095367431640625"},
            turning_triangle("0.34375", ("0.999023", "0.000976", "0.000001")),
            periods=10.37,
        ),
        Variant(
            "trojan",
            "the third body has no mass, like an asteroid sixty degrees ahead of Jupiter",
            {"m2": "0.0009765625", "m3": 0},
            turning_triangle("0.34375", ("0.999023", "0.000976", 0)),
            periods=10.37,
        ),
        Variant(
            "escape",
            "unbound: the triangle grows without end",
            initial_state=turning_triangle("0.40625", ("0.5", "0.3125", "0.1875"), "1.25"),
            span=20,
        ),
        Variant(
            "beside",
            "1e-6 from the triangle, where no formula is known: errors grow as for the triangle",
            initial_state=(
                Fraction("0.500001"),
                *turning_triangle("0.40625", ("0.5", "0.3125", "0.1875"))[1:],
            ),
        ),
    )
    invariants = conserved(
        energy=triple_energy,
        momentum_x=triple_momentum_x,
        momentum_y=triple_momentum_y,
        momentum_z=triple_momentum_z,
        spin_x=triple_spin_x,
        spin_y=triple_spin_y,
        spin_z=triple_spin_z,
    )
    forms = (SecondOrder(triple_attraction), NBody(three_masses, three_bodies, three_states))
    scene = SCENE
    alike = tuple(tuple(f"{name}{k}" for name in ("x", "y", "z", "vx", "vy", "vz", "m")) for k in (1, 2, 3))

    @cached_property
    def triangle(self) -> Homographic | None:
        """The closed form if the start is exactly an equilateral triangle that keeps its shape, else None."""
        G, *masses = self.parameter_values()
        vectors = [self.initial_state[i : i + 3] for i in range(0, 18, 3)]
        if not keeps_its_shape(vectors[:3], vectors[3:]):
            return None
        return Homographic(tuple(G * m for m in masses), tuple(vectors[:3]), tuple(vectors[3:]))  # type: ignore[arg-type]

    @cached_property
    def time_scale(self) -> float:  # type: ignore[override]
        """sqrt(s^3/GM), s the shortest side at the start: a radian of a triangle on a circle."""
        G, *masses = map(float, self.parameter_values())
        corners = np.array([float(x) for x in self.initial_state[:9]]).reshape(3, 3)
        side = min(float(np.linalg.norm(a - b)) for a, b in combinations(corners, 2))
        return sqrt(side**3 / (G * sum(masses)))

    def natural_span(self) -> Number:
        """2.37 turns; 8 time scales if the triangle is unbound or the start is not a triangle."""
        if self.triangle is None or self.triangle.conic <= 0:
            return 8 * self.time_scale
        return float(self.triangle.period()) * self.periods

    def scales(self) -> dict[str, float]:
        """On a grid, and at the first pericentre, where the speeds have a peak narrower than the grid spacing."""
        scales = accuracy.grid_scales(self)
        moment = 0.0 if self.triangle is None else float(self.triangle.pericentre_time())
        if 0 < moment < self.times[-1]:
            state = self.sample(np.array([moment]))[0]
            for name in scales:
                members = [i for i, coordinate in enumerate(self.state) if coordinate.group == name]
                scales[name] = max(scales[name], float(np.linalg.norm(state[members])))
        return scales

    def derived(self, digits: int) -> dict[str, Any]:
        """`routh`: 27 (m1 m2 + m2 m3 + m3 m1)/(m1 + m2 + m3)^2; a circular triangle is stable if it is below 1.

        `growth_a_turn`: the factor by which a small error grows in each turn of an unstable circular triangle.
        """
        _, m1, m2, m3 = self.parameter_values()
        routh = 27 * (m1 * m2 + m2 * m3 + m3 * m1) / (m1 + m2 + m3) ** 2

        def growth(mp: Any) -> Any:
            """By the roots of s^4 + s^2 + routh/4 = 0, s over the rate of turn (Routh 1875)."""
            return mp.exp(2 * mp.pi * mp.re(mp.sqrt((mp.sqrt(mp.mpc(1 - routh)) - 1) / 2)))

        quantities = {"routh": routh, "growth_a_turn": quantity(digits, growth, 20) if routh > 1 else None}
        if self.triangle is None:
            return quantities
        shortest, longest = self.triangle.sides(digits)
        return quantities | {
            "eccentricity": self.triangle.eccentricity(digits),
            "shortest_side": shortest,
            "longest_side": longest,
            "period": None if longest is None else self.triangle.period(digits),
        }
