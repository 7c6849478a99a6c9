"""Right methods that are written in other ways than most: adaptive ones of several kinds, Jacobians of differences,
iterations that do not converge at long steps, and methods that wait."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import right_methods
from gnomon.harness.contract.integrator import Integrator, Steps, Tolerance
from gnomon.harness.verification.function_adapter import from_solve, from_step
from passing_time import pass_time
from scipy.integrate import solve_ivp


@dataclass(frozen=True)
class Pair:
    """An embedded pair whose last stage is the result of the step, or is not used for it: nodes, stages, estimate.

    `order` is the order of the result, `local` the power of the step size of the estimate.
    """

    nodes: tuple[float, ...]
    stages: tuple[tuple[float, ...], ...]
    estimate: tuple[float, ...]
    order: int
    local: int
    tightest: float = 1e-10


PAIRS: Mapping[str, Pair] = {
    "Dormand-Prince": Pair(right_methods.C, right_methods.A, right_methods.E, 5, 5),
    "Bogacki-Shampine": Pair(
        (0, 1 / 2, 3 / 4, 1), ((), (1 / 2,), (0, 3 / 4), (2 / 9, 1 / 3, 4 / 9)), (-5 / 72, 1 / 12, 1 / 9, -1 / 8), 3, 3, 1e-7
    ),
    # The result has order 4: no local extrapolation, so that each step may spend the whole tolerance.
    "Fehlberg": Pair(
        (0, 1 / 4, 3 / 8, 12 / 13, 1, 1 / 2, 1),
        (
            (),
            (1 / 4,),
            (3 / 32, 9 / 32),
            (1932 / 2197, -7200 / 2197, 7296 / 2197),
            (439 / 216, -8, 3680 / 513, -845 / 4104),
            (-8 / 27, 2, -3544 / 2565, 1859 / 4104, -11 / 40),
            (25 / 216, 0, 1408 / 2565, 2197 / 4104, -1 / 5, 0),
        ),
        (1 / 360, 0, -128 / 4275, -2197 / 75240, 1 / 50, 2 / 55, 0),
        4,
        5,
    ),
}  # fmt: skip


@dataclass(frozen=True)
class Adaptive:
    """A solver with a pair. `size`: the divisor of the estimate. `unit`: the tolerance is for a unit of time.

    `divide`: a fault, the estimate is so many times too small.
    """

    pair: Pair
    size: Callable[[Any, Any], Any]
    dense: bool
    unit: bool = False
    divide: float = 1.0

    def __call__(self, f: Any, t0: float, y0: Any, times: Any, tolerance: float) -> Any:
        pair, t, y, h, found = self.pair, t0, y0, 1e-3 * (times[-1] - t0), list[Any]()
        first = f(t, y)
        while len(found) < len(times):
            end = times[-1] if self.dense else times[len(found)]
            last = t + h >= end
            step = end - t if last else h
            slopes, new = [first], y
            for c, row in zip(pair.nodes[1:], pair.stages[1:], strict=True):
                new = y + step * sum(a * k for a, k in zip(row, slopes, strict=True))
                slopes.append(f(t + c * step, new))
            local = step * sum(e * k for e, k in zip(pair.estimate, slopes, strict=True)) / self.divide
            error = np.sqrt(np.mean((local / (tolerance * self.size(y, new))) ** 2)) / (step if self.unit else 1.0)
            if not np.isfinite(error) or step < 1e-15 * max(abs(t), 1e-300):
                return np.full((len(times), len(y0)), np.nan)
            if error <= 1:
                after = end if last else t + step
                while len(found) < len(times) and times[len(found)] <= after:
                    x = (times[len(found)] - t) / (after - t)
                    found.append(new if x == 1 else self.between(x, y, new, step * first, step * slopes[-1]))
                t, y, first = after, new, slopes[-1]
            h = step * min(5.0, max(0.2, 0.9 * max(error, 1e-10) ** (-1 / (pair.local - self.unit))))
        return np.array(found)

    @staticmethod
    def between(x: float, y: Any, new: Any, before: Any, after: Any) -> Any:
        """Hermite's cubic."""
        start, end = (1 + 2 * x) * (1 - x) ** 2 * y, x * x * (3 - 2 * x) * new
        return start + end + x * (1 - x) ** 2 * before + x * x * (x - 1) * after


def norm(y: Any, new: Any) -> Any:
    return max(np.linalg.norm(y), 1e-3) / np.sqrt(len(y))


def components(y: Any, new: Any) -> Any:
    """rtol and atol alike."""
    return 1 + np.maximum(abs(y), abs(new))


def relative(y: Any, new: Any) -> Any:
    """atol is a thousandth of rtol."""
    return 1e-3 + np.maximum(abs(y), abs(new))


def adaptive(divide: float = 1.0) -> list[Integrator]:
    """Right adaptive solvers; with `divide` solvers whose estimate of the error is so many times too small."""
    ways = {
        "norm": Adaptive(PAIRS["Dormand-Prince"], norm, True, divide=divide),
        "components, stops": Adaptive(PAIRS["Dormand-Prince"], components, False, divide=divide),
        "relative, unit step": Adaptive(PAIRS["Dormand-Prince"], relative, True, True, divide),
        "3(2)": Adaptive(PAIRS["Bogacki-Shampine"], components, True, divide=divide),
        "3(2) stops": Adaptive(PAIRS["Bogacki-Shampine"], relative, False, divide=divide),
        "4(5)": Adaptive(PAIRS["Fehlberg"], components, True, divide=divide),
        "4(5) unit step": Adaptive(PAIRS["Fehlberg"], relative, False, True, divide),
    }
    return [
        from_solve(
            way,
            name=f"{name} / {divide:g}",
            order=way.pair.order,
            sweep=Tolerance(1e-3, 1e-7 if way.unit else way.pair.tightest),
            dense_order=3 if way.dense else None,
        )
        for name, way in ways.items()
    ]


def radau(f: Any, t0: float, y0: Any, times: Any, tolerance: float) -> Any:
    """SciPy's Radau IIA of order 5, called as its users do."""
    found = solve_ivp(f, (t0, times[-1]), y0, method="Radau", t_eval=times, rtol=tolerance, atol=1e-3 * tolerance)
    states = np.full((len(times), len(y0)), np.nan)
    states[: len(found.t)] = found.y.T
    return states


right_radau = from_solve(radau, name="Radau", order=5, sweep=Tolerance(1e-3, 1e-8), dense_order=3)


def ros2(f: Any, t: float, y: Any, h: float) -> Any:
    """Verwer's Rosenbrock method of order 2, with a Jacobian of forward differences."""
    gamma, n, first = 1 + 1 / np.sqrt(2), len(y), f(t, y)
    jacobian = np.empty((n, n))
    for i in range(n):
        moved = y.copy()
        moved[i] += 2.0**-26 * max(abs(y[i]), 1.0)
        jacobian[:, i] = (f(t, moved) - first) / (moved[i] - y[i])
    matrix = np.eye(n) - gamma * h * jacobian
    a = np.linalg.solve(matrix, first)
    b = np.linalg.solve(matrix, f(t + h, y + h * a) - 2 * a)
    return y + h * (1.5 * a + 0.5 * b)


def midpoint(f: Any, t: float, y: Any, h: float, iterations: int = 100) -> Any:
    """The implicit midpoint rule by fixed-point iteration, which diverges at too long a step and does not say so."""
    slope = f(t, y)
    for _ in range(iterations):
        before, slope = slope, f(t + h / 2, y + h / 2 * slope)
        if np.max(np.abs(slope - before)) <= 1e-16 * np.max(np.abs(slope)):
            break
    return y + h * slope


def three_iterations(f: Any, t: float, y: Any, h: float) -> Any:
    """A fault: it conserves nothing to round-off."""
    return midpoint(f, t, y, h, 3)


@dataclass
class Waits:
    """RK4 that first waits in each solution."""

    seconds: float
    wait: Callable[[float], object] = pass_time

    def __call__(self, f: Any, t0: float, y0: Any, times: Any, step: float) -> Any:
        self.wait(self.seconds)
        y, t, found = y0, t0, []
        for end in times:
            count = max(1, round((end - t) / step))
            for i in range(count):
                y = right_methods.rk4(f, t + i * (end - t) / count, y, (end - t) / count)
            t = end
            found.append(y)
        return np.array(found)


def waiting(seconds: float, wait: Callable[[float], object] = pass_time) -> Integrator:
    """RK4 that waits for so many seconds, by the turned clock, in each solution."""
    return from_solve(Waits(seconds, wait), name=f"RK4 after {seconds:g} s", order=4, sweep=Steps(0.25, 4))


def with_differences(method: Integrator) -> Integrator:
    """The method, declared to take its Jacobian from differences."""
    method.jacobian = "differences"
    return method


undeclared_ros2 = from_step(ros2, name="ROS2", order=2)
right_ros2 = with_differences(from_step(ros2, name="ROS2", order=2))
right_midpoint = from_step(
    midpoint, name="midpoint", order=2, sweep=Steps(4.0, 9), conserves=("symplectic", "reversible")
)
