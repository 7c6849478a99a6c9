"""Small JSON files beside a page, as the commands of gnomon write them."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

PAIR = {
    "group": "against heyoka:Taylor", "problem": "pendulum_simple/speed", "level": "1e-06", "unit": "s",
    "first_name": "Gauss", "second_name": "heyoka:Taylor", "first": 1e-4, "second": 7.65e-4, "first_null": 1e-6,
    "second_null": None, "median": 7.65, "low": 7.0, "high": 8.0, "launches": 5, "ratios": [7.0, 7.65, 8.0, 7.5, 7.9],
}  # fmt: skip
LAW = {
    "integrator": "RK4", "case": "pendulum_simple", "setting": "128 steps a period", "periods": 1e5, "starts": 4,
    "size": 1e-3, "power": 1.0, "uncertainty": 0.01, "low": 0.98, "high": 1.02, "law": "t", "expected": "t",
}  # fmt: skip
ORDER = {
    "integrator": "RK4", "case": "pendulum_simple", "span": 3.0, "digits": 16, "at_fixed_steps": False, "points": 6,
    "order": 3.9487, "declared": 4, "keeps": ["symplectic", "momentum"],
}  # fmt: skip
CERTIFICATE = {
    "case": "kepler_orbit", "variant": "default", "ways": {"taylor": 48.2, "residual": 46.1}, "note": "a note",
    "required": 45, "digits": 46.1, "passed": True, "worst": "residual",
}  # fmt: skip
COMPUTATION = {
    "check": "inertia_tensor_special_bodies", "variant": "default", "computation": "cubature", "library": "scipy",
    "quantity": "box", "error": 5e-15, "seconds": 0.1, "status": "ok", "reason": "",
}  # fmt: skip
STABILITY = {
    "schema": 1, "depth": "normal", "environment": {}, "panels": {"linear": "Linear stability"},
    "figures": {"linear": {"cells": False, "columns": [{"id": "limit", "title": "h w", "decades": False, "ends": None}]}},
    "tiers": {"lost_digits": {"tiers": [["gnomon:RK4"], ["heyoka:Taylor"]]}},
    "rows": [
        {"integrator": "gnomon:RK4", "panel": "linear", "data": {}, "sentences": ["Use it up to h w < 2.828."],
         "marks": [{"column": "limit", "at": 2.828, "low": None, "high": None, "text": "limit 2.828"}]},
        {"integrator": "heyoka:Taylor", "panel": "linear", "data": {"refused": "not here"}, "sentences": []},
    ],
}  # fmt: skip

WAY = {
    "id": "pybullet:stepSimulation [configured]", "library": "pybullet", "title": "PyBullet", "policy": "configured",
    "order": 1, "bits": 53, "versions": {"pybullet": "3.2.7"}, "changed": {"linearDamping": "0.0"},
    "lacks": {"curved_guide": "no curve as a constraint"},
}  # fmt: skip
LEAGUE = {
    "environment": {},
    "absent": {"pydrake": "not installed"},
    "lines": {"pybullet": ["# always", "p.changeDynamics(body, -1, linearDamping=0.0)"]},
    "engines": [WAY, WAY | {"id": "pybullet:stepSimulation [as shipped]", "policy": "as shipped", "order": None}],
    "scenes": [
        {"scene": "pendulum_simple/engines", "title": "Simple pendulum", "span": 25.0, "time_scale": 0.32, "binary64": 2e-14, "binary32": 1.1e-5},
        {"scene": "billiard_ball/engines", "title": "Billiard ball", "span": 2.0, "time_scale": 0.5, "binary64": 1e-16, "binary32": 5e-8},
    ],
    "rows": [
        {"scene": "pendulum_simple/engines", "integrator": WAY["id"], "policy": "configured", "status": "ran", "reason": "",
         "points": [[0.01, 1e-2, 2e-6], [0.001, 1e-3, None], [0.0001, None, 2e-6]], "order": 1.0, "constant": 0.32,
         "rest": None, "rest_is": "", "precision": 2e-14, "solver": None,
         "steps": {"0.01": 0.01, "0.001": 0.001, "0.0001": None}},
        {"scene": "billiard_ball/engines", "integrator": WAY["id"], "policy": "configured", "status": "ran", "reason": "",
         "points": [[0.01, 2e-3, 2e-6], [0.001, 1.9e-3, 2e-6]], "order": None, "constant": None, "rest": 1.9e-3,
         "rest_is": "model", "precision": 1e-16, "solver": 1e-6, "steps": {"0.01": 0.01, "0.001": None, "0.0001": None}},
        {"scene": "billiard_ball/engines", "integrator": "pybullet:stepSimulation [as shipped]", "policy": "as shipped",
         "status": "refused", "reason": "it did not move", "points": []},
    ],
    "table": {WAY["id"]: {"pendulum_simple": "", "cycloidal_pendulum": "lacks curved_guide (no curve as a constraint)"}},
    "preflights": [
        {"integrator": WAY["id"], "name": "restitution", "verdict": "passed", "text": "0.5 is 0.5"},
        {"integrator": "pybullet:stepSimulation [as shipped]", "name": "damping", "verdict": "failed", "text": "speed falls by 4 % in a second"},
    ],
    "costs": [
        {"integrator": WAY["id"], "scene": "spring_pendulum", "step_us": 5.4, "engine_us": 1.3, "forces_us": 4.1,
         "python_share": 0.76, "call_us": 0.3,
         "read_us": 4.3, "world_kilobytes": 28589.2, "grown_kilobytes": 0.0, "same_bits": {"in a new world": True, "in two threads": False},
         "energy_an_hour": 0.011},
        {"integrator": "pybullet:stepSimulation [as shipped]", "reason": "its process was killed"},
    ],
}  # fmt: skip


SHARE = {"held": 9, "of": 10, "systems": 5, "share": 0.9, "low": 0.42, "high": 0.99}


def files(revisions: Mapping[str, str | None] = {}) -> dict[str, Any]:
    """The contents of each file, with its revision where one is given."""
    at = {name: {"revision": revisions[name]} if name in revisions else {} for name in ROWS}
    found = {name: content | {"environment": at[name]} for name, content in ROWS.items()}
    found["certificates.json"]["rows"] = [CERTIFICATE | at["certificates.json"]]
    return found


ROWS: dict[str, dict[str, Any]] = {
    "benchmarks.json": {"launches": 5, "rows": [PAIR]},
    "growth.json": {"rows": [LAW]},
    "engines.json": LEAGUE,
    "orders.json": {"rows": [ORDER]},
    "stability.json": STABILITY,
    "certificates.json": {"rows": [CERTIFICATE]},
    "checks.json": {"rows": [COMPUTATION]},
    "verification.json": {"not_measured": {}, "survivors_without_reason": []},
    "outside.json": {"margin": 0.1, "share": SHARE, "order": SHARE},
}


def write(folder: Path, revisions: Mapping[str, str | None] = {}) -> None:
    """Write all of them."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in files(revisions).items():
        (folder / name).write_text(json.dumps(content))
