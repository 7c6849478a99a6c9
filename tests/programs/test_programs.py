"""The programs that drive GSL and odeint solve the equations of the cases, and what is published of them can be repeated."""

import ctypes
import math
import os
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import measure_programs as measure
import numpy as np
import pytest
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.adapters.absent import ABSENT, Series, measured
from gnomon.harness.measuring.score import Scorer
from gnomon.harness.verification.program_adapter import from_command

from gnomon import cases

HERE = Path(__file__).parent
NAMES = sorted({name.partition("/")[0] for name in measure.CASES})
Doubles = np.ndarray[Any, np.dtype[np.float64]]
FUNCTIONS = """
#include "five_cases.h"
void slopes(const char *name, double t, const double *y, const double *p, double *dy) {
    find_case(name)->slopes(t, y, p, dy);
}
void jacobian(const char *name, double t, const double *y, const double *p, double *J, double *dt) {
    find_case(name)->jacobian(t, y, p, J, dt);
}
const char *parameter(const char *name, int k) { return find_case(name)->parameters[k]; }
"""


@pytest.fixture(scope="module")
def five_cases(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("needs a C compiler called cc")
    library = tmp_path_factory.mktemp("five_cases") / "five_cases.so"
    subprocess.run(
        [compiler, "-shared", "-fPIC", f"-I{HERE}", "-o", library, "-x", "c", "-", "-lm"],
        input=FUNCTIONS, text=True, check=True,
    )  # fmt: skip
    found = ctypes.CDLL(str(library))
    found.parameter.restype = ctypes.c_char_p
    return found


def called(function: Any, name: str, t: float, *arrays: Doubles) -> None:
    pointers = [array.ctypes.data_as(ctypes.c_void_p) for array in arrays]
    function(name.encode(), ctypes.c_double(t), *pointers)


def differences(f: Callable[[float, Doubles], Doubles], t: float, y: Doubles, unit: Doubles) -> Doubles:
    """The derivative of f(t, y) along a unit vector of (y, t), to some nine digits."""

    def at(x: float) -> Doubles:
        return f(t + x * unit[-1], y + x * unit[:-1])

    h = 1e-3
    return (8 * (at(h) - at(-h)) - (at(2 * h) - at(-2 * h))) / (12 * h)


@pytest.mark.parametrize("name", NAMES)
def test_the_programs_have_the_equations_of_the_case_and_their_jacobian(five_cases: ctypes.CDLL, name: str) -> None:
    """A wrong Jacobian would still let implicit methods converge, only more slowly: it would look like a slow library."""
    scorer = Scorer.of(cases.get(name).rounded())
    form = next(form for form in scorer.case.all_forms() if isinstance(form, FirstOrder))
    given = [five_cases.parameter(name.encode(), k) for k in range(len(scorer.parameters))]
    assert [text.decode() for text in given] == [one.name for one in scorer.case.parameter_list]
    p, n, draw = np.array(scorer.parameters), len(scorer.case.state), np.random.default_rng(41)
    for _ in range(20):
        t, y = draw.uniform(0, 5), draw.uniform(0.5, 1.5, n) * draw.choice([-1, 1], n)

        def slopes(t: float, y: Doubles) -> Doubles:
            found = np.empty(n)
            called(five_cases.slopes, name, t, y, p, found)
            return found

        own = np.array(form.equations(t, tuple(y), tuple(p.tolist())))
        assert np.allclose(slopes(t, y), own, rtol=1e-14, atol=1e-14)
        J, dt = np.zeros((n, n)), np.zeros(n)
        called(five_cases.jacobian, name, t, y, p, J, dt)
        wanted = [differences(slopes, t, y, unit) for unit in np.eye(n + 1)]
        assert np.allclose([*J.T, dt], wanted, rtol=1e-7, atol=1e-7)


@pytest.fixture(scope="module", params=[*measure.PROGRAMS])
def program(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> str:
    lacking = measure.missing(request.param)
    if lacking:
        pytest.skip(f"needs {lacking}")
    return str(measure.build(request.param, tmp_path_factory.mktemp("programs")))


@pytest.mark.skipif(os.name != "posix", reason="programs are processes that need POSIX")
def test_what_is_published_of_a_program_is_what_it_gives(program: str) -> None:
    """On the pendulum, at two tolerances: the errors within a factor of 1.5 and the counts within 2 %, as libraries and
    compilers of other versions round differently. A program that is changed must be measured again."""
    scorer = Scorer.of(cases.get("pendulum_simple").rounded())
    name = Path(program).name
    for method in measure.METHODS[name][:2]:
        integrator = from_command([program, method], seconds=20.0)
        series = published("pendulum_simple", integrator.id)
        for tolerance in (1e-6, 1e-10):
            at = series.setting.index(tolerance)
            form = next(form for form in scorer.case.all_forms() if isinstance(form, FirstOrder))
            problem = scorer.problem(form, counted=True)
            states = integrator.prepare(problem, tolerance)(scorer.reference.start[None]).states
            assert abs(math.log(scorer.largest_error(states[0]) / series.error[at])) < math.log(1.5)
            assert abs(problem.buffer[-1] / series.rhs_calls[at] - 1) < 0.02


def published(case: str, integrator: str) -> Series:
    (found,) = (one for one in measured().series if (one.case, one.integrator) == (case, integrator))
    return found


def test_every_method_was_measured_on_every_case_and_follows_its_tolerance() -> None:
    """A method that never reaches 1e-6 would be driven wrongly; a stiff variant may be beyond explicit methods, and one
    method of odeint has a fault of its own, which the page names."""
    ids = {f"command:{library} {method}" for name, library in (("gsl", "GSL"), ("odeint", "odeint"))
           for method in measure.METHODS[name]}  # fmt: skip
    assert {(one.case, one.integrator) for one in measured().series} == {
        (case, name) for case in measure.CASES for name in ids | {*measure.COMPARED}
    }
    for one in measured().series:
        faulty = one.integrator == "command:odeint rosenbrock4" and one.case == "forced_oscillator"
        if "stiff" not in one.case and not faulty:
            assert one.least_error < 1e-6, (one.case, one.integrator)


@pytest.mark.skipif(measure.missing("odeint") is not None, reason="needs c++ and the headers of Boost")
def test_the_fault_of_rosenbrock4_is_the_one_that_the_page_names(tmp_path: Path) -> None:
    """With the coefficient of RODAS its order is 4 on an equation that depends on time too. If a newer Boost has that
    coefficient, `make other-languages` and the sentence on the page are due."""
    program = tmp_path / "order"
    subprocess.run(["c++", "-O1", "-o", program, HERE / "rosenbrock_order.cpp"], check=True)
    told = subprocess.run([program], capture_output=True, text=True, check=True).stdout
    forced, free, mended = map(float, told.split())
    assert free > 3.7
    assert mended > 3.7
    assert forced < 1.5


def test_each_absent_integrator_is_named_once_with_a_reason() -> None:
    titles = [one.title for one in ABSENT]
    assert len({*titles}) == len(titles)
    assert all(one.reason.endswith(".") for one in ABSENT)
