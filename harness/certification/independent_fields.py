"""Independent computations of fields and path integrals: special functions, quadratures, formulas in binary64."""

import itertools
import math
from collections.abc import Callable

import numpy as np
from gnomon.harness.certification.independent import Numbers, Quantities, independent
from scipy import integrate
from scipy.special import ellipe, ellipk, ellipkm1

FIELD = "gravity_field_particle_body"


@independent("ellipk, ellipe", "scipy", FIELD)
def ring_special(p: Numbers) -> Quantities:
    """scipy.special.ellipk and ellipe of m, the usual formula: next to the ring 1 - m has no correct digits."""
    return _ring(p, lambda m, rest: ellipk(m))


@independent("ellipkm1, ellipe", "scipy", FIELD)
def ring_special_complement(p: Numbers) -> Quantities:
    """scipy.special.ellipkm1 of 1 - m, computed without cancellation; in the field K - E cancels near the axis."""
    return _ring(p, lambda m, rest: ellipkm1(rest))


def integral(f: object, low: float, high: float) -> float:
    return float(integrate.quad(f, low, high, epsabs=0, epsrel=1e-12, limit=200)[0])


def _ring(p: Numbers, complete: Callable[[float, float], float]) -> Quantities:
    """The usual formulas, with the integral K as `complete`(m, 1 - m)."""
    a, rho, z, mu = p["a"], p["rho"], p["z"], p["mu"]
    far, near = (a + rho) ** 2 + z * z, (a - rho) ** 2 + z * z
    m = 4 * a * rho / far
    K, E = complete(m, near / far), ellipe(m)
    potential = -2 * mu * K / (math.pi * math.sqrt(far))
    factor = mu / (math.pi * math.sqrt(far))
    outward = -factor * (K - (a * a - rho * rho + z * z) / near * E) / rho if rho else 0.0
    disc = 2 * mu / (a * a) * (1 - z / math.sqrt(a * a + z * z))
    return _fields(p, potential, (outward, -2 * factor * z * E / near), disc)


def _fields(p: Numbers, potential: float, ring: tuple[float, float], disc: float) -> Quantities:
    excess = potential + p["mu"] / math.hypot(p["rho"], p["z"])
    return {"ring_potential": potential, "ring_excess": excess, "ring": ring, "disc": disc}


@independent("cubature", "scipy", FIELD)
def field_cubature(p: Numbers) -> Quantities:
    """scipy.integrate.cubature: the ring's potential and field, and the disc's field, as integrals over particles."""
    a, rho, z, mu = p["a"], p["rho"], p["z"], p["mu"]

    def ring(points: np.ndarray) -> np.ndarray:
        cosine = np.cos(points[:, 0])
        distance = np.sqrt(a * a + rho * rho + z * z - 2 * a * rho * cosine)
        share = mu / (math.pi * distance)
        return np.stack([-share, share * (a * cosine - rho) / distance**2, -share * z / distance**2], axis=1)

    def disc(points: np.ndarray) -> np.ndarray:
        s = points[:, 0]
        return np.asarray(2 * mu / (a * a) * s * z / np.sqrt(s * s + z * z) ** 3)

    how = {"rule": "gk21", "rtol": 1e-12, "atol": 0, "max_subdivisions": 500}
    potential, outward, along = integrate.cubature(ring, [0.0], [math.pi], **how).estimate
    return _fields(p, potential, (outward, along), integrate.cubature(disc, [0.0], [a], **how).estimate)


@independent("quad", "scipy", FIELD)
def field_quad(p: Numbers) -> Quantities:
    """scipy.integrate.quad: QUADPACK on the same integrals, one component at a time, at tolerance 1e-12."""
    a, rho, z, mu = p["a"], p["rho"], p["z"], p["mu"]

    def distance(phi: float) -> float:
        return math.sqrt(a * a + rho * rho + z * z - 2 * a * rho * math.cos(phi))

    potential = integral(lambda phi: -mu / (math.pi * distance(phi)), 0.0, math.pi)
    outward = integral(lambda phi: mu / math.pi * (a * math.cos(phi) - rho) / distance(phi) ** 3, 0.0, math.pi)
    along = integral(lambda phi: -mu / math.pi * z / distance(phi) ** 3, 0.0, math.pi)
    disc = integral(lambda s: 2 * mu / (a * a) * s * z / math.hypot(s, z) ** 3, 0.0, a)
    return _fields(p, potential, (outward, along), disc)


@independent("quad", "scipy", "conservative_force_test")
def circulation_quad(p: Numbers) -> Quantities:
    """scipy.integrate.quad around the circle and along the line, at its default tolerance."""
    X, Y, R = p["X"], p["Y"], p["R"]
    dx, dy = p["Bx"] - p["Ax"], p["By"] - p["Ay"]

    def circle(t: float) -> float:
        cosine, sine = R * math.cos(t), R * math.sin(t)
        x, y = X + cosine, Y + sine
        return (x * cosine + y * sine) / (x * x + y * y)

    def line(s: float) -> float:
        x, y = p["Ax"] + s * dx, p["Ay"] + s * dy
        return (x * dy - y * dx) / (x * x + y * y)

    return {"circle": integrate.quad(circle, 0.0, 2 * math.pi)[0], "line": integrate.quad(line, 0.0, 1.0)[0]}


@independent("formulas in doubles", "numpy", "weight_local_gravity")
def weight_doubles(p: Numbers) -> Quantities:
    """The formulas in binary64 as they are written: differences of nearly equal numbers cancel."""
    g0, R, h = p["g0"], p["R"], p["h"]
    below, above = R + h, R + h + p["L"]
    g, first = g0 * (R / (R + h)) ** 2, g0 * (1 - 2 * h / R)
    return {
        "g": g,
        "first_order": first,
        "beyond_first_order": g - first,
        "rod_weight_per_mass": g0 * R * R / (below * above),
        "centre_of_gravity_below": (below + above) / 2 - math.sqrt(below * above),
    }


@independent("solve", "numpy", "moment_equipollent")
def wrench_solve(p: Numbers) -> Quantities:
    """numpy.linalg.solve: the wrench's axis and pitch from four linear equations."""
    F, M, Q = (np.array([p[name + axis] for axis in "xyz"]) for name in "FMQ")
    matrix = np.zeros((4, 4))
    matrix[:3, :3] = [[0, F[2], -F[1]], [-F[2], 0, F[0]], [F[1], -F[0], 0]]
    matrix[:3, 3] = F
    matrix[3, :3] = F
    x, y, z, pitch = np.linalg.solve(matrix, [*M, 0])
    return {"moment_Q": M - np.cross(Q, F), "pitch": pitch, "axis": (x, y, z), "momentum_O": M + np.cross(Q, F)}


@independent("solve", "numpy", "generalized_impulse")
def impulse_solve(p: Numbers) -> Quantities:
    """numpy.linalg.solve: M(q) q' = Q for the struck rods."""
    m1, m2, l1, l2 = p["m1"], p["m2"], p["L1"], p["L2"]
    coupling = m2 * l1 * l2 * math.cos(p["th1"] - p["th2"]) / 2
    matrix = np.array([[(m1 / 3 + m2) * l1 * l1, coupling], [coupling, m2 * l2 * l2 / 3]])
    struck = np.array([p["P"] * l1 * math.cos(p["th1"]), p["P"] * p["d"] * math.cos(p["th2"])])
    first, second = np.linalg.solve(matrix, struck)
    return {"first_rate": first, "second_rate": second, "energy": struck @ [first, second] / 2}


@independent("quad over round bodies", "scipy", FIELD)
def round_bodies_quad(p: Numbers) -> Quantities:
    """scipy.integrate.quad over particles of the rod, and over rings and discs of shell and sphere.

    Rings and discs are perpendicular to the line to the point.
    """
    mu, a, r, length = p["mu"], p["a"], p["r"], p["L"]

    def ring(cosine: float) -> float:
        square = r * r + a * a - 2 * a * r * cosine
        return mu / 2 * (r - a * cosine) / (square * math.sqrt(square))

    def disc(x: float) -> float:
        off = r - x
        return 3 * mu / (2 * a**3) * (math.copysign(1.0, off) - off / math.sqrt(a * a - x * x + off * off))

    parts = [-a, r, a] if r < a else [-a, a]
    return {
        "particle": mu / (r * r),
        "rod": 2 * integral(lambda x: mu / length * r / math.hypot(x, r) ** 3, 0.0, length / 2),
        "shell": integral(ring, -1.0, 1.0),
        "sphere": sum(integral(disc, low, high) for low, high in itertools.pairwise(parts)),
    }
