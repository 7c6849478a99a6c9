"""Independent computations of the action along paths and of a belt's friction: SciPy's quadrature and integrator."""

import math
from collections.abc import Callable

from gnomon.harness.certification.independent import Numbers, Quantities, independent
from scipy import integrate


@independent("quad", "scipy", "hamilton_action")
def action_quad(p: Numbers) -> Quantities:
    """scipy.integrate.quad of the Lagrangian along the true and the varied path, at its default tolerance."""
    m, w, g, T, begin, end, eps = (p[name] for name in ("m", "w", "g", "T", "begin", "end", "eps"))
    rate = p["mode"] * math.pi / T
    speed = (end - begin * math.cos(w * T)) * w / math.sin(w * T)
    upward = (end - begin) / T + g * T / 2

    def swing(t: float) -> tuple[float, float]:
        cosine, sine = math.cos(w * t), math.sin(w * t)
        return begin * cosine + speed / w * sine, speed * cosine - begin * w * sine

    def throw(t: float) -> tuple[float, float]:
        return begin + upward * t - g * t * t / 2, upward - g * t

    def spring(x: float, v: float) -> float:
        return m * (v * v - w * w * x * x) / 2

    def weight(x: float, v: float) -> float:
        return m * (v * v / 2 - g * x)

    def action(
        lagrangian: Callable[[float, float], float], path: Callable[[float], tuple[float, float]], size: float
    ) -> float:
        def along(t: float) -> float:
            x, v = path(t)
            return lagrangian(x + size * math.sin(rate * t), v + size * rate * math.cos(rate * t))

        return float(integrate.quad(along, 0.0, T)[0])

    swung, thrown = action(spring, swing, 0.0), action(weight, throw, 0.0)
    return {
        "oscillator": swung,
        "oscillator_variation": action(spring, swing, eps) - swung,
        "fall": thrown,
        "fall_variation": action(weight, throw, eps) - thrown,
    }


@independent("solve_ivp", "scipy", "capstan_belt")
def belt_ivp(p: Numbers) -> Quantities:
    """scipy.integrate.solve_ivp, RK45 at rtol 1e-10, of dT/dphi = mu T around the pulley, and of the normal force."""
    solution = integrate.solve_ivp(
        lambda phi, y: [p["mu"] * y[0], y[0]], (0.0, p["beta"]), [p["slack"], 0.0], rtol=1e-10, atol=1e-10 * p["slack"]
    )
    tight, pressing = (float(x) for x in solution.y[:, -1])
    return {"tight": tight, "ratio": tight / p["slack"], "torque": (tight - p["slack"]) * p["r"], "pressing": pressing}
