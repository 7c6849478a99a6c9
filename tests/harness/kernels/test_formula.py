"""Equations for a reader's eyes have the values of the case's functions, and nothing that one would not write."""

import math
import re
from typing import Any

import pytest
from case_equations import EVERY
from gnomon.harness.kernels.equation_text import EquationText, equation_text
from gnomon.harness.kernels.formula import plain


def value(formula: str, scope: dict[str, Any]) -> float:
    """A formula by the rules of notation: juxtaposed factors are a product, from left to right."""
    python = re.sub(r"(?<=[\w)]) (?=[\w(])", "*", formula).replace("^", "**")
    return float(eval(python, {"__builtins__": {}}, scope))


def derivatives(lines: list[str], scope: dict[str, Any]) -> list[float]:
    scope = {name: getattr(math, name) for name in dir(math) if name != "e"} | scope
    named = [line.strip().removeprefix("with ").split(" = ") for line in lines if line.startswith("  with ")]
    for name, formula in named:
        assert name not in scope
        scope[name] = value(formula, scope)
    return [value(line.split(" = ")[1], scope) for line in lines if not line.startswith("  with ")]


@pytest.mark.parametrize("name", EVERY)
def test_formulas_and_functions_give_the_same_derivatives(name: str) -> None:
    equations = EVERY[name]
    coordinates = [x.name for x in equations.case.state]
    parameters = [x.name for x in equations.case.parameter_list] + [f"k_{i}" for i in range(len(equations.constants))]
    t, state, numbers = equations.at_random(5)
    lines = list(plain(equation_text(equations.form, coordinates, parameters), [f"{x}' =" for x in coordinates]))
    found = derivatives(lines, dict(zip(["t", *coordinates, *parameters], [t, *state, *numbers], strict=True)))
    wanted = [float(x) for x in equations.form.equations(t, tuple(state), tuple(numbers))]
    assert found == pytest.approx(wanted, rel=1e-12, abs=1e-12 * max(map(abs, wanted)))
    text = "\n".join(lines)
    assert not re.search(r"(?<![\w.])1(\.0)? (?=[\w(])|\*|\.0\b|--|\+ -|\b(\w+) \2\b", text), "what one would not write"


@pytest.mark.parametrize(
    ("expression", "wanted"),
    [
        ("x * x", "x^2"),
        ("pow(x, 2.0)", "x^2"),
        ("1.0 * x", "x"),
        ("-(a - b)", "b - a"),
        ("a - (b - c)", "a - b + c"),
        ("-(g / L) * sin(x)", "-g/L sin(x)"),
        ("x / (2.0 * a)", "x/(2 a)"),
        ("x * 0.5 * 9.81", "4.905 x"),
        ("a * sqrt(a)", "a^(3/2)"),
        ("sqrt(x * x)", "sqrt(x^2)"),  # not x, which may be negative
        ("b / (a * sqrt(a))", "b/a^(3/2)"),
        ("sin(x) * (a - b)", "(a - b) sin(x)"),
        ("4 * atan(1.0) * x", "pi x"),
        ("pow(a, b) * pow(a, 2)", "a^(b + 2)"),
        ("0 * x", "0"),
    ],
)
def test_an_expression_is_written_as_one_writes_it(expression: str, wanted: str) -> None:
    (line,) = plain(EquationText((), (expression,)), ["y ="])
    assert line == f"y = {wanted}"
