"""Closed forms for rigid bodies: unbalanced rotors, struck rods (Beatty 10.11, 10.12, 11.10).

Checks: rotor_dynamic_balance, generalized_impulse.
"""

from typing import ClassVar

from gnomon.cases.checks.frames import second_derivative
from gnomon.cases.declare import *
from gnomon.reference.numerics.vectors import named
from gnomon.reference.rigid_bodies import bodies
from gnomon.reference.rigid_bodies.struck_rods import rates


class RotorDynamicBalance(Check):
    name = "rotor_dynamic_balance"
    title = "Static and dynamic unbalance of a rotor; bearing reactions"
    section = "10.11.3, 10.12.4"
    conventions = (
        "A disc of radius r and thickness h rotates at w about z, its axis tilted by beta in the x-z plane, which rotates "
        "with it, its centre at x = e; bearings at z = d (A) and z = -d (B), no gravity. In rotating axes: I_xz, the torque "
        "about y and the forces along x on the rotor, and the mass times radius along x in the planes of the bearings that "
        "balances it."
    )
    m = Parameter("kg", 12, "mass", positive())
    r = Parameter("m", "0.25", "radius", positive())
    h = Parameter("m", "0.04", "thickness", positive())
    beta = Parameter("rad", "0.01", "tilt", Range(-1.5, 1.5, typical=(-1.5, 1.5)))
    e = Parameter("m", "2e-4", "eccentricity", typical(-1, 1))
    d = Parameter("m", "0.3", "distance of the bearings from the centre", positive())
    w = Parameter("rad/s", "157.1", "rate")
    variants = (
        Variant("statically_balanced", "e = 0: a pure couple", {"e": 0}),
        Variant("slight_tilt", "a tilt of 1e-10", {"beta": "1e-10"}),
        Variant(
            "nearly_isotropic",
            "h = sqrt(3) r up to 1e-15: I3 - I1 nearly vanishes",
            {"r": 1, "h": "1.732050807568877"},
        ),
        Variant(
            "one_bearing_free", "the couple relieves bearing A except for 1e-6", {"e": "5.163534e-4", "beta": "0.01"}
        ),
    )
    guard = 50

    def formulas(self, p: Any) -> Mapping[str, Any]:
        product = p.m * (p.r * p.r / 4 - p.h * p.h / 12) * p.beta.sin() * p.beta.cos()
        square = p.w * p.w
        force, torque = -p.m * p.e * square, square * product
        a, b = force / 2 + torque / (2 * p.d), force / 2 - torque / (2 * p.d)
        return {
            "I_xz": product,
            "torque": torque,
            "force": force,
            **named("bearing", (a, b), ("A", "B")),
            **named(
                "correction", (-p.m * p.e / 2 + product / (2 * p.d), -p.m * p.e / 2 - product / (2 * p.d)), ("A", "B")
            ),
        }

    natural_sizes: ClassVar[Mapping[str, float]] = {"force": 1.0}

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """The disc as particles: their accelerations by second differences, summed to a force and a moment."""
        cosine, sine = mp.cos(p.beta), mp.sin(p.beta)
        points = [
            (x * cosine + z * sine + p.e, y, z * cosine - x * sine, p.m * share)
            for x, y, z, share in bodies.masses(mp, bodies.BODIES["cylinder"], (p.r, p.h))
        ]
        circle = second_derivative(mp, lambda t: [mp.cos(p.w * t), mp.sin(p.w * t)], mp.mpf(0), 1 / (1 + abs(p.w)))
        turn = mp.mpc(*circle)  # the acceleration of a particle at (1, 0) as a complex number
        force = moment = product = mp.mpf(0)
        for x, y, z, mass in points:
            pull = mass * (turn * mp.mpc(x, y)).real
            force += pull
            moment += z * pull
            product -= mass * z * (x - p.e)
        # A + B = force, d (A - B) = moment.
        a, b = mp.lu_solve(mp.matrix([[1, 1], [p.d, -p.d]]), mp.matrix([force, moment]))
        return {
            "I_xz": product,
            "torque": moment,
            "force": force,
            **named("bearing", (a, b), ("A", "B")),
            **named("correction", (a / p.w**2, b / p.w**2) if p.w else self._at_rest(mp, p, product), ("A", "B")),
        }

    @staticmethod
    def _at_rest(mp: Any, p: Any, product: Any) -> tuple[Any, Any]:
        """The correction of a rotor at rest, which is equal."""
        return tuple(mp.lu_solve(mp.matrix([[1, 1], [p.d, -p.d]]), mp.matrix([-p.m * p.e, product])))


class GeneralizedImpulse(Check):
    name = "generalized_impulse"
    title = "Struck double rod: generalized impulse and momentum"
    section = "11.10.5"
    conventions = (
        "Two uniform rods in a chain, at rest at angles th1, th2 from the downward vertical, the first on a fixed pivot, are "
        "struck by a horizontal impulse P at distance d from the joint along the second. rate: th1', th2' after the blow."
    )
    m1 = Parameter("kg", 2, "mass of the first rod", positive())
    m2 = Parameter("kg", 3, "mass of the second rod", positive())
    L1 = Parameter("m", "0.8", "length of the first rod", positive())
    L2 = Parameter("m", "1.2", "length of the second rod", positive())
    th1 = Parameter("rad", "0.3", "angle of the first rod", typical(-3, 3))
    th2 = Parameter("rad", "-0.5", "angle of the second rod", typical(-3, 3))
    P = Parameter("N s", 5, "impulse")
    d = Parameter("m", "0.9", "distance of the impulse from the joint", nonnegative())
    rules = (Rule("d <= L2 (the impulse strikes the rod)", lambda p: p["d"] <= p["L2"]),)
    variants = (
        Variant("hanging", "both straight down", {"th1": 0, "th2": 0}),
        Variant("percussion", "straight down, struck at 2/3 of the second rod: the first rod does not move", {"th1": 0, "th2": 0, "L2": "1.2", "d": "0.8"}),
        Variant("heavy_above", "m1 = 1e8 m2", {"m1": 10**8, "m2": 1}),
        Variant("heavy_below", "m2 = 1e8 m1, rods in line: M is nearly singular", {"m1": 1, "m2": 10**8, "th1": "0.4", "th2": "0.4"}),
        Variant("short_second", "L2 = 1e-8 L1", {"L1": 1, "L2": "1e-8", "d": "5e-9"}),
    )  # fmt: skip
    guard = 60

    def formulas(self, p: Any) -> Mapping[str, Any]:
        first, second = rates((p.m1, p.m2), (p.L1, p.L2), (p.th1, p.th2), p.P, p.d)
        struck = p.P * (p.L1 * p.th1.cos() * first + p.d * p.th2.cos() * second)
        return {"first_rate": first, "second_rate": second, "energy": struck / 2}

    def sizes(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """The first rate can vanish: its size is then the joint's speed due to the second rod."""
        sizes = super().sizes(values)
        ratio = float(self.parameters["L2"] / self.parameters["L1"])
        return sizes | {"first_rate": sizes["first_rate"] + 1e-3 * ratio * sizes["second_rate"]}

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """Newton's and Euler's laws for each rod with the impulses of pivot and joint: ten linear equations."""
        arm1 = (p.L1 * mp.sin(p.th1) / 2, -p.L1 * mp.cos(p.th1) / 2)
        arm2 = (p.L2 * mp.sin(p.th2) / 2, -p.L2 * mp.cos(p.th2) / 2)
        hit = ((2 * p.d / p.L2 - 1) * arm2[0], (2 * p.d / p.L2 - 1) * arm2[1])
        # Unknowns: v1x v1y w1 v2x v2y w2, impulse K of the pivot on rod 1, impulse J of the joint on rod 2.
        rows, right = [], []

        def equation(value: Any, **terms: Any) -> None:
            unknowns = ("v1x", "v1y", "w1", "v2x", "v2y", "w2", "Kx", "Ky", "Jx", "Jy")
            rows.append([terms.get(name, 0) for name in unknowns])
            right.append(value)

        equation(0, v1x=p.m1, Kx=-1, Jx=1)
        equation(0, v1y=p.m1, Ky=-1, Jy=1)
        equation(p.P, v2x=p.m2, Jx=-1)
        equation(0, v2y=p.m2, Jy=-1)
        # About each centre: pivot and upper joint at -arm, lower joint at +arm; x Fy - y Fx.
        equation(0, w1=p.m1 * p.L1**2 / 12, Ky=arm1[0], Kx=-arm1[1], Jy=arm1[0], Jx=-arm1[1])
        equation(-hit[1] * p.P, w2=p.m2 * p.L2**2 / 12, Jy=arm2[0], Jx=-arm2[1])
        # The pivot is at rest; the joint moves with both rods: v + w x arm.
        equation(0, v1x=1, w1=arm1[1])
        equation(0, v1y=1, w1=-arm1[0])
        equation(0, v1x=1, w1=-arm1[1], v2x=-1, w2=-arm2[1])
        equation(0, v1y=1, w1=arm1[0], v2y=-1, w2=arm2[0])
        v1x, v1y, w1, v2x, v2y, w2, *_ = mp.lu_solve(mp.matrix(rows), mp.matrix(right))
        energy = (
            p.m1 * (v1x**2 + v1y**2)
            + p.m1 * p.L1**2 / 12 * w1**2
            + p.m2 * (v2x**2 + v2y**2)
            + p.m2 * p.L2**2 / 12 * w2**2
        ) / 2
        return {"first_rate": w1, "second_rate": w2, "energy": energy}
