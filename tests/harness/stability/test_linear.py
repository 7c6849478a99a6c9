"""Linear stability as measured agrees with theory, for tongues, both axes and large z; planted faults move it."""

import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import mpmath
import numpy as np
import planted_methods
import pytest
from command_line import numbers_in
from gnomon.harness.contract.integrator import Steps
from gnomon.harness.integrators.geometric.splitting import Composition, Splitting, StormerVerlet
from gnomon.harness.registry import lookup
from gnomon.harness.stability.linear import first_limit, linear, scan
from gnomon.harness.stability.linear_problems import problem_for
from gnomon.harness.stability.step_matrix import StepMatrix, stable_intervals
from gnomon.harness.verification.function_adapter import from_solve, from_step
from right_methods import verlet
from scipy.optimize import brentq

SECONDS = 2.0
COMPOSITIONS = {"Volume-preserving 4": "Suzuki 4", "RATTLE Suzuki 4": "Suzuki 4", "Volume-preserving 6": "Kahan-Li 6",
                "RATTLE Kahan-Li 6": "Kahan-Li 6", "RATTLE": "Störmer-Verlet", "Boris": "Störmer-Verlet",
                "Higuera-Cary": "Störmer-Verlet"}  # fmt: skip
"""Where only the vibration of a spring acts, these methods are compositions of Störmer-Verlet."""
SPLITTINGS = [one.name for one in lookup.own().values() if isinstance(one, Splitting)]
RUNGE_KUTTA = {"Explicit Euler": 1, "Explicit midpoint": 2, "Heun": 2, "RK3": 3, "RK4": 4, "Exponential Runge-Kutta 4": 4,
               "Explicit Euler [events]": 1, "RK4 [events]": 4}  # fmt: skip
"""Order = number of stages: R is the exponential series up to it (Hairer and Wanner, IV.2)."""
GAUSS = [("Implicit midpoint", 1), *((f"Gauss {stages}-stage", stages) for stages in range(2, 9))]


def measured(identity: str, seconds: float = SECONDS) -> dict[str, Any]:
    found = linear.measured(lookup.own()[identity], seconds)
    assert "refused" not in found, found
    return found


def series_limit(order: int, direction: complex) -> float:
    """The first x > 0 at which |1 + z + ... + z^order / order!| - 1 changes its sign from below 0, z = direction x."""
    z = [(direction**k) / math.factorial(k) for k in range(order + 1)]

    def excess(x: float) -> float:
        return abs(sum(term * x**k for k, term in enumerate(z))) - 1

    x = np.arange(0.01, 4, 0.01)
    above = [k for k in range(len(x) - 1) if excess(x[k]) < 0 <= excess(x[k + 1])]
    return brentq(excess, x[above[0]], x[above[0] + 1]) if excess(x[0]) < 0 else 0.0


@cache
def splitting_intervals(method: type[Splitting], to: float = 12.0) -> list[tuple[float, float]]:
    """Where |tr M| <= 2 for the product M of kicks and drifts: roots on a grid a hundred times as fine as the panel's."""
    kicks, drifts = (np.array([float(value) for value in row]) for row in method.coefficients(mpmath.mp))

    def excess(x: Any) -> Any:
        """|tr M| - 2 for frequencies x (n,)."""
        found = np.tile(np.eye(2), (len(x), 1, 1))
        for kick, drift in zip(kicks, drifts, strict=True):
            found[:, 1] -= (kick * x)[:, None] * found[:, 0]
            found[:, 0] += (drift * x)[:, None] * found[:, 1]
        return np.abs(found[:, 0, 0] + found[:, 1, 1]) - 2

    x = np.arange(0.00013, to, 0.0002)
    inside = excess(x) < 0
    edges = [0.0] if inside[0] else []
    edges += x[np.flatnonzero(inside[1:] != inside[:-1])].tolist()
    return list(zip(edges[::2], edges[1::2], strict=True))


def merged(intervals: Sequence[Sequence[float]], width: float) -> list[list[float]]:
    """Intervals of at least this width, after closer neighbours were joined: a scan may miss narrower ones."""
    found: list[list[float]] = []
    for low, high in intervals:
        if found and low - found[-1][1] < width:
            found[-1][1] = high
        else:
            found.append([low, high])
    return [ends for ends in found if ends[1] - ends[0] > width]


@pytest.mark.parametrize("name", RUNGE_KUTTA)
def test_explicit_runge_kutta_methods_have_the_limits_of_the_exponential_series(name: str) -> None:
    found = measured(f"gnomon:{name}")
    for axis, direction in (("imaginary", 1j), ("negative_real", -1.0)):
        expected = series_limit(RUNGE_KUTTA[name], direction)
        assert first_limit(found[axis]) == pytest.approx(expected, rel=1e-3)
        assert len(found[axis]["stable"]) == (expected > 0)
    assert not found["a_stable"]


@pytest.mark.parametrize("name", [*SPLITTINGS, *COMPOSITIONS])
def test_splitting_methods_have_all_intervals_of_the_trace_of_their_product(name: str) -> None:
    """Tongues too: of intervals and gaps of theory those wider than the scan are found, and no others."""
    method = type(lookup.own()[f"gnomon:{COMPOSITIONS.get(name, name)}"])
    assert issubclass(method, Splitting)
    found = measured(f"gnomon:{name}")["imaginary"]
    assert merged(found["stable"], found["scan_step"]) == [
        pytest.approx(ends, rel=1e-3) for ends in merged(splitting_intervals(method), found["scan_step"])
    ]


@pytest.mark.parametrize(
    ("name", "stages"), [pytest.param(*each, marks=[pytest.mark.slow] * (each[1] in (5, 6, 7))) for each in GAUSS]
)
def test_gauss_methods_are_a_stable_and_not_l_stable(name: str, stages: int) -> None:
    """R is the diagonal Padé approximation: |R| = 1 on the imaginary axis, and 1 - 2 s (s + 1)/|z| + ... at large -z."""
    found = measured(f"gnomon:{name}", SECONDS / 8)
    assert found["a_stable"]
    assert not found["l_stable"]
    assert 1 - found["at_minus_1e6"] == pytest.approx(2e-6 * stages * (stages + 1), rel=1e-2)


def stormer_limit(order: int) -> float:
    """The limit of Störmer's explicit method with `order` accelerations on the vibration: the first hw at which a root of
    its characteristic polynomial leaves the unit circle. Its weights of backward differences are the series of
    (t / log(1 - t))^2 / (1 - t) (Hairer, Nørsett, Wanner, III.10)."""
    log = [mpmath.mpf(1) / (k + 1) for k in range(order + 1)]  # -log(1 - t)/t
    inverse = [mpmath.mpf(1)]
    for n in range(1, order + 1):
        inverse.append(-sum(log[k] * inverse[n - k] for k in range(1, n + 1)))
    square = [sum(inverse[k] * inverse[n - k] for k in range(n + 1)) for n in range(order + 1)]
    sigma = [sum(square[: n + 1]) for n in range(order + 1)]
    weights = [sum(sigma[j] * mpmath.binomial(j, i) * (-1) ** i for j in range(i, order)) for i in range(order)]

    def grows(x: float) -> bool:
        polynomial = [1.0, -2.0, 1.0] + [0.0] * (order - 2)
        for i, weight in enumerate(weights):
            polynomial[i + 1] += x * x * float(weight)
        return bool(np.max(np.abs(np.roots(polynomial))) > 1 + 1e-6)

    low, high = 0.01, 1.5
    for _ in range(40):
        middle = (low + high) / 2
        low, high = (low, middle) if grows(middle) else (middle, high)
    return low


@pytest.mark.parametrize("order", [8, 12])
def test_multistep_methods_have_the_limit_of_their_characteristic_roots(order: int) -> None:
    """Within 2 %: just above the limit 65536 steps do not let round-off grow to the size of the motion."""
    found = measured(f"gnomon:Störmer {order}")
    assert found["multistep"]
    assert first_limit(found["imaginary"]) == pytest.approx(stormer_limit(order), rel=0.02)


def test_the_leapfrog_of_rebound_is_measured_on_an_exactly_linear_motion() -> None:
    pytest.importorskip("rebound")
    assert first_limit(measured("rebound:leapfrog")["imaginary"]) == pytest.approx(2.0, rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("policy", ["configured", "staggered"])
def test_a_physics_engine_is_measured_on_a_mass_on_a_spring(policy: str) -> None:
    """Its step is symplectic Euler, and a staggered start makes it the leapfrog: limit 2 both."""
    pytest.importorskip("pybullet")
    found = measured(f"pybullet:stepSimulation [{policy}]", SECONDS / 40)
    assert first_limit(found["imaginary"]) == pytest.approx(2.0, rel=1e-3)


@pytest.mark.parametrize(("name", "growth"), [("Blanes-Moan 4", 0.00239), ("Blanes-Moan 6", 0.000444)])
def test_a_tongue_narrower_than_the_scan_is_found_with_its_growth(name: str, growth: float) -> None:
    """Near hw = pi the trace passes -2 by so little that only a refined scan finds it: with |tr M|/2 = 1 + e a motion
    grows by sqrt(2 e) a step, where e is 2.85e-6 and 9.86e-8 by the product of kicks and drifts."""
    method = type(lookup.own()[f"gnomon:{name}"])
    assert issubclass(method, Splitting)
    (_, low), (high, _) = splitting_intervals(method)[:2]
    assert high - low < 0.02
    found = measured(f"gnomon:{name}")["imaginary"]
    edges = [found["stable"][0][1], found["stable"][1][0]]
    assert edges == [pytest.approx(low, abs=3e-4), pytest.approx(high, abs=3e-4)]
    assert found["gaps"][0] == pytest.approx(growth, rel=0.02)


def test_an_engine_whose_steps_have_no_matrix_is_refused() -> None:
    """WHFast moves each planet on a Kepler orbit about one centre: for two equal ones its step is not linear."""
    pytest.importorskip("rebound")
    assert "no step matrix" in linear.measured(lookup.own()["rebound:WHFast"], SECONDS)["refused"]


def test_an_interval_between_two_points_of_a_scan_is_not_found_and_edges_are_bisected() -> None:
    def stable(x: Any) -> Any:
        return (x < 0.345678) | ((x > 0.52) & (x < 0.58)) | (x > 0.7123)

    assert stable_intervals(stable, np.arange(0.1, 1.05, 0.1), 30) == [
        (0.0, pytest.approx(0.345678, abs=1e-9)), (pytest.approx(0.7123, abs=1e-9), pytest.approx(1.0))
    ]  # fmt: skip


def test_sentences_name_the_limit_and_the_tongue() -> None:
    first, second, *_, last = linear.sentences(measured("gnomon:Kahan-Li 8"))
    assert [numbers_in(text) for text in (first, second, last)] == [["3.096"], ["3.096", "3.14", "2.3"], ["5.849"]]
    assert [text.split()[0] for text in (first, second, last)] == ["Use", "Not", "Not"]
    assert linear.sentences(measured("gnomon:Heun"))[0].startswith("Not")
    assert linear.sentences(measured("gnomon:Gauss 2-stage"))[0].startswith("Use")


def damped(f: Any, t: float, y: Any, h: float) -> Any:
    """Störmer-Verlet that loses a ten-thousandth of its velocity a step."""
    found = verlet(f, t, y, h)
    found[len(y) // 2 :] *= 1 - 1e-4
    return found


def midpoint(iterations: int) -> Callable[..., Any]:
    """Implicit midpoint by fixed-point iterations: few of them make it an explicit method."""

    def step(f: Any, t: float, y: Any, h: float) -> Any:
        middle = y
        for _ in range(iterations):
            middle = y + h / 2 * f(t + h / 2, middle)
        return y + h * f(t + h / 2, middle)

    return step


def adams(f: Any, t0: float, y0: Any, times: Any, h: float) -> Any:
    """Adams-Bashforth 2 with a first step of Heun's."""
    y, found, before, t, each = y0, [], None, t0, round((times[0] - t0) / h)
    for k in range(each * len(times)):
        slope = f(t, y)
        y = y + h / 2 * (slope + f(t + h, y + h * slope)) if before is None else y + h / 2 * (3 * slope - before)
        before, t = slope, t + h
        if (k + 1) % each == 0:
            found.append(y)
    return np.array(found)


def on_axes(integrator: Any) -> list[float]:
    """The limits on the imaginary and, for first-order equations, on the negative real axis, by the finest scan."""
    problem = problem_for(integrator)
    assert problem is not None
    step = StepMatrix(integrator, problem)
    rays = (1j, -1.0) if problem.plane else (1j,)
    return [first_limit(scan(step, ray, cost=0.0, seconds=1.0)) for ray in rays]


def test_right_methods_of_users_have_the_limits_of_theory() -> None:
    assert on_axes(planted_methods.rk4()) == [pytest.approx(math.sqrt(8), rel=1e-3), pytest.approx(2.78529, rel=1e-3)]
    assert on_axes(planted_methods.verlet()) == [pytest.approx(2.0, rel=1e-6)]


@pytest.mark.parametrize("fault", ["coefficient_5", "sign", "aliased", "order_of_stages"])
def test_faults_of_runge_kutta_move_a_limit(fault: str) -> None:
    """A thousandth of the limit: a weight wrong by 1e-5 makes every step on the imaginary axis grow, or damp too much."""
    imaginary, real = on_axes(planted_methods.rk4(fault))
    assert abs(imaginary / math.sqrt(8) - 1) > 1e-3 or abs(real / 2.78529 - 1) > 1e-3


@pytest.mark.parametrize("fault", ["coefficient_5", "sign", "missing_half"])
def test_faults_of_verlet_move_its_limit(fault: str) -> None:
    """Edges are bisected to 1e-6 and better, so a weight that is wrong by 5e-6 shows too."""
    assert abs(on_axes(planted_methods.verlet(fault))[0] / 2 - 1) > 1e-6


def test_an_implicit_method_with_too_few_iterations_is_not_a_stable() -> None:
    found = linear.measured(from_step(midpoint(3), name="midpoint of three iterations", order=2), SECONDS / 8)
    assert not found["a_stable"]
    assert first_limit(found["negative_real"]) < 5


def test_a_multistep_method_is_not_measured_by_its_starting_method() -> None:
    """Adams-Bashforth 2 is stable on the negative real axis down to -1, Heun's method to -2."""
    method = from_solve(adams, name="Adams 2", order=2, sweep=Steps(0.25, 8))
    found = linear.measured(method, SECONDS / 20)
    assert found["multistep"]
    assert first_limit(found["negative_real"]) == pytest.approx(1.0, rel=0.02)


def test_the_matrix_of_a_step_is_that_of_theory_on_the_whole_plane() -> None:
    """R(z) of RK4 to 1e-13 of its terms, from both columns of the matrix."""
    method = lookup.own()["gnomon:RK4"]
    problem = problem_for(method)
    assert problem is not None
    z = np.array([x + 1j * y for x in (-6.0, -1.0, 2.0) for y in (0.0, 0.5, 6.0)])
    matrices = StepMatrix(method, problem).matrices(z)
    expected = sum(z**k / math.factorial(k) for k in range(5))
    size = sum(np.abs(z) ** k / math.factorial(k) for k in range(5))
    assert np.all(np.abs(matrices[:, 0, 0] + 1j * matrices[:, 1, 0] - expected) < 1e-13 * size)
    assert np.all(np.abs(matrices[:, 1, 1] - 1j * matrices[:, 0, 1] - expected) < 1e-13 * size)


def test_the_table_of_theory_has_at_least_25_methods() -> None:
    assert len({*RUNGE_KUTTA, *SPLITTINGS, *COMPOSITIONS, *(name for name, _ in GAUSS)}) + 3 >= 25
    assert issubclass(StormerVerlet, Composition)
