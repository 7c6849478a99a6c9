"""Mutants of the right methods: every constant, sign, term and time argument changed in turn, and chosen faults."""

from __future__ import annotations

import ast
import copy
import itertools
import sys
import types
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gnomon.harness.contract.integrator import Integrator, Steps, Tolerance

from gnomon.verify import from_solve, from_step

TEXT = Path(__file__).with_name("right_methods.py").read_text()
Floats = Any


@dataclass(frozen=True)
class Method:
    """A function of right_methods.py, what is declared of it, and the module's constants that belong to it."""

    name: str
    make: Callable[..., Integrator]
    declared: dict[str, Any]
    constants: tuple[str, ...] = ()


SYMPLECTIC = ("symplectic", "reversible")
METHODS = (
    Method("rk4", from_step, {"order": 4}),
    Method("verlet", from_step, {"order": 2, "accelerations": True, "conserves": (*SYMPLECTIC, "momentum")}),
    Method("yoshida", from_step, {"order": 4, "accelerations": True, "conserves": (*SYMPLECTIC, "momentum")}),
    Method("implicit_midpoint", from_step, {"order": 2, "conserves": SYMPLECTIC, "sweep": Steps(0.125, 8)}),
    Method("gauss4", from_step, {"order": 4, "conserves": SYMPLECTIC, "sweep": Steps(0.125, 8)}),
    Method("adams", from_solve, {"order": 4, "sweep": Steps(0.125, 8)}),
    Method("dormand_prince", from_solve, {"order": 5, "dense_order": 4}, ("A", "C", "D", "E")),
    Method("bogacki_shampine", from_solve, {"order": 3, "sweep": Tolerance(1e-3, 1e-10)}),
    Method("richardson", from_solve, {"order": 6}),
)
CHOSEN = (
    ("rk4", "stages in another order", "(a + 2 * b + 2 * c + d)", "(a + 2 * b + 2 * d + c)"),
    ("rk4", "single precision inside", "    a = f(t, y)", "    y = y.astype('f4').astype('f8')\n    a = f(t, y)"),
    ("rk4", "one stage in single precision", "    c = f(t + h / 2, y + h / 2 * b)",
     "    c = f(t + h / 2, (y + h / 2 * b).astype('f4').astype('f8'))"),
    ("rk4", "a slope is kept for the next step", "    a = f(t, y)",
     "    a = KEPT.pop('a', None) if KEPT.get('n') == len(y) else f(t, y)\n    a = f(t, y) if a is None else a\n    KEPT['n'] = len(y)"),
    ("rk4", "the state is changed in place", "    b = f(t + h / 2, y + h / 2 * a)", "    y += 0 * a\n    b = f(t + h / 2, y + h / 2 * a)"),
    ("rk4", "the state of the start is changed", "    a = f(t, y)", "    a = f(t, y)\n    y[0] += 1e-12 * h"),
    ("rk4", "the last slope at the middle", "f(t + h, y + h * c)", "f(t + h / 2, y + h * c)"),
    ("rk4", "slopes replaced where they are not finite", "    return y +", "    a, b, c, d = map(np.nan_to_num, (a, b, c, d))\n    return y +"),
    ("rk4", "nonsense is made finite", "    return y + h / 6 * (a + 2 * b + 2 * c + d)",
     "    return np.nan_to_num(y + h / 6 * (a + 2 * b + 2 * c + d))"),
    ("rk4", "steps are never longer than .01", "    a = f(t, y)", "    h = min(h, 0.01)\n    a = f(t, y)"),
    ("rk4", "a slow random force", "    return y +", "    y = y * (1 + 1e-13 * np.random.default_rng().standard_normal(len(y)))\n    return y +"),
    ("verlet", "the half kick at the end is left out", "    v = middle + h / 2 * f(t + h, q)", "    v = middle"),
    ("verlet", "Euler's method called Verlet", "    middle = v + h / 2 * f(t, q)\n    q = q + h * middle\n    v = middle + h / 2 * f(t + h, q)",
     "    middle = v\n    q = q + h * middle\n    v = middle + h * f(t, q)"),
    ("verlet", "position and velocity take turns a step apart", "    q = q + h * middle", "    q = q + h * v"),
    ("verlet", "the old force is kept", "    v = middle + h / 2 * f(t + h, q)", "    v = middle + h / 2 * KEPT.setdefault(len(q), f(t + h, q))"),
    ("yoshida", "the middle step is positive", "1 - 2 * outer", "2 * outer - 1"),
    ("yoshida", "the time does not advance", "        t = t + part * h\n", ""),
    ("implicit_midpoint", "one iteration", "range(100)", "range(1)"),
    ("implicit_midpoint", "three iterations", "range(100)", "range(3)"),
    ("implicit_midpoint", "a loose stopping rule", "1e-16", "1e-6"),
    ("gauss4", "two iterations", "range(100)", "range(2)"),
    ("gauss4", "a loose stopping rule", "1e-16", "1e-6"),
    ("adams", "started by Euler's method", "y = rk4(f, t, y, h)", "y = y + h * slopes[-1]"),
    ("adams", "the time starts at 0 of each step", "f(t, y)]", "f(t - k * h, y)]"),
    ("adams", "one slope late", "w, x, u, s = slopes", "x, u, s, w = slopes[0], slopes[1], slopes[2], slopes[3]"),
    ("dormand_prince", "FSAL is not passed on", "new, k[6]", "new, k[5]"),
    ("dormand_prince", "rejected steps are accepted", "if error <= 1:", "if error <= 1e9:"),
    ("dormand_prince", "the error estimate is divided by the step", "np.linalg.norm(h * sum(", "np.linalg.norm(sum("),
    ("dormand_prince", "linear interpolation", "(r1 + (1 - x) * (r2 + x * (r3 + (1 - x) * r4)))", "r1"),
    ("dormand_prince", "cubic interpolation", "(r3 + (1 - x) * r4)", "r3"),
    ("dormand_prince", "a sample takes the state of the step's end", "x = (times[len(found)] - t) / h", "x = 1.0"),
    ("dormand_prince", "the tolerance is squared", "return max(np.linalg.norm(y), 1e-3) * tolerance", "return tolerance**0.5"),
    ("dormand_prince", "the tolerance is a constant", "return max(np.linalg.norm(y), 1e-3) * tolerance", "return 1e-6"),
    ("dormand_prince", "the 4th-order row is passed on", "t + h, new, k[6]", "t + h, new - h * sum(e * s for e, s in zip(E, k, strict=True)), k[6]"),
    ("dormand_prince", "single precision inside", "            new = y +", "            y = y.astype('f4').astype('f8')\n            new = y +"),
    ("dormand_prince", "the step size is kept between runs", "t, y, h = t0, y0, 1e-3 * times[-1]", "t, y, h = t0, y0, KEPT.get('h', 1e-3 * times[-1])\n    KEPT['h'] = h / 3"),
    ("bogacki_shampine", "the last step is not shortened", "step = end - t if last else h", "step = h"),
    ("bogacki_shampine", "the second-order row is passed on", "else t + step, new, d", "else t + step, y + step * (7 / 24 * a + 1 / 4 * b + 1 / 3 * c + 1 / 8 * d), d"),
    ("bogacki_shampine", "no step is rejected", "if error <= 1:", "if True:"),
    ("bogacki_shampine", "what diverges is made finite", "np.full((len(times), len(y0)), np.nan)", "np.tile(y0, (len(times), 1))"),
    ("richardson", "the smoothing step is left out", "(z + w + step / n * f(t + step, w)) / 2", "w"),
    ("richardson", "numbers of an expansion in h", "(16 * rows[1] - 4 * rows[0]) / 12", "(4 * rows[1] - 2 * rows[0]) / 2"),
    ("richardson", "the last step is not shortened", "step = end - t if last else h", "step = h"),
)  # fmt: skip
"""(method, fault, text before, text after)."""
RELATIVE = (1e-5, 1e-10)


@dataclass(frozen=True)
class Mutant:
    """A method with one fault; `text` is the module's."""

    method: Method
    fault: str
    text: str

    @property
    def id(self) -> str:
        return f"{self.method.name}: {self.fault}"

    def integrator(self) -> Integrator:
        return made(self.method, self.text, self.fault)


def made(method: Method, text: str, fault: str = "") -> Integrator:
    """The integrator of a method in a module of this text; the module can be found by the name of the integrator."""
    module = types.ModuleType(f"detection_{method.name}_{abs(hash(text))}")
    module.__dict__["KEPT"] = {}
    sys.modules[module.__name__] = module
    exec(compile(text, f"<{module.__name__}>", "exec"), module.__dict__)
    declared = {"name": f"{method.name} {fault}".strip(), "library": "detection", **method.declared}
    integrator = method.make(getattr(module, method.name), **declared)
    return integrator


def right() -> dict[str, Integrator]:
    return {method.name: made(method, TEXT) for method in METHODS}


def mutants() -> list[Mutant]:
    """All mutants, method by method: the chosen faults first."""
    found = []
    for method in METHODS:
        for name, fault, before, after in CHOSEN:
            if name == method.name:
                found.append(Mutant(method, fault, replaced(method, before, after)))
        found += [Mutant(method, fault, text) for fault, text in _automatic(method)]
    return found


def replaced(method: Method, before: str, after: str, text: str = TEXT) -> str:
    """The text with a change in the function of a method or, where it is not there, in the constants of the module."""
    begin = text.index(f"def {method.name}(")
    end = text.find("\n\n\ndef ", begin)
    end = len(text) if end < 0 else end
    body = text[begin:end]
    if before in body:
        if body.count(before) != 1:
            raise ValueError(f"{method.name}: {before!r} is {body.count(before)} times in its function")
        return text[:begin] + body.replace(before, after) + text[end:]
    if text.count(before) != 1:
        raise ValueError(f"{method.name}: {before!r} is not in the text exactly once")
    return text.replace(before, after)


def _automatic(method: Method) -> Iterator[tuple[str, str]]:
    """(fault, text) for every place of the method's function and constants that an operator changes."""
    tree = ast.parse(TEXT)
    parts = [
        node
        for node in tree.body
        if (isinstance(node, ast.FunctionDef) and node.name == method.name)
        or (
            isinstance(node, ast.Assign)
            and isinstance(node.targets[0], ast.Name)
            and node.targets[0].id in method.constants
        )
    ]
    for part in parts:
        parents = {child: parent for parent in ast.walk(part) for child in ast.iter_child_nodes(parent)}
        for (place, node), way in itertools.product(enumerate(ast.walk(part)), WAYS):
            if WAYS[way].applies(node, parents):
                twin = copy.deepcopy(part)
                WAYS[way].change(list(ast.walk(twin))[place])
                text = ast.unparse(ast.Module([twin if each is part else each for each in tree.body], []))
                yield f"{way}, line {node.lineno} column {node.col_offset}: {ast.unparse(node)}", text  # type: ignore[attr-defined]


@dataclass(frozen=True)
class Way:
    """How a node is changed: whether it may be, given each node's parent, and the change in place."""

    applies: Callable[[Any, dict[ast.AST, ast.AST]], bool]
    change: Callable[[Any], None]


def _is_coefficient(node: Any, parents: dict[ast.AST, ast.AST]) -> bool:
    """A number that is multiplied, divided or subtracted: not an index, a count, a power or a limit of step control."""
    if not isinstance(node, ast.Constant) or type(node.value) not in (int, float) or not node.value:
        return False
    above: Any = parents.get(node)
    if not isinstance(above, ast.BinOp) or not isinstance(above.op, ast.Mult | ast.Div | ast.Sub):
        return False
    while above is not None:
        called = isinstance(above, ast.Call) and getattr(above.func, "id", "")
        if isinstance(above, ast.Subscript | ast.Compare) or called in ("range", "max", "min"):
            return False
        above = parents.get(above)
    return True


def _is_sum(node: Any, parents: dict[ast.AST, ast.AST]) -> bool:
    return isinstance(node, ast.BinOp) and isinstance(node.op, ast.Add | ast.Sub)


def _has_term(node: Any, parents: dict[ast.AST, ast.AST]) -> bool:
    return _is_sum(node, parents) and isinstance(node.op, ast.Add) and not isinstance(node.right, ast.Constant)


def _has_time(node: Any, parents: dict[ast.AST, ast.AST]) -> bool:
    named = isinstance(node, ast.Call) and getattr(node.func, "id", "") == "f"
    return named and isinstance(node.args[0], ast.BinOp)


def _scale(relative: float) -> Callable[[Any], None]:
    def change(node: Any) -> None:
        node.value *= 1 + relative

    return change


def _turn(node: Any) -> None:
    node.op = ast.Sub() if isinstance(node.op, ast.Add) else ast.Add()


def _drop(node: Any) -> None:
    node.op, node.right = ast.Mult(), ast.Constant(1)


def _stop(node: Any) -> None:
    node.args[0] = ast.Name("t", ast.Load())


WAYS = {
    "coefficient, 5th digit": Way(_is_coefficient, _scale(RELATIVE[0])),
    "coefficient, 10th digit": Way(_is_coefficient, _scale(RELATIVE[1])),
    "sign": Way(_is_sum, _turn),
    "missing term": Way(_has_term, _drop),
    "time argument": Way(_has_time, _stop),
}
