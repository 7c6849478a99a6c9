"""Independent computations of inertia: SciPy's quadratures, NumPy's eigenvalues, PyBullet's inertia of shapes."""

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np
from gnomon.harness.certification.independent import Numbers, Quantities, independent
from gnomon.harness.contract.integrator import Unsupported
from gnomon.reference.numerics.vectors import AXES, PLANES
from gnomon.reference.rigid_bodies.bodies import BODIES, Body
from scipy import integrate

BODY, COMPOSITE = "inertia_tensor_special_bodies", "inertia_composite_parallel_axis"
PRINCIPAL = "inertia_transformation_principal"

INTEGRATED = ("box", "cylinder", "cone", "torus")
"""The bodies on which quadratures are timed: a polynomial integrand, an angle, a tip, two angles."""


def _edges(body: Body) -> tuple[list[float], list[float]]:
    pairs = [(0.0, 2 * math.pi) if edges is None else edges for edges in body.edges]
    return [low for low, _ in pairs], [high for _, high in pairs]


@independent("cubature", "scipy", BODY)
def cubature(p: Numbers) -> Quantities:
    """scipy.integrate.cubature: adaptive Gauss-Kronrod over the volume, all moments in one vector-valued integrand."""
    quantities: Quantities = {}
    for name in INTEGRATED:
        body = BODIES[name]
        sizes = [p[size] for size in body.sizes]

        def moments(points: Any, body: Body = body, sizes: list[float] = sizes) -> Any:
            x, y, z, weight = body.place(np, points[:, 0], points[:, 1], points[:, 2], *sizes)
            return np.stack([weight * q for q in (1 + 0 * x, x, y, z, x * x, y * y, z * z)], axis=1)

        # Some moments are zero by symmetry: without an absolute tolerance their refinement would not end.
        unit = max(sizes)
        low, high = _edges(body)
        result = integrate.cubature(
            moments, low, high, rule="gk15", rtol=1e-12, atol=1e-13 * unit**2, max_subdivisions=10
        )
        quantities |= _principal(name, p["m"], result.estimate)
    return quantities


@independent("nquad", "scipy", BODY)
def integrate_nested(p: Numbers) -> Quantities:
    """scipy.integrate.nquad: nested QUADPACK, one moment at a time; of the box only, at the loose default tolerance."""
    ranges = list(zip(*_edges(BODIES["box"]), strict=True))
    return _one_at_a_time("box", p, lambda integrand: integrate.nquad(integrand, ranges)[0])


@independent("tplquad", "scipy", BODY)
def triple(p: Numbers) -> Quantities:
    """scipy.integrate.tplquad of the cylinder, in cylindrical coordinates."""

    def integral(integrand: Callable[[float, float, float], float]) -> float:
        edges = (0.0, 1.0, 0.0, 2 * math.pi, -0.5, 0.5)
        return float(integrate.tplquad(lambda w, v, u: integrand(u, v, w), *edges)[0])

    return _one_at_a_time("cylinder", p, integral)


def _one_at_a_time(name: str, p: Numbers, integral: Callable[..., float]) -> Quantities:
    """The moments of a body, each an integral of its own over u, v, w."""
    body = BODIES[name]
    sizes = [p[size] for size in body.sizes]

    def moment(power: int, axis: int) -> float:
        def integrand(u: float, v: float, w: float) -> float:
            point = body.place(math, u, v, w, *sizes)
            return float(point[3] * point[axis] ** power)

        return float(integral(integrand))

    return _principal(name, p["m"], [moment(0, 0), 0, 0, 0, *(moment(2, axis) for axis in range(3))])


def _principal(name: str, m: float, moments: Any) -> Quantities:
    """Moments about the centre of mass from the integrals of 1, x, y, z, x^2, y^2, z^2."""
    mass = moments[0]
    squares = [m * (moments[4 + i] / mass - (moments[1 + i] / mass) ** 2) for i in range(3)]
    return {name: [sum(squares) - square for square in squares]}


@contextmanager
def _world() -> Iterator[tuple[Any, int]]:
    import pybullet  # without the library this computation alone is missing

    client = pybullet.connect(pybullet.DIRECT)
    try:
        yield pybullet, client
    finally:
        pybullet.disconnect(client)


@independent("inertia from shapes", "pybullet", BODY)
def bullet_shapes(p: Numbers) -> Quantities:
    """PyBullet's inertia of collision shapes, which createMultiBody gives to a box, a sphere or a cylinder."""
    with _world() as (bullet, client):
        shapes = {
            "box": {"shapeType": bullet.GEOM_BOX, "halfExtents": [p["a"] / 2, p["b"] / 2, p["c"] / 2]},
            "sphere": {"shapeType": bullet.GEOM_SPHERE, "radius": p["r"]},
            "cylinder": {"shapeType": bullet.GEOM_CYLINDER, "radius": p["r"], "height": p["h"]},
        }
        quantities: Quantities = {}
        for name, shape in shapes.items():
            collision = bullet.createCollisionShape(**shape, physicsClientId=client)
            if collision < 0:
                raise Unsupported(f"createCollisionShape refuses the {name}")
            body = bullet.createMultiBody(p["m"], collision, physicsClientId=client)
            quantities[name] = bullet.getDynamicsInfo(body, -1, physicsClientId=client)[2]
        return quantities


@independent("parallel axes there and back", "numpy", COMPOSITE)
def transfer_and_back(p: Numbers) -> Quantities:
    """The textbook's method in binary64: tensor about the origin by parallel axes, then back to the centre of mass."""
    a, b, c, rho = p["a"], p["b"], p["c"], p["rho"]
    plate, hole = rho * a * b * c, -rho * math.pi * p["r"] ** 2 * c
    r2 = p["r"] ** 2
    middle, apart = np.array([p["X"], p["Y"], p["Z"]]), np.array([p["p"], p["q"], 0.0])
    parts = (
        (plate, np.diag([b * b + c * c, a * a + c * c, a * a + b * b]) / 12, middle),
        (hole, np.diag([3 * r2 + c * c, 3 * r2 + c * c, 6 * r2]) / 12, middle + apart),
    )
    mass = sum(m for m, _, _ in parts)
    centre: Any = sum(m * place for m, _, place in parts) / mass
    origin = sum(m * (own + _shift(place)) for m, own, place in parts)
    tensors = {"about_centre": origin - mass * _shift(centre), "about_origin": origin}
    return {"mass": mass, "centre": centre} | {name: _entries(tensor) for name, tensor in tensors.items()}


def _shift(r: Any) -> Any:
    return np.dot(r, r) * np.eye(3) - np.outer(r, r)


def _entries(tensor: Any) -> list[Any]:
    return [*np.diag(tensor), *tensor[np.triu_indices(3, 1)]]


def _tensor(p: Numbers) -> Any:
    xx, yy, zz, xy, xz, yz = (p["I" + plane] for plane in PLANES)
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


@independent("eigh", "numpy", PRINCIPAL)
def symmetric_eigenvalues(p: Numbers) -> Quantities:
    """numpy.linalg.eigh: LAPACK's symmetric eigenvalues; the change of axes as two products of matrices."""
    values = np.linalg.eigh(_tensor(p))[0]
    ca, sa, cb, sb = math.cos(p["alpha"]), math.sin(p["alpha"]), math.cos(p["beta"]), math.sin(p["beta"])
    axes = np.array([[ca, sa, 0], [-cb * sa, cb * ca, sb], [sb * sa, -sb * ca, cb]])
    n = np.array([p["n" + axis] for axis in AXES])
    moment = float(n @ _tensor(p) @ n / (n @ n))
    return {
        "principal": values,
        "turned": _entries(axes @ _tensor(p) @ axes.T),
        "moment_about_n": moment,
        "radius_of_gyration": math.sqrt(abs(moment) / p["m"]),
    }


@independent("eigvals", "numpy", PRINCIPAL)
def general_eigenvalues(p: Numbers) -> Quantities:
    """numpy.linalg.eigvals: eigenvalues of a general matrix, without use of the symmetry."""
    return {"principal": np.sort(np.linalg.eigvals(_tensor(p)).real)}


@independent("trigonometric cubic", "numpy", PRINCIPAL)
def trigonometric_cubic(p: Numbers) -> Quantities:
    """The textbook's cubic in binary64: q + 2 p cos(acos(r)/3 + 2 pi k/3); acos loses half the digits near +-1."""
    tensor = _tensor(p)
    q = np.trace(tensor) / 3
    rest = tensor - q * np.eye(3)
    size = math.sqrt(float(np.sum(rest * rest)) / 6)
    if size == 0:
        return {"principal": [q, q, q]}
    r = min(1.0, max(-1.0, float(np.linalg.det(rest / size)) / 2))
    angle = math.acos(r) / 3
    return {"principal": sorted(q + 2 * size * math.cos(angle + 2 * math.pi * k / 3) for k in range(3))}
