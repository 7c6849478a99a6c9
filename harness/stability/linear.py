"""The panel of linear stability: the region where |R(z)| <= 1, for methods of fixed steps.

A step of a method on y' = z y with h = 1 multiplies y by R(z), a function of z = h lambda alone: the sign of h and the
size of y have no effect. An undamped vibration has z = i h w, a decay z = -h rate. Hairer and Wanner, Solving Ordinary
Differential Equations II, IV.2 and IV.3.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from gnomon.harness.contract.integrator import Floats, Integrator, Refused, Steps
from gnomon.harness.stability.linear_problems import problem_for
from gnomon.harness.stability.panel import Column, Mark, panel
from gnomon.harness.stability.step_matrix import FEWER, StepMatrix, spectral_radius, stable_intervals
from gnomon.harness.stability.subjects import processor_seconds

SCAN_STEPS = (0.02, 0.04, 0.1, 0.2)
"""Distances of the points of a scan; a narrower interval may be missed, except tongues (`touching`)."""
FINE_TO, COARSE_TO = 12.0, 60.0
"""The scan is fine up to the first number, five times as coarse up to the second, and ends with `LARGE`."""
LARGE = (1e2, 1e3, 1e4, 1e5, 1e6)
GAP_POINTS = 41
"""Points of a gap at which its growth is measured."""
ENGINES_TO = 4.0
"""End of the scan for problems that need a `prepare` for each point."""
REGION = (-6.0, 2.0, 6.0)
"""The least and the largest real part, and the largest imaginary part, of the grid on which |R| is drawn, from 0 up."""
REGION_STEPS = (0.1, 0.2, 0.4)
SHARE = 0.3
"""Share of the time that a scan may take; there are two scans, and the grid."""
SMALL, FAR = 0.2, 3.0
"""A step with this h w turns the phase by as many radians. A method that turns it FAR times more or less solves another
problem, and its limits mean nothing."""
L_STABLE = 1e-3
"""|R(-1e6)| is about 1e-6 or less for an L-stable method, and near 1 for a method that is only A-stable."""
GROWS = 30.0
"""Smallest growth of a matrix's powers that counts: near a limit the matrix of a stable step has large elements."""
MULTISTEP_TO = 4.0
LONG, LONGER = 1024, 4.0
"""Steps between the 64 samples when an edge of a multistep method is bisected, as growth from round-off takes long; and
the multiple of a scan's time that this may take."""


def steps_reason(integrator: Integrator) -> str | None:
    """Why the map of a step is not measured; None if it is."""
    if not isinstance(integrator.sweep, Steps):
        return "it chooses its own steps: see stiffness"
    return None if problem_for(integrator) is not None else "no exactly linear problem has a form that it takes"


def sentences(data: Mapping[str, Any]) -> list[str]:
    return [*_on_vibrations(data["imaginary"]), *(_on_decay(data) if data["negative_real"] is not None else [])]


def _on_vibrations(axis: Mapping[str, Any]) -> list[str]:
    limit, stable = first_limit(axis), axis["stable"]
    if limit == 0:
        return ["Not for undamped vibrations over long times: they grow at any step."]
    if math.isinf(limit):
        return [f"Use it for undamped vibrations at any h w (scanned to {axis['scanned_to']:g})."]
    advice = [f"Use it for undamped vibrations up to h w = {limit:.4g}."]
    gaps = [f"from {a[1]:.4g} to {b[0]:.4g}" for a, b in pairwise(stable)]
    for text, growth in zip(gaps, axis["gaps"], strict=True):
        size = "" if growth is None else f" by up to {float(f'{100 * growth:.2g}'):g} % a step"
        advice.append(f"Not for vibrations at h w {text}: they grow{size}.")
    return advice if len(stable) == 1 else [*advice, f"Not for vibrations at h w above {stable[-1][1]:.4g}."]


def _on_decay(data: Mapping[str, Any]) -> list[str]:
    limit = first_limit(data["negative_real"])
    if not math.isinf(limit):
        return [f"Not for decay above h rate = {limit:.4g}."]
    if data["multistep"]:
        return [f"Use it for decay up to h rate = {data['negative_real']['scanned_to']:g} at least."]
    word = "A-stable" if data["a_stable"] else "not A-stable"
    damping = "L-stable" if data["l_stable"] else f"|R(-1e6)| = {data['at_minus_1e6']:.6g}"
    return [f"Use it for decay at any h rate: {word}, {damping}."]


def first_limit(axis: Mapping[str, Any]) -> float:
    """The end of the stable interval from 0; 0 without one, infinity if it reaches the end of the scan."""
    stable = axis["stable"]
    if not stable or stable[0][0] > 0:
        return 0.0
    return math.inf if stable[0][1] >= axis["scanned_to"] else float(stable[0][1])


COLUMNS = (
    Column("imaginary", "stable on vibrations at h w", True, (0.1, 60.0)),
    Column("negative_real", "stable on decay at h rate", True, (0.1, 60.0)),
)


def marks(data: Mapping[str, Any]) -> list[Mark]:
    """The stable intervals on both axes, and the first limit."""
    marks = []
    for column in COLUMNS:
        axis = data[column.id]
        if axis is None:
            continue
        limit = first_limit(axis)
        text = "no limit" if math.isinf(limit) else f"limit {limit:.4g}" if limit else "at no step"
        marks.append(Mark(column.id, None if math.isinf(limit) else limit, text=text))
        marks += [
            Mark(column.id, low=low, high=high, text=f"from {low:.4g} to {high:.4g}") for low, high in axis["stable"]
        ]
    return marks


@panel("linear", "Linear stability", sentences, COLUMNS, marks, steps_reason)
def linear(integrator: Integrator, seconds: float) -> dict[str, Any]:
    problem = problem_for(integrator)
    assert problem is not None
    step = StepMatrix(integrator, problem)
    cost = step.seconds_per_point(1j * np.linspace(0.3, 1.5, 4 if problem.alone else 128))
    rays = {"imaginary": 1j, "negative_real": -1.0} if problem.plane else {"imaginary": 1j}
    data: dict[str, Any] = {"problem": problem.what, "negative_real": None, "region": None}
    data |= {axis: scan(step, ray, cost, SHARE * seconds) for axis, ray in rays.items()}
    if not data["imaginary"]["answers"]:
        raise Refused(f"no step matrix on {problem.what}: no answer, or another matrix in each step")
    turn = math.acos(min(max(float(step.turning(np.array([SMALL]))[0][0]), -1.0), 1.0))
    if turn < SMALL / FAR or turn > SMALL * FAR:
        raise Refused(f"no solution of {problem.what}: a step of h w = {SMALL:g} turns the phase by {turn:.2g} rad")
    several = {axis: several_steps(step, ray, first_limit(data[axis])) for axis, ray in rays.items()}
    data["multistep"] = any(contrary for contrary, _ in several.values())
    if data["multistep"]:  # one step shows the starting method alone
        longer = {axis: long_scan(step, ray, several[axis][1], SHARE * seconds) for axis, ray in rays.items()}
        return data | longer | {"a_stable": None, "l_stable": None, "at_minus_1e6": None}
    if not problem.plane:
        return data
    return data | large(step, data) | {"region": region(step, cost, SHARE * seconds)}


def scan(step: StepMatrix, direction: complex, cost: float, seconds: float) -> dict[str, Any]:
    """The stable intervals on the ray of `direction`, and for each gap between them the largest growth in a step."""
    spacing = affordable(SCAN_STEPS, lambda d: cost * len(scan_grid(step, d)), seconds)
    grid = scan_grid(step, spacing)
    answers = int(np.count_nonzero(np.isfinite(spectral_radius(step.matrices(direction * grid)))))
    points = np.sort(np.concatenate([grid, step.touching(grid)])) if direction == 1j else grid
    stable = stable_intervals(lambda x: step.stable(direction * x), points, step.bisections)
    gaps = [np.linspace(a[1], b[0], GAP_POINTS) for a, b in pairwise(stable)]
    return {
        "stable": stable,
        "gaps": [np.nanmax(spectral_radius(step.matrices(direction * x))) - 1 for x in gaps],
        "scanned_to": grid[-1],
        "scan_step": spacing,
        "width": spacing / 2**step.bisections,
        "answers": answers,
    }


def scan_grid(step: StepMatrix, spacing: float) -> Floats:
    if step.problem.alone:
        return np.arange(spacing, ENGINES_TO + spacing / 2, spacing)
    fine = np.arange(spacing, FINE_TO + spacing / 2, spacing)
    coarse = np.arange(FINE_TO + 5 * spacing, COARSE_TO + spacing, 5 * spacing)
    return np.concatenate([fine, coarse, LARGE])


def affordable(choices: tuple[float, ...], cost: Any, seconds: float) -> float:
    """The first of the choices, from the finest, that costs at most `seconds`; else the last one."""
    return next((choice for choice in choices if cost(choice) <= seconds), choices[-1])


def several_steps(step: StepMatrix, direction: complex, limit: float) -> tuple[bool, float]:
    """Whether the matrix of a step predicts the growth over 1024 steps wrongly, as for a multistep method.

    The points are on the ray of `direction`, below its limit. The second result is the processor time of a step.
    """
    if step.problem.alone:
        return False, 0.0  # the matrices of two successive steps were equal
    points = direction * np.linspace(0.2, 0.95, 4) * (limit if 0 < limit < math.inf else 4.0)
    step.growth(points[:1], 1)  # compiles
    grown: list[Floats] = []
    seconds = processor_seconds(lambda: grown.append(step.growth(points))) / (len(points) * 1024)
    (observed,) = grown
    with np.errstate(all="ignore"):
        predicted = np.array([_growth_of(matrix) for matrix in step.matrices(points)])
    contrary = ((observed > 1e3) & (predicted < GROWS)) | ((observed < GROWS) & (predicted > 1e3))
    return bool(np.any(contrary)), seconds


def _growth_of(matrix: Floats) -> float:
    """The largest element of the powers 16, 32, ... 1024 of a matrix; infinity if one is not finite."""
    sixteen = np.linalg.matrix_power(matrix, 16)
    power, largest = np.eye(2), 0.0
    for _ in range(64):
        power = sixteen @ power
        largest = max(largest, float(np.max(np.abs(power))))
        if not np.all(np.isfinite(power)):
            return math.inf
    return largest


def long_scan(step: StepMatrix, direction: complex, seconds_a_step: float, seconds: float) -> dict[str, Any]:
    """The stable intervals of a multistep method, on which motions do not grow over 1024 steps.

    If the time allows, edges are found with 65536 steps, and intervals that are unstable over this longer time are left
    out.
    """
    spacing = affordable(SCAN_STEPS, lambda d: seconds_a_step * 1024 * MULTISTEP_TO / d, seconds / 2)
    grid = np.arange(spacing, MULTISTEP_TO + spacing / 2, spacing)
    rough = stable_intervals(lambda x: step.bounded(direction * x), grid, 6)
    edges = sorted({edge for interval in rough for edge in interval if 0 < edge < grid[-1]})
    long = seconds_a_step * LONG * 64 * FEWER * max(len(edges), 1) < LONGER * seconds
    steps, stable = (LONG if long else 16), rough
    if edges:
        near = np.unique([[0.5 * edge, edge, 1.05 * edge] for edge in edges])
        stable = stable_intervals(lambda x: step.bounded(direction * x, steps), near, FEWER)
    width = max(edges, default=spacing) / 2**FEWER
    return {
        "stable": stable, "gaps": [math.nan] * (len(stable) - 1), "scanned_to": grid[-1], "scan_step": spacing,
        "width": width, "answers": len(grid), "steps": 64 * steps,
    }  # fmt: skip


def large(step: StepMatrix, scans: Mapping[str, Any]) -> dict[str, Any]:
    """A-stability, on a grid of the left half-plane and on both axes, and L-stability, at -1e6."""
    angles = np.linspace(0.5, 1.0, 7)[1:]
    z = np.array([r * np.exp(1j * np.pi * a) for r in (0.3, 1.0, 3.0, 10.0, 30.0, *LARGE) for a in angles])
    radii = spectral_radius(step.matrices(z))
    axes = all(math.isinf(first_limit(scans[axis])) and len(scans[axis]["stable"]) == 1 for axis in (
        "imaginary", "negative_real"))  # fmt: skip
    end = float(radii[-1])
    a_stable = bool(axes and np.all(radii <= 1 + step.tolerance))
    return {"a_stable": a_stable, "l_stable": bool(a_stable and end < L_STABLE), "at_minus_1e6": end}


def region(step: StepMatrix, cost: float, seconds: float) -> dict[str, Any]:
    """|R| on a grid of the upper half-plane, rows from Im z = 0, four significant digits.

    `cost`: the seconds of one value of R. The grid is the finest one of REGION_STEPS that takes at most `seconds`.
    """
    low, high, top = REGION
    area = (high - low) * top
    spacing = affordable(REGION_STEPS, lambda d: cost * area / d**2, seconds)
    real = np.linspace(low, high, round((high - low) / spacing) + 1)
    imaginary = np.linspace(0, top, round(top / spacing) + 1)
    z = real[None, :] + 1j * imaginary[:, None]
    radii = spectral_radius(step.matrices(z.ravel())).reshape(z.shape)
    rows = [[float(f"{value:.4g}") for value in row] for row in radii]
    return {"real": [low, high], "imaginary": [0.0, top], "spacing": spacing, "modulus": rows}
