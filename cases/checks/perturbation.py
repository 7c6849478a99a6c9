"""First-order results, compared with the motions that they approximate (Beatty, Dynamics, 6.14, 6.18).

Checks: projectile_coriolis_first_order, falkland_gunnery, stability_pendulum_linearisation.
"""

from typing import ClassVar

from gnomon.cases.declare import *
from gnomon.reference.guided.pendulum_on_hoop import Hoop
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.taylor import integrate
from gnomon.reference.numerics.vectors import add, components, named, scale, subtract
from gnomon.reference.rotating_frames.coriolis import displacement, first_order


class ProjectileCoriolisFirstOrder(Check):
    name = "projectile_coriolis_first_order"
    title = "Projectile on the rotating Earth, Coriolis acceleration to first order"
    section = "6.18.1"
    conventions = (
        "Axes x east, y north, z up; g includes the centrifugal acceleration. place: displacement to first order in Om; "
        "coriolis: its part due to the Coriolis acceleration; beyond: the error of the first order, of order (Om t)^2. "
        "lateral: the deflection to the right of the throw, seen from above; lateral_mirrored: that at latitude -lat."
    )
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    Om = Parameter("rad/s", "7.292115e-5", "rate of the Earth", positive(0.001, 1))
    lat = Parameter("rad", "0.89", "latitude", Range(-1.5708, 1.5708, typical=(-1.5, 1.5)))
    vx = Parameter("m/s", 300, "velocity at the start")
    vy = Parameter("m/s", 200, "velocity at the start")
    vz = Parameter("m/s", 250, "velocity at the start")
    t = Parameter("s", 45, "time of flight", positive())
    rules = (Rule("the throw has a horizontal velocity", lambda p: bool(p["vx"] or p["vy"])),)
    variants: ClassVar[tuple[Variant, ...]] = (
        Variant("equator", "no lateral deflection from horizontal velocity: only east and up", {"lat": 0}),
        Variant("drop", "nearly at rest at 158.5 m: 27 mm east", {"vx": 0, "vy": "1e-6", "vz": 0, "t": "5.6846"}),
        Variant("slow", "Om t = 1e-12: the error of the first order is 1e-24", {"Om": "1e-13", "t": 10}),
        Variant("turntable", "Om t = 3: the first order does not approximate the motion", {"Om": "0.3", "t": 10}),
        Variant("a_day", "24 h", {"t": 86400}),
    )
    guard = 70

    def _turning(self, p: Any, cosine: Any, sine: Any) -> tuple[Any, Any, Any]:
        return p.Om * 0, p.Om * cosine, p.Om * sine

    def formulas(self, p: Any) -> Mapping[str, Any]:
        cosine, sine = p.lat.cos(), p.lat.sin()
        gravity, velocity = (p.g * 0, p.g * 0, -p.g), components(p, "v")
        turning = self._turning(p, cosine, sine)
        coriolis = first_order(turning, gravity, velocity, p.t)
        mirrored = first_order(self._turning(p, cosine, -sine), gravity, velocity, p.t)
        place = add(scale(p.t, velocity), scale(p.t * p.t / 2, gravity), coriolis)
        level = (p.vx * p.vx + p.vy * p.vy).sqrt()
        return {
            **named("place", place),
            **named("coriolis", coriolis),
            **named("beyond", subtract(displacement(turning, gravity, velocity, p.t), place)),
            "lateral": (coriolis[0] * p.vy - coriolis[1] * p.vx) / level,
            "lateral_mirrored": (mirrored[0] * p.vy - mirrored[1] * p.vx) / level,
        }

    def sizes(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """A lateral deflection has the size of the whole deflection."""
        sizes = super().sizes(values)
        return sizes | dict.fromkeys(("lateral", "lateral_mirrored"), sizes["coriolis.x"])

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """The exponential of the linear equations of motion, and its derivative by Om at Om = 0."""
        digits = mp.dps
        with mp.workdps(3 * digits):
            small = mp.mpf(10) ** (-digits)

            def flown(rate: Any, latitude: Any) -> Any:
                x, y, z = 0, 2 * rate * mp.cos(latitude), 2 * rate * mp.sin(latitude)
                spin = [[0, -z, y], [z, 0, -x], [-y, x, 0]]
                system = mp.zeros(7)
                for i in range(3):
                    system[i, i + 3] = 1
                    for j in range(3):
                        system[i + 3, j + 3] = -spin[i][j]
                system[5, 6] = -p.g
                start = mp.matrix([0, 0, 0, *components(p, "v"), 1])
                return (mp.expm(system * p.t) * start)[:3, 0]

            plain, whole = flown(mp.mpf(0), p.lat), flown(p.Om, p.lat)

            def slope(latitude: Any) -> Any:
                return (flown(small, latitude) - flown(-small, latitude)) * p.Om / (2 * small)

            coriolis, mirrored = slope(p.lat), slope(-p.lat)
            place = plain + coriolis
            right = mp.expj(mp.arg(mp.mpc(p.vx, p.vy)) - mp.pi / 2)
            return {
                **named("place", list(place)),
                **named("coriolis", list(coriolis)),
                **named("beyond", list(whole - place)),
                "lateral": (mp.conj(right) * mp.mpc(coriolis[0], coriolis[1])).real,
                "lateral_mirrored": (mp.conj(right) * mp.mpc(mirrored[0], mirrored[1])).real,
            }


class FalklandGunnery(ProjectileCoriolisFirstOrder):
    name = "falkland_gunnery"
    title = "Naval gunnery in the southern hemisphere"
    section = "6.18.2"
    lat = Parameter(
        "rad",
        "-0.9023352232810683",
        "latitude: 51.7 degrees south",
        Range(-1.5708, 1.5708, typical=(-1.5, 1.5)),
    )
    vx = Parameter("m/s", 0, "muzzle velocity")
    vy = Parameter("m/s", "-600", "muzzle velocity")
    vz = Parameter("m/s", "300", "muzzle velocity")
    t = Parameter("s", 60, "time of flight", positive())
    variants = (
        Variant("west", "fired west", {"vx": -600, "vy": 0}),
        Variant("equator", "at the equator, due south: only the vertical velocity deflects", {"lat": 0}),
    )


class StabilityPendulumLinearisation(Check):
    name = "stability_pendulum_linearisation"
    title = "Stability of the pendulum's equilibria by linearisation"
    section = "6.14"
    conventions = (
        "rate_down: the eigenvalues at the bottom are +-i times this; rate_up: those at the top are plus and minus this. "
        "Released at rest at the angle delta from upright: angle from upright and speed at time t, exact and linearised."
    )
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(1, 10))
    L = Parameter("m", "9.81", "length", positive(1, 10))
    delta = Parameter("rad", "1e-3", "initial angle from upright", Range(-3.14, 3.14, typical=(0.001, 3.0)))
    t = Parameter("s", 5, "time", nonnegative(0, 5))
    variants = (
        Variant("upright_1e_12", "1e-12 rad from upright: 28 e-foldings until it falls", {"delta": "1e-12", "t": 27}),
        Variant(
            "still_linear",
            "1e-12 rad from upright, after one e-folding: the linear solution is accurate to 24 digits",
            {"delta": "1e-12", "t": 1},
        ),
        Variant("past_the_bottom", "0.1 rad from upright: past the bottom and back", {"delta": "0.1", "t": 14}),
    )
    guard = 50

    def formulas(self, p: Any) -> Mapping[str, Any]:
        n = self.parameters
        rate = (p.g / p.L).sqrt()
        if n["t"] == 0 or n["delta"] == 0:
            angle, speed = p.delta, p.t * 0
        else:
            angle, speed = Hoop(-n["g"] / n["L"], Fraction(0), n["delta"], Fraction(0))._balls(n["t"])
        return {
            "rate_down": rate,
            "rate_up": rate,
            "angle": angle,
            "speed": speed,
            "linear_angle": p.delta * (rate * p.t).cosh(),
            "linear_speed": p.delta * rate * (rate * p.t).sinh(),
        }

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """Eigenvalues of the Jacobian by QR; Taylor integration; the exponential of the linear system."""
        n = self.parameters
        down, _ = mp.eig(mp.matrix([[0, 1], [-p.g / p.L, 0]]))
        up, _ = mp.eig(mp.matrix([[0, 1], [p.g / p.L, 0]]))

        def falling(t: Any, state: Any) -> Any:
            angle, speed = state
            return speed, angle.sin() * ball(n["g"]) / ball(n["L"])

        fallen: Any = (n["delta"], Fraction(0))
        if n["t"] > 0:
            (fallen,) = integrate(falling, [n["delta"], Fraction(0)], [n["t"]], mp.dps)
        linear = mp.expm(mp.matrix([[0, 1], [p.g / p.L, 0]]) * p.t) * mp.matrix([p.delta, 0])
        return {
            "rate_down": max(mp.im(x) for x in down),
            "rate_up": max(mp.re(x) for x in up),
            "angle": mp.mpf(fallen[0].numerator) / fallen[0].denominator,
            "speed": mp.mpf(fallen[1].numerator) / fallen[1].denominator,
            "linear_angle": linear[0],
            "linear_speed": linear[1],
        }
