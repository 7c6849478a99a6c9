"""Frames: apparent gravity, the transformation of accelerations, frame indifference (Beatty, Dynamics, 5.13-5.18).

Checks: apparent_gravity_earth, frame_transformation, material_frame_indifference.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import flint
from gnomon.cases.core.check import Check, Setting
from gnomon.cases.core.numbers import Domain, Parameter, Range, Rule, positive
from gnomon.reference.numerics.vectors import (
    add,
    apply,
    components,
    cross,
    dot,
    multiply,
    named,
    scale,
    subtract,
    turn_x,
    turn_z,
)


def second_derivative(mp: Any, place: Any, t: Any, scale_of_time: Any) -> list[Any]:
    """Central second difference of a vector-valued function; its error is the step squared."""
    digits = mp.dps
    with mp.workdps(3 * digits):
        h = mp.mpf(scale_of_time) * mp.mpf(10) ** (-digits)
        before, here, after = place(t - h), place(t), place(t + h)
        return [(a - 2 * b + c) / h**2 for a, b, c in zip(before, here, after, strict=True)]


class ApparentGravityEarth(Check):
    name = "apparent_gravity_earth"
    title = "Apparent gravity on a turning planet, and the deviation of the plumb line"
    section = "5.14-5.17"
    conventions = (
        "A spherical planet; south: horizontal component of apparent gravity, towards the equator in the north; down: "
        "component towards the centre; deviation: angle from the line to the centre, positive towards the south."
    )
    parameter_list = (
        Parameter("G", "m/s^2", "9.825", "gravitation"),
        Parameter("R", "m", "6.371e6", "radius"),
        Parameter("Om", "rad/s", "7.292115e-5", "rate of turning"),
        Parameter("lat", "rad", "0.785", "latitude"),
    )
    domain = Domain(
        {
            "G": positive(),
            "R": positive(),
            "Om": Range(typical=(-2.0, 2.0)),
            "lat": Range(-1.5708, 1.5708, typical=(-1.5, 1.5)),
        },
        (Rule("G > Om^2 R (else things fly off)", lambda p: p["G"] > p["Om"] ** 2 * p["R"]),),
    )
    variants = (
        Setting("equator", "no deviation, the least weight", {"lat": 0}),
        Setting("south", "the deviation changes its sign", {"lat": "-0.785"}),
        Setting("slow", "a deviation of 1e-20", {"Om": "1e-13"}),
        Setting(
            "almost_flying_off",
            "Om^2 R = (1 - 1e-12) G at the equator",
            {"G": 1, "R": "0.999999999999", "Om": 1, "lat": "1e-9"},
        ),
    )
    guard = 50

    def formulas(self, p: Any) -> Mapping[str, Any]:
        centrifugal = p.Om * p.Om * p.R
        sine, cosine = p.lat.sin(), p.lat.cos()
        south, down = centrifugal * sine * cosine, p.G - centrifugal * cosine * cosine
        return {
            "south": south,
            "down": down,
            "magnitude": (south * south + down * down).sqrt(),
            "deviation": flint.arb.atan2(south, down),
        }

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """The acceleration, in space, of a particle at rest on the planet, by differences of its circle."""

        def place(t: Any) -> list[Any]:
            across = p.R * mp.cos(p.lat)
            return [across * mp.cos(p.Om * t), across * mp.sin(p.Om * t), p.R * mp.sin(p.lat)]

        acceleration = second_derivative(mp, place, mp.mpf(0), 1)
        up = [x / p.R for x in place(mp.mpf(0))]
        apparent = [-p.G * u - a for u, a in zip(up, acceleration, strict=True)]
        down = -mp.fsum(x * u for x, u in zip(apparent, up, strict=True))
        south_way = [mp.sin(p.lat), 0, -mp.cos(p.lat)]
        south = mp.fsum(x * s for x, s in zip(apparent, south_way, strict=True))
        magnitude = mp.norm(mp.matrix(apparent))
        return {"south": south, "down": down, "magnitude": magnitude, "deviation": mp.asin(south / magnitude)}


class FrameTransformation(Check):
    name = "frame_transformation"
    title = "Acceleration seen from a frame that turns in any manner"
    section = "5.13-5.17"
    conventions = (
        "The frame is turned by R = Rz(alpha) Rx(beta), alpha = a1 t + a2 t^2/2, beta = b1 t + b2 t^2/2; a particle moves "
        "in it as r = r0 + v t + c t^2/2. At t: its acceleration in space, seen in the frame, is "
        "r'' + 2 w x r' + w x (w x r) + w' x r; the parts are named."
    )
    parameter_list = (
        *(Parameter(name, unit, v) for name, unit, v in (
            ("a1", "rad/s", "0.8"), ("a2", "rad/s^2", "-0.3"), ("b1", "rad/s", "1.4"), ("b2", "rad/s^2", "0.5"))),
        *(Parameter(f"r{k}", "m", v, "place at t = 0") for k, v in zip("xyz", (1, "-0.5", 2), strict=True)),
        *(Parameter(f"v{k}", "m/s", v, "velocity at t = 0") for k, v in zip("xyz", ("0.3", 1, "-0.7"), strict=True)),
        *(Parameter(f"c{k}", "m/s^2", v, "acceleration") for k, v in zip("xyz", ("-0.2", "0.4", "0.9"), strict=True)),
        Parameter("t", "s", "0.7"),
    )  # fmt: skip
    domain = Domain({})
    variants = (
        Setting(
            "fast", "a rate of 1e6: centrifugal acceleration drowns what is seen in the frame", {"a1": 10**6, "b1": 3}
        ),
        Setting("slow", "a rate of 1e-12", {"a1": "1e-12", "a2": 0, "b1": 0, "b2": 0}),
        Setting("late", "after 1e10 turns", {"t": 700000}),
    )
    guard = 60

    def formulas(self, p: Any) -> Mapping[str, Any]:
        t = p.t
        beta = p.b1 * t + p.b2 * t * t / 2
        cosine, sine = beta.cos(), beta.sin()
        alpha_rate, beta_rate = p.a1 + p.a2 * t, p.b1 + p.b2 * t
        # In the frame: beta' along its x axis, and alpha' along the fixed z axis, which is (0, sin beta, cos beta) there.
        w = (beta_rate, alpha_rate * sine, alpha_rate * cosine)
        w_rate = (p.b2, p.a2 * sine + alpha_rate * beta_rate * cosine, p.a2 * cosine - alpha_rate * beta_rate * sine)
        r0, v0, c = (components(p, name) for name in "rvc")
        r, v = add(r0, scale(t, v0), scale(t * t / 2, c)), add(v0, scale(t, c))
        coriolis, centripetal, euler = scale(2, cross(w, v)), cross(w, cross(w, r)), cross(w_rate, r)
        return {
            **named("acceleration", add(c, coriolis, centripetal, euler)),
            **named("coriolis", coriolis),
            **named("centripetal", centripetal),
            **named("euler", euler),
        }

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """Second differences of R(t) r(t), and of the same with parts of the motion held still."""
        r0, v0, c = (mp.matrix(components(p, name)) for name in "rvc")

        def turn(t: Any) -> Any:
            alpha, beta = p.a1 * t + p.a2 * t**2 / 2, p.b1 * t + p.b2 * t**2 / 2
            return mp.matrix(multiply(turn_z(mp.cos(alpha), mp.sin(alpha)), turn_x(mp.cos(beta), mp.sin(beta))))

        def moving(t: Any) -> Any:
            return r0 + v0 * t + c * t**2 / 2

        now = turn(p.t).T
        step = 1 / (1 + abs(p.a1) + abs(p.b1) + abs(p.a2 * p.t) + abs(p.b2 * p.t))

        def seen(place: Any) -> Any:
            return now * mp.matrix(second_derivative(mp, place, p.t, step))

        here = moving(p.t)
        velocity = v0 + c * p.t
        whole = seen(lambda t: turn(t) * moving(t))
        steady = seen(lambda t: turn(t) * here)
        # With velocity, no acceleration, in the frame: the rest is Coriolis'.
        drifting = seen(lambda t: turn(t) * (here + velocity * (t - p.t)))
        # Centripetal and Euler's acceleration part by reversal: held at this rate, the frame turns about a fixed axis.
        axis = self._rate(mp, turn, p.t, step)
        centripetal = axis * (axis.T * here)[0] - here * (axis.T * axis)[0]
        return {
            **named("acceleration", list(whole)),
            **named("coriolis", list(drifting - steady)),
            **named("centripetal", list(centripetal)),
            **named("euler", list(steady - centripetal)),
        }

    @staticmethod
    def _rate(mp: Any, turn: Any, t: Any, step: Any) -> Any:
        """The angular velocity in the frame from R^T R', by central differences."""
        digits = mp.dps
        with mp.workdps(3 * digits):
            h = step * mp.mpf(10) ** (-digits)
            spin = turn(t).T * (turn(t + h) - turn(t - h)) / (2 * h)
            return mp.matrix([spin[2, 1], spin[0, 2], spin[1, 0]])


class MaterialFrameIndifference(Check):
    name = "material_frame_indifference"
    title = "Frame indifference of a law of force between two particles"
    section = "5.18"
    conventions = (
        "F12 = -(mu/r^n) e_r on particle 2, r from 1 to 2. The frame is changed to Q r + s, Q = Rz(alpha) Rx(beta): the "
        "force turns with Q; distance and force along the line are invariants."
    )
    parameter_list = (
        Parameter("mu", "N m^n", 3, "strength; attraction is positive"),
        Parameter("n", "", 2, "exponent, a whole number"),
        *(Parameter(f"p{k}", "m", v, "particle 1") for k, v in zip("xyz", ("0.5", -1, "0.3"), strict=True)),
        *(Parameter(f"q{k}", "m", v, "particle 2") for k, v in zip("xyz", (2, "0.7", "-0.9"), strict=True)),
        Parameter("alpha", "rad", "0.9"),
        Parameter("beta", "rad", "-0.4"),
        *(Parameter(f"s{k}", "m", v, "shift of the origin") for k, v in zip("xyz", (7, -3, 11), strict=True)),
    )
    domain = Domain(
        {"n": Range(-10, 10, typical=(2.0, 2.0))},
        (
            Rule("n is a whole number other than 1", lambda p: p["n"].denominator == 1 and p["n"] != 1),
            Rule("the particles are apart", lambda p: any(p["p" + k] != p["q" + k] for k in "xyz")),
        ),
    )
    variants = (
        Setting(
            "close",
            "1e-10 apart, seen from 1e8 away",
            {"qx": "0.5000000001", "qy": -1, "qz": "0.3", "sx": 10**8, "sy": -(10**8)},
        ),
        Setting("spring", "a linear spring", {"n": -1}),
        Setting("fifth_power", "the force under which circles through the centre are run", {"n": 5}),
    )
    guard = 80

    def formulas(self, p: Any) -> Mapping[str, Any]:
        r = subtract(components(p, "q"), components(p, "p"))
        distance = dot(r, r).sqrt()
        force = scale(-p.mu / distance ** (int(self.parameters["n"]) + 1), r)
        Q = multiply(turn_z(p.alpha.cos(), p.alpha.sin()), turn_x(p.beta.cos(), p.beta.sin()))
        return {
            "distance": distance,
            "along": -p.mu / distance ** int(self.parameters["n"]),
            **named("force", apply(Q, force)),
        }

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """Both particles moved to the new frame by complex turns; the force there, minus the slope of the potential."""
        n = int(self.parameters["n"])

        def moved(place: Any) -> list[Any]:
            x, y, z = place
            up = mp.expj(p.beta) * mp.mpc(y, z)
            flat = mp.expj(p.alpha) * mp.mpc(x, up.real)
            return [flat.real + p.sx, flat.imag + p.sy, up.imag + p.sz]

        first, second = moved(components(p, "p")), moved(components(p, "q"))

        def potential(place: Any) -> Any:
            return p.mu / (1 - n) * mp.norm(mp.matrix([b - a for a, b in zip(first, place, strict=True)])) ** (1 - n)

        digits = mp.dps
        distance = mp.norm(mp.matrix([b - a for a, b in zip(first, second, strict=True)]))
        with mp.workdps(3 * digits):
            h = distance * mp.mpf(10) ** (-digits)
            force = []
            for k in range(3):
                there, back = list(second), list(second)
                there[k] += h
                back[k] -= h
                force.append(-(potential(there) - potential(back)) / (2 * h))
        along = mp.fsum(f * (b - a) for f, a, b in zip(force, first, second, strict=True)) / distance
        return {"distance": distance, "along": along, **named("force", force)}
