"""Boris's method and related ones: order in uniform and other fields, speed, volume, reversal, the E x B drift."""

import random
from fractions import Fraction
from math import sqrt
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.cases.core.forms import Charged, Values
from gnomon.cases.core.registry import get
from gnomon.harness.contract.integrator import Problem
from gnomon.harness.integrators.base.fixed_step import FixedStep
from gnomon.harness.integrators.geometric import boris
from gnomon.harness.integrators.geometric.boris import Boris, HigueraCary
from gnomon.harness.results.convergence_order import fit_order
from gnomon.harness.studies.orders import measure_order, solve_exactly
from gnomon.reference.numerics import taylor
from gnomon.reference.numerics.precision import nearest_double, working
from on_cases import of_order

START = (1.0, 0.5, 0.25, 0.5, -0.25, 0.75)
TIMES = np.arange(1, 65) * 0.125
CASES = ("charge_in_E_and_B", "relativistic_charge")


def bottle(t: Any, place: Values, parameters: Values) -> Values:
    """A field B = (-x z, -y z, 2 + z^2)/2 without divergence, and a wave of E along x."""
    x, y, z = place
    return y / 4, x / 4, t / 8, -x * z / 2, -y * z / 2, 1 + z * z / 2


def bottle_equations(t: Any, state: Values, parameters: Values) -> Values:
    x, y, z, u1, u2, u3 = state
    a1, a2, a3, w1, w2, w3 = bottle(t, (x, y, z), parameters)
    return u1, u2, u3, a1 + u2 * w3 - u3 * w2, a2 + u3 * w1 - u1 * w3, a3 + u1 * w2 - u2 * w1


def relativistic_bottle_equations(t: Any, state: Values, parameters: Values) -> Values:
    x, y, z, u1, u2, u3 = state
    a1, a2, a3, w1, w2, w3 = bottle(t, (x, y, z), parameters)
    gamma = sqrt(1 + (u1 * u1 + u2 * u2 + u3 * u3) / 4)
    v1, v2, v3 = u1 / gamma, u2 / gamma, u3 / gamma
    return v1, v2, v3, a1 + v2 * w3 - v3 * w2, a2 + v3 * w1 - v1 * w3, a3 + v1 * w2 - v2 * w1


def slow_light(parameters: Values) -> Values:
    return (2,)


BOTTLE = Charged(bottle_equations, fields=bottle)
RELATIVISTIC = Charged(relativistic_bottle_equations, fields=bottle, light=slow_light)
PAIRS = [
    pytest.param(method, form, id=f"{method.name}-{name}")
    for method in boris.INTEGRATORS
    for name, form in (("slow", BOTTLE), ("relativistic", RELATIVISTIC))
    if method().unsupported(form) is None
]


def states(method: FixedStep, form: Charged, substeps: int, start: Any = START) -> Any:
    problem = Problem(form, 6, np.zeros(0), TIMES, 1.0)
    solution = method.prepare(problem, problem.interval / substeps)(np.array([start]))
    assert solution.stopped is None
    return solution.states[0]


@pytest.mark.parametrize("name", CASES)
def test_fields_and_equations_agree(name: str) -> None:
    """u' = a + v x w with v = u/gamma, at random states in sixty digits."""
    case, source = get(name), random.Random(name)
    (form,) = (form for form in case.forms if isinstance(form, Charged))
    with working(60) as mp:
        for _ in range(5):
            state = [mp.mpf(source.uniform(-3, 3)) for _ in range(6)]
            parameters = tuple(mp.mpf(source.uniform(1, 3)) for _ in case.parameter_list)
            ax, ay, az, wx, wy, wz = form.fields(mp.mpf(0), tuple(state[:3]), parameters)
            light = mp.inf if form.light is None else form.light(parameters)[0]
            gamma = mp.sqrt(1 + mp.fsum(u * u for u in state[3:]) / light**2)
            vx, vy, vz = (u / gamma for u in state[3:])
            wanted = (vx, vy, vz, ax + vy * wz - vz * wy, ay + vz * wx - vx * wz, az + vx * wy - vy * wx)
            found = rebind(form.equations, mpmath_arithmetic(mp))(mp.mpf(0), tuple(state), parameters)
            assert max(abs(a - b) for a, b in zip(found, wanted, strict=True)) < 1e-55


@pytest.mark.parametrize("method", boris.INTEGRATORS, ids=lambda method: method.name)
@pytest.mark.parametrize("name", CASES)
def test_order_in_uniform_fields(method: type[FixedStep], name: str) -> None:
    case = get(name, "oblique")
    if method().unsupported(case.forms[0]) is not None:
        return
    assert measure_order(method(), case, most_steps=6_000) == of_order(method.order)


@pytest.mark.parametrize(("method", "form"), PAIRS)
def test_order_in_a_magnetic_bottle(method: type[FixedStep], form: Charged) -> None:
    """The reference solution is the Taylor integration in balls, which shares nothing with the method."""
    found = taylor.integrate(
        lambda t, y: form.equations(t, y, ()) if form is BOTTLE else _in_balls(t, y),
        list(map(Fraction, START)),
        [Fraction(4)],
        20,
    )
    with working(30) as mp:
        exact = np.array([nearest_double(mp.mpf(x.numerator) / x.denominator) for x in found[0]])
    counts = [1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 64, 128, 256]
    errors = [float(np.max(np.abs(states(method(), form, n)[31] - exact))) for n in counts]
    # Sums are compensated: a few ulps of a state of size 2 are left.
    assert fit_order([0.125 / n for n in counts], errors, floor=4e-15) == of_order(method.order)


def _in_balls(t: Any, y: Values) -> Values:
    return rebind(relativistic_bottle_equations, {"sqrt": lambda x: x.sqrt()})(t, y, ())


def only_turning(t: Any, place: Values, parameters: Values) -> Values:
    x, y, z = place
    return 0 * x, 0 * x, 0 * x, -x * z / 2, -y * z / 2, 1 + z * z / 2


@pytest.mark.parametrize(
    "method", [m for m in boris.INTEGRATORS if m is not HigueraCary], ids=lambda method: method.name
)
def test_a_magnetic_field_leaves_the_speed_alone(method: type[FixedStep]) -> None:
    found = states(method(), Charged(bottle_equations, fields=only_turning), 1)
    speeds = np.linalg.norm(found[:, 3:], axis=1)
    # An ulp for each of at most nine turns a step, at random, summed with compensation.
    assert np.max(np.abs(speeds / np.linalg.norm(START[3:]) - 1)) < 64 * 9 * np.finfo(float).eps


@pytest.mark.parametrize(("method", "form"), PAIRS)
def test_volume_in_phase_space_is_preserved(method: type[FixedStep], form: Charged) -> None:
    """The Jacobian of a step, by central differences of 1e-20 in sixty digits, has determinant 1."""
    tiny = Fraction(1, 10**20)
    with working(60) as mp:
        columns = []
        for i in range(6):
            ends = [
                solve_exactly(
                    method(),
                    form,
                    (),
                    [Fraction(x) + s * tiny * (i == j) for j, x in enumerate(START)],
                    Fraction(1, 2),
                    1,
                )
                for s in (1, -1)
            ]
            columns.append([(a - b) * 10**20 / 2 for a, b in zip(*ends, strict=True)])
        assert abs(mp.det(mp.matrix(columns)) - 1) < 1e-35


def backwards(t: Any, place: Values, parameters: Values) -> Values:
    """The same fields with B reversed, as under time reversal; here at a fixed time."""
    ax, ay, az, wx, wy, wz = bottle(0, place, parameters)
    return ax, ay, az, -wx, -wy, -wz


def forwards(t: Any, place: Values, parameters: Values) -> Values:
    return bottle(0, place, parameters)


@pytest.mark.parametrize(("method", "form"), PAIRS)
def test_reversible(method: type[FixedStep], form: Charged) -> None:
    with working(60) as mp:
        there, back = (Charged(form.equations, fields=fields, light=form.light) for fields in (forwards, backwards))
        end = solve_exactly(method(), there, (), list(map(Fraction, START)), Fraction(3), 10)
        turned = [Fraction(str(x * s)) for x, s in zip(end, (1, 1, 1, -1, -1, -1), strict=True)]
        start = solve_exactly(method(), back, (), turned, Fraction(3), 10)
        wanted = [mp.mpf(x) * s for x, s in zip(START, (1, 1, 1, -1, -1, -1), strict=True)]
        assert max(abs(a - b) for a, b in zip(start, wanted, strict=True)) < 1e-50


def crossed(t: Any, place: Values, parameters: Values) -> Values:
    """E along x, B along z, v = E/B = 3/5 c along -y: no force."""
    x = place[0]
    return 3 + 0 * x, 0 * x, 0 * x, 0 * x, 0 * x, 5 + 0 * x


def unit_light(parameters: Values) -> Values:
    return (1,)


def test_higuera_and_cary_keep_the_drift_and_boris_does_not() -> None:
    form, start = Charged(bottle_equations, fields=crossed, light=unit_light), (0.0, 0.0, 0.0, 0.0, -0.75, 0.0)
    deviation = {m: np.max(np.abs(states(m(), form, 1, start)[:, 3:] - start[3:])) for m in (HigueraCary, Boris)}
    assert deviation[HigueraCary] < 1e-13, "64 steps of a few ulps"
    assert deviation[Boris] > 1e-3


def test_a_slow_charge_is_left_to_boris() -> None:
    assert HigueraCary().unsupported(BOTTLE) is not None
    assert HigueraCary().unsupported(RELATIVISTIC) is None
