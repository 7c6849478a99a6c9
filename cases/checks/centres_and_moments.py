"""Centres of mass, and forces and moments that are equipollent (Beatty, Dynamics, 5.2-5.4).

Checks: com_rigid_body, moment_equipollent.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import flint
from gnomon.cases.core.check import Check, Setting
from gnomon.cases.core.numbers import Domain, Parameter, Range, Rule, positive
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.quadrature import integral
from gnomon.reference.numerics.vectors import add, components, cross, dot, named, scale, subtract


class ComRigidBody(Check):
    name = "com_rigid_body"
    title = "Centres of mass"
    section = "5.2"
    conventions = (
        "From the middle of the base or of the full circle: hemisphere, half_disc and semicircular_wire of radius r, cone "
        "of radius r and height h. plate: a disc of radius r with a hole of radius s centred at x = d. particles: three "
        "masses at x = x1, x2, x3; a negative mass is a cavity."
    )
    guard = 60
    parameter_list = (
        Parameter("r", "m", "0.6", "radius"),
        Parameter("h", "m", "0.9", "height of the cone"),
        Parameter("s", "m", "0.25", "radius of the hole"),
        Parameter("d", "m", "0.3", "centre of the hole"),
        Parameter("m1", "kg", 2),
        Parameter("m2", "kg", "-0.7"),
        Parameter("m3", "kg", "1.1"),
        Parameter("x1", "m", "0.2"),
        Parameter("x2", "m", "-1.3"),
        Parameter("x3", "m", "2.5"),
    )
    domain = Domain(
        {"r": positive(1.0, 10.0), "h": positive(), "s": positive(0.01, 0.4)} | {"d": Range(typical=(-0.5, 0.5))},
        (
            Rule(
                "|d| + s <= r and s < r (the hole lies in the plate)", lambda p: abs(p["d"]) + p["s"] <= p["r"] > p["s"]
            ),
            Rule("m1 + m2 + m3 is not zero", lambda p: p["m1"] + p["m2"] + p["m3"] != 0),
        ),
    )
    variants = (
        Setting(
            "ring_left",
            "the hole leaves 1e-12 of the plate, its centre 1e-13 off",
            {"r": 1, "s": "0.999999999999", "d": "1e-13"},
        ),
        Setting(
            "cancelling_masses",
            "masses whose sum is 1e-15 of each: the centre is 1e15 away",
            {"m1": 1, "m2": "-1.000000000000001", "m3": "2e-15", "x1": 1, "x2": 2, "x3": 3},
        ),
        Setting("pin_hole", "a hole of 1e-8 radii", {"s": "6e-9"}),
        Setting("flat_cone", "a cone 1e-8 of its radius high", {"h": "6e-9"}),
    )

    def formulas(self, p: Any) -> Mapping[str, Any]:
        masses, places = (p.m1, p.m2, p.m3), (p.x1, p.x2, p.x3)
        return {
            "hemisphere": 3 * p.r / 8,
            "half_disc": 4 * p.r / (3 * flint.arb.pi()),
            "semicircular_wire": 2 * p.r / flint.arb.pi(),
            "cone": p.h / 4,
            "plate": -p.d * p.s * p.s / (p.r * p.r - p.s * p.s),
            "particles": dot(masses, places) / (p.m1 + p.m2 + p.m3),
        }

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """Quadratures over slices; particles by the point of support about which their weights balance."""
        # r sin(t) and r cos(t) bound the slices: no root at the end of the interval.
        half = [mp.mpf(0), mp.pi / 2]

        def centre(slices: Any, edges: Any) -> Any:
            moment, mass = integral(mp, slices, edges)
            return moment / mass

        def plate(t: Any) -> list[Any]:
            full, hole = p.r * mp.cos(t), p.s * mp.cos(t)
            x, x_hole = p.r * mp.sin(t), p.d + p.s * mp.sin(t)
            return [2 * x * full**2 - 2 * x_hole * hole**2, 2 * full**2 - 2 * hole**2]

        def unbalance(support: Any) -> Any:
            return mp.fsum(m * (x - support) for m, x in ((p.m1, p.x1), (p.m2, p.x2), (p.m3, p.x3)))

        begin, end = unbalance(mp.mpf(0)), unbalance(mp.mpf(1))
        return {
            "hemisphere": centre(lambda t: [p.r * mp.sin(t) * mp.cos(t) ** 3, mp.cos(t) ** 3], half),
            "half_disc": centre(lambda t: [p.r * mp.sin(t) * mp.cos(t) ** 2, mp.cos(t) ** 2], half),
            "semicircular_wire": centre(lambda t: [p.r * mp.sin(t), mp.mpf(1)], [mp.mpf(0), mp.pi]),
            "cone": centre(lambda z: [z * (p.h - z) ** 2, (p.h - z) ** 2], [mp.mpf(0), p.h]),
            "plate": centre(plate, [-mp.pi / 2, mp.pi / 2]),
            "particles": begin / (begin - end),
        }


class MomentEquipollent(Check):
    name = "moment_equipollent"
    title = "Equipollent force systems: moment about another point, wrench, moment of momentum"
    section = "5.3-5.4"
    conventions = (
        "A force F through the origin O and a couple M. moment_Q: moment about Q. pitch, axis: the wrench to which they "
        "reduce, and the point of its axis nearest to O. momentum_O: moment about O of the momentum p of a body whose "
        "centre of mass is at Q and whose moment of momentum about it is M."
    )
    guard = 80
    parameter_list = (
        *(Parameter(f"F{k}", "N", v, "force, and momentum in kg m/s") for k, v in zip("xyz", (3, -2, 5), strict=True)),
        *(Parameter(f"M{k}", "N m", v, "couple") for k, v in zip("xyz", ("0.7", 4, "-1.5"), strict=True)),
        *(Parameter(f"Q{k}", "m", v, "point") for k, v in zip("xyz", (1, "-0.4", "2.2"), strict=True)),
    )
    domain = Domain({}, (Rule("F is not zero (a couple has no axis)", lambda p: any(p["F" + k] for k in "xyz")),))
    variants = (
        Setting(
            "faint_force",
            "|F| = 1e-20 of |M|: pitch and axis 1e20 away",
            {"Fx": "3e-20", "Fy": "-2e-20", "Fz": "5e-20"},
        ),
        Setting("lever_1e8", "a lever arm of 1e8", {"Qx": "123456789.125", "Qy": "-98765432.5", "Qz": "1e8"}),
        Setting("pure_force", "M perpendicular to F: pitch zero", {"Mx": 2, "My": 3, "Mz": 0}),
        Setting("pure_wrench", "M along F: the axis goes through O", {"Mx": "0.3", "My": "-0.2", "Mz": "0.5"}),
    )

    def formulas(self, p: Any) -> Mapping[str, Any]:
        # In rational numbers: what is zero is then exactly so.
        F, M, Q = (tuple(self.parameters[name + k] for k in "xyz") for name in "FMQ")
        square = dot(F, F)
        found = {
            **named("moment_Q", subtract(M, cross(Q, F))),
            "pitch": dot(F, M) / square,
            **named("axis", scale(1 / square, cross(F, M))),
            **named("momentum_O", add(M, cross(Q, F))),
        }
        return {name: ball(value) for name, value in found.items()}

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """The wrench from four linear equations; moments of its force along its axis, as the rate of area about Q."""
        F, M, Q = (components(p, name) for name in "FMQ")
        # r x F + pitch F = M and r.F = 0 for the axis point r and the pitch.
        matrix = mp.matrix(
            [
                [0, F[2], -F[1], F[0]],
                [-F[2], 0, F[0], F[1]],
                [F[1], -F[0], 0, F[2]],
                [F[0], F[1], F[2], 0],
            ]
        )
        x, y, z, pitch = mp.lu_solve(matrix, mp.matrix([*M, 0]))

        def moment(point: Any) -> list[Any]:
            arm = (x - point[0], y - point[1], z - point[2])
            planes = ((1, 2), (2, 0), (0, 1))
            areas = [mp.det(mp.matrix([[arm[i], arm[j]], [F[i], F[j]]])) for i, j in planes]
            return [area + pitch * f for area, f in zip(areas, F, strict=True)]

        about_Q = moment(Q)
        mirrored = moment([-q for q in Q])
        return {
            **named("moment_Q", about_Q),
            "pitch": pitch,
            **named("axis", (x, y, z)),
            **named("momentum_O", mirrored),
        }
