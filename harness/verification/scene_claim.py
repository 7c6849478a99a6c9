"""The claim about engines that needs no case: a body in space, under springs and under forces of time."""

from __future__ import annotations

from math import cos

import numpy as np
from gnomon.cases.core.scene import Body, Force, Readings, Scene, SceneForm, Vector
from gnomon.harness.contract.integrator import Problem, Refused
from gnomon.harness.results.convergence_order import LARGEST_ERROR
from gnomon.harness.verification.claims import Finding, Outcome, claim, failed, not_applicable
from gnomon.harness.verification.convergence_claims import Point, slope_of
from gnomon.harness.verification.trials import HALF_ULP, Floats, Trials

FREQUENCIES = np.array([1.0, 2.0, 3.0])
"""Of the springs, or of the forces, along the axes of space: each differs, so that no axis can stand for another."""
SAMPLES = 4
COUNTS = 2 ** np.arange(4, 12)
"""Numbers of steps in a time of 1; the finest show a time that is wrong by its fifth digit."""
STARTS = np.array([[-1.0, 2.0, -0.5, 1.0, 0.5, -2.0], [0.5, -0.75, 1.0, 1.0, 0.25, -0.5]])
"""Two starts that one engine solves in turn; the second one is compared with its exact motion."""
ROUNDINGS = 4
"""Half ulps that each step may add to the state: two roundings, carried to the samples by a growth below 2."""


def springs(t: float, position: Vector, velocity: Vector) -> Vector:
    x, y, z = position
    return -x, -4 * y, -9 * z


def pushes(t: float, position: Vector, velocity: Vector) -> Vector:
    return cos(t), cos(2 * t), cos(3 * t)


def _scene(token: str) -> SceneForm:
    law = springs if token == "position_force" else pushes

    def build(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
        x, y, z, u, v, w = state
        body = Body("body", 1.0, (0.0, 0.0, 0.0), (x, y, z), velocity=(u, v, w))
        return Scene((0.0, 0.0, 0.0), (body,), forces=(Force("body", token, law),))

    def observe(readings: Readings, parameters: tuple[float, ...]) -> tuple[float, ...]:
        position, _, velocity, _ = readings.bodies["body"]
        return *position, *velocity

    return SceneForm(build, observe, frozenset({token}), conservative=token == "position_force")


def _exact(token: str, t: float) -> Floats:
    place, speed = np.split(STARTS[1], 2)
    w = FREQUENCIES
    c, s = np.cos(w * t), np.sin(w * t)
    if token == "position_force":
        return np.concatenate([place * c + speed * s / w, speed * c - place * w * s])
    return np.concatenate([place + speed * t + (1 - c) / w**2, speed + s / w])


def _applies(trials: Trials) -> str | None:
    if SceneForm not in trials.integrator.accepts or not trials.steps:
        return "it is not an engine that takes scenes"
    return "it declares no order" if trials.integrator.order is None else None


@claim("scene", _applies, once=True)
def _scenes(trials: Trials) -> Finding:
    order = trials.integrator.order
    assert order is not None
    found = not_applicable("it takes neither forces of position nor forces of time")
    for token, what in (("position_force", "springs"), ("time_force", "forces of time")):
        if trials.integrator.unsupported(_scene(token)) is not None:
            continue
        points = _points(trials, token)
        if points and points[-1][0] == 1 / COUNTS[-1] and not points[-1][1] < LARGEST_ERROR:
            expected = f"an error of a body under {what} below {LARGEST_ERROR:g}, as of order 1"
            return failed(f"h = {points[-1][0]:.3g}", expected, f"{points[-1][1]:.2g}")
        finding = slope_of(points, order, f"errors of a body under {what}")
        if finding.outcome == Outcome.FAILED:
            return finding
        if found.outcome != Outcome.PASSED:
            found = finding
    return found


def _points(trials: Trials, token: str) -> list[Point]:
    times = np.arange(1, SAMPLES + 1) / SAMPLES
    exact = np.array([_exact(token, t) for t in times])
    found: list[Point] = []
    for count in COUNTS.tolist():
        problem = Problem(_scene(token), STARTS.shape[1], np.zeros(0), times, 1.0)
        try:
            states = trials.solutions(problem, 1 / count, list(STARTS))[1]
        except Refused:
            continue
        error = float(np.max(np.abs(states - exact)) / np.max(np.abs(exact)))
        roundoff = ROUNDINGS * HALF_ULP * count
        found.append((1 / count, error, roundoff))
        if error < roundoff:
            break
    return found
