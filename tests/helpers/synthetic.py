"""A results file with invented rows of every kind, for tests of code that only reads the store."""

import json
import math
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from gnomon.harness.results.store import Store

CASES = {
    "pendulum_simple": ("Simple pendulum", "7.10", 2, ("default", "separatrix", "long")),
    "kepler_orbit": ("Kepler orbit", "7.12, 5.9", 4, ("default", "e09")),
    "bouncing_ball": ("Bouncing ball", "8.13", 2, ("default",)),
}
INTEGRATORS = (
    # library, name, policy, order, kind of setting, seconds a right-hand side, conserves
    ("gnomon", "RK4", "", 4, "step", 17e-9, ""),
    ("gnomon", "Stormer-Verlet", "", 2, "step", 17e-9, "symplectic"),
    ("gnomon", "DOP853", "", 8, "tolerance", 20e-9, ""),
    ("scipy", "RK45", "", 5, "tolerance", 4e-6, ""),
    ("rebound", "IAS15", "", 15, "tolerance", 1e-7, ""),
    ("pybullet", "multibody", "configured", 1, "step", 1.4e-6, ""),
    ("pybullet", "multibody", "as shipped", 1, "step", 1.4e-6, ""),
)
FLOOR, CONDITIONING, SPAN = 5e-17, 3e-15, 62.8
NULL_SECONDS = 2e-7
"""The null call of every integrator: a tenth of 2 microseconds, which only the fastest calls take."""
MADE_BY: dict[str, str] = {}
"""More of the environment of the run, set by tests that need it."""


Values = dict[str, Any]
Change = Callable[[Values, int, Values], Values | None]


def _unchanged(trial: Values, launch: int, measurement: Values) -> Values | None:
    return measurement


def write(
    path: Path,
    cases: Mapping[str, tuple[str, str, int, Sequence[str]]] = CASES,
    integrators: Sequence[tuple[Any, ...]] = INTEGRATORS,
    change: Change = _unchanged,
) -> Path:
    """Write the file and return its path.

    `change` of a trial, a launch and its measurement is what is written for it; None leaves the launch out.
    """
    with Store(path) as store:
        environment: dict[str, Any] = {
            "cpu": "Invented CPU", "cores": 2, "python": "3.11.0", "git": "0000000", "numpy": "2.0.0",
        }  # fmt: skip
        run = store.begin_run("full", "gnomon run", environment | MADE_BY)
        for name, (*words, variants) in cases.items():
            for variant in variants:
                for integrator in integrators:
                    _series(store, run, (name, *words, variant), integrator, change)
        store.end_run(run)
    return path


def _series(store: Store, run: int, problem: tuple[Any, ...], integrator: tuple[Any, ...], change: Change) -> None:
    case, title, section, dimension, variant = problem
    library, name, policy, order, kind, cost, conserves = integrator
    identity = f"{library}:{name}" + (f" [{policy}]" if policy else "")
    series = f"{case}/{variant} | standard | {identity}"
    unsupported = library == "rebound" and case == "bouncing_ball"
    settings = [None] if unsupported else [10.0**-k for k in range(1, 12)]
    if kind == "step" and not unsupported:
        settings = [0.5 / 2**k for k in range(11)]
    trial = {
        "series": series, "section": section, "title": title, "case": case, "variant": variant, "stresses": "invented",
        "formulation": "standard", "form": "Separable", "library": library, "integrator": name, "policy": policy,
        "integrator_id": identity, "order_declared": order, "sampling": "grid" if kind == "step" else "dense",
        "conserves": conserves, "setting_kind": kind, "dimension": dimension, "span": SPAN, "time_scale": 1.0,
        "numbers": json.dumps({"g": "1"}), "floor": FLOOR, "conditioning": CONDITIONING, "machine": "invented",
    }  # fmt: skip
    trials = [{**trial, "trial_key": f"{series} @ {s}", "setting": s} for s in settings]
    store.plan(run, trials)
    stopped = False
    for row in trials:
        for launch in range(1, 6 if variant == "default" else 2):
            measurement, states = _measurement(row, launch, cost)
            if stopped:
                measurement = {"status": "skipped", "reason": "predicted 2.4 s, limit 1 s"}
            written = change(row, launch, measurement)
            if written is None:
                continue
            extra = {"bounceRestitution": "0"} if policy == "configured" else {}
            scored = written["status"] in ("ok", "inaccurate")
            fixed = {"trial_key": row["trial_key"], "launch": launch, "limit_seconds": 1.0}
            store.add(run, fixed | written, extra, states if scored else None)
        stopped = stopped or measurement["status"] == "timeout"


def _measurement(trial: dict[str, Any], launch: int, cost: float) -> tuple[dict[str, Any], Any]:
    setting, order = trial["setting"], trial["order_declared"]
    if setting is None:
        return {"status": "unsupported", "reason": "lacks rigid_impact"}, None
    if trial["setting_kind"] == "step":
        error = 0.3 * setting**order
        calls = round(SPAN / setting) * max(1, min(order, 4))
    else:
        error = 30 * setting
        calls = round(40 * SPAN * setting ** (-1 / order))
    error = 0.0 if trial["case"] == "bouncing_ball" and error < 1e-12 else max(error, CONDITIONING / 3)
    if (
        trial["library"] == "gnomon"
        and trial["integrator"] == "RK4"
        and trial["variant"] == "separatrix"
        and setting > 0.2
    ):
        return {"status": "diverged", "reason": "states are not finite from t = 12", "rhs_calls": calls}, None
    if calls * cost > 0.05:
        return {"status": "timeout", "reason": "no answer within 1 s"}, None
    seconds = calls * cost * (1 + 0.03 * math.sin(launch))
    times = np.arange(1, 65) * SPAN / 64
    states = np.cos(times)[:, None] + error * (times / SPAN)[:, None] * np.ones(trial["dimension"])
    status = "diverged" if error > 1 else "inaccurate" if error > 0.1 else "ok"
    measurement = {
        "status": status, "reason": "" if status == "ok" else f"error {error:.2g}", "error_max": error,
        "error_end": error, "error_rms": error / 2, "error_phase": error * 0.9, "error_shape": error * 0.3,
        "turns": 12 if trial["library"] == "pybullet" else 0, "invariant_drift": {"energy": error / 10},
        "rhs_calls": calls if trial["library"] != "pybullet" else None,
        "steps": calls, "repeats": 20, "seconds_median": seconds, "seconds_low": seconds * 0.98,
        "seconds_high": seconds * 1.1, "prepare_seconds": 0.01, "null_seconds": NULL_SECONDS,
    }  # fmt: skip
    if trial["setting_kind"] == "tolerance":
        measurement["error_over_tolerance"] = error / setting
    if trial["case"] == "bouncing_ball":
        measurement |= {"events_missing": 0, "events_extra": 0, "events_time_error": error}
    return measurement, states
