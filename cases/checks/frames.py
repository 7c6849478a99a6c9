"""Frames: apparent gravity, the transformation of accelerations, frame indifference (Beatty, Dynamics, 5.13-5.18).

Checks: apparent_gravity_earth, frame_transformation, material_frame_indifference.
"""

import flint
from gnomon.cases.declare import *
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
    """Central second difference of a vector-valued function; its error is proportional to the step squared."""
    digits = mp.dps
    with mp.workdps(3 * digits):
        h = mp.mpf(scale_of_time) * mp.mpf(10) ** (-digits)
        before, here, after = place(t - h), place(t), place(t + h)
        return [(a - 2 * b + c) / h**2 for a, b, c in zip(before, here, after, strict=True)]


class ApparentGravityEarth(Check):
    name = "apparent_gravity_earth"
    title = "Apparent gravity on a rotating planet, and the deviation of the plumb line"
    section = "5.14-5.17"
    conventions = (
        "A spherical planet; south: horizontal southward component of apparent gravity; down: component towards the centre; "
        "deviation: angle of the plumb line from the line to the centre, positive towards the south."
    )
    G = Parameter("m/s^2", "9.825", "gravitation", positive())
    R = Parameter("m", "6.371e6", "radius", positive())
    Om = Parameter("rad/s", "7.292115e-5", "rate of rotation", typical(-2, 2))
    lat = Parameter("rad", "0.785", "latitude", Range(-1.5708, 1.5708, typical=(-1.5, 1.5)))
    rules = (
        Rule("G > Om^2 R (apparent gravity points down at the equator)", lambda p: p["G"] > p["Om"] ** 2 * p["R"]),
    )
    variants = (
        Variant("equator", "no deviation, least weight", {"lat": 0}),
        Variant("south", "the deviation changes its sign", {"lat": "-0.785"}),
        Variant("slow", "a deviation of 1e-20", {"Om": "1e-13"}),
        Variant(
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
        """The acceleration in space of a particle at rest on the planet, by differences of its circular path."""

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
    title = "Acceleration in a frame that rotates in any manner"
    section = "5.13-5.17"
    conventions = (
        "The frame has the attitude R = Rz(alpha) Rx(beta), alpha = a1 t + a2 t^2/2, beta = b1 t + b2 t^2/2; a particle "
        "moves in it as r = r0 + v t + c t^2/2. At t: its acceleration in space, in components of the frame, is "
        "r'' + 2 w x r' + w x (w x r) + w' x r; each part is given by its name."
    )
    a1 = Parameter("rad/s", "0.8")
    a2 = Parameter("rad/s^2", "-0.3")
    b1 = Parameter("rad/s", "1.4")
    b2 = Parameter("rad/s^2", "0.5")
    rx = Parameter("m", 1, "place at t = 0")
    ry = Parameter("m", "-0.5", "place at t = 0")
    rz = Parameter("m", 2, "place at t = 0")
    vx = Parameter("m/s", "0.3", "velocity at t = 0")
    vy = Parameter("m/s", 1, "velocity at t = 0")
    vz = Parameter("m/s", "-0.7", "velocity at t = 0")
    cx = Parameter("m/s^2", "-0.2", "acceleration")
    cy = Parameter("m/s^2", "0.4", "acceleration")
    cz = Parameter("m/s^2", "0.9", "acceleration")
    t = Parameter("s", "0.7")
    variants = (
        Variant(
            "fast",
            "a rate of 1e6 rad/s: the relative acceleration is far below the centripetal one",
            {"a1": 10**6, "b1": 3},
        ),
        Variant("slow", "a rate of 1e-12", {"a1": "1e-12", "a2": 0, "b1": 0, "b2": 0}),
        Variant("late", "after 1e10 turns", {"t": 700000}),
    )
    guard = 60

    def formulas(self, p: Any) -> Mapping[str, Any]:
        t = p.t
        beta = p.b1 * t + p.b2 * t * t / 2
        cosine, sine = beta.cos(), beta.sin()
        alpha_rate, beta_rate = p.a1 + p.a2 * t, p.b1 + p.b2 * t
        # Components of w in the frame: beta' along its x axis, alpha' along the fixed z axis, (0, sin beta, cos beta) there.
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
        """Second differences of R(t) r(t), with the whole motion and with parts of it held constant."""
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
        # With velocity but no acceleration in the frame: the difference is the Coriolis acceleration.
        drifting = seen(lambda t: turn(t) * (here + velocity * (t - p.t)))
        # Centripetal acceleration is that at a constant rate about a fixed axis; the rest is Euler's.
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
        """The angular velocity, in components of the frame, from R^T R' by central differences."""
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
        "force changes to Q F; the distance and the force along the line are invariant."
    )
    mu = Parameter("N m^n", 3, "strength, positive for attraction")
    n = Parameter("", 2, "exponent, a whole number", Range(-10, 10, typical=(2.0, 2.0)))
    px = Parameter("m", "0.5", "particle 1")
    py = Parameter("m", -1, "particle 1")
    pz = Parameter("m", "0.3", "particle 1")
    qx = Parameter("m", 2, "particle 2")
    qy = Parameter("m", "0.7", "particle 2")
    qz = Parameter("m", "-0.9", "particle 2")
    alpha = Parameter("rad", "0.9")
    beta = Parameter("rad", "-0.4")
    sx = Parameter("m", 7, "shift of the origin")
    sy = Parameter("m", -3, "shift of the origin")
    sz = Parameter("m", 11, "shift of the origin")
    rules = (
        Rule("n is a whole number other than 1", lambda p: p["n"].denominator == 1 and p["n"] != 1),
        Rule("the particles are apart", lambda p: any(p["p" + k] != p["q" + k] for k in "xyz")),
    )
    variants = (
        Variant(
            "close",
            "particles 1e-10 m apart, 1e8 m from the origin",
            {"qx": "0.5000000001", "qy": -1, "qz": "0.3", "sx": 10**8, "sy": -(10**8)},
        ),
        Variant("spring", "a linear spring", {"n": -1}),
        Variant("fifth_power", "the force whose orbits include circles through the centre", {"n": 5}),
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
        """Both particles moved to the new frame by complex rotations; the force there from the slope of the potential."""
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
