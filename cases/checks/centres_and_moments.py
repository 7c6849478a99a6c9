"""Centres of mass, and forces and moments that are equipollent (Beatty, Dynamics, 5.2-5.4).

Checks: com_rigid_body, moment_equipollent.
"""

import flint
from gnomon.cases.declare import *
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.quadrature import integral
from gnomon.reference.numerics.vectors import add, components, cross, dot, named, scale, subtract


class ComRigidBody(Check):
    name = "com_rigid_body"
    title = "Centres of mass"
    section = "5.2"
    conventions = (
        "Measured from the centre of the base or of the full circle: hemisphere, half_disc and semicircular_wire of radius r, cone "
        "of radius r and height h. plate: a disc of radius r with a hole of radius s centred at x = d. particles: three "
        "masses at x = x1, x2, x3; a negative mass is a cavity."
    )
    guard = 60
    r = Parameter("m", "0.6", "radius", positive(1, 10))
    h = Parameter("m", "0.9", "height of the cone", positive())
    s = Parameter("m", "0.25", "radius of the hole", positive(0.01, 0.4))
    d = Parameter("m", "0.3", "centre of the hole", typical(-0.5, 0.5))
    m1 = Parameter("kg", 2)
    m2 = Parameter("kg", "-0.7")
    m3 = Parameter("kg", "1.1")
    x1 = Parameter("m", "0.2")
    x2 = Parameter("m", "-1.3")
    x3 = Parameter("m", "2.5")
    rules = (
        Rule("|d| + s <= r and s < r (the hole lies in the plate)", lambda p: abs(p["d"]) + p["s"] <= p["r"] > p["s"]),
        Rule("m1 + m2 + m3 is not zero", lambda p: p["m1"] + p["m2"] + p["m3"] != 0),
    )
    variants = (
        Variant(
            "ring_left",
            "the hole leaves 1e-12 of the plate, its centre is 1e-13 from the plate's",
            {"r": 1, "s": "0.999999999999", "d": "1e-13"},
        ),
        Variant(
            "cancelling_masses",
            "masses whose sum is 1e-15 of each: the centre is 1e15 m away",
            {"m1": 1, "m2": "-1.000000000000001", "m3": "2e-15", "x1": 1, "x2": 2, "x3": 3},
        ),
        Variant("pin_hole", "a hole of 1e-8 radii", {"s": "6e-9"}),
        Variant("flat_cone", "a cone with a height of 1e-8 radii", {"h": "6e-9"}),
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
        """Quadratures over slices; for particles the point of support about which their weights balance."""
        # Slices bounded by r sin(t) and r cos(t): no square-root singularity at the end of the interval.
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
        "A force F through the origin O and a couple M. moment_Q: moment about Q. pitch, axis: of the equivalent "
        "wrench, axis being its point nearest to O. momentum_O: moment of momentum about O of a body with momentum F, its "
        "centre of mass at Q, and moment of momentum M about that."
    )
    guard = 80
    Fx = Parameter("N", 3, "force, and momentum in kg m/s")
    Fy = Parameter("N", -2, "force, and momentum in kg m/s")
    Fz = Parameter("N", 5, "force, and momentum in kg m/s")
    Mx = Parameter("N m", "0.7", "couple")
    My = Parameter("N m", 4, "couple")
    Mz = Parameter("N m", "-1.5", "couple")
    Qx = Parameter("m", 1, "point")
    Qy = Parameter("m", "-0.4", "point")
    Qz = Parameter("m", "2.2", "point")
    rules = (Rule("F is not zero (a couple has no axis)", lambda p: any(p["F" + k] for k in "xyz")),)
    variants = (
        Variant(
            "faint_force",
            "|F| = 1e-20 of |M|: pitch and distance of the axis are 1e20",
            {"Fx": "3e-20", "Fy": "-2e-20", "Fz": "5e-20"},
        ),
        Variant("lever_1e8", "a lever arm of 1e8", {"Qx": "123456789.125", "Qy": "-98765432.5", "Qz": "1e8"}),
        Variant("pure_force", "M perpendicular to F: pitch zero", {"Mx": 2, "My": 3, "Mz": 0}),
        Variant("pure_wrench", "M along F: the axis goes through O", {"Mx": "0.3", "My": "-0.2", "Mz": "0.5"}),
    )

    def formulas(self, p: Any) -> Mapping[str, Any]:
        # In rational numbers, so that zeros are exact.
        F, M, Q = (tuple(self.parameters[name + k] for k in "xyz") for name in "FMQ")
        square = dot(F, F)
        numbers = {
            **named("moment_Q", subtract(M, cross(Q, F))),
            "pitch": dot(F, M) / square,
            **named("axis", scale(1 / square, cross(F, M))),
            **named("momentum_O", add(M, cross(Q, F))),
        }
        return {name: ball(value) for name, value in numbers.items()}

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """The wrench from four linear equations; the moments from its force along its axis."""
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
