"""Independent computations of work along paths and of particles: SciPy's quadrature, integrator and differences."""

import math
from itertools import combinations

import numpy as np
from gnomon.harness.certification.independent import Numbers, Quantities, independent
from scipy import integrate
from scipy.optimize import approx_fprime
from scipy.special import ellipe

WORK, PARTICLES = "work_constant_linear_coulomb", "internal_potential_energy"


@independent("quad", "scipy", WORK)
def work_quad(p: Numbers) -> Quantities:
    """scipy.integrate.quad along each path, at its default tolerance."""
    R, rise, weight = p["R"], p["p"] / (2 * math.pi), p["mu"] * p["m"] * p["g"]

    def constant(s: float) -> float:
        return -p["Fx"] * R * math.sin(s) + p["Fy"] * R * math.cos(s) + p["Fz"] * rise

    def spring(s: float) -> float:
        length = math.hypot(R, rise * s)
        return -p["k"] * (length - p["l"]) * rise * rise * s / length

    def parabola(x: float) -> float:
        return math.hypot(1, 2 * p["c"] * x)

    def ellipse(t: float) -> float:
        return math.hypot(p["a"] * math.sin(t), p["b"] * math.cos(t))

    return {
        "constant": integrate.quad(constant, 0.0, p["phi"])[0],
        "spring": integrate.quad(spring, 0.0, p["phi"])[0],
        "friction_circle": -weight * integrate.quad(lambda s: R, 0.0, 2 * math.pi * p["turns"])[0],
        "friction_parabola": -weight * integrate.quad(parabola, 0.0, p["X"])[0],
        "friction_ellipse": -weight * integrate.quad(ellipse, 0.0, 2 * math.pi)[0],
    }


@independent("ellipe, asinh", "scipy", WORK)
def work_special(p: Numbers) -> Quantities:
    """The closed forms in binary64, with scipy.special.ellipe of m = 1 - (b/a)^2."""
    weight, bend = p["mu"] * p["m"] * p["g"], 2 * p["c"] * p["X"]
    parabola = p["X"] * math.hypot(1, bend) / 2 + math.asinh(bend) / (4 * p["c"])
    return {
        "friction_circle": -weight * 2 * math.pi * p["R"] * p["turns"],
        "friction_parabola": -weight * parabola,
        "friction_ellipse": -weight * 4 * p["a"] * float(ellipe(1 - (p["b"] / p["a"]) ** 2)),
    }


@independent("solve_ivp", "scipy", "rod_tension_circular")
def tension_ivp(p: Numbers) -> Quantities:
    """scipy.integrate.solve_ivp (DOP853, rtol 1e-12) up to the given time, then the tension in the final state."""
    g, length = p["g"], p["L"]
    start, options = (p["theta"], p["omega"]), {"method": "DOP853", "rtol": 1e-12, "atol": 1e-14}
    solution = integrate.solve_ivp(lambda t, y: (y[1], -g / length * math.sin(y[0])), (0.0, p["t"]), start, **options)
    theta, omega = solution.y[:, -1]
    return {"tension": p["m"] * (length * omega**2 + g * math.cos(theta))}


def _energy(p: Numbers, q: np.ndarray) -> float:
    masses = (p["m1"], p["m2"], p["m3"])
    total = 0.0
    for i, j in combinations(range(3), 2):
        r = float(np.linalg.norm(q[3 * i : 3 * i + 3] - q[3 * j : 3 * j + 3]))
        total += p["k"] * (r - p["l"]) ** 2 / 2 - p["G"] * masses[i] * masses[j] / r
    return total


def _places(p: Numbers) -> np.ndarray:
    return np.array([p[name + axis] for name in "abc" for axis in "xyz"])


def _forces(gradient: np.ndarray) -> Quantities:
    return {f"force{n}": -part for n, part in enumerate(gradient.reshape(3, 3), 1)}


@independent("approx_fprime", "scipy", PARTICLES)
def gradient_forward(p: Numbers) -> Quantities:
    """scipy.optimize.approx_fprime of the energy: forward differences, as optimisers use them."""
    return {"energy": _energy(p, _places(p))} | _forces(approx_fprime(_places(p), lambda q: _energy(p, q)))


@independent("sum over pairs", "numpy", PARTICLES)
def forces_doubles(p: Numbers) -> Quantities:
    """Forces summed over pairs in binary64, as in an N-body code."""
    masses, places = (p["m1"], p["m2"], p["m3"]), _places(p).reshape(3, 3)
    forces = np.zeros((3, 3))
    for i, j in combinations(range(3), 2):
        apart = places[j] - places[i]
        r = float(np.linalg.norm(apart))
        pull = (p["G"] * masses[i] * masses[j] / r**2 + p["k"] * (r - p["l"])) / r * apart
        forces[i] += pull
        forces[j] -= pull
    return {"energy": _energy(p, _places(p))} | _forces(-forces.ravel())


@independent("central differences", "numpy", "moment_momentum_moving_point")
def moments_differences(p: Numbers) -> Quantities:
    """numpy: H_Q of the exact motion in binary64, differentiated by central differences of 1e-5 s."""
    a, b, v, w, q, u, c = (np.array([p[name + axis] for axis in "xyz"]) for name in "abvwquc")
    m1, m2 = p["m1"], p["m2"]
    mass, weight = m1 + m2, np.array([0.0, 0.0, -p["g"]])
    rate = math.sqrt(p["k"] * mass / (m1 * m2))

    def particles(t: float) -> tuple[list[np.ndarray], list[np.ndarray], np.ndarray, np.ndarray]:
        centre = (m1 * (a + v * t) + m2 * (b + w * t)) / mass + weight * t * t / 2
        speed = (m1 * v + m2 * w) / mass + weight * t
        apart = (b - a) * math.cos(rate * t) + (w - v) * math.sin(rate * t) / rate
        drift = (w - v) * math.cos(rate * t) - (b - a) * rate * math.sin(rate * t)
        places = [centre - m2 / mass * apart, centre + m1 / mass * apart]
        speeds = [speed - m2 / mass * drift, speed + m1 / mass * drift]
        return places, speeds, q + u * t + c * t * t / 2, u + c * t

    def moment(t: float, relative: bool) -> np.ndarray:
        places, speeds, Q, moving = particles(t)
        own = moving if relative else 0 * moving
        total = np.zeros(3)
        for m, r, s in zip((m1, m2), places, speeds, strict=True):
            total += m * np.cross(r - Q, s - own)
        return total

    t, h = p["t"], 1e-5
    rates = [(moment(t + h, relative) - moment(t - h, relative)) / (2 * h) for relative in (False, True)]
    places, _, Q, _ = particles(t)
    pulled = sum((np.cross(r - Q, m * weight) for m, r in zip((m1, m2), places, strict=True)), np.zeros(3))
    return {"moment": pulled, "rate": rates[0], "relative_rate": rates[1]}
