"""Elimination in equations: systems, and the multipliers of constraints."""

import random

import numpy as np
import pytest
from constrained_forms import FORMS, check_parts
from gnomon.cases import get, names
from gnomon.cases.core.elimination import multipliers, rows_of, solve_linear
from gnomon.cases.core.forms import Constrained
from gnomon.harness.kernels.equations import function_kernel
from gnomon.reference.numerics.precision import working

OF_CASES = {
    f"{name} {kind}": (form, len(get(name).parameter_list))
    for name in names()
    for kind, forms in [("", get(name).forms), *((each.name, each.forms) for each in get(name).formulations)]
    for form in forms
    if isinstance(form, Constrained)
}


@pytest.mark.parametrize("size", [1, 2, 5])
def test_a_symmetric_definite_system_is_solved_to_all_digits(size: int) -> None:
    source = random.Random(size)
    with working(60) as mp:
        half = mp.matrix(size, size)
        for i in range(size):
            for j in range(size):
                half[i, j] = mp.mpf(source.uniform(-1, 1))
        whole = half * half.T + mp.eye(size)
        expected = [mp.mpf(source.uniform(-1, 1)) for _ in range(size)]
        right = whole * mp.matrix(expected)
        found = solve_linear([tuple(whole[i, :]) for i in range(size)], tuple(right))
        assert max(abs(a - b) for a, b in zip(found, expected, strict=True)) < 1e-55


def test_plain_integers_are_divided_in_the_arithmetic_of_one() -> None:
    with working(60) as mp:
        (third,) = solve_linear(((3,),), (1,), mp.mpf(1))
        assert abs(3 * third - 1) < 1e-58


@pytest.mark.parametrize("name", FORMS)
def test_the_equations_of_index_1_are_what_the_parts_imply(name: str) -> None:
    check_parts(FORMS[name], 6, 4, name)


@pytest.mark.parametrize("name", OF_CASES)
def test_parts_of_the_constrained_forms_of_cases(name: str) -> None:
    form, count = OF_CASES[name]
    width = next(n for n in range(1, 100) if accepts(form, n, count))
    check_parts(form, width, count, name)


def accepts(form: Constrained, n: int, count: int) -> bool:
    """Whether a form has n coordinates."""
    try:
        return len(form.force(0.0, (0.5,) * n, (1.0,) * count)) == n
    except (ValueError, IndexError):
        return False


@pytest.mark.parametrize("name", FORMS)
def test_multipliers_balance_the_forces_and_compile(name: str) -> None:
    """M q'' + G^T lam is the sum of the other forces; compiled and plain values agree to round-off."""
    form, source = FORMS[name], np.random.default_rng(1)
    t, y, p = 0.25, source.uniform(-1, 1, 12), source.uniform(1, 2, 4)
    state, numbers = tuple(y.tolist()), tuple(p.tolist())
    function = multipliers(form)
    lam = np.array(function(t, state, numbers))
    assert function_kernel(function, 12, 4, 3).array(t, y, p) == pytest.approx(lam, rel=1e-12)
    accelerations = form.equations(t, state, numbers)[6:]
    assert function_kernel(form.equations, 12, 4, 12).array(t, y, p)[6:] == pytest.approx(accelerations, rel=1e-12)
    forces = np.array(form.force(t, state[:6], numbers), dtype=float)
    if form.velocity_force is not None:
        forces += form.velocity_force(t, state, numbers)
    inertia = np.array(rows_of(form.mass(t, state[:6], numbers), 6)) if form.mass else np.eye(6)
    pulled = inertia @ accelerations + np.array(rows_of(form.gradient(t, state[:6], numbers), 6)).T @ lam
    assert pulled == pytest.approx(forces, rel=1e-10, abs=1e-10)
