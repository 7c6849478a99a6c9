"""Work, kinetic energy and power of rigid bodies: a free body, a heavy top, a sliding ball (Beatty 10.16-10.21)."""

from collections.abc import Callable, Sequence
from fractions import Fraction
from typing import ClassVar

from gnomon.cases.declare import *
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.quadrature import integral
from gnomon.reference.numerics.vectors import multiply, turn_x, turn_z
from gnomon.reference.rigid_bodies.euler_top import EulerTop
from gnomon.reference.rigid_bodies.lagrange_top import LagrangeTop


class WorkEnergyRigidBody(Check):
    name = "work_energy_rigid_body"
    title = "Kinetic energy (Koenig), power and work of rigid bodies"
    section = "10.16, 10.18-10.21"
    conventions = (
        "A free body with principal moments I1, I2, I3 falls with weight along -z while it rotates: kinetic energy about the "
        "centre of mass and total one at time t, power of its weight, work since the start. top_*: the same for a symmetric "
        "top on a fixed point (moments A, A, C about it, weight times distance W, momenta p_psi and p_phi, theta from the "
        "upward vertical), whose weight has the power M.w. ball_loss: energy that friction takes from a billiard ball "
        "(mass m, mu) whose contact point slides at (s0x, s0y) at first, until it rolls."
    )
    I1 = Parameter("kg m^2", 1, "principal moment", positive(3, 5))
    I2 = Parameter("kg m^2", 2, "principal moment", positive(3, 5))
    I3 = Parameter("kg m^2", "2.5", "principal moment", positive(3, 5))
    w1 = Parameter("rad/s", "0.4", "rate at the start", typical(-2, 2))
    w2 = Parameter("rad/s", "1.3", "rate at the start", typical(-2, 2))
    w3 = Parameter("rad/s", "-0.7", "rate at the start", typical(-2, 2))
    vx = Parameter("m/s", 3, "velocity of the centre")
    vy = Parameter("m/s", "-1.5", "velocity of the centre")
    vz = Parameter("m/s", 7, "velocity of the centre")
    m = Parameter("kg", 4, "mass", positive())
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    t = Parameter("s", "1.7", "time", nonnegative(0, 3))
    A = Parameter("kg m^2", "0.8", "transverse moment of the top about its fixed point", positive(2, 5))
    C = Parameter("kg m^2", "0.3", "moment of the top about its axis", positive(0.5, 3))
    W = Parameter("N m", 3, "weight of the top times the distance of its centre from the fixed point", positive(1, 20))
    theta = Parameter("rad", "0.6", "tilt of the top at the start", Range(0.0, pi, low_open=True, typical=(0.1, 3.0)))
    rate = Parameter("rad/s", "0.5", "theta' at the start", typical(-2, 2))
    p_psi = Parameter("kg m^2/s", "4.5", "momentum of the spin", typical(-5, 5))
    p_phi = Parameter("kg m^2/s", 4, "momentum about the vertical", typical(-5, 5))
    mu = Parameter("", "0.2", "coefficient of friction", positive())
    s0x = Parameter("m/s", "1.2", "sliding speed", typical(-3, 3))
    s0y = Parameter("m/s", "-0.5", "sliding speed", typical(0.1, 3))
    rules = (
        Rule(
            "the triangle inequality of I1, I2, I3",
            lambda p: 2 * max(p[i] for i in ("I1", "I2", "I3")) <= p["I1"] + p["I2"] + p["I3"],
        ),
        Rule("C <= 2 A (the triangle inequality of the top)", lambda p: p["C"] <= 2 * p["A"]),
        Rule(
            "p_phi differs from p_psi and -p_psi (the top passes neither pole)",
            lambda p: abs(p["p_phi"]) != abs(p["p_psi"]),
        ),
        Rule("(s0x, s0y) is not zero (the ball slides)", lambda p: bool(p["s0x"] or p["s0y"])),
    )
    variants = (
        Variant(
            "middle_axis", "rotation about the middle axis, 1e-6 from it", {"w1": "1e-6", "w2": 3, "w3": 0, "t": 6}
        ),
        Variant("flat_body", "I3 = I1 + I2: all mass in a plane", {"I1": 1, "I2": 2, "I3": 3}),
        Variant(
            "slow_turn", "rotation has 2e-22 of the energy", {"w1": "1e-10", "w2": "2e-10", "w3": "-1e-10", "t": 2}
        ),
        Variant("apex", "at t the body is at its apex: the power vanishes", {"g": 10, "vz": 20, "t": 2}),
        Variant(
            "fast_top",
            "the work of the weight is 4e-12 of the top's energy",
            {"p_psi": 10**4, "p_phi": 9000, "t": "0.002"},
        ),
        Variant(
            "top_without_spin",
            "a spherical pendulum: the work of the weight is most of its energy",
            {"p_psi": 0, "p_phi": "0.01"},
        ),
    )
    guard = 50
    natural_sizes: ClassVar[Mapping[str, float]] = {"power": 100.0, "work": 100.0}

    def formulas(self, p: Any) -> Mapping[str, Any]:
        # All rational: the energy of rotation is constant.
        n = self.parameters
        rise = n["vz"] - n["g"] * n["t"]
        turning = sum((n["I" + k] * n["w" + k] ** 2 for k in "123"), Fraction(0)) / 2
        moving = n["m"] * (n["vx"] ** 2 + n["vy"] ** 2 + rise**2) / 2
        numbers = {
            "translational": moving,
            "rotational": turning,
            "kinetic": moving + turning,
            "power": -n["m"] * n["g"] * rise,
            "work": -n["m"] * n["g"] * (n["vz"] * n["t"] - n["g"] * n["t"] ** 2 / 2),
            "ball_loss": n["m"] * (n["s0x"] ** 2 + n["s0y"] ** 2) / 7,
        }
        # The top's initial energy and the work since then need only theta and its rate.
        theta, rate, _phi, _psi = self._top()._balls(n["t"])
        sine, cosine = p.theta.sin_cos()
        across = (p.p_phi - p.p_psi * cosine) / sine
        start = (p.A * p.rate * p.rate + across * across / p.A + p.p_psi * p.p_psi / p.C) / 2
        work = 2 * p.W * ((theta + p.theta) / 2).sin() * ((theta - p.theta) / 2).sin()
        return {name: ball(value) for name, value in numbers.items()} | {
            "top_kinetic": start + work,
            "top_power": p.W * theta.sin() * rate,
            "top_work": work,
        }

    def _top(self) -> LagrangeTop:
        n = self.parameters
        return LagrangeTop(
            n["A"], n["C"], n["W"], n["p_psi"], n["p_phi"], n["theta"], n["rate"], Fraction(0), Fraction(0)
        )

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """Six particles on the principal axes that move with the exact attitude: speeds from differences of positions."""
        n = self.parameters
        digits = mp.dps
        body = EulerTop((n["I1"], n["I2"], n["I3"]), (n["w1"], n["w2"], n["w3"]))
        top = self._top()

        with mp.workdps(4 * digits):

            def falling(time: Fraction) -> list[Any]:
                t = mp.mpf(time)
                return [mp.mpf(n["vx"]) * t, mp.mpf(n["vy"]) * t, mp.mpf(n["vz"]) * t - mp.mpf(n["g"]) * t**2 / 2]

            def attitude(time: Fraction) -> list[Sequence[Any]]:
                entries = [mp.mpf(x) for x in body.state(time, 4 * digits)[3:]]
                return [entries[3 * i : 3 * i + 3] for i in range(3)]

            def leaning(time: Fraction) -> Sequence[Sequence[Any]]:
                theta, _rate, phi, psi = (mp.mpf(x) for x in top.state(time, 4 * digits))
                tilt = multiply(turn_x(mp.cos(theta), mp.sin(theta)), turn_z(mp.cos(psi), mp.sin(psi)))
                return multiply(turn_z(mp.cos(phi), mp.sin(phi)), tilt)

            free = _six(mp, [n["I1"], n["I2"], n["I3"]], attitude, falling, n["m"])
            fixed = _six(mp, [n["A"], n["A"], n["C"]], leaning)
            now, power, work = _energies(mp, free, n["t"], digits)
            moving, _, _ = _energies(mp, lambda time: [(n["m"], falling(time))], n["t"], digits)
            top_now, top_power, top_work = _energies(mp, fixed, n["t"], digits)

        sliding = mp.hypot(p.s0x, p.s0y)
        until = 2 * sliding / (7 * p.mu * p.g)
        loss = integral(mp, lambda t: p.mu * p.m * p.g * (sliding - 7 * p.mu * p.g * t / 2), [mp.mpf(0), until])
        return {
            "translational": moving,
            "rotational": now - moving,
            "kinetic": now,
            "power": power,
            "work": work,
            "ball_loss": loss,
            "top_kinetic": top_now,
            "top_power": top_power,
            "top_work": top_work,
        }


Particles = Callable[[Fraction], list[tuple[Fraction, list[Any]]]]
"""(mass, position) of each particle at a time."""


def _six(
    mp: Any,
    moments: Sequence[Fraction],
    attitude: Callable[[Fraction], Sequence[Sequence[Any]]],
    centre: Callable[[Fraction], list[Any]] = lambda time: [0, 0, 0],
    mass: Fraction = Fraction(1),
) -> Particles:
    """Six equal particles on the principal axes with these principal moments."""
    half = sum(moments, Fraction(0)) / 2
    arms = [mp.sqrt(3 * mp.mpf(half - moment) / mp.mpf(mass)) for moment in moments]

    def particles(time: Fraction) -> list[tuple[Fraction, list[Any]]]:
        turned, middle = attitude(time), centre(time)
        return [
            (mass / 6, [middle[i] + side * arms[k] * turned[i][k] for i in range(3)])
            for k in range(3)
            for side in (1, -1)
        ]

    return particles


def _energies(mp: Any, particles: Particles, t: Fraction, digits: int) -> tuple[Any, Any, Any]:
    """Kinetic energy, its rate and its gain since the start, from central differences of positions."""
    step, wide = Fraction(1, 10**digits), Fraction(1, 10 ** (digits // 2))

    def energy(time: Fraction) -> Any:
        before, after = particles(time - step), particles(time + step)
        return mp.fsum(
            mp.mpf(mass) / 2 * mp.fsum(((b - a) / (2 * mp.mpf(step))) ** 2 for a, b in zip(earlier, later, strict=True))
            for (mass, earlier), (_, later) in zip(before, after, strict=True)
        )

    now = energy(t)
    return now, (energy(t + wide) - energy(t - wide)) / (2 * mp.mpf(wide)), now - energy(Fraction(0))
