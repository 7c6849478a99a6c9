"""Inertia: closed forms of special bodies, composite bodies and transfer, principal moments (Beatty 9, App. D).

Checks: inertia_tensor_special_bodies, inertia_composite_parallel_axis, inertia_transformation_principal.
"""

from itertools import pairwise

import flint
from gnomon.cases.core.check import Numbers
from gnomon.cases.declare import *
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.vectors import (
    PLANES,
    apply,
    components,
    dot,
    entries,
    multiply,
    named,
    symmetric,
    transpose,
)
from gnomon.reference.rigid_bodies import bodies, inertia
from gnomon.reference.rigid_bodies.principal import determinant, is_inertia, multiplicity, principal_moments


class InertiaTensorSpecialBodies(Check):
    name = "inertia_tensor_special_bodies"
    title = "Inertia tensors of special bodies"
    section = "9.3-9.5, App. D"
    conventions = (
        "Each body has mass m; principal moments about its centre of mass (cone_apex: about the apex); z is the axis "
        "of revolution. a, b, c: edges of the box, semi-axes of the ellipsoid; a, b: edges of the lamina. r: radius, for "
        "the torus the radius of its tube; inner: inner radius of the tube; h: height; R: radius of the torus' middle circle."
    )
    m = Parameter("kg", "2.5", "mass", positive())
    a = Parameter("m", "0.3", "edge or semi-axis along x", positive())
    b = Parameter("m", "0.5", "edge or semi-axis along y", positive())
    c = Parameter("m", "0.7", "edge or semi-axis along z", positive())
    r = Parameter("m", "0.4", "radius", positive())
    inner = Parameter("m", "0.25", "inner radius of the tube", nonnegative(0, 5))
    h = Parameter("m", "1.1", "height", positive())
    R = Parameter("m", "0.9", "radius of the torus' middle circle", positive())
    rules = (
        Rule("inner < r", lambda p: p["inner"] < p["r"]),
        Rule("r <= R (the torus does not intersect itself)", lambda p: p["r"] <= p["R"]),
    )
    variants = (
        Variant("thin_disc", "h = 1e-8 r: cylinder, cone and box become laminae", {"h": "4e-9", "c": "4e-9"}),
        Variant("thin_rod", "r = 1e-8 h: cylinder and cone become rods", {"r": "1e-8", "inner": 0, "h": 1}),
        Variant("thin_wall", "a tube with a wall of 1e-12 radii", {"inner": "0.3999999999996"}),
        Variant("aspect_1e8", "edges 1e-8, 1 and 1e8", {"a": "1e-8", "b": 1, "c": "1e8"}),
        Variant("horn_torus", "r = R: a torus without a hole", {"R": "0.4"}),
    )

    def formulas(self, p: Any) -> Mapping[str, Any]:
        m = p.m
        moments = {
            "box": inertia.box(m, p.a, p.b, p.c),
            "ellipsoid": inertia.ellipsoid(m, p.a, p.b, p.c),
            "sphere": inertia.ellipsoid(m, p.r, p.r, p.r),
            "spherical_shell": inertia.spherical_shell(m, p.r),
            "hemisphere": inertia.hemisphere(m, p.r),
            "cylinder": inertia.cylinder(m, p.r, p.h),
            "tube": inertia.tube(m, p.r, p.inner, p.h),
            "cone": inertia.cone(m, p.r, p.h),
            "cone_apex": inertia.cone_apex(m, p.r, p.h),
            "torus": inertia.torus(m, p.R, p.r),
            "ring": inertia.ring(m, p.r),
            "lamina": inertia.lamina(m, p.a, p.b),
        }
        return {k: v for body, values in moments.items() for k, v in named(body, values).items()}

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """Quadrature over the volume of each body: the centre of mass, then the tensor."""
        moments: dict[str, Any] = {}
        for name, body in bodies.BODIES.items():
            points = bodies.masses(mp, body, [getattr(p, size) for size in body.sizes])
            origin = (0, 0, 0) if body.about_origin else bodies.centre(mp, points)
            tensor = bodies.second_moments(mp, points, origin)
            moments |= named(name, [p.m * tensor[i][i] for i in range(3)])
        return moments


class InertiaCompositeParallelAxis(Check):
    name = "inertia_composite_parallel_axis"
    title = "Composite body and the parallel-axis theorem"
    section = "9.2, 9.6, 9.7"
    conventions = (
        "A box with edges a, b, c and density rho, centred at (X, Y, Z), with a hole along z of radius r whose axis "
        "is at (p, q) from the box's centre. Tensors about the centre of mass and about the origin."
    )
    guard = 60
    rho = Parameter("kg/m^3", 2700, "density", positive(1, 10))
    a = Parameter("m", "0.4", "edge along x", positive(1, 10))
    b = Parameter("m", "0.3", "edge along y", positive(1, 10))
    c = Parameter("m", "0.1", "edge along z", positive(1, 10))
    r = Parameter("m", "0.05", "radius of the hole; 0 for none", nonnegative(0, 0.4))
    p = Parameter("m", "0.08", "x of the hole from the box's centre", typical(-0.1, 0.1))
    q = Parameter("m", "-0.06", "y of the hole from the box's centre", typical(-0.1, 0.1))
    X = Parameter("m", "1.5", "x of the box's centre")
    Y = Parameter("m", "-0.7", "y of the box's centre")
    Z = Parameter("m", "0.9", "z of the box's centre")
    rules = (
        Rule("|p| + r <= a/2 (the hole lies in the box)", lambda p: abs(p["p"]) + p["r"] <= p["a"] / 2),
        Rule("|q| + r <= b/2 (the hole lies in the box)", lambda p: abs(p["q"]) + p["r"] <= p["b"] / 2),
    )
    variants = (
        Variant(
            "far_1e8",
            "the origin is 1e8 edge lengths away: a transfer back cancels 16 digits",
            {"X": 3 * 10**7, "Y": 10**7},
        ),
        Variant("no_hole", "a box without a hole: products of inertia from the transfer alone", {"r": 0}),
        Variant("largest_hole", "the hole touches two faces", {"r": "0.15", "p": 0, "q": 0}),
        Variant("pin_hole", "a hole of 1e-8 edge lengths", {"r": "3e-9"}),
    )

    def formulas(self, p: Any) -> Mapping[str, Any]:
        plate, hole = p.rho * p.a * p.b * p.c, -p.rho * flint.arb.pi() * p.r * p.r * p.c
        m = plate + hole
        local = [hole * p.p / m, hole * p.q / m, p.a * 0]
        tensor = [[p.a * 0] * 3 for _ in range(3)]
        for mass, moments, place in (
            (plate, inertia.box(plate, p.a, p.b, p.c), (p.a * 0, p.a * 0, p.a * 0)),
            (hole, inertia.cylinder(hole, p.r, p.c), (p.p, p.q, p.a * 0)),
        ):
            own = [[moments[i] if i == j else p.a * 0 for j in range(3)] for i in range(3)]
            moved = inertia.transferred(own, mass, [x - o for x, o in zip(place, local, strict=True)])
            tensor = [[x + y for x, y in zip(*rows, strict=True)] for rows in zip(tensor, moved, strict=True)]
        centre = [x + y for x, y in zip(local, (p.X, p.Y, p.Z), strict=True)]
        return {
            "mass": m,
            **named("centre", centre),
            **named("about_centre", entries(tensor), PLANES),
            **named("about_origin", entries(inertia.transferred(tensor, m, centre)), PLANES),
        }

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """Quadrature over box and hole, about each point directly."""
        plate, hole = p.rho * p.a * p.b * p.c, -p.rho * mp.pi * p.r**2 * p.c
        points = []
        for mass, body, sizes, shift in (
            (plate, "box", (p.a, p.b, p.c), (0, 0)),
            (hole, "cylinder", (p.r, p.c), (p.p, p.q)),
        ):
            points += [
                (x + shift[0] + p.X, y + shift[1] + p.Y, z + p.Z, mass * w)
                for x, y, z, w in bodies.masses(mp, bodies.BODIES[body], sizes)
            ]
        centre = bodies.centre(mp, points)
        return {
            "mass": mp.fsum(point[3] for point in points),
            **named("centre", centre),
            **named("about_centre", entries(bodies.second_moments(mp, points, centre)), PLANES),
            **named("about_origin", entries(bodies.second_moments(mp, points)), PLANES),
        }


def _triangle(numbers: Numbers) -> bool:
    xx, yy, zz, xy, xz, yz = (numbers[name] for name in ("Ixx", "Iyy", "Izz", "Ixy", "Ixz", "Iyz"))
    return is_inertia((xx, yy, zz, xy, xz, yz))


def _turned(first: Fraction | int, second: Fraction | int, third: Fraction | int) -> dict[str, Number]:
    """Moments 9 (first, second, third) about axes (1, 2, 2), (2, 1, -2), (2, -2, 1): rational entries."""
    axes = ((1, 2, 2), (2, 1, -2), (2, -2, 1))
    values = (first, second, third)
    pairs = {"Ixx": (0, 0), "Iyy": (1, 1), "Izz": (2, 2), "Ixy": (0, 1), "Ixz": (0, 2), "Iyz": (1, 2)}
    return {k: sum(Fraction(d) * n[i] * n[j] for d, n in zip(values, axes, strict=True)) for k, (i, j) in pairs.items()}


class InertiaTransformationPrincipal(Check):
    name = "inertia_transformation_principal"
    title = "Change of axes and principal moments of inertia"
    section = "9.8-9.10"
    conventions = (
        "Ixy is the tensor's component (minus the product of inertia). The axes are rotated by Rx(beta) Rz(alpha); the "
        "moment and the radius of gyration are about the direction (nx, ny, nz), of any length. coinciding: the number of "
        "equal principal moments; invariant: trace, sum of principal minors, determinant; ellipsoid_radius: of "
        "Cauchy's ellipsoid x.I x = 1 along n."
    )
    Ixx = Parameter("kg m^2", 3, "", positive(3, 5))
    Iyy = Parameter("kg m^2", 4, "", positive(3, 5))
    Izz = Parameter("kg m^2", 5, "", positive(3, 5))
    Ixy = Parameter("kg m^2", "-0.4", "", typical(-0.5, 0.5))
    Ixz = Parameter("kg m^2", "0.3", "", typical(-0.5, 0.5))
    Iyz = Parameter("kg m^2", "-0.7", "", typical(-0.5, 0.5))
    m = Parameter("kg", 2, "mass", positive())
    alpha = Parameter("rad", "0.6", "first rotation, about z", typical(-3, 3))
    beta = Parameter("rad", "-1.1", "second rotation, about x", typical(-3, 3))
    nx = Parameter("", 1)
    ny = Parameter("", -2)
    nz = Parameter("", "0.5")
    rules = (
        Rule("the triangle inequality I1 + I2 >= I3 of the principal moments", _triangle),
        Rule("(nx, ny, nz) is not zero", lambda p: any(p[n] for n in ("nx", "ny", "nz"))),
    )
    variants = (
        Variant(
            "near_double",
            "two moments differ by 1.8e-15 of them: acos loses half the digits",
            _turned(1, 1 + Fraction(1, 2**49), Fraction(3, 2)),
        ),
        Variant(
            "near_double_1e_15",
            "two moments differ by 1e-15 of them, exact numbers",
            _turned(1, 1 + Fraction(1, 10**15), Fraction(3, 2)),
        ),
        Variant(
            "near_triple",
            "all three moments differ by less than 4e-15 of them",
            _turned(1, 1 + Fraction(1, 2**49), 1 + Fraction(2, 2**49)),
        ),
        Variant("exact_double", "two equal moments, the smaller ones, rotated axes", _turned(2, 2, 3)),
        Variant("exact_double_least", "two equal moments, the larger ones, rotated axes", _turned(2, 3, 3)),
        Variant("exact_triple", "three equal moments: every axis is principal", _turned(2, 2, 2)),
        Variant("flat", "I3 = I1 + I2 exactly: a lamina", _turned(1, 2, 3)),
        Variant("rod", "one moment exactly zero", _turned(0, 2, 2)),
        Variant("aspect_1e8", "a thin rod: one moment is 9e-16 of the others", _turned(Fraction(1, 2**50), 1, 1)),
    )

    @property
    def _entries(self) -> tuple[Fraction, Fraction, Fraction, Fraction, Fraction, Fraction]:
        xx, yy, zz, xy, xz, yz = (self.parameters["I" + plane] for plane in PLANES)
        return xx, yy, zz, xy, xz, yz

    def formulas(self, p: Any) -> Mapping[str, Any]:
        tensor = symmetric(components(p, "I", PLANES))
        ca, sa, cb, sb = p.alpha.cos(), p.alpha.sin(), p.beta.cos(), p.beta.sin()
        zero = p.m * 0
        # The rows of A are the new axes in components of the old ones: A = (Rx(beta) Rz(alpha))^T, rotations of the axes.
        A = ((ca, sa, zero), (-cb * sa, cb * ca, sb), (sb * sa, -sb * ca, cb))
        n = components(p, "n")
        moment = dot(n, apply(tensor, n)) / dot(n, n)
        return {
            **named("principal", principal_moments(self._entries), ("least", "middle", "largest")),
            **named("turned", entries(multiply(multiply(A, tensor), transpose(A))), PLANES),
            "moment_about_n": moment,
            "radius_of_gyration": (abs(moment) / p.m).sqrt(),
            "coinciding": flint.arb(multiplicity(self._entries)),
            **named("invariant", [ball(x) for x in self._invariants], ("first", "second", "third")),
            **({"ellipsoid_radius": 1 / moment.sqrt()} if self._turns_about_n else {}),
        }

    @property
    def _invariants(self) -> tuple[Fraction, Fraction, Fraction]:
        """Trace, sum of the principal minors, determinant."""
        xx, yy, zz, xy, xz, yz = self._entries
        minors = xx * yy - xy * xy + xx * zz - xz * xz + yy * zz - yz * yz
        return xx + yy + zz, minors, determinant(self._entries)

    @property
    def _turns_about_n(self) -> bool:
        """Whether the moment about n is not zero; if it is, as for a thin rod, Cauchy's ellipsoid is unbounded along n."""
        x, y, z = (self.parameters["n" + axis] for axis in "xyz")
        xx, yy, zz, xy, xz, yz = self._entries
        return xx * x * x + yy * y * y + zz * z * z + 2 * (xy * x * y + xz * x * z + yz * y * z) != 0

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """Eigenvalues by QR; the tensor of six equimomental points, rotated; the moment from distances to the axis."""
        matrix = mp.matrix(symmetric(components(p, "I", PLANES)))
        values = sorted(mp.eigsy(matrix, eigvals_only=True))
        near = [mp.fabs(b - a) <= mp.fabs(values[2]) * mp.mpf(10) ** (10 - mp.dps) for a, b in pairwise(values)]
        points = _points(mp, *mp.eigsy(matrix))
        n = mp.matrix(components(p, "n"))
        n = n / mp.norm(n)
        moment = mp.fsum(
            mass * (mp.norm(mp.matrix(place)) ** 2 - (mp.matrix(place).T * n)[0] ** 2) for *place, mass in points
        )
        # In components of rotated axes the points rotate the other way.
        turned = []
        for x, y, z, mass in points:
            along = mp.expj(-p.alpha) * mp.mpc(x, y)
            up = mp.expj(-p.beta) * mp.mpc(along.imag, z)
            turned.append((along.real, up.real, up.imag, mass))
        return {
            **named("principal", values, ("least", "middle", "largest")),
            **named("turned", entries(bodies.second_moments(mp, turned)), PLANES),
            "moment_about_n": moment,
            "radius_of_gyration": mp.sqrt(mp.fabs(moment) / p.m),
            "coinciding": 1 + sum(near),
            **named("invariant", _symmetric_functions(values), ("first", "second", "third")),
            **({"ellipsoid_radius": _to_the_surface(mp, matrix, n)} if self._turns_about_n else {}),
        }


def _symmetric_functions(values: Any) -> tuple[Any, Any, Any]:
    a, b, c = values
    return a + b + c, a * b + b * c + c * a, a * b * c


def _to_the_surface(mp: Any, matrix: Any, n: Any) -> Any:
    """The distance along n at which x.I x = 1, by bisection."""

    def outside(r: Any) -> bool:
        x = r * n
        return bool((x.T * matrix * x)[0] > 1)

    low, high = mp.zero, mp.one
    while not outside(high):
        low, high = high, 2 * high
    while high - low > 4 * mp.eps * high:
        middle = (low + high) / 2
        low, high = (low, middle) if outside(middle) else (middle, high)
    return (low + high) / 2


def _points(mp: Any, values: Any, vectors: Any) -> list[tuple[Any, Any, Any, Any]]:
    """Six points of mass 1/2 on the principal axes with the given moments."""
    half = (values[0] + values[1] + values[2]) / 2
    points = []
    for k in range(3):
        distance = mp.sqrt(max(half - values[k], mp.mpf(0)))
        for sign in (1, -1):
            points.append((*(sign * distance * vectors[i, k] for i in range(3)), mp.mpf(1) / 2))
    return points
