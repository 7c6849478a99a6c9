"""Rides of an amusement park: the forces that keep a rider on a circle."""

import flint
from gnomon.cases.core.check import Numbers
from gnomon.cases.declare import *


def _swung_out(n: Numbers) -> bool:
    return n["w"] ** 2 * n["L"] > n["g"]


def _holds_on_the_bank(n: Numbers) -> bool:
    """mu tan(beta) < 1 and tan(beta) > mu, proved in balls."""
    beta, mu = n["beta"], n["mu"]
    tangent = flint.arb(flint.fmpq(beta.numerator, beta.denominator)).tan()
    share = flint.arb(flint.fmpq(mu.numerator, mu.denominator))
    return bool(share * tangent < 1) and bool(tangent > share)


class AmusementRides(Check):
    """A conical pendulum, a rotor whose floor is lowered, a banked curve, a loop."""

    name = "amusement_rides"
    title = "Conical pendulum, rotor, banked curve, loop: speeds and forces that hold a rider"
    section = "6.3.4"
    conventions = (
        "Chairs on chains of length L from a shaft at rate w: cos(angle) = g/(L w^2), tension over mass L w^2; below "
        "bifurcation_rate = sqrt(g/L) they hang straight down. A rotor of radius R at rate w_r needs the friction "
        "mu_min = g/(R w_r^2). A curve of radius R banked by beta with friction mu: speeds from sqrt(g R tan(beta - phi)) "
        "to sqrt(g R tan(beta + phi)), tan(phi) = mu. A loop of radius R: contact lasts from the speed sqrt(5 g R) at the "
        "bottom on; the normal force there is then 6 m g."
    )
    g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive(5, 10))
    L = Parameter("m", 6, "length of the chains", positive(2, 8))
    w = Parameter("rad/s", "1.6", "rate of the shaft", positive(2.5, 4))
    R = Parameter("m", 20, "radius of rotor, curve and loop", positive(2, 50))
    w_r = Parameter("rad/s", "1.2", "rate of the rotor", positive(0.5, 3))
    beta = Parameter(
        "rad", "0.5", "bank angle of the curve", Range(low=0.0, high=1.5, low_open=True, typical=(0.4, 0.8))
    )
    mu = Parameter("1", "0.3", "coefficient of friction on the curve", nonnegative(0, 0.35))
    rules = (
        Rule("the chairs swing out: w^2 > g/L", _swung_out),
        Rule(
            "tan(beta) > mu and mu tan(beta) < 1 (there is a lowest and a highest speed)",
            _holds_on_the_bank,
        ),
    )
    variants = (
        Variant(
            "bifurcation",
            "w^2 = (1 + 1e-12) g/L: the angle is sqrt(2e-12), its cosine is close to 1",
            {"g": 10, "L": "2.5", "w": Fraction(2) * (1 + Fraction(1, 2 * 10**12))},
        ),
        Variant("smooth_bank", "no friction: both limits are the same speed", {"mu": 0}),
        Variant("no_limit", "1e-9 below the bank angle without a highest speed", {"beta": 1, "mu": "0.642092615"}),
    )

    def formulas(self, p: Any) -> Mapping[str, Any]:
        tangent = p.beta.tan()
        ratio = p.g / (p.L * p.w * p.w)
        # acos of a number close to 1, from the sine of half the angle
        angle = 2 * ((1 - ratio) / 2).sqrt().asin()
        return {
            "chair_angle": angle,
            "chair_tension": p.L * p.w * p.w,
            "bifurcation_rate": (p.g / p.L).sqrt(),
            "rotor_friction": p.g / (p.R * p.w_r * p.w_r),
            "slowest": (p.g * p.R * (tangent - p.mu) / (1 + p.mu * tangent)).sqrt(),
            "fastest": (p.g * p.R * (tangent + p.mu) / (1 - p.mu * tangent)).sqrt(),
            "loop_speed": (5 * p.g * p.R).sqrt(),
            "loop_weight": 6 * p.g,
        }

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """Newton's equations along and normal to each path, solved numerically."""
        # chair: T cos = g, T sin = w^2 L sin; the angle by bisection of the torque about the hinge
        low, high = mp.zero, mp.pi / 2
        for _ in range(mp.prec + 40):
            middle = (low + high) / 2
            if p.w**2 * p.L * mp.sin(middle) * mp.cos(middle) > p.g * mp.sin(middle):
                low = middle
            else:
                high = middle
        angle = (low + high) / 2
        pull = mp.hypot(p.g, p.w**2 * p.L * mp.sin(angle))
        sine, cosine = mp.sin(p.beta), mp.cos(p.beta)

        def speed(friction: Any) -> Any:
            """N and v^2 from N cos - F sin = g, N sin + F cos = v^2/R with F = `friction` N."""
            rows = mp.matrix([[cosine - friction * sine, 0], [sine + friction * cosine, -1 / p.R]])
            return mp.sqrt(mp.lu_solve(rows, mp.matrix([p.g, 0]))[1])

        # loop: N = v^2/R + g cos from the bottom, v^2 = v0^2 - 2 g R (1 - cos); N = 0 at the top alone
        top, drop = p.g * p.R, 2 * p.g * p.R * (1 - mp.cos(mp.pi))
        bottom = top + drop
        return {
            "chair_angle": angle,
            "chair_tension": pull,
            "bifurcation_rate": mp.sqrt(mp.diff(lambda x: p.g / p.L * mp.sin(x), 0)),
            "rotor_friction": 1 / (p.w_r**2 * p.R / p.g),
            "slowest": speed(-p.mu),
            "fastest": speed(p.mu),
            "loop_speed": mp.sqrt(bottom),
            "loop_weight": bottom / p.R + p.g,
        }
