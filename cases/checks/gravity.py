"""Gravitation of bodies, weight and centre of gravity (Beatty, Dynamics, 5.6-5.10).

Checks: gravity_field_particle_body, weight_local_gravity.
"""

from gnomon.cases.declare import *
from gnomon.reference.numerics.quadrature import integral, integral_near, unit_steps
from gnomon.reference.numerics.vectors import named
from gnomon.reference.orbits import fields


class GravityFieldParticleBody(Check):
    name = "gravity_field_particle_body"
    title = "Gravitational field of a particle, rod, ring, disc, shell and sphere"
    section = "5.6, 5.7"
    conventions = (
        "mu = G M for each body. Ring of radius a about z, field point (rho, z), components outward and along z; "
        "ring_excess: its potential minus the potential of a particle at the centre. Disc of radius a, point z on its axis. Rod of "
        "length L, point at distance r from its middle, perpendicular to it. Shell and solid sphere of radius a, distance r; "
        "attractions are positive."
    )
    guard = 60
    mu = Parameter("m^3/s^2", "3.986e14", "G M", positive())
    a = Parameter("m", "6.4e6", "radius of ring, disc, shell and sphere", positive())
    L = Parameter("m", "5e6", "length of the rod", positive())
    rho = Parameter("m", "5e6", "distance of the field point from the ring's axis", nonnegative())
    z = Parameter("m", "3e6", "height of the field point above ring and disc", positive())
    r = Parameter("m", "8e6", "distance from rod, shell and sphere", positive())
    rules = (Rule("r is not a (the shell's field jumps there)", lambda p: p["r"] != p["a"]),)
    variants = (
        Variant(
            "at_ring",
            "1e-10 of a radius from the ring: 1 - m = 2.5e-21",
            {"mu": 1, "a": 1, "rho": 1, "z": "1e-10", "r": "1.5", "L": 1},
        ),
        Variant(
            "inside_ring",
            "1e-10 above the ring's plane, 1e-10 from the ring",
            {"mu": 1, "a": 1, "rho": "0.9999999999", "z": "1e-10", "r": "0.5", "L": 1},
        ),
        Variant(
            "above_shell",
            "1e-10 outside the shell",
            {"mu": 1, "a": 1, "rho": "0.5", "z": 1, "r": "1.0000000001", "L": "1e-8"},
        ),
        Variant(
            "below_shell",
            "1e-10 inside the shell: the field is zero, outside it is not",
            {"mu": 1, "a": 1, "rho": "0.5", "z": 1, "r": "0.9999999999", "L": "1e8"},
        ),
        Variant(
            "far",
            "1e8 radii away: ring and disc differ from a particle by 1e-16",
            {"mu": 1, "a": 1, "rho": 6 * 10**7, "z": 8 * 10**7, "r": 10**8, "L": 1},
        ),
        Variant("on_axis", "m = 0", {"mu": 1, "a": 1, "rho": 0, "z": "0.3", "r": "0.2", "L": 1}),
    )

    def formulas(self, p: Any) -> Mapping[str, Any]:
        outside = self.parameters["r"] > self.parameters["a"]
        shell, sphere = fields.shell(p.mu, p.a, p.r, outside), fields.sphere(p.mu, p.a, p.r, outside)
        ring = fields.ring_potential(p.mu, p.a, p.rho, p.z)
        return {
            "particle": p.mu / (p.r * p.r),
            "rod": fields.rod_midplane(p.mu, p.L, p.r),
            "ring_potential": ring,
            "ring_excess": ring + p.mu / (p.rho * p.rho + p.z * p.z).sqrt(),
            **named("ring", fields.ring_field(p.mu, p.a, p.rho, p.z), ("rho", "z")),
            "disc": fields.disc_axis(p.mu, p.a, p.z),
            "shell": shell[0],
            "shell_potential": shell[1],
            "sphere": sphere[0],
            "sphere_potential": sphere[1],
        }

    @property
    def _shell_scale(self) -> Fraction:
        return self.parameters["mu"] / self.parameters["a"] ** 2

    def sizes(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """The field inside the shell is zero: its size is the field just outside."""
        sizes = super().sizes(values)
        return sizes | {"shell": sizes["shell"] if values["shell"] else float(self._shell_scale)}

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """Newton's law integrated over the bodies: quadratures over particles, and over rings of them."""
        ring = self._ring(mp, p)
        shell, shell_potential = self._shell(mp, p)
        sphere, sphere_potential = self._sphere(mp, p)
        # The potential of a particle along the line towards it.
        particle = mp.diff(lambda r: -p.mu / r, p.r, h=p.r * mp.mpf(10) ** (-mp.dps // 3))
        rod = integral_near(
            mp, lambda x: p.mu / p.L * p.r / mp.sqrt(p.r**2 + x**2) ** 3, -p.L / 2, p.L / 2, mp.mpf(0), p.r
        )
        disc = integral_near(
            mp, lambda s: 2 * p.mu / p.a**2 * s * p.z / mp.sqrt(s**2 + p.z**2) ** 3, mp.mpf(0), p.a, mp.mpf(0), p.z
        )
        return {
            "particle": particle,
            "rod": rod,
            "ring_potential": ring[0],
            "ring_excess": ring[0] + p.mu / mp.hypot(p.rho, p.z),
            **named("ring", ring[1:], ("rho", "z")),
            "disc": disc,
            "shell": shell,
            "shell_potential": shell_potential,
            "sphere": sphere,
            "sphere_potential": sphere_potential,
        }

    def _ring(self, mp: Any, p: Any) -> list[Any]:
        """Potential and field from half the ring; the distance at azimuth phi is sqrt(near^2 + 4 a rho sin^2(phi/2))."""
        near = (p.a - p.rho) ** 2 + p.z**2

        def particles(phi: Any) -> list[Any]:
            distance = mp.sqrt(near + 4 * p.a * p.rho * mp.sin(phi / 2) ** 2)
            share = p.mu / (mp.pi * distance)
            towards = p.a * mp.cos(phi) - p.rho
            return [-share, share * towards / distance**2, -share * p.z / distance**2]

        # The distance vanishes at a complex azimuth i delta.
        delta = 2 * mp.asinh(mp.sqrt(near / (4 * p.a * p.rho))) if p.rho > 0 else mp.pi
        return list(integral_near(mp, particles, mp.mpf(0), mp.pi, mp.mpf(0), delta))

    def _shell(self, mp: Any, p: Any) -> tuple[Any, Any]:
        """From rings about the line to the field point, at distances D = exp(v); their area is proportional to D dD."""
        low, high = mp.log(mp.fabs(p.r - p.a)), mp.log(p.r + p.a)

        def ring(v: Any) -> list[Any]:
            D = mp.exp(v)
            share = p.mu * D * D / (2 * p.r * p.a)
            cosine = (p.r**2 + D**2 - p.a**2) / (2 * p.r * D)
            return [share * cosine / D**2, -share / D]

        field = integral(mp, ring, unit_steps(low, high))
        return field[0], field[1]

    def _sphere(self, mp: Any, p: Any) -> tuple[Any, Any]:
        """From discs normal to the line to the field point; the disc at x has radius sqrt(a^2 - x^2)."""
        density = p.mu / (4 * mp.pi * p.a**3 / 3)

        def discs(D: Any) -> list[Any]:
            # x = (a^2 + r^2 - D^2)/(2 r), D the distance of the disc's rim: no square roots remain.
            height = p.r - (p.a**2 + p.r**2 - D**2) / (2 * p.r)
            side = mp.sign(height)
            share = 2 * mp.pi * density * D / p.r
            return [share * (side - height / D), -share * (D - mp.fabs(height))]

        edges = [mp.fabs(p.r - p.a), p.r + p.a]
        if p.r < p.a:
            # The disc through the field point separates the discs that pull inward from those that pull outward.
            edges.insert(1, mp.sqrt(p.a**2 - p.r**2))
        field = integral(mp, discs, edges)
        return field[0], field[1]


class WeightLocalGravity(Check):
    name = "weight_local_gravity"
    title = "Weight at a height; centre of gravity of a vertical rod"
    section = "5.10"
    conventions = (
        "g(h) = g0 (R/(R+h))^2, its first order, and the error of that; for a vertical rod of length L from h to h + L: "
        "its weight per mass, and the distance of its centre of gravity below its centre of mass."
    )
    guard = 60
    g0 = Parameter("m/s^2", "9.81", "acceleration of gravity at the ground", positive())
    R = Parameter("m", "6.371e6", "radius of the planet", positive(1, 10))
    h = Parameter("m", "4e5", "height", nonnegative())
    L = Parameter("m", "1e3", "length of the rod", positive())
    variants = (
        Variant("short_rod", "L = 1e-12 R: the two centres are 1e-25 R apart", {"R": 10**7, "L": "1e-5", "h": 0}),
        Variant("low", "h = 1e-12 R: the error of the first order is 3e-24", {"R": 10**7, "h": "1e-5"}),
        Variant("high", "1e8 radii away", {"h": "6.371e14"}),
        Variant("space_elevator", "a rod with a length of five radii", {"L": "3.2e7", "h": 0}),
    )

    def formulas(self, p: Any) -> Mapping[str, Any]:
        g = p.g0 * (p.R / (p.R + p.h)) ** 2
        first = p.g0 * (1 - 2 * p.h / p.R)
        below, above = p.R + p.h, p.R + p.h + p.L
        return {
            "g": g,
            "first_order": first,
            "beyond_first_order": g - first,
            "rod_weight_per_mass": p.g0 * p.R * p.R / (below * above),
            "centre_of_gravity_below": (above.sqrt() - below.sqrt()) ** 2 / 2,
        }

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """Differences of the potential; the weight integrated along the rod; the height where a particle weighs the same."""
        mu = p.g0 * p.R**2
        step = p.R * mp.mpf(10) ** (-mp.dps // 2)

        def potential(h: Any) -> Any:
            return -mu / (p.R + h)

        with mp.workdps(3 * mp.dps):
            g = (potential(p.h + step) - potential(p.h - step)) / (2 * step)
            g_ground = (potential(step) - potential(-step)) / (2 * step)
            slope = (potential(step) - 2 * potential(0) + potential(-step)) / step**2

        # With exp(v) as variable for the height the integrand is smooth at any length. g falls by 2 g/r per metre.
        begin, end = mp.log(p.R), mp.log(p.R + p.h)
        beyond = integral(mp, lambda v: (2 * p.g0 / p.R - 2 * mu * mp.exp(-3 * v)) * mp.exp(v), unit_steps(begin, end))
        below, above = mp.log(p.R + p.h), mp.log(p.R + p.h + p.L)
        weight = integral(mp, lambda v: mu * mp.exp(-v) / p.L, unit_steps(below, above))
        # The height of a given weight, by Newton's method from the middle of the rod.
        middle = p.R + p.h + p.L / 2
        centre = middle
        for _ in range(2 * mp.dps):
            correction = (mu / centre**2 - weight) / (-2 * mu / centre**3)
            centre -= correction
            if mp.fabs(correction) <= centre * mp.mpf(10) ** (2 - mp.dps):
                break
        return {
            "g": g,
            "first_order": g_ground + slope * p.h,
            "beyond_first_order": beyond,
            "rod_weight_per_mass": weight,
            "centre_of_gravity_below": middle - centre,
        }
