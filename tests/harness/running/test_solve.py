"""`solve` on equations of the reader's own: the motion is the exact one, at any times, and wrong input is named."""

import math
from collections.abc import Callable
from math import sin
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.forms import FirstOrder, SecondOrder
from gnomon.harness import solve
from gnomon.harness.contract.integrator import Refused, Steps
from gnomon.harness.registry import lookup

ALL = {one.id: one for one in lookup.everything().values() if {FirstOrder, SecondOrder} & set(one.accepts)}
QUICK = ("gnomon:RK4", "gnomon:Störmer-Verlet", "gnomon:DOP853", "scipy:RK45")
TIMES = (0.7, 0.71, 1.9, 2.0, 6.3)


def growth(t: float, y: Any) -> Any:
    return (y[1], -4.0 * y[0] + t)


def accelerated(t: float, q: Any, p: Any) -> Any:
    return (-p[0] * q[0] + t,)


def exact(t: float) -> tuple[float, float]:
    """The motion of q'' = -4 q + t from q = 1/8 + .3, q' = 1/4 at t = 1/2."""
    return t / 4 + 0.3 * math.cos(2 * (t - 0.5)), 0.25 - 0.6 * math.sin(2 * (t - 0.5))


def error(method: str) -> float:
    integrator, start = ALL[method], exact(0.5)
    setting = 2.0**-9 if isinstance(integrator.sweep, Steps) else 1e-8
    second = SecondOrder in integrator.accepts and FirstOrder not in integrator.accepts
    f: Callable[..., Any] = accelerated if second else growth
    given: dict[str, Any] = {"parameters": (4.0,), "accelerations": True} if second else {}
    states = solve(f, 0.5, start, [0.5 + t for t in TIMES], setting, method, **given)
    return float(np.max(np.abs(states - [exact(0.5 + t) for t in TIMES])))


@pytest.mark.parametrize("method", [*QUICK, *(pytest.param(m, marks=pytest.mark.slow) for m in ALL if m not in QUICK)])
def test_the_motion_is_the_exact_one_at_decimal_times(method: str) -> None:
    """Steps of 2^-9 of a method of order p leave some (2^-8)^p times the span; a tolerance some hundred times itself."""
    order = ALL[method].order if isinstance(ALL[method].sweep, Steps) else None
    assert error(method) < (1e-5 if order is None else 20 * 2.0 ** (-8 * min(order, 4)))


def branching(t: float, y: Any) -> Any:
    return (1.0,) if y[0] > 0 else (sin(t),)


@pytest.mark.parametrize(
    ("changed", "says"),
    [
        ({"y0": [math.nan, 1.0]}, "y0="),
        ({"y0": [[1.0, 1.0]]}, "y0="),
        ({"times": [1.0, 1.0]}, "increase"),
        ({"times": [0.4]}, "after t0=0.5"),
        ({"tolerance": 0.0}, "tolerance=0.0"),
        ({"method": "RK5"}, "no integrator is called 'RK5'"),
        ({"method": "gnomon:Störmer-Verlet"}, "needs equations as SecondOrder"),
        ({"method": "gnomon:Taylor", "f": branching, "y0": [1.0]}, "branch"),
    ],
)
def test_wrong_input_is_named(changed: dict[str, Any], says: str) -> None:
    given = {"f": growth, "t0": 0.5, "y0": [1.0, 0.0], "times": [1.0], "tolerance": 1e-6, "method": "gnomon:DOP853"}
    with pytest.raises((ValueError, Refused), match=says):
        solve(**(given | changed))  # type: ignore[arg-type]
