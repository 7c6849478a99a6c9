"""The equations of every case compile, and the compiled ones give the numbers of Python.

The exact motion calls the equations in Python, where lists and itertools work: without these tests, equations that no
compiled integrator can run would pass all others.
"""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest
from gnomon.cases import Case
from gnomon.cases.core import forms
from gnomon.harness.kernels import equations

from gnomon import cases


def functions(case: Case) -> Iterator[tuple[Callable[..., Any], tuple[float, ...], tuple[float, ...]]]:
    """The functions (t, state, parameters) that integrators compile, each with a state and parameters."""
    state, parameters = (tuple(map(float, values)) for values in (case.initial_state, case.parameter_values()))
    for form in case.all_forms():
        first = forms.first_order(form)
        if first is not None:
            yield first.equations, state, parameters
        if isinstance(form, forms.Constrained):
            place = state[: len(state) // 2]
            for function in (form.constraint, form.gradient, form.mass, form.constraint_rate):
                if function is not None:
                    yield function, place, parameters
        if isinstance(form, forms.Hybrid):
            for mode in form.modes:
                yield mode.equations, state, (*parameters, *mode.constants)
            for transition in form.transitions:
                yield transition.guard, state, parameters


@pytest.mark.parametrize("name", cases.names())
def test_the_compiled_equations_give_the_numbers_of_python(name: str) -> None:
    compiled = 0
    for function, state, parameters in functions(cases.get(name)):
        expected = np.array(function(0.0, state, parameters), dtype=float)
        kernel = equations.function_kernel(function, len(state), len(parameters), expected.size)
        found = kernel.array(0.0, np.array(state), np.array(parameters))
        # Compiled code may fuse a product and a sum: a few roundings of the largest term, which sums may cancel.
        assert found == pytest.approx(expected, rel=1e-12, abs=1e-12 * np.abs(expected).max(initial=0.0), nan_ok=True)
        compiled += 1
    assert compiled, "no function of this case was compiled"
