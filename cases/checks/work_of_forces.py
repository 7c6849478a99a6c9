"""Work along paths, and the test for conservative forces (Beatty, Dynamics, 7.4, 7.6).

Checks: work_constant_linear_coulomb, conservative_force_test.
"""

from typing import ClassVar

import flint
from gnomon.cases.core.check import Numbers
from gnomon.cases.declare import *
from gnomon.reference.numerics.quadrature import integral, integral_near, unit_steps
from gnomon.reference.numerics.vectors import components, dot, square


class WorkConstantLinearCoulomb(Check):
    name = "work_constant_linear_coulomb"
    title = "Work of a constant force, a spring and Coulomb friction along paths"
    section = "7.4"
    conventions = (
        "constant, spring: along the helix (R cos s, R sin s, p s/(2 pi)), s from 0 to phi; the spring of stiffness k and "
        "natural length l is fixed at the origin. friction_*: a weight m g on a rough table, around a circle of radius R "
        "(`turns` times), along y = c x^2 from x = 0 to X, once around an ellipse with semi-axes a and b."
    )
    Fx = Parameter("N", 2, "constant force")
    Fy = Parameter("N", -1, "constant force")
    Fz = Parameter("N", "3.5", "constant force")
    k = Parameter("N/m", 40, "stiffness", positive())
    l = Parameter("m", "0.3", "natural length", nonnegative())
    R = Parameter("m", "0.8", "radius of helix and circle", positive())
    p = Parameter("m", "0.5", "pitch of the helix")
    phi = Parameter("rad", 5, "angle along the helix", nonnegative())
    mu = Parameter("", "0.3", "coefficient of friction", nonnegative())
    m = Parameter("kg", 2, "mass", positive())
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    turns = Parameter("", "2.5", "turns around the circle", nonnegative())
    c = Parameter("1/m", "0.7", "coefficient of the parabola", positive())
    X = Parameter("m", "1.9", "end of the parabola", positive())
    a = Parameter("m", "1.5", "larger semi-axis", positive())
    b = Parameter("m", "0.4", "smaller semi-axis", positive())
    rules = (Rule("b <= a", lambda p: p["b"] <= p["a"]),)
    variants = (
        Variant("flat_ellipse", "b = 1e-8 a: the path is curved only in 1e-8 of its length", {"a": 1, "b": "1e-8"}),
        Variant("straight_parabola", "c X = 1e-10: x/2 + asinh/(4c) cancels", {"c": "1e-10", "X": 1}),
        Variant("long_helix", "1e4 rad: the work depends only on the end points", {"phi": 10000}),
        Variant(
            "closed",
            "nearly a whole turn without pitch: the spring's work nearly vanishes",
            {"p": 0, "phi": Fraction(6283185307179586, 10**15)},
        ),
    )
    guard = 40

    def formulas(self, p: Any) -> Mapping[str, Any]:
        pi = flint.arb.pi()
        begin = (p.R, p.R * 0, p.R * 0)
        end = (p.R * p.phi.cos(), p.R * p.phi.sin(), p.p * p.phi / (2 * pi))
        length = (p.R * p.R + end[2] * end[2]).sqrt()
        weight = p.mu * p.m * p.g
        bend = 2 * p.c * p.X
        parabola = p.X * (1 + bend * bend).sqrt() / 2 + bend.asinh() / (4 * p.c)
        ellipse = 4 * p.a * flint.acb(1 - p.b * p.b / (p.a * p.a)).elliptic_e().real
        return {
            "constant": dot(components(p, "F"), [e - b for b, e in zip(begin, end, strict=True)]),
            "spring": p.k / 2 * (square(p.R - p.l) - square(length - p.l)),
            "friction_circle": -weight * 2 * pi * p.R * p.turns,
            "friction_parabola": -weight * parabola,
            "friction_ellipse": -weight * ellipse,
        }

    def sizes(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Work that vanishes has the size of the spring's energy or of force times radius."""
        sizes = super().sizes(values)
        n = {name: float(value) for name, value in self.parameters.items()}
        force = sum(abs(n[f"F{axis}"]) for axis in "xyz")
        sizes["constant"] = max(sizes["constant"], force * n["R"])
        sizes["spring"] = max(sizes["spring"], n["k"] / 2 * (n["R"] - n["l"]) ** 2, n["k"] * n["R"] ** 2 * 1e-3)
        return sizes

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """Force times displacement, integrated along each path."""
        rise = p.p / (2 * mp.pi)

        def power(s: Any) -> Any:
            way = (-p.R * mp.sin(s), p.R * mp.cos(s), rise)
            return mp.fsum(f * w for f, w in zip(components(p, "F"), way, strict=True))

        def pull(s: Any) -> Any:
            place = (p.R * mp.cos(s), p.R * mp.sin(s), rise * s)
            length = mp.sqrt(mp.fsum(x * x for x in place))
            radial = mp.fsum(x * w for x, w in zip(place, (-place[1], place[0], rise), strict=True)) / length
            return -p.k * (length - p.l) * radial

        # All turns are the same for the constant force; the distance from the origin is zero at s = i R/rise.
        whole = mp.floor(p.phi / (2 * mp.pi))
        turn = [mp.pi * k / 2 for k in range(5)]
        constant = whole * integral(mp, power, turn) + integral(mp, power, [mp.mpf(0), p.phi - 2 * mp.pi * whole])
        spring = integral_near(mp, pull, mp.mpf(0), p.phi, mp.mpf(0), p.R / rise) if rise else mp.mpf(0)
        weight = p.mu * p.m * p.g
        circle = integral(mp, lambda s: p.R, [mp.mpf(0), 2 * mp.pi * p.turns])
        parabola = integral_near(
            mp, lambda x: mp.sqrt(1 + (2 * p.c * x) ** 2), mp.mpf(0), p.X, mp.mpf(0), 1 / (2 * p.c)
        )
        ratio = p.b / p.a
        delta = mp.pi if ratio > mp.mpf(9) / 10 else mp.atanh(ratio)
        quarter = integral_near(
            mp, lambda t: mp.hypot(p.a * mp.sin(t), p.b * mp.cos(t)), mp.mpf(0), mp.pi / 2, mp.mpf(0), delta
        )
        return {
            "constant": constant,
            "spring": spring,
            "friction_circle": -weight * circle,
            "friction_parabola": -weight * parabola,
            "friction_ellipse": -weight * 4 * quarter,
        }


def _off_segment(p: Numbers) -> bool:
    """Whether the origin is not on the straight line from A to B."""
    turned = p["Ax"] * p["By"] - p["Ay"] * p["Bx"]
    return turned != 0 or p["Ax"] * p["Bx"] + p["Ay"] * p["By"] > 0


class ConservativeForceTest(Check):
    name = "conservative_force_test"
    title = "Is a force conservative? Curl, circulation and potential"
    section = "7.6.1, 7.6.2"
    conventions = (
        "[inferred] From the title of 7.6.2 (a needle in the haystack): the force (-y, x)/(x^2 + y^2), free of curl but with "
        "a circulation of 2 pi for each turn about the origin. circle: work once around a circle of radius R about (X, Y); "
        "line: work along the straight line from A to B. potential: work of (2xy + z^3, x^2, 3xz^2), which has the potential "
        "-(x^2 y + x z^3), on a helix of radius R and unit pitch about z from angle 0 to phi; shear: circulation of (-y, 0)."
    )
    X = Parameter("m", "0.4", "centre of the circle")
    Y = Parameter("m", "-0.3")
    R = Parameter("m", "1.1", "radius of circle and helix", positive())
    Ax = Parameter("m", 2, "start of the line")
    Ay = Parameter("m", "0.5")
    Bx = Parameter("m", "-1.3", "end of the line")
    By = Parameter("m", "0.9")
    phi = Parameter("rad", "4.5", "angle along the helix", nonnegative())
    rules = (
        Rule("the circle does not pass through the origin", lambda p: p["X"] ** 2 + p["Y"] ** 2 != p["R"] ** 2),
        Rule("the line does not pass through the origin", _off_segment),
    )
    variants = (
        Variant(
            "needle_inside", "the origin 1e-10 m inside the circle, the line 1e-10 m from it",
            {"X": 1, "Y": 0, "R": "1.0000000001", "Ax": 1, "Ay": "1e-10", "Bx": -1, "By": "1e-10"},
        ),
        Variant(
            "needle_outside", "the origin 1e-10 m outside the circle, the line 1e-10 m from it on the other side",
            {"X": 1, "Y": 0, "R": "0.9999999999", "Ax": 1, "Ay": "-1e-10", "Bx": -1, "By": "-1e-10"},
        ),
        Variant("far_outside", "no turn about the origin: no work", {"X": 50}),
        Variant("long_helix", "1000 rad", {"phi": 1000}),
    )  # fmt: skip
    natural_sizes: ClassVar[Mapping[str, float]] = {"circle": 2 * 3.141592653589793}
    guard = 40

    def formulas(self, p: Any) -> Mapping[str, Any]:
        n = self.parameters
        pi = flint.arb.pi()
        inside = n["X"] ** 2 + n["Y"] ** 2 < n["R"] ** 2
        x, y, z = p.R * p.phi.cos(), p.R * p.phi.sin(), p.phi / (2 * pi)
        turned, along = p.Ax * p.By - p.Ay * p.Bx, p.Ax * p.Bx + p.Ay * p.By
        return {
            "circle": 2 * pi if inside else flint.arb(0),
            "line": flint.arb.atan2(turned, along),
            "potential": x * x * y + x * z * z * z,
            "shear": pi * p.R * p.R,
        }

    def sizes(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """The work on the helix has the size of its potential."""
        sizes = super().sizes(values)
        R, height = float(self.parameters["R"]), float(self.parameters["phi"]) / 6.283185307179586
        return sizes | {"potential": R**3 + R * height**3}

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """Force times displacement, integrated along each path."""

        def vortex(x: Any, y: Any, dx: Any, dy: Any) -> Any:
            return (x * dy - y * dx) / (x * x + y * y)

        # The integrand is singular at a complex angle, log(distance of the centre / R) from the nearest real one.
        distance = mp.hypot(p.X, p.Y)
        nearest = mp.atan2(-p.Y, -p.X) if distance else mp.mpf(0)
        delta = min(mp.fabs(mp.log(distance / p.R)), mp.pi) if distance else mp.pi

        def circle(t: Any) -> Any:
            cosine, sine = p.R * mp.cos(t), p.R * mp.sin(t)
            return vortex(p.X + cosine, p.Y + sine, -sine, cosine)

        dx, dy = p.Bx - p.Ax, p.By - p.Ay
        length = mp.hypot(dx, dy)
        if length:
            foot = -(p.Ax * dx + p.Ay * dy) / length**2
            gap = mp.fabs(p.Ax * dy - p.Ay * dx) / length**2
            # On a line towards the origin that does not reach it the work is zero: the polar angle is constant.
            line = (
                integral_near(
                    mp, lambda s: vortex(p.Ax + s * dx, p.Ay + s * dy, dx, dy), mp.mpf(0), mp.mpf(1), foot, gap
                )
                if gap
                else mp.mpf(0)
            )
        else:
            line = mp.mpf(0)

        def helix(s: Any) -> Any:
            x, y, z = p.R * mp.cos(s), p.R * mp.sin(s), s / (2 * mp.pi)
            return (2 * x * y + z**3) * -y + x * x * x + 3 * x * z * z / (2 * mp.pi)

        return {
            "circle": integral_near(mp, circle, nearest - mp.pi, nearest + mp.pi, nearest, delta),
            "line": line,
            "potential": integral(mp, helix, [8 * s for s in unit_steps(mp.mpf(0), p.phi / 8)]),
            "shear": integral(mp, lambda s: (p.R * mp.sin(s)) ** 2, [mp.pi * k / 2 for k in range(5)]),
        }
