"""Independent computations of centres of mass, frames, deflections and rides: NumPy and SciPy in their usual way."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from gnomon.harness.certification.independent import IndependentComputation, Numbers
from gnomon.reference.numerics.vectors import named

Floats = Any


def centre_averages(p: Numbers) -> dict[str, float]:
    """numpy.average of the particles; scipy.integrate.quad over slices of the bodies."""
    from scipy.integrate import quad  # slow to load: only its own computation waits

    r, h, s, d = p["r"], p["h"], p["s"], p["d"]

    def centre(slices: Any, low: float, high: float) -> float:
        moment = quad(lambda x: x * slices(x), low, high, epsabs=0, epsrel=1e-12)[0]
        return float(moment / quad(slices, low, high, epsabs=0, epsrel=1e-12)[0])

    def plate(x: float) -> float:
        hole = s * s - (x - d) ** 2
        return math.sqrt(max(r * r - x * x, 0.0)) - (math.sqrt(hole) if hole > 0 else 0.0)

    places, masses = [p[f"x{k}"] for k in "123"], [p[f"m{k}"] for k in "123"]
    return {
        "hemisphere": centre(lambda z: r * r - z * z, 0.0, r),
        "half_disc": centre(lambda x: math.sqrt(max(r * r - x * x, 0.0)), 0.0, r),
        "cone": centre(lambda z: (1 - z / h) ** 2, 0.0, h),
        "plate": centre(plate, -r, r),
        "particles": float(np.average(places, weights=masses)),
    }


def plumb_doubles(p: Numbers) -> dict[str, float]:
    """The formulas in binary64, the magnitude by numpy.hypot."""
    centrifugal = p["Om"] ** 2 * p["R"]
    south = centrifugal * math.sin(p["lat"]) * math.cos(p["lat"])
    down = p["G"] - centrifugal * math.cos(p["lat"]) ** 2
    return {
        "south": south,
        "down": down,
        "magnitude": float(np.hypot(south, down)),
        "deviation": float(np.arctan2(south, down)),
    }


def turned_differences(p: Numbers) -> dict[str, float]:
    """scipy's Rotation applied to the path, and second differences with a step that suits the rate of rotation."""
    from scipy.spatial.transform import Rotation

    r0, v0, c = (np.array([p[name + axis] for axis in "xyz"]) for name in "rvc")

    def turn(t: float) -> Any:
        return Rotation.from_euler("ZX", [p["a1"] * t + p["a2"] * t * t / 2, p["b1"] * t + p["b2"] * t * t / 2])

    def place(t: float) -> Floats:
        return turn(t).apply(r0 + v0 * t + c * (t * t / 2))

    t = p["t"]
    rate = 1 + abs(p["a1"] + p["a2"] * t) + abs(p["b1"] + p["b2"] * t)
    step = np.finfo(float).eps ** 0.25 / rate
    bend = (place(t + step) - 2 * place(t) + place(t - step)) / step**2
    return named("acceleration", [float(x) for x in turn(t).inv().apply(bend)])


def rotated_force(p: Numbers) -> dict[str, float]:
    """scipy's Rotation applied to both particles, then the force law to their difference."""
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_euler("ZX", [p["alpha"], p["beta"]])
    shift = np.array([p["s" + axis] for axis in "xyz"])
    first, second = (turn.apply([p[name + axis] for axis in "xyz"]) + shift for name in "pq")
    line = second - first
    distance = float(np.linalg.norm(line))
    along = -p["mu"] / distance ** p["n"]
    return {"distance": distance, "along": along, **named("force", [float(x) for x in along * line / distance])}


def coriolis_flight(p: Numbers) -> dict[str, float]:
    """scipy.integrate.solve_ivp, DOP853 at 1e-13, of the complete equation, minus the first order in binary64."""
    from scipy.integrate import solve_ivp

    g, rate, lat, t = p["g"], p["Om"], p["lat"], p["t"]
    turning = np.array([0.0, rate * math.cos(lat), rate * math.sin(lat)])
    velocity, gravity = np.array([p["v" + axis] for axis in "xyz"]), np.array([0.0, 0.0, -g])

    def motion(_: float, state: Floats) -> Floats:
        return np.concatenate([state[3:], gravity - 2 * np.cross(turning, state[3:])])

    start = np.concatenate([np.zeros(3), velocity])
    small = 1e-14 * float(np.linalg.norm(velocity) + g * t) * np.array([t, t, t, 1.0, 1.0, 1.0])
    end = solve_ivp(motion, (0.0, t), start, method="DOP853", rtol=1e-13, atol=small).y[:3, -1]
    coriolis = -np.cross(turning, velocity * t**2 + gravity * t**3 / 3)
    place = velocity * t + gravity * t**2 / 2 + coriolis
    return {
        **named("place", [float(x) for x in place]),
        **named("coriolis", [float(x) for x in coriolis]),
        **named("beyond", [float(x) for x in end - place]),
    }


def falling_from_the_top(p: Numbers) -> dict[str, float]:
    """numpy.linalg.eigvals of the Jacobians; solve_ivp, DOP853 at 1e-12, of the angle from the downward vertical."""
    from scipy.integrate import solve_ivp

    pull = p["g"] / p["L"]
    down, up = (np.linalg.eigvals([[0.0, 1.0], [sign * pull, 0.0]]) for sign in (-1, 1))
    found = {"rate_down": float(np.max(down.imag)), "rate_up": float(np.max(up.real))}
    if p["t"] == 0:
        return found
    start = [math.pi - p["delta"], 0.0]
    end = solve_ivp(
        lambda _, y: [y[1], -pull * math.sin(y[0])], (0.0, p["t"]), start, method="DOP853", rtol=1e-12, atol=1e-15
    ).y[:, -1]
    return found | {"angle": float(math.pi - end[0]), "speed": float(-end[1])}


def rides_as_written(p: Numbers) -> dict[str, float]:
    """The formulas in binary64 as they are written, the angle by arccos of a number close to 1."""
    g, radius = p["g"], p["R"]
    return {
        "chair_angle": float(np.arccos(g / (p["L"] * p["w"] ** 2))),
        "chair_tension": p["L"] * p["w"] ** 2,
        "bifurcation_rate": float(np.sqrt(g / p["L"])),
        "rotor_friction": g / (radius * p["w_r"] ** 2),
        "slowest": float(np.sqrt(g * radius * np.tan(p["beta"] - np.arctan(p["mu"])))),
        "fastest": float(np.sqrt(g * radius * np.tan(p["beta"] + np.arctan(p["mu"])))),
        "loop_speed": float(np.sqrt(5 * g * radius)),
        "loop_weight": 6 * g,
    }


def rides_by_roots(p: Numbers) -> dict[str, float]:
    """scipy.optimize.brentq for zeros of the torque about the chair's hinge and of the rider's weight along the bank."""
    from scipy.optimize import brentq

    g, radius, beta, mu = p["g"], p["R"], p["beta"], p["mu"]

    def torque(angle: float) -> float:
        return float(p["w"] ** 2 * p["L"] * math.cos(angle) - g)

    def limit(side: float) -> float:
        def excess(square: float) -> float:
            down = g * math.sin(beta) - square / radius * math.cos(beta)
            return down + side * mu * (g * math.cos(beta) + square / radius * math.sin(beta))

        high = g * radius
        while excess(high) > 0:
            high *= 2
        return math.sqrt(brentq(excess, 0.0, high, xtol=1e-300, rtol=1e-15))

    return {
        "chair_angle": float(brentq(torque, 0.0, math.pi / 2, xtol=1e-300, rtol=1e-15)),
        "slowest": limit(-1.0),
        "fastest": limit(1.0),
    }


def aim_by_the_path(p: Numbers) -> dict[str, float]:
    """Shot and target in binary64, at the time when both have the same x."""
    aim = math.atan2(p["Y"], p["X"])
    time = p["X"] / (p["v"] * math.cos(aim))
    fall = p["g"] * time * time / 2
    return {
        "time": time,
        "height": p["Y"] - fall,
        "miss": p["v"] * math.sin(aim) * time - fall - (p["Y"] - fall),
        "envelope": p["v"] ** 2 / (2 * p["g"]) - p["g"] * p["X"] ** 2 / (2 * p["v"] ** 2),
    }


COMPUTATIONS = (
    IndependentComputation("average, quad", "scipy", "com_rigid_body", centre_averages),
    IndependentComputation("formulas in doubles", "numpy", "apparent_gravity_earth", plumb_doubles),
    IndependentComputation("Rotation, second differences", "scipy", "frame_transformation", turned_differences),
    IndependentComputation("Rotation", "scipy", "material_frame_indifference", rotated_force),
    *(
        IndependentComputation("solve_ivp", "scipy", check, coriolis_flight)
        for check in ("projectile_coriolis_first_order", "falkland_gunnery")
    ),
    IndependentComputation("eigvals, solve_ivp", "scipy", "stability_pendulum_linearisation", falling_from_the_top),
    IndependentComputation("formulas in doubles", "numpy", "amusement_rides", rides_as_written),
    IndependentComputation("brentq", "scipy", "amusement_rides", rides_by_roots),
    IndependentComputation("formulas in doubles", "numpy", "falling_target", aim_by_the_path),
)
