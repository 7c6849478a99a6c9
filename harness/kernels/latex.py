"""Write equations of motion in LaTeX, as one prints them."""

import re
from collections.abc import Sequence
from fractions import Fraction

from gnomon.harness.kernels.equation_text import EquationText
from gnomon.harness.kernels.formula import Base, Call, Sum, Term, formulas, write

GREEK = (
    r"(alpha|beta|gamma|delta|zeta|eta|theta|kappa|lambda|mu|nu|xi|pi|rho|sigma|tau|phi|chi|psi|omega|"
    r"Gamma|Delta|Theta|Lambda|Xi|Pi|Sigma|Phi|Psi|Omega)"
)
SHORT = {"th": "theta", "gam": "gamma", "Om": "Omega"}
"""Letters that cases write shorter."""
COMPONENT = re.compile(r"([abeuvwBE])([xyzrs])(\d*)")
"""A component of a vector, as vx1."""
RATE = re.compile(r"(\w+?)(?:_rate|dot)")
NAMES = {"asin": r"\arcsin", "acos": r"\arccos", "atan": r"\arctan", "log": r"\ln"}
NAMES |= {name: rf"\operatorname{{{name}}}" for name in ("asinh", "acosh", "atanh", "atan2", "hypot")}
RAISED = ("sin", "cos", "tan", "sinh", "cosh", "tanh")
"""Functions whose power is written behind their names."""
TALL = re.compile(r"\\frac|\\sqrt|\\left")


def latex(text: EquationText, coordinates: Sequence[str]) -> str:
    """An `aligned` environment with the values that have a name, then the derivative of each coordinate.

    A coordinate that is itself written as a derivative, as phidot, needs no line for it.
    """
    named, derivatives = formulas(text)
    notation = Latex()
    lines = [(symbol(name), value) for name, value in named.items()]
    lines += [(dot_name(x), value) for x, value in zip(coordinates, derivatives, strict=True)]
    sides = [(name, write(value, notation)) for name, value in lines]
    shown = [f"{left} &= {right}" for left, right in sides if left != right]
    return "\n".join([r"\begin{aligned}", " \\\\\n".join(shown), r"\end{aligned}"])


def symbol(name: str) -> str:
    r"""The symbol of a name: theta is \theta, I1 is I_1, vx is v_x, mu_k is \mu_k, phidot is \dot\phi, rate is \mathrm{rate}."""
    rate = RATE.fullmatch(name)
    if rate:
        return dot_name(rate[1])
    letter, index = _parts(name)
    return letter + (f"_{index}" if index else "")


def dot_name(name: str) -> str:
    """The symbol of the derivative of a name."""
    rate = RATE.fullmatch(name)
    letter, index = _parts(rate[1] if rate else name)
    dot = r"\ddot" if rate else r"\dot"
    text = f"{dot} {letter}" if len(letter) == 1 else f"{dot}{letter}"
    text = f"{dot}{{{letter}}}" if letter.startswith(r"\mathrm") else text
    return text + (f"_{index}" if index else "")


def _parts(name: str) -> tuple[str, str]:
    """The letter of a symbol, and its index."""
    component = COMPONENT.fullmatch(name)
    if component:
        letters, index = component[1], component[2] + component[3]
    else:
        letters, _, index = re.sub(r"(?<=[A-Za-z])(\d)", r"_\1", name, count=1).partition("_")
    letters = SHORT.get(letters, letters)
    greek = bool(re.fullmatch(GREEK, letters))
    letter = rf"\{letters}" if greek else letters if len(letters) == 1 else rf"\mathrm{{{letters}}}"
    if re.fullmatch(GREEK, index):
        return letter, rf"\{index}"
    return letter, index if len(index) < 2 else f"{{{index}}}" if len(index) == 2 else rf"{{\mathrm{{{index}}}}}"


class Latex:
    """The notation of print."""

    def symbol(self, name: str) -> str:
        return symbol(name)

    def number(self, value: Fraction) -> str:
        if value.denominator == 1 and abs(value) < 10**6:
            return str(value)
        digits, _, power = repr(float(value)).removesuffix(".0").partition("e")
        return rf"{digits} \cdot 10^{{{int(power)}}}" if power else digits

    def power(self, base: Base, exponent: str) -> str:
        raised = exponent if len(exponent) == 1 else f"{{{exponent}}}"
        if isinstance(base, str):
            text = symbol(base)
            return f"{{{text}}}^{raised}" if text.startswith((r"\dot", r"\ddot", r"\mathrm")) else f"{text}^{raised}"
        if isinstance(base, Call):
            if base.function in RAISED and exponent.isdigit():
                return self.call(base, f"^{raised}")
            return f"{self.enclosed((Term(Fraction(1), ((base, Fraction(1)),)),))}^{raised}"
        return f"{self.enclosed(base)}^{raised}"

    def root(self, under: Sum) -> str:
        return rf"\sqrt{{{write(under, self)}}}"

    def call(self, call: Call, raised: str = "") -> str:
        function = NAMES.get(call.function, rf"\{call.function}") + raised
        inner = ", ".join(write(x, self) for x in call.arguments)
        ((first, *_), *_) = call.arguments if all(call.arguments) else ((Term(Fraction(0)),),)
        bare = len(call.arguments) == 1 and len(call.arguments[0]) == 1 and first.number == 1
        if bare and len(first.factors) == 1 and isinstance(first.factors[0][0], str) and first.factors[0][1] == 1:
            return f"{function}{'' if inner[0] == chr(92) else ' '}{inner}"
        return f"{function}{_parentheses(inner)}"

    def enclosed(self, inner: Sum) -> str:
        return _parentheses(write(inner, self))

    def quotient(self, above: Sequence[str], below: Sequence[str], alone: tuple[Sum | None, Sum | None]) -> str:
        up, down = (
            self.product(texts) if factor is None else write(factor, self)
            for texts, factor in zip((above, below), alone, strict=True)
        )
        return rf"\frac{{{up}}}{{{down}}}"

    def product(self, factors: Sequence[str]) -> str:
        text = ""
        for factor in factors:
            words = r"\mathrm" in text + factor
            text += (r" \cdot " if factor[0].isdigit() else r" \, " if words else " ") * bool(text) + factor
        return text


def _parentheses(text: str) -> str:
    return rf"\left({text}\right)" if TALL.search(text) else f"({text})"
