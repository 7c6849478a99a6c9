"""Derived numbers of rigid bodies: unbalanced rotors, struck rods (Beatty 10.11, 10.12, 11.10).

Checks: rotor_dynamic_balance, generalized_impulse.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, ClassVar

from gnomon.cases.checks.frames import second_derivative
from gnomon.cases.core.check import Check, Setting
from gnomon.cases.core.numbers import Domain, Parameter, Range, Rule, positive
from gnomon.reference.numerics.vectors import named
from gnomon.reference.rigid_bodies import bodies
from gnomon.reference.rigid_bodies.struck_rods import rates


class RotorDynamicBalance(Check):
    name = "rotor_dynamic_balance"
    title = "Static and dynamic unbalance of a rotor; bearing reactions"
    section = "10.11.3, 10.12.4"
    conventions = (
        "A disc of radius r and thickness h turns at w about z, its axis tilted by beta in the x-z plane that turns with it, "
        "its centre at x = e; bearings at z = d (A) and z = -d (B), no gravity. In turning axes: I_xz, the torque about y "
        "and the forces along x on the rotor, and the mass times radius, in the bearings' planes along x, that balances it."
    )
    parameter_list = (
        Parameter("m", "kg", 12, "mass"),
        Parameter("r", "m", "0.25", "radius"),
        Parameter("h", "m", "0.04", "thickness"),
        Parameter("beta", "rad", "0.01", "tilt"),
        Parameter("e", "m", "2e-4", "eccentricity"),
        Parameter("d", "m", "0.3", "distance of the bearings from the centre"),
        Parameter("w", "rad/s", "157.1", "rate"),
    )
    domain = Domain(
        {name: positive() for name in ("m", "r", "h", "d")}
        | {"beta": Range(-1.5, 1.5, typical=(-1.5, 1.5)), "e": Range(typical=(-1.0, 1.0))}
    )
    variants = (
        Setting("statically_balanced", "e = 0: a pure couple", {"e": 0}),
        Setting("slight_tilt", "a tilt of 1e-10", {"beta": "1e-10"}),
        Setting(
            "nearly_isotropic",
            "h = sqrt(3) r but for 1e-15: I3 - I1 all but vanishes",
            {"r": 1, "h": "1.732050807568877"},
        ),
        Setting(
            "one_bearing_free", "the couple takes all from bearing A but 1e-6", {"e": "5.163534e-4", "beta": "0.01"}
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
        """A rotor that does not turn needs the same balance."""
        return tuple(mp.lu_solve(mp.matrix([[1, 1], [p.d, -p.d]]), mp.matrix([-p.m * p.e, product])))


class GeneralizedImpulse(Check):
    name = "generalized_impulse"
    title = "Struck double rod: generalized impulse and momentum"
    section = "11.10.5"
    conventions = (
        "Two uniform rods in a chain, at rest at angles th1, th2 from the downward vertical, the first on a fixed pivot, are "
        "struck by a horizontal impulse P at distance d from the joint along the second. rate: th1', th2' after the blow."
    )
    parameter_list = (
        Parameter("m1", "kg", 2, "mass of the first rod"),
        Parameter("m2", "kg", 3, "mass of the second rod"),
        Parameter("L1", "m", "0.8", "length of the first rod"),
        Parameter("L2", "m", "1.2", "length of the second rod"),
        Parameter("th1", "rad", "0.3", "angle of the first rod"),
        Parameter("th2", "rad", "-0.5", "angle of the second rod"),
        Parameter("P", "N s", 5, "impulse"),
        Parameter("d", "m", "0.9", "where it strikes"),
    )
    domain = Domain(
        {name: positive() for name in ("m1", "m2", "L1", "L2")}
        | {
            "th1": Range(typical=(-3.0, 3.0)),
            "th2": Range(typical=(-3.0, 3.0)),
            "d": Range(low=0.0, typical=(0.0, 10.0)),
        },
        (Rule("d <= L2 (the impulse strikes the rod)", lambda p: p["d"] <= p["L2"]),),
    )
    variants = (
        Setting("hanging", "both straight down", {"th1": 0, "th2": 0}),
        Setting("percussion", "straight down, struck at 2/3 of the second rod: the first does not move", {"th1": 0, "th2": 0, "L2": "1.2", "d": "0.8"}),
        Setting("heavy_above", "m1 = 1e8 m2", {"m1": 10**8, "m2": 1}),
        Setting("heavy_below", "m2 = 1e8 m1: M all but singular in line", {"m1": 1, "m2": 10**8, "th1": "0.4", "th2": "0.4"}),
        Setting("short_second", "L2 = 1e-8 L1", {"L1": 1, "L2": "1e-8", "d": "5e-9"}),
    )  # fmt: skip
    guard = 60

    def formulas(self, p: Any) -> Mapping[str, Any]:
        found = rates((p.m1, p.m2), (p.L1, p.L2), (p.th1, p.th2), p.P, p.d)
        struck = p.P * (p.L1 * p.th1.cos() * found[0] + p.d * p.th2.cos() * found[1])
        return {"first_rate": found[0], "second_rate": found[1], "energy": struck / 2}

    def sizes(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """The first rate can vanish: it is measured by the speed of the joint that the second would give it."""
        found = super().sizes(values)
        ratio = float(self.parameters["L2"] / self.parameters["L1"])
        return found | {"first_rate": found["first_rate"] + 1e-3 * ratio * found["second_rate"]}

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """Newton's and Euler's laws for each rod with the impulses of pivot and joint: ten linear equations."""
        arm1 = (p.L1 * mp.sin(p.th1) / 2, -p.L1 * mp.cos(p.th1) / 2)
        arm2 = (p.L2 * mp.sin(p.th2) / 2, -p.L2 * mp.cos(p.th2) / 2)
        hit = ((2 * p.d / p.L2 - 1) * arm2[0], (2 * p.d / p.L2 - 1) * arm2[1])
        # Unknown: v1x v1y w1 v2x v2y w2, impulse K of the pivot on rod 1, impulse J of the joint on rod 2.
        rows, right = [], []

        def equation(value: Any, **terms: Any) -> None:
            order = ("v1x", "v1y", "w1", "v2x", "v2y", "w2", "Kx", "Ky", "Jx", "Jy")
            rows.append([terms.get(name, 0) for name in order])
            right.append(value)

        equation(0, v1x=p.m1, Kx=-1, Jx=1)
        equation(0, v1y=p.m1, Ky=-1, Jy=1)
        equation(p.P, v2x=p.m2, Jx=-1)
        equation(0, v2y=p.m2, Jy=-1)
        # About each centre: pivot and upper joint at -arm, lower joint at +arm; x Fy - y Fx.
        equation(0, w1=p.m1 * p.L1**2 / 12, Ky=arm1[0], Kx=-arm1[1], Jy=arm1[0], Jx=-arm1[1])
        equation(-hit[1] * p.P, w2=p.m2 * p.L2**2 / 12, Jy=arm2[0], Jx=-arm2[1])
        # The pivot stands still; the joint moves with both rods: v + w x arm.
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
