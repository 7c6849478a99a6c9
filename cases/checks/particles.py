"""Derived numbers of particles and systems: rod tension, moment of momentum, internal energy (Beatty 7.10, 8.5-8.9).

Checks: rod_tension_circular, moment_momentum_moving_point, internal_potential_energy.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from itertools import combinations
from typing import Any

import flint
from gnomon.cases.core.check import Check, Setting
from gnomon.cases.core.numbers import Domain, Parameter, Range, Rule, positive
from gnomon.reference.guided.pendulum_on_hoop import Hoop
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.quadrature import integral, unit_steps
from gnomon.reference.numerics.vectors import add, components, cross, dot, named, scale, subtract


class RodTensionCircular(Check):
    name = "rod_tension_circular"
    title = "Tension in the rod of a pendulum"
    section = "7.10.1"
    conventions = (
        "theta from the downward vertical; negative tension is a push. tension: at time t of the motion; extreme.bottom and "
        "extreme.top: at the lowest and the highest point of the circle, by the energy (top: also where the pendulum does "
        "not get there, the speed squared being negative then)."
    )
    parameter_list = (
        Parameter("m", "kg", 2, "mass"),
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity"),
        Parameter("L", "m", "1.5", "length"),
        Parameter("theta", "rad", "0.9", "angle at the start"),
        Parameter("omega", "rad/s", "2.4", "rate at the start"),
        Parameter("t", "s", "1.3", "time"),
    )
    domain = Domain(
        {name: positive(1.0, 10.0) for name in ("m", "g", "L")}
        | {
            "theta": Range(typical=(-3.0, 3.0)),
            "omega": Range(typical=(-5.0, 5.0)),
            "t": Range(low=0.0, typical=(0.0, 5.0)),
        }
    )
    variants = (
        Setting(
            "loop",
            "v0^2 = 5 g L: the tension at the top is exactly zero",
            {"g": 5, "L": 1, "theta": 0, "omega": 5, "t": "0.9"},
        ),
        Setting(
            "separatrix",
            "creeping up to the top: the rod carries the weight",
            {"g": 1, "L": 1, "theta": 0, "omega": 2, "t": 20},
        ),
        Setting("whirl", "1e6 rad/s: weight is 1e-12 of the tension", {"omega": 10**6, "t": "0.001"}),
    )
    guard = 40

    def formulas(self, p: Any) -> Mapping[str, Any]:
        n = self.parameters
        motion = Hoop(n["g"] / n["L"], Fraction(0), n["theta"], n["omega"])
        still = motion.regime == Hoop.REST or n["t"] == 0
        theta, omega = (p.theta, p.omega) if still else motion._balls(n["t"])
        start = p.omega * p.omega * p.L - 2 * p.g * p.theta.cos()
        bottom, top = p.m * (start + 2 * p.g + p.g), p.m * (start - 2 * p.g - p.g)
        return {
            "tension": p.m * (p.L * omega * omega + p.g * theta.cos()),
            **named("extreme", (bottom, top), ("bottom", "top")),
        }

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """Second differences of the mass' place; the work of its weight by quadrature along the circle."""
        n = self.parameters
        motion = Hoop(n["g"] / n["L"], Fraction(0), n["theta"], n["omega"])
        digits = mp.dps
        # The place is that of the exact angle; time moves in steps far below all that happens.
        step = Fraction(1, 10 ** (digits // 2 + 20))
        with mp.workdps(3 * digits):
            places = []
            for time in (n["t"] - step, n["t"], n["t"] + step):
                theta = mp.mpf(motion.state(time, 3 * digits)[0])
                places.append(p.L * mp.mpc(mp.sin(theta), -mp.cos(theta)))
            before, here, after = places
            acceleration = (before - 2 * here + after) / mp.mpf(step) ** 2
            inward = -here / p.L
            needed = acceleration + mp.mpc(0, p.g)
            tension = p.m * (needed * mp.conj(inward)).real

        def speed_squared(to: Any) -> Any:
            low, high = sorted((p.theta, to))
            gained = integral(mp, lambda s: -2 * p.g * mp.sin(s), unit_steps(low, high))
            return p.L * p.omega**2 + (gained if p.theta < to else -gained)

        extreme = (p.m * (speed_squared(mp.mpf(0)) + p.g), p.m * (speed_squared(mp.pi) - p.g))
        return {"tension": tension, **named("extreme", extreme, ("bottom", "top"))}


class MomentMomentumMovingPoint(Check):
    name = "moment_momentum_moving_point"
    title = "Moment of momentum about a moving point"
    section = "8.5-8.6"
    conventions = (
        "Two particles joined by a spring of natural length zero fall in uniform gravity; Q moves as q + u t + c t^2/2. "
        "rate: of H_Q = sum (r - Q) x m v, which is M_Q - v_Q x p; relative_rate: of sum (r - Q) x m (v - v_Q), which is "
        "M_Q - (r_C - Q) x m a_Q. moment: M_Q, of the weights."
    )
    parameter_list = (
        Parameter("m1", "kg", 2, "mass of particle 1"),
        Parameter("m2", "kg", "0.5", "mass of particle 2"),
        Parameter("k", "N/m", 30, "stiffness"),
        Parameter("g", "m/s^2", "9.81", "acceleration of gravity, along -z"),
        *(Parameter(f"a{k}", "m", v, "particle 1 at the start") for k, v in zip("xyz", ("0.3", -1, 2), strict=True)),
        *(Parameter(f"b{k}", "m", v, "particle 2 at the start") for k, v in zip("xyz", ("1.1", "0.4", 1), strict=True)),
        *(Parameter(f"v{k}", "m/s", v, "velocity of particle 1") for k, v in zip("xyz", (2, "0.5", 3), strict=True)),
        *(Parameter(f"w{k}", "m/s", v, "velocity of particle 2") for k, v in zip("xyz", (-1, 4, "0.2"), strict=True)),
        *(Parameter(f"q{k}", "m", v, "Q at the start") for k, v in zip("xyz", ("0.6", "-0.2", 1), strict=True)),
        *(Parameter(f"u{k}", "m/s", v, "velocity of Q") for k, v in zip("xyz", ("0.9", -2, "1.4"), strict=True)),
        *(Parameter(f"c{k}", "m/s^2", v, "acceleration of Q") for k, v in zip("xyz", (3, "-0.7", 5), strict=True)),
        Parameter("t", "s", "0.8", "time"),
    )
    domain = Domain({name: positive() for name in ("m1", "m2", "k", "g")} | {"t": Range(low=0.0, typical=(0.0, 3.0))})
    variants = (
        Setting("light_partner", "m2 = 1e-9 m1", {"m2": "2e-9"}),
        Setting("stiff", "k = 1e10: the internal forces dwarf the weights and cancel", {"k": 10**10}),
        Setting("far_point", "Q is 1e8 away", {"qx": 10**8, "qy": -(10**8)}),
        Setting("fixed_point", "Q at rest: both forms are one", {f"{s}{k}": 0 for s in "uc" for k in "xyz"}),
    )
    guard = 60

    def formulas(self, p: Any) -> Mapping[str, Any]:
        # In rational numbers: what is zero is then exactly so.
        a, b, v, w, q, u, c = (tuple(self.parameters[name + k] for k in "xyz") for name in "abvwquc")
        n = self.parameters
        t, mass = n["t"], n["m1"] + n["m2"]
        weight = (Fraction(0), Fraction(0), -n["g"])
        centre_start = scale(1 / mass, add(scale(n["m1"], a), scale(n["m2"], b)))
        centre_velocity = scale(1 / mass, add(scale(n["m1"], v), scale(n["m2"], w)))
        # The internal forces appear nowhere: that is the theorem.
        centre = add(centre_start, scale(t, centre_velocity), scale(t * t / 2, weight))
        momentum = scale(mass, add(centre_velocity, scale(t, weight)))
        Q, Q_velocity = add(q, scale(t, u), scale(t * t / 2, c)), add(u, scale(t, c))
        arm = subtract(centre, Q)
        moment = cross(arm, scale(mass, weight))
        found = {
            **named("moment", moment),
            **named("rate", subtract(moment, cross(Q_velocity, momentum))),
            **named("relative_rate", subtract(moment, cross(arm, scale(mass, c)))),
        }
        return {name: ball(value) for name, value in found.items()}

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """Rates of H_Q from the motion of both particles, by differences of places and of H_Q."""
        digits = mp.dps
        with mp.workdps(6 * digits):
            a, b, v, w, q, u, c = (mp.matrix(components(p, name)) for name in "abvwquc")
            mass = p.m1 + p.m2
            rate = mp.sqrt(p.k * mass / (p.m1 * p.m2))
            weight = mp.matrix([0, 0, -p.g])
            fine, wide = mp.mpf(10) ** (-2 * digits) / (1 + rate), mp.mpf(10) ** (-digits) / (1 + rate)

            def places(t: Any) -> tuple[Any, Any, Any]:
                centre = (p.m1 * a + p.m2 * b + t * (p.m1 * v + p.m2 * w)) / mass + weight * t**2 / 2
                apart = (b - a) * mp.cos(rate * t) + (w - v) * mp.sin(rate * t) / rate
                return centre - p.m2 / mass * apart, centre + p.m1 / mass * apart, q + u * t + c * t**2 / 2

            def moments(t: Any) -> tuple[Any, Any]:
                here = places(t)
                speeds = [(y - x) / (2 * fine) for x, y in zip(places(t - fine), places(t + fine), strict=True)]
                plain, relative = mp.zeros(3, 1), mp.zeros(3, 1)
                for m, r, speed in zip((p.m1, p.m2), here, speeds, strict=False):
                    plain += m * mp.matrix(cross(list(r - here[2]), list(speed)))
                    relative += m * mp.matrix(cross(list(r - here[2]), list(speed - speeds[2])))
                return plain, relative

            before, after = moments(p.t - wide), moments(p.t + wide)
            rates = [list((y - x) / (2 * wide)) for x, y in zip(before, after, strict=True)]
            first, second, Q = places(p.t)
            pulled = [mp.matrix(cross(list(r - Q), list(m * weight))) for m, r in ((p.m1, first), (p.m2, second))]
            return {
                **named("moment", list(pulled[0] + pulled[1])),
                **named("rate", rates[0]),
                **named("relative_rate", rates[1]),
            }


class InternalPotentialEnergy(Check):
    name = "internal_potential_energy"
    title = "Internal potential energy of three particles and the forces that follow from it"
    section = "8.9.2, App. C"
    conventions = (
        "Each pair attracts by gravitation, G m_i m_j/r, and by a spring of stiffness k and natural length l. energy: their "
        "sum; force1, force2, force3: minus its gradient; their sum and their moment vanish."
    )
    parameter_list = (
        Parameter("G", "m^3/(kg s^2)", 1, "constant of gravitation"),
        Parameter("k", "N/m", "0.3", "stiffness"),
        Parameter("l", "m", "0.8", "natural length"),
        *(Parameter(f"m{k}", "kg", v) for k, v in zip("123", (3, 2, "1.5"), strict=True)),
        *(Parameter(f"a{k}", "m", v, "particle 1") for k, v in zip("xyz", ("0.3", -1, 2), strict=True)),
        *(Parameter(f"b{k}", "m", v, "particle 2") for k, v in zip("xyz", ("1.1", "0.4", 1), strict=True)),
        *(Parameter(f"c{k}", "m", v, "particle 3") for k, v in zip("xyz", ("-0.6", "0.9", "0.2"), strict=True)),
    )
    domain = Domain(
        {name: positive() for name in ("m1", "m2", "m3")}
        | {name: Range(low=0.0, typical=(0.0, 2.0)) for name in ("G", "k", "l")},
        (
            Rule(
                "no two particles are at one place",
                lambda p: all(any(p[i + k] != p[j + k] for k in "xyz") for i, j in combinations("abc", 2)),
            ),
        ),
    )
    variants = (
        Setting("close_pair", "two particles 1e-10 apart: their forces dwarf the third's", {"bx": "0.3000000001", "by": -1, "bz": 2}),
        Setting(
            "equilateral", "Lagrange's triangle: every force points at the centre of mass",
            {"k": 0, "ax": 1, "ay": 0, "az": 0, "bx": 0, "by": 1, "bz": 0, "cx": 0, "cy": 0, "cz": 1},
        ),
        Setting("far", "one particle 1e8 away", {"k": 0, "cx": 10**8}),
        Setting("light", "a mass of 1e-12", {"m3": "1e-12", "k": 0}),
    )  # fmt: skip
    guard = 60

    def formulas(self, p: Any) -> Mapping[str, Any]:
        places = {name: components(p, name) for name in "abc"}
        masses = {"a": p.m1, "b": p.m2, "c": p.m3}
        energy = flint.arb(0)
        forces = {name: (energy, energy, energy) for name in "abc"}
        for i, j in combinations("abc", 2):
            apart = subtract(places[j], places[i])
            square = dot(apart, apart)
            r = square.sqrt()
            stretch = r - p.l
            energy += -p.G * masses[i] * masses[j] / r + p.k * stretch * stretch / 2
            pull = scale(p.G * masses[i] * masses[j] / (square * r) + p.k * stretch / r, apart)
            forces[i], forces[j] = add(forces[i], pull), subtract(forces[j], pull)
        named_forces = {k: v for n, name in enumerate("abc", 1) for k, v in named(f"force{n}", forces[name]).items()}
        return {"energy": energy, **named_forces}

    def sizes(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Energies of gravitation and of springs can cancel: their sum is measured by a force times a length too."""
        found = super().sizes(values)
        return found | {"energy": found["energy"] + abs(values["force1.x"]) * 1e-3}

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """The energy by pairs as functions of all nine coordinates, differentiated by central differences."""
        masses = (p.m1, p.m2, p.m3)
        start = [x for name in "abc" for x in components(p, name)]

        def energy(q: Any) -> Any:
            total = mp.mpf(0)
            for i in range(3):
                for j in range(i):
                    r = mp.norm(mp.matrix([q[3 * i + n] - q[3 * j + n] for n in range(3)]))
                    total += p.k * (r - p.l) ** 2 / 2 - p.G * masses[i] * masses[j] / r
            return total

        digits = mp.dps
        with mp.workdps(3 * digits):
            h = mp.mpf(10) ** (-digits)
            slopes = []
            for n in range(9):
                there, back = list(start), list(start)
                there[n] += h
                back[n] -= h
                slopes.append(-(energy(there) - energy(back)) / (2 * h))
        found = {k: v for n in range(3) for k, v in named(f"force{n + 1}", slopes[3 * n : 3 * n + 3]).items()}
        return {"energy": energy(start), **found}
