"""Independent computations of rigid bodies by SciPy: an unbalanced rotor, work and energy."""

import math
from typing import Any

import numpy as np
from gnomon.harness.certification.independent import Numbers, Quantities, independent
from gnomon.reference.rigid_bodies.bodies import BODIES
from scipy import integrate
from scipy.spatial.transform import Rotation

ROTOR = "rotor_dynamic_balance"

Floats = Any


@independent("Rotation, solve", "scipy", ROTOR)
def rotor_turned(p: Numbers) -> Quantities:
    """The disc's tensor rotated by scipy's Rotation, the torque w x I w, the bearing forces by numpy.linalg.solve."""
    m, square = p["m"], p["r"] ** 2
    across = m * (square / 4 + p["h"] ** 2 / 12)
    turn = Rotation.from_euler("y", p["beta"]).as_matrix()
    tensor = turn @ np.diag([across, across, m * square / 2]) @ turn.T
    rate = np.array([0.0, 0.0, p["w"]])
    torque = np.cross(rate, tensor @ rate)
    force = m * np.cross(rate, np.cross(rate, [p["e"], 0.0, 0.0]))
    return _rotor(p, float(tensor[0, 2]), float(torque[1]), float(force[0]))


@independent("cubature", "scipy", ROTOR)
def rotor_cubature(p: Numbers) -> Quantities:
    """scipy.integrate.cubature over the tilted disc of its accelerations and their moments."""
    cosine, sine = math.cos(p["beta"]), math.sin(p["beta"])
    disc = BODIES["cylinder"]

    def pull(points: Floats) -> Floats:
        x, _, z, share = disc.place(np, points[:, 0], points[:, 1], points[:, 2], p["r"], p["h"])
        across, along = x * cosine + z * sine, z * cosine - x * sine
        return np.stack([share * q for q in (1 + 0 * x, across + p["e"], along * (across + p["e"]))], axis=1)

    low, high = [0.0, 0.0, -0.5], [1.0, 2 * math.pi, 0.5]
    # Some moments are zero by symmetry: without an absolute tolerance their refinement would not end.
    size = max(p["r"], p["h"], abs(p["e"]))
    moments = integrate.cubature(
        pull, low, high, rule="gk15", rtol=1e-12, atol=1e-14 * size**2, max_subdivisions=10
    ).estimate
    volume, first, second = (float(x) for x in moments)
    square = p["w"] ** 2
    return _rotor(p, -p["m"] * second / volume, -p["m"] * square * second / volume, -p["m"] * square * first / volume)


def _rotor(p: Numbers, product: float, torque: float, force: float) -> Quantities:
    """Bearing forces at z = d and z = -d for a force and a torque, and masses times radius that balance the rotor."""
    arms = [[1.0, 1.0], [p["d"], -p["d"]]]
    bearing = np.linalg.solve(arms, [force, torque])
    correction = np.linalg.solve(arms, [-p["m"] * p["e"], product])
    return {"I_xz": product, "torque": torque, "force": force, "bearing": bearing, "correction": correction}


@independent("solve_ivp, quad", "scipy", "work_energy_rigid_body")
def energies_ivp(p: Numbers) -> Quantities:
    """scipy.integrate.solve_ivp (DOP853, rtol 1e-12) of Euler's equations; energies from rates, work as integral."""
    weight = np.array([0.0, 0.0, -p["m"] * p["g"]])
    inertia, heavy = (np.array([p[name] for name in names]) for names in (("I1", "I2", "I3"), ("A", "A", "C")))
    axis = np.array([0.0, 0.0, 1.0])

    def motion(_: float, y: Floats) -> Floats:
        """Time derivatives: velocity, rates and work of the free body; rates, upward vertical and work of the top."""
        v, w, top, up = y[0:3], y[3:6], y[7:10], y[10:13]
        torque = p["W"] * np.cross(up, axis)
        free = weight / p["m"], np.cross(inertia * w, w) / inertia, weight @ v
        return np.hstack([*free, (np.cross(heavy * top, top) + torque) / heavy, np.cross(up, top), torque @ top])

    sine, cosine = math.sin(p["theta"]), math.cos(p["theta"])
    around = (p["p_phi"] - p["p_psi"] * cosine) / sine / p["A"]
    free_start = [p[name] for name in ("vx", "vy", "vz", "w1", "w2", "w3")]
    end = np.array([*free_start, 0.0, p["rate"], around, p["p_psi"] / p["C"], 0.0, sine, cosine, 0.0])
    if p["t"] > 0:
        end = integrate.solve_ivp(motion, (0.0, p["t"]), end, method="DOP853", rtol=1e-12, atol=1e-13).y[:, -1]
    v, w, top, up = end[0:3], end[3:6], end[7:10], end[10:13]
    sliding, pull = math.hypot(p["s0x"], p["s0y"]), p["mu"] * p["g"]
    until = 2 * sliding / (7 * pull)
    translational, rotational = p["m"] * (v @ v) / 2, (inertia * w) @ w / 2
    return {
        "translational": translational,
        "rotational": rotational,
        "kinetic": translational + rotational,
        "power": weight @ v,
        "work": end[6],
        "ball_loss": integrate.quad(lambda t: p["m"] * pull * (sliding - 7 * pull * t / 2), 0.0, until)[0],
        "top_kinetic": (heavy * top) @ top / 2,
        "top_power": p["W"] * np.cross(up, axis) @ top,
        "top_work": end[13],
    }
