"""Closed forms for particles and systems: rod tension, moment of momentum, internal energy (Beatty 7.10, 8.5-8.9).

Checks: rod_tension_circular, moment_momentum_moving_point, internal_potential_energy.
"""

from itertools import combinations

import flint
from gnomon.cases.declare import *
from gnomon.reference.guided.pendulum_on_hoop import Hoop
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.quadrature import integral, unit_steps
from gnomon.reference.numerics.vectors import add, components, cross, dot, named, scale, subtract


class RodTensionCircular(Check):
    name = "rod_tension_circular"
    title = "Tension in the rod of a pendulum"
    section = "7.10.1"
    conventions = (
        "theta from the downward vertical; a negative tension is compression. tension: at time t of the motion; "
        "extreme.bottom and extreme.top: at the lowest and the highest point of the circle, from the energy (at the top also "
        "if the pendulum does not reach it; the squared speed is then negative)."
    )
    m = Parameter("kg", 2, "mass", positive(1, 10))
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(1, 10))
    L = Parameter("m", "1.5", "length", positive(1, 10))
    theta = Parameter("rad", "0.9", "angle at the start", typical(-3, 3))
    omega = Parameter("rad/s", "2.4", "rate at the start", typical(-5, 5))
    t = Parameter("s", "1.3", "time", nonnegative(0, 5))
    variants = (
        Variant(
            "loop",
            "v0^2 = 5 g L: the tension at the top is exactly zero",
            {"g": 5, "L": 1, "theta": 0, "omega": 5, "t": "0.9"},
        ),
        Variant(
            "separatrix",
            "slowly close to the top: the rod carries the weight",
            {"g": 1, "L": 1, "theta": 0, "omega": 2, "t": 20},
        ),
        Variant("whirl", "1e6 rad/s: the weight is 1e-12 of the tension", {"omega": 10**6, "t": "0.001"}),
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
        """Second differences of the position of the mass; the work of its weight by quadrature along the circle."""
        n = self.parameters
        motion = Hoop(n["g"] / n["L"], Fraction(0), n["theta"], n["omega"])
        digits = mp.dps
        # The position follows from the exact angle; the time step is far below every time scale of the motion.
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
        "rate: of H_Q = sum (r - Q) x m v, equal to M_Q - v_Q x p; relative_rate: of sum (r - Q) x m (v - v_Q), "
        "equal to M_Q - (r_C - Q) x m a_Q. moment: M_Q of the weights."
    )
    m1 = Parameter("kg", 2, "mass of particle 1", positive())
    m2 = Parameter("kg", "0.5", "mass of particle 2", positive())
    k = Parameter("N/m", 30, "stiffness", positive())
    g = Parameter("m/s^2", "9.81", "acceleration of gravity, along -z", positive())
    ax = Parameter("m", "0.3", "particle 1 at the start")
    ay = Parameter("m", -1, "particle 1 at the start")
    az = Parameter("m", 2, "particle 1 at the start")
    bx = Parameter("m", "1.1", "particle 2 at the start")
    by = Parameter("m", "0.4", "particle 2 at the start")
    bz = Parameter("m", 1, "particle 2 at the start")
    vx = Parameter("m/s", 2, "velocity of particle 1")
    vy = Parameter("m/s", "0.5", "velocity of particle 1")
    vz = Parameter("m/s", 3, "velocity of particle 1")
    wx = Parameter("m/s", -1, "velocity of particle 2")
    wy = Parameter("m/s", 4, "velocity of particle 2")
    wz = Parameter("m/s", "0.2", "velocity of particle 2")
    qx = Parameter("m", "0.6", "Q at the start")
    qy = Parameter("m", "-0.2", "Q at the start")
    qz = Parameter("m", 1, "Q at the start")
    ux = Parameter("m/s", "0.9", "velocity of Q")
    uy = Parameter("m/s", -2, "velocity of Q")
    uz = Parameter("m/s", "1.4", "velocity of Q")
    cx = Parameter("m/s^2", 3, "acceleration of Q")
    cy = Parameter("m/s^2", "-0.7", "acceleration of Q")
    cz = Parameter("m/s^2", 5, "acceleration of Q")
    t = Parameter("s", "0.8", "time", nonnegative(0, 3))
    variants = (
        Variant("light_partner", "m2 = 1e-9 m1", {"m2": "2e-9"}),
        Variant("stiff", "k = 1e10 N/m: the internal forces are far larger than the weights and cancel", {"k": 10**10}),
        Variant("far_point", "Q is 1e8 away", {"qx": 10**8, "qy": -(10**8)}),
        Variant("fixed_point", "Q at rest: both definitions agree", {f"{s}{k}": 0 for s in "uc" for k in "xyz"}),
    )
    guard = 60

    def formulas(self, p: Any) -> Mapping[str, Any]:
        # In rational numbers, so that zeros are exact.
        a, b, v, w, q, u, c = (tuple(self.parameters[name + k] for k in "xyz") for name in "abvwquc")
        n = self.parameters
        t, mass = n["t"], n["m1"] + n["m2"]
        weight = (Fraction(0), Fraction(0), -n["g"])
        centre_start = scale(1 / mass, add(scale(n["m1"], a), scale(n["m2"], b)))
        centre_velocity = scale(1 / mass, add(scale(n["m1"], v), scale(n["m2"], w)))
        # By the theorem, internal forces do not appear.
        centre = add(centre_start, scale(t, centre_velocity), scale(t * t / 2, weight))
        momentum = scale(mass, add(centre_velocity, scale(t, weight)))
        Q, Q_velocity = add(q, scale(t, u), scale(t * t / 2, c)), add(u, scale(t, c))
        arm = subtract(centre, Q)
        moment = cross(arm, scale(mass, weight))
        numbers = {
            **named("moment", moment),
            **named("rate", subtract(moment, cross(Q_velocity, momentum))),
            **named("relative_rate", subtract(moment, cross(arm, scale(mass, c)))),
        }
        return {name: ball(value) for name, value in numbers.items()}

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """Rates of H_Q from the motion of both particles, by differences of positions and of H_Q."""
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
        "Each pair has gravitation, potential -G m_i m_j/r, and a spring of stiffness k and natural length l. energy: the "
        "sum of potentials; force1, force2, force3: minus its gradient; their sum and their moment vanish."
    )
    G = Parameter("m^3/(kg s^2)", 1, "constant of gravitation", nonnegative(0, 2))
    k = Parameter("N/m", "0.3", "stiffness", nonnegative(0, 2))
    l = Parameter("m", "0.8", "natural length", nonnegative(0, 2))
    m1 = Parameter("kg", 3, "", positive())
    m2 = Parameter("kg", 2, "", positive())
    m3 = Parameter("kg", "1.5", "", positive())
    ax = Parameter("m", "0.3", "particle 1")
    ay = Parameter("m", -1, "particle 1")
    az = Parameter("m", 2, "particle 1")
    bx = Parameter("m", "1.1", "particle 2")
    by = Parameter("m", "0.4", "particle 2")
    bz = Parameter("m", 1, "particle 2")
    cx = Parameter("m", "-0.6", "particle 3")
    cy = Parameter("m", "0.9", "particle 3")
    cz = Parameter("m", "0.2", "particle 3")
    rules = (
        Rule(
            "no two particles are at the same position",
            lambda p: all(any(p[i + k] != p[j + k] for k in "xyz") for i, j in combinations("abc", 2)),
        ),
    )
    variants = (
        Variant("close_pair", "two particles 1e-10 m apart: their forces are far larger than the third's", {"bx": "0.3000000001", "by": -1, "bz": 2}),
        Variant(
            "equilateral", "Lagrange's triangle: every force points to the centre of mass",
            {"k": 0, "ax": 1, "ay": 0, "az": 0, "bx": 0, "by": 1, "bz": 0, "cx": 0, "cy": 0, "cz": 1},
        ),
        Variant("far", "one particle 1e8 m away", {"k": 0, "cx": 10**8}),
        Variant("light", "a mass of 1e-12 kg", {"m3": "1e-12", "k": 0}),
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
        """Energies of gravitation and springs can cancel: the size of the sum is at least a force times a length."""
        sizes = super().sizes(values)
        return sizes | {"energy": sizes["energy"] + abs(values["force1.x"]) * 1e-3}

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """The energy as a sum over pairs, a function of all nine coordinates; the forces by central differences."""
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
        forces = {k: v for n in range(3) for k, v in named(f"force{n + 1}", slopes[3 * n : 3 * n + 3]).items()}
        return {"energy": energy(start), **forces}
