"""Independent computations of centres of mass, frames, deflections and rides: NumPy and SciPy in their usual way."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
from gnomon.harness.certification.independent import Numbers, Quantities, independent
from scipy import integrate
from scipy.optimize import brentq
from scipy.spatial.transform import Rotation

Floats = Any


@independent("average, quad", "scipy", "com_rigid_body")
def centre_averages(p: Numbers) -> Quantities:
    """numpy.average of the particles; scipy.integrate.quad over slices of the bodies."""
    r, h, s, d = p["r"], p["h"], p["s"], p["d"]

    def centre(slices: Any, low: float, high: float) -> float:
        moment = integrate.quad(lambda x: x * slices(x), low, high, epsabs=0, epsrel=1e-12)[0]
        return float(moment / integrate.quad(slices, low, high, epsabs=0, epsrel=1e-12)[0])

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


@independent("formulas in doubles", "numpy", "apparent_gravity_earth")
def plumb_doubles(p: Numbers) -> Quantities:
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


@independent("Rotation, second differences", "scipy", "frame_transformation")
def differentiate_turned(p: Numbers) -> Quantities:
    """scipy's Rotation applied to the path, and second differences with a step that suits the rate of rotation."""
    r0, v0, c = (np.array([p[name + axis] for axis in "xyz"]) for name in "rvc")

    def turn(t: float) -> Any:
        return Rotation.from_euler("ZX", [p["a1"] * t + p["a2"] * t * t / 2, p["b1"] * t + p["b2"] * t * t / 2])

    def place(t: float) -> Floats:
        return turn(t).apply(r0 + v0 * t + c * (t * t / 2))

    t = p["t"]
    rate = 1 + abs(p["a1"] + p["a2"] * t) + abs(p["b1"] + p["b2"] * t)
    step = np.finfo(float).eps ** 0.25 / rate
    bend = (place(t + step) - 2 * place(t) + place(t - step)) / step**2
    return {"acceleration": turn(t).inv().apply(bend)}


@independent("Rotation", "scipy", "material_frame_indifference")
def rotate_force(p: Numbers) -> Quantities:
    """scipy's Rotation applied to both particles, then the force law to their difference."""
    turn = Rotation.from_euler("ZX", [p["alpha"], p["beta"]])
    shift = np.array([p["s" + axis] for axis in "xyz"])
    first, second = (turn.apply([p[name + axis] for axis in "xyz"]) + shift for name in "pq")
    line = second - first
    distance = float(np.linalg.norm(line))
    along = -p["mu"] / distance ** p["n"]
    return {"distance": distance, "along": along, "force": along * line / distance}


@independent("solve_ivp", "scipy", "projectile_coriolis_first_order")
def coriolis_flight(p: Numbers) -> Quantities:
    """scipy.integrate.solve_ivp, DOP853 at 1e-13, of the complete equation, minus the first order in binary64."""
    g, rate, lat, t = p["g"], p["Om"], p["lat"], p["t"]
    turning = np.array([0.0, rate * math.cos(lat), rate * math.sin(lat)])
    velocity, gravity = np.array([p["v" + axis] for axis in "xyz"]), np.array([0.0, 0.0, -g])

    def motion(_: float, state: Floats) -> Floats:
        return np.concatenate([state[3:], gravity - 2 * np.cross(turning, state[3:])])

    start = np.concatenate([np.zeros(3), velocity])
    small = 1e-14 * float(np.linalg.norm(velocity) + g * t) * np.array([t, t, t, 1.0, 1.0, 1.0])
    end = integrate.solve_ivp(motion, (0.0, t), start, method="DOP853", rtol=1e-13, atol=small).y[:3, -1]
    coriolis = -np.cross(turning, velocity * t**2 + gravity * t**3 / 3)
    place = velocity * t + gravity * t**2 / 2 + coriolis
    return {"place": place, "coriolis": coriolis, "beyond": end - place}


gunnery_flight = replace(coriolis_flight, check="falkland_gunnery")


@independent("eigvals, solve_ivp", "scipy", "stability_pendulum_linearisation")
def falling_from_the_top(p: Numbers) -> Quantities:
    """numpy.linalg.eigvals of the Jacobians; solve_ivp, DOP853 at 1e-12, of the angle from the downward vertical."""
    pull = p["g"] / p["L"]
    down, up = (np.linalg.eigvals([[0.0, 1.0], [sign * pull, 0.0]]) for sign in (-1, 1))
    quantities = {"rate_down": float(np.max(down.imag)), "rate_up": float(np.max(up.real))}
    if p["t"] == 0:
        return quantities
    start = [math.pi - p["delta"], 0.0]
    end = integrate.solve_ivp(
        lambda _, y: [y[1], -pull * math.sin(y[0])], (0.0, p["t"]), start, method="DOP853", rtol=1e-12, atol=1e-15
    ).y[:, -1]
    return quantities | {"angle": float(math.pi - end[0]), "speed": float(-end[1])}


@independent("formulas in doubles", "numpy", "amusement_rides")
def rides_as_written(p: Numbers) -> Quantities:
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


@independent("brentq", "scipy", "amusement_rides")
def rides_by_roots(p: Numbers) -> Quantities:
    """scipy.optimize.brentq: zeros of the torque about the chair's hinge and of the rider's weight along the bank."""
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


@independent("formulas in doubles", "numpy", "falling_target")
def aim_by_the_path(p: Numbers) -> Quantities:
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
