"""Three methods made of plain functions, each right or with one planted fault by name: RK4, Störmer-Verlet, a pair."""

import os
from collections.abc import Callable
from typing import Any

import numpy as np
from gnomon.harness.contract.integrator import Integrator, Refused, Steps, Tolerance
from gnomon.harness.verification.function_adapter import from_solve, from_step
from passing_time import hang

SCRATCH: dict[str, Any] = {}
"""State that faulty methods keep between calls."""

RK4_FAULTS = (
    "coefficient_5", "coefficient_10", "sign", "time", "float32", "aliased", "kept", "order_of_stages",
)  # fmt: skip
VERLET_FAULTS = ("coefficient_5", "coefficient_10", "sign", "time", "float32", "kept", "missing_half")
PAIR_FAULTS = ("coefficient_5", "coefficient_10", "sign", "time", "float32", "last_step", "kept")


def rk4(fault: str = "") -> Integrator:
    """The classical Runge-Kutta method."""
    sixth = {"coefficient_5": 1.00001, "coefficient_10": 1 + 1e-10}.get(fault, 1.0) / 6
    half = -0.5 if fault == "sign" else 0.5

    def step(f: Callable[..., Any], t: float, y: Any, h: float) -> Any:
        if fault == "float32":
            y = y.astype(np.float32).astype(np.float64)
        middle = t if fault == "time" else t + h / 2
        a = f(t, y)
        if fault == "kept":
            a = SCRATCH.get("slope", a) if len(SCRATCH.get("slope", a)) == len(a) else a
        if fault == "aliased":
            stage = y
            stage += half * h * a
        b = f(middle, y + half * h * a)
        c = f(middle, y + h / 2 * b)
        d = f(t + h, y + h * c)
        if fault == "order_of_stages":
            c, d = d, c
        found = y + h * (sixth * a + b / 3 + c / 3 + d / 6)
        if fault == "kept":
            SCRATCH["slope"] = f(t + h, found)
        return found

    return from_step(step, name=f"RK4 {fault}".strip(), order=4, sweep=Steps(0.25, 10))


def verlet(fault: str = "") -> Integrator:
    """Störmer-Verlet in its velocity form."""
    half = {"coefficient_5": 0.500005, "coefficient_10": 0.5 + 5e-11, "sign": -0.5}.get(fault, 0.5)

    def step(f: Callable[..., Any], t: float, y: Any, h: float) -> Any:
        if fault == "float32":
            y = y.astype(np.float32).astype(np.float64)
        n = len(y) // 2
        q, v = y[:n], y[n:]
        before = f(t, q)
        if fault == "kept" and len(SCRATCH.get("force", ())) == n:
            before = SCRATCH["force"]
        v_half = v + h / 2 * before
        q = q + h * v_half
        after = f(t if fault == "time" else t + h, q)
        SCRATCH["force"] = after
        return np.concatenate([q, v_half + (0.0 if fault == "missing_half" else half) * h * after])

    return from_step(
        step,
        name=f"Verlet {fault}".strip(),
        order=2,
        sweep=Steps(0.25, 10),
        accelerations=True,
        conserves=("symplectic", "reversible", "momentum"),
    )


_C = (0.0, 1 / 5, 3 / 10, 4 / 5, 8 / 9, 1.0, 1.0)
_A = (
    (),
    (1 / 5,),
    (3 / 40, 9 / 40),
    (44 / 45, -56 / 15, 32 / 9),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656),
    (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
)
_ERROR = (71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40)


def pair(fault: str = "") -> Integrator:
    """Dormand and Prince's 5(4) pair with a step size of its own, which stops at the samples."""
    rows = [list(row) for row in _A]
    rows[6][2] *= {"coefficient_5": 1.00001, "coefficient_10": 1 + 1e-10}.get(fault, 1.0)
    rows[3][1] *= -1.0 if fault == "sign" else 1.0

    def solve(f: Callable[..., Any], t0: float, y0: Any, times: Any, tolerance: float) -> Any:
        t, y, found = t0, y0, []
        h = SCRATCH.get("h", 1e-3) if fault == "kept" else 1e-3 * float(times[-1])
        for end in times.tolist():
            while t < end:
                last = t + h >= end * (1 - 1e-14)
                step = end - t if last and fault != "last_step" else h
                if fault == "float32":
                    y = y.astype(np.float32).astype(np.float64)
                k: list[Any] = []
                for c, row in zip(_C, rows, strict=True):
                    at = y + step * sum((a * b for a, b in zip(row, k, strict=True)), np.zeros_like(y))
                    k.append(f(t + (0.0 if fault == "time" else c) * step, at))
                new = at
                size = np.maximum(np.linalg.norm(y), 1e-3) * tolerance
                error = np.linalg.norm(step * sum(e * s for e, s in zip(_ERROR, k, strict=True))) / size
                if not np.isfinite(error) or step < 1e-14 * max(abs(t), 1e-300):
                    raise Refused("the step size went to zero")
                if error <= 1:
                    t, y = (end if last else t + step), new
                h = step * min(5.0, max(0.2, 0.9 * max(error, 1e-10) ** -0.2))
            found.append(y)
        SCRATCH["h"] = h
        return np.array(found)

    return from_solve(solve, name=f"pair {fault}".strip(), order=5, sweep=Tolerance(1e-4, 1e-12))


GOOD = (rk4(), verlet(), pair())
MUTANTS = (*map(rk4, RK4_FAULTS), *map(verlet, VERLET_FAULTS), *map(pair, PAIR_FAULTS))
good_rk4, good_verlet, good_pair = GOOD


def raising(f: Callable[..., Any], t: float, y: Any, h: float) -> Any:
    return y + h * f(t, y)[:1] * undefined  # type: ignore[name-defined]  # noqa: F821


broken = from_step(raising, name="broken", order=1)
hanging = from_step(lambda f, t, y, h: hang(), name="hanging", order=1)
signed = verlet("sign")


def _ends(f: Callable[..., Any], t: float, y: Any, h: float) -> Any:
    if not np.all(np.isfinite(y)):
        os._exit(7)
    return y + h * f(t, y)


ends_its_process = from_step(_ends, name="ends its process", order=1)


def seventh(f: Callable[..., Any], t0: float, y0: Any, times: Any, step: float) -> Any:
    """Heun's method of order 2, whose seventh and later solutions in a process are wrong."""
    SCRATCH["solutions"] = SCRATCH.get("solutions", 0) + 1
    t, y, found = t0, y0 * (1 + 1e-9 * (SCRATCH["solutions"] >= 7)), []
    for end in times:
        count = max(1, round((end - t) / step))
        h = (end - t) / count
        for k in range(count):
            a = f(t + k * h, y)
            y = y + h / 2 * (a + f(t + (k + 1) * h, y + h * a))
        t = end
        found.append(y)
    return np.array(found)


wrong_from_the_seventh = from_solve(seventh, name="seventh", order=2, sweep=Steps(0.125, 6))
