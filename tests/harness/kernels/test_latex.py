"""Equations in LaTeX, read back by the rules of notation, have the same values as the functions of the case."""

import math
import re
from collections.abc import Mapping
from typing import Any

import pytest
from case_equations import EVERY
from gnomon.harness.kernels.equation_text import EquationText, equation_text
from gnomon.harness.kernels.latex import dot_name, latex, symbol

FUNCTIONS = {rf"\{name}": getattr(math, name) for name in ("sin", "cos", "tan", "sinh", "cosh", "tanh", "exp")}
FUNCTIONS |= {r"\arcsin": math.asin, r"\arccos": math.acos, r"\arctan": math.atan, r"\ln": math.log}
FUNCTIONS |= {
    rf"\operatorname{{{name}}}": getattr(math, name) for name in ("asinh", "acosh", "atanh", "atan2", "hypot")
}


class Reader:
    """Evaluates LaTeX: a product is written side by side or with \\cdot, and binds more tightly than a sum."""

    def __init__(self, text: str, values: Mapping[str, float]) -> None:
        self.values = values
        words = sorted([*values, *FUNCTIONS], key=len, reverse=True)
        other = [r"\\frac", r"\\sqrt", r"\\cdot", r"(?<=\^)[0-9]", r"[0-9.]+", r"[-+^{},()/]"]
        pattern = "|".join([*map(re.escape, words), *other])
        text = text.replace(r"\left", "").replace(r"\right", "").replace(r"\,", "")
        self.tokens = re.findall(pattern, text)
        assert "".join(self.tokens) == text.replace(" ", ""), "every character has a meaning"

    def take(self, *wanted: str) -> bool:
        found = bool(self.tokens) and self.tokens[0] in wanted
        if found:
            self.tokens.pop(0)
        return found

    def sum(self) -> float:
        total = -self.product() if self.take("-") else self.product()
        while self.tokens and self.tokens[0] in "+-":
            total = total + self.product() if self.take("+") else total - (self.take("-") and self.product())
        return total

    def product(self) -> float:
        value = self.factor()
        while self.take(r"\cdot") or (self.tokens and self.tokens[0] not in ("+", "-", "}", ",", ")", "/")):
            value *= self.factor()
        while self.take("/"):
            value /= self.factor()
        return value

    def factor(self) -> float:
        base = self.atom()
        return base ** self.atom() if self.take("^") else base

    def braced(self) -> float:
        assert self.take("{")
        value = self.sum()
        assert self.take("}")
        return value

    def arguments(self) -> list[float]:
        found = [self.sum()]
        while self.take(","):
            found.append(self.sum())
        assert self.take(")")
        return found

    def atom(self) -> float:
        if self.tokens[0] == "{":
            return self.braced()
        token = self.tokens.pop(0)
        if token == r"\frac":
            return self.braced() / self.braced()
        if token == r"\sqrt":
            return math.sqrt(self.braced())
        if token in FUNCTIONS:
            power = self.atom() if self.take("^") else 1  # the power of a function's value stands behind its name
            arguments = self.arguments() if self.take("(") else [self.atom()]
            return float(FUNCTIONS[token](*arguments)) ** power
        if token == "(":
            (value,) = self.arguments()
            return value
        return self.values[token] if token in self.values else float(token)


def read(text: str, values: dict[str, float], states: list[str]) -> list[float]:
    """The derivatives of the states."""
    begin, *lines, end = text.split("\n")
    assert (begin, end) == (r"\begin{aligned}", r"\end{aligned}")
    for line in lines:
        name, _, expression = line.removesuffix(r" \\").partition(" &= ")
        reader = Reader(expression, values)
        values = values | {name: reader.sum()}
        assert not reader.tokens
    return [values[dot_name(state)] for state in states]


@pytest.mark.parametrize("name", EVERY)
def test_latex_and_functions_give_the_same_derivatives(name: str) -> None:
    equations = EVERY[name]
    coordinates = [x.name for x in equations.case.state]
    constants = [f"k_{i}" for i in range(len(equations.constants))]
    parameters = [*(x.name for x in equations.case.parameter_list), *constants]
    t, state, numbers = equations.at_random(3)
    symbols = [symbol(x) for x in ("t", *coordinates, *parameters)]
    assert len(set(symbols)) == len(symbols)
    values = dict(zip(symbols, [t, *state, *numbers], strict=True)) | {r"\pi": math.pi}
    text = latex(equation_text(equations.form, coordinates, parameters), coordinates)
    found = read(text, values, coordinates)
    wanted = [float(x) for x in equations.form.equations(t, tuple(state), tuple(numbers))]
    # The same operations, most of them in another sequence.
    assert found == pytest.approx(wanted, rel=1e-12, abs=1e-12 * max(map(abs, wanted)))


def test_parentheses_and_numbers() -> None:
    text = EquationText((), ("-(a - b) * c / (2 * (a + b)) - pow(a / b, 1e-05) * -b", "a - (b - sqrt(c)) - c"))
    values = {"a": 0.3, "b": 0.7, "c": 0.2}
    wanted: list[Any] = [eval(x, {"pow": pow, "sqrt": math.sqrt} | values) for x in text.derivatives]
    assert read(latex(text, ["x", "y"]), dict(values), ["x", "y"]) == pytest.approx(wanted, rel=1e-14)


def test_symbols_of_names() -> None:
    names = ("theta", "I1", "mu_k", "rate", "x", "omega2", "vx", "vx12", "phidot", "th1", "rho_air")
    assert [symbol(x) for x in names] == [
        r"\theta", "I_1", r"\mu_k", r"\mathrm{rate}", "x", r"\omega_2", "v_x", r"v_{\mathrm{x12}}", r"\dot\phi",
        r"\theta_1", r"\rho_{\mathrm{air}}",
    ]  # fmt: skip
    assert [dot_name(x) for x in ("theta", "x1", "phidot", "rate")] == [
        r"\dot\theta", r"\dot x_1", r"\ddot\phi", r"\dot{\mathrm{rate}}",
    ]  # fmt: skip
