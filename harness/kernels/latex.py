"""Convert equations of motion from plain text to LaTeX."""

import ast
import re
from collections.abc import Sequence

from gnomon.harness.kernels.equation_text import EquationText

GREEK = (
    r"(alpha|beta|gamma|delta|zeta|eta|theta|kappa|lambda|mu|nu|xi|pi|rho|sigma|tau|phi|chi|psi|omega|"
    r"Gamma|Delta|Theta|Lambda|Xi|Pi|Sigma|Phi|Psi|Omega)"
)
NAMES = {"asin": r"\arcsin", "acos": r"\arccos", "atan": r"\arctan", "log": r"\ln"}
NAMES |= {name: rf"\operatorname{{{name}}}" for name in ("asinh", "acosh", "atanh", "atan2", "hypot")}
SUM, PRODUCT, ATOM = 1, 2, 3
"""The precedence of the last operation of a text."""


def latex(text: EquationText, coordinates: Sequence[str]) -> str:
    """An `aligned` environment with the values that are used more than once, then the derivative of each coordinate."""
    lines = [(symbol(name), value) for name, value in (line.split(" = ") for line in text.where)]
    lines += [(rf"\dot{{{symbol(x)}}}", value) for x, value in zip(coordinates, text.derivatives, strict=True)]
    written = [f"{name} &= {expression(ast.parse(value, mode='eval').body)[0]}" for name, value in lines]
    return "\n".join([r"\begin{aligned}", " \\\\\n".join(written), r"\end{aligned}"])


def symbol(name: str) -> str:
    r"""The symbol of a name: theta is \theta, I1 is I_{1}, mu_k is \mu_{k}, rate is \mathrm{rate}."""
    letters, _, index = re.sub(r"(?<=[A-Za-z])(\d)", r"_\1", name, count=1).partition("_")
    base = rf"\{letters}" if re.fullmatch(GREEK, letters) else letters
    base = base if len(letters) == 1 or base != letters else rf"\mathrm{{{letters}}}"
    return f"{base}_{{{index}}}" if index else base


def expression(node: ast.expr) -> tuple[str, int]:
    """The LaTeX of a parsed expression, and the precedence of its last operation."""
    match node:
        case ast.Constant(value):
            digits, _, power = repr(value).removesuffix(".0").partition("e")
            return (rf"{digits} \cdot 10^{{{int(power)}}}", PRODUCT) if power else (digits, ATOM)
        case ast.Name(name):
            return symbol(name), ATOM
        case ast.UnaryOp(_, x):
            return f"-{within(x, PRODUCT)}", SUM
        case ast.BinOp(ast.UnaryOp(sign, x), ast.Mult() | ast.Div() as operation, y):
            return expression(ast.UnaryOp(sign, ast.BinOp(x, operation, y)))
        case ast.BinOp(x, ast.Div(), y):
            return rf"\frac{{{expression(x)[0]}}}{{{expression(y)[0]}}}", PRODUCT
        case ast.BinOp(x, ast.Mult(), y):
            left, right = within(x, PRODUCT), within(y, PRODUCT)
            return rf"{left} \cdot {right}" if right[0].isdigit() else f"{left} {right}", PRODUCT
        case ast.BinOp(x, operation, y):
            return f"{within(x, SUM)} {'+' if isinstance(operation, ast.Add) else '-'} {within(y, PRODUCT)}", SUM
        case ast.Call(ast.Name("sqrt"), [x]):
            return rf"\sqrt{{{expression(x)[0]}}}", ATOM
        case ast.Call(ast.Name("pow"), [x, y]):
            return f"{{{within(x, ATOM)}}}^{{{expression(y)[0]}}}", ATOM
        case ast.Call(ast.Name(name), arguments):
            listed = ", ".join(expression(x)[0] for x in arguments)
            return rf"{NAMES.get(name, chr(92) + name)}\left({listed}\right)", ATOM
    raise ValueError(f"{ast.unparse(node)} has no LaTeX; equations have + - * /, powers and functions")


def within(node: ast.expr, least: int) -> str:
    """The LaTeX of an operand, in parentheses if its precedence is lower than `least`."""
    text, strength = expression(node)
    return text if strength >= least else rf"\left({text}\right)"
