"""Hamilton's principle: the action of actual and varied paths (Beatty, Dynamics, 11.11)."""

from collections.abc import Callable

from gnomon.cases.declare import *
from gnomon.reference.numerics.quadrature import integral, unit_steps
from gnomon.reference.oscillators import action


class HamiltonAction(Check):
    name = "hamilton_action"
    title = "Action of the harmonic oscillator and of free fall; stationarity"
    section = "11.11"
    conventions = (
        "From `begin` to `end` in the time T; the varied path has eps sin(mode pi t/T) added; *_variation: the change of "
        "the action, of second order in eps. Beyond the conjugate point w T = pi the action is not a minimum."
    )
    m = Parameter("kg", "1.5", "mass", positive())
    w = Parameter("rad/s", 2, "rate of the oscillator", positive())
    g = Parameter("m/s^2", "9.81", "acceleration of gravity")
    T = Parameter("s", "1.2", "time", positive(0.1, 4))
    begin = Parameter("m", "0.7", "position at t = 0")
    end = Parameter("m", "-0.4", "position at t = T")
    eps = Parameter("m", "1e-3", "size of the variation", positive(1e-06, 1))
    mode = Parameter("", 1, "half waves of the variation", Range(1, 1000, typical=(1.0, 1.0)))
    rules = (Rule("mode is a whole number", lambda p: p["mode"].denominator == 1),)
    variants = (
        Variant(
            "conjugate_point",
            "T is the double nearest to pi/w: the path goes 1e16 m away, the variation nearly vanishes",
            {"w": 1, "T": Fraction(pi)},
        ),
        Variant("beyond_conjugate", "w T = 4: a variation lowers the action", {"w": 1, "T": 4}),
        Variant("small_variation", "eps = 1e-12: the change is 1e-24 of the action", {"eps": "1e-12"}),
        Variant("short", "w T = 1e-8: the free particle", {"T": "5e-9", "eps": "1e-9"}),
        Variant("rippled", "a variation of 40 half waves", {"mode": 40}),
    )
    guard = 100

    def formulas(self, p: Any) -> Mapping[str, Any]:
        mode = int(self.parameters["mode"])
        return {
            "oscillator": action.oscillator(p.m, p.w, p.T, p.begin, p.end),
            "oscillator_variation": action.variation(p.m, p.w, p.T, p.eps, mode),
            "fall": action.fall(p.m, p.g, p.T, p.begin, p.end),
            "fall_variation": action.variation(p.m, p.T * 0, p.T, p.eps, mode),
        }

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """The Lagrangian integrated along both paths; the actual path from its initial speed."""
        rate = p.mode * mp.pi / p.T
        # Sines are entire: an interval of the quadrature may hold several waves.
        waves = max(rate, p.w) * p.T / 20
        edges = [p.T * u / waves for u in unit_steps(mp.mpf(0), waves)]

        def integrated(lagrangian: Callable[[Any, Any], Any], path: Callable[[Any], tuple[Any, Any]], eps: Any) -> Any:
            def along(t: Any) -> Any:
                x, v = path(t)
                return lagrangian(x + eps * mp.sin(rate * t), v + eps * rate * mp.cos(rate * t))

            return integral(mp, along, edges)

        # The initial speed of the path that ends at `end`: x is linear in it.
        speed = (p.end - p.begin * mp.cos(p.w * p.T)) * p.w / mp.sin(p.w * p.T)

        def swing(t: Any) -> tuple[Any, Any]:
            cosine, sine = mp.cos(p.w * t), mp.sin(p.w * t)
            return p.begin * cosine + speed / p.w * sine, speed * cosine - p.begin * p.w * sine

        upward = (p.end - p.begin) / p.T + p.g * p.T / 2

        def throw(t: Any) -> tuple[Any, Any]:
            return p.begin + upward * t - p.g * t**2 / 2, upward - p.g * t

        def spring(x: Any, v: Any) -> Any:
            return p.m * (v**2 - (p.w * x) ** 2) / 2

        def weight(y: Any, v: Any) -> Any:
            return p.m * (v**2 / 2 - p.g * y)

        swung, thrown = integrated(spring, swing, 0), integrated(weight, throw, 0)
        return {
            "oscillator": swung,
            "oscillator_variation": integrated(spring, swing, p.eps) - swung,
            "fall": thrown,
            "fall_variation": integrated(weight, throw, p.eps) - thrown,
        }
