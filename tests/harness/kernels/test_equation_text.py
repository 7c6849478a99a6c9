"""The equations of a case as text give the same derivatives as its functions, in names that other languages can read."""

import math
import re
from typing import Any

import pytest
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.kernels.equation_text import equation_text

from gnomon import cases

NAME = re.compile(r"[A-Za-z_][A-Za-z_0-9]*")


@pytest.mark.parametrize("name", cases.names())
def test_text_and_functions_give_the_same_derivatives(name: str) -> None:
    """Evaluated as Python. Sums and products keep their sequence: only a common factor that is taken out, or an inverse
    that is computed once, may round in another way, a few ulps of the largest derivative each."""
    case = cases.get(name)
    form = next((form for form in case.all_forms() if isinstance(form, FirstOrder)), None)
    if form is None:  # a motion with events has equations for each mode
        assert case.hybrid is not None
        return
    coordinates = [coordinate.name for coordinate in case.state]
    parameters = [parameter.name for parameter in case.parameter_list]
    state, values = (tuple(map(float, x)) for x in (case.initial_state, case.parameter_values()))
    text = equation_text(form, coordinates, parameters)
    scope: dict[str, Any] = {key: getattr(math, key) for key in dir(math) if key[0] != "_"}
    scope |= dict(zip([*coordinates, *parameters], [*state, *values], strict=True)) | {"t": 0.25}
    for line in text.where:
        defined, _, expression = line.partition(" = ")
        assert NAME.fullmatch(defined)
        assert defined not in scope
        scope[defined] = eval(expression, {}, scope)
    found = [eval(expression, {}, scope) for expression in text.derivatives]
    wanted = form.equations(0.25, state, values)
    size = max(map(abs, map(float, wanted)), default=0.0)
    assert found == pytest.approx([float(x) for x in wanted], rel=1e-13, abs=1e-13 * size)
    assert not re.search(r"\*\*|\[|\]", " ".join((*text.where, *text.derivatives)))


def test_parentheses_keep_the_sequence_of_operations() -> None:
    def equations(t: Any, y: Any, p: Any) -> Any:
        (x,), (a,) = y, p
        return (a - (x - t) - -x * (2 - x) / (a / (x * a)) + x**3 * -0.5,)

    text = equation_text(FirstOrder(equations), ["x"], ["a"])
    assert text.where == ()
    scope = {"x": 0.3, "a": 0.7, "t": 0.1, "pow": pow}
    assert eval(text.derivatives[0], scope) == equations(0.1, (0.3,), (0.7,))[0]
