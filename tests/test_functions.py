"""A function can be read whole and called without a list at hand, unless it is compiled.

Compiled functions pass numbers and arrays one by one, and each call that is not inlined costs time.
"""

import ast
import inspect
import json
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from gnomon.harness.contract.integrator import Integrator
from scipy.integrate import solve_ivp

ROOT = Path(__file__).parents[1]
FOLDERS = ("reference", "cases", "harness", "src")
MOST_LINES, MOST_PARAMETERS = 60, 8

PREPARE_ALL = """
import json, sys
from contextlib import suppress
from functools import cache
from textwrap import dedent
from types import FunctionType, SimpleNamespace

from gnomon import cases
from gnomon.harness.adapters import sundials
from gnomon.harness.measuring.settings import sweep_settings
from gnomon.harness.contract.integrator import Refused
from gnomon.harness.contract.problem import find_accepted_form, problem_of
from gnomon.harness.integrators.gauss.gauss_fast_ensemble import advance_eight
from gnomon.harness.kernels import emission, machine, rewriting
from gnomon.harness.registry import lookup
from gnomon.harness.running import plan
from gnomon.harness.studies.fixed_step_formulas import at_fixed_steps

texts, seen = set(), set()


def visit(value):
    if isinstance(value, FunctionType) and value not in seen:
        seen.add(value)
        texts.add(dedent(rewriting.source_of(value)))
        for used in emission.uses(value).values():
            visit(used)


def fingerprint(plain, replaced=None):
    for value in (plain, *(replaced or {}).values()):
        visit(value)
    return ""


emission.fingerprint = fingerprint
machine.callable_at = lambda address, name, own=None: None
machine.code = lambda key, names, emit: SimpleNamespace(addresses=dict.fromkeys(names, 0))


@cache
def offering(kind):
    offers = (case for name in cases.names() if find_accepted_form(case := cases.get(name), (kind,)) is not None)
    return next((case.rounded() for case in offers), None)


for method in lookup.own().values():
    for one in (method, at_fixed_steps(method)) if method.library == "gnomon" else ():
        for kind in one.accepts:
            case = offering(kind)
            if case is not None:
                problem = problem_of(case, (kind,))
                with suppress(Refused):
                    setting = sweep_settings(one, case, problem)[0]
                    one.prepare(problem, setting)
                    if hasattr(one, "by_newton"):
                        one.by_newton(problem, setting, 1)
sundials.compile_functions(0)
visit(advance_eight)  # which the first ensemble compiles
json.dump(sorted(texts), sys.stdout)
"""
"""Prints the texts of functions that the methods of gnomon and their fixed-step formulas pass to the compilers, which do
not run."""

Key = tuple[tuple[str, ...], str]


def functions(text: str) -> Iterator[ast.FunctionDef | ast.AsyncFunctionDef]:
    tree = ast.parse(text)
    return (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef))


def key(function: ast.FunctionDef | ast.AsyncFunctionDef) -> Key:
    """Parameters and body: decorators, and for the function of a loop its name, differ where it is compiled."""
    return tuple(one.arg for one in function.args.args), ast.dump(ast.Module(function.body, []))


def parameters(function: ast.FunctionDef | ast.AsyncFunctionDef) -> int:
    """Without the instance or class, what its user names (options of a command line, declarations of an integrator by
    keyword), and what SciPy's users know."""
    declared = {one.arg for one in function.args.kwonlyargs if one.arg in Integrator.__annotations__}
    every = [*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs]
    known = (
        {"self", "cls"}
        | declared
        | (set(inspect.signature(solve_ivp).parameters) if function.name == "solve" else set())
    )
    kinds = [ast.unparse(one.annotation or ast.Constant(None)) for one in every if one.arg not in known]
    return sum(not ("Annotated[" in kind or kind.startswith("options.")) for kind in kinds)


def contracts_alone(function: ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    """Whether a compiled function may contract a product and a sum into one rounding, and do nothing else with roundings."""
    options = [option for one in function.decorator_list for option in getattr(one, "keywords", ())]
    return all(ast.unparse(option.value) == "{'contract'}" for option in options if option.arg == "fastmath")


def stands_for_another(function: ast.FunctionDef | ast.AsyncFunctionDef) -> bool:
    """Whether it only states the parameters of the functions that take its place when they are compiled."""
    return ast.unparse(function.body[-1]) == "raise NotImplementedError"


def test_functions_are_short_and_take_few_parameters_unless_they_are_compiled(tmp_path: Path) -> None:
    """A compiled function is passed to a compiler, or has the decorator of numba."""
    cold = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path)}  # functions compiled before are not passed again
    command = [sys.executable, "-c", PREPARE_ALL]
    listed = subprocess.run(command, env=cold, stdout=subprocess.PIPE, text=True, check=True).stdout
    generated = [function for text in json.loads(listed) for function in functions(text)]
    assert all(map(contracts_alone, generated))
    compiled = {key(function) for function in generated}
    found = []
    for path in sorted(path for folder in FOLDERS for path in (ROOT / folder).rglob("*.py")):
        for function in functions(path.read_text(encoding="utf-8")):
            assert function.end_lineno is not None
            assert contracts_alone(function), f"{path}: {function.name}"
            text = ast.get_docstring(function, clean=False) or ""
            lines = function.end_lineno - function.lineno + 1 - len(text.splitlines())
            if lines <= MOST_LINES and parameters(function) <= MOST_PARAMETERS:
                continue
            decorated = any("njit" in ast.unparse(one) for one in function.decorator_list)
            if decorated or key(function) in compiled or stands_for_another(function):
                continue
            where = f"{path.relative_to(ROOT)}:{function.lineno} {function.name}"
            found.append(f"{where}: {lines} lines, {parameters(function)} parameters")
    assert not found, f"more than {MOST_LINES} lines or {MOST_PARAMETERS} parameters: {'; '.join(found)}"


PARTICIPLE = re.compile(
    r"_*([a-z]+ed|found|said|told|made|kept|held|given|taken|chosen|shown|known|written|lost|seen|grown)(_|$)"
)
NO_PARTICIPLES = ("speed_of_light", "need_fork")
FLAG = re.compile(r"_*((is|has|are|can)_|[a-z]+s(_|$))")


def top_level() -> Iterator[tuple[str, ast.FunctionDef | ast.AsyncFunctionDef]]:
    """The functions of the modules of harness, with their places."""
    for path in sorted((ROOT / "harness").rglob("*.py")):
        for node in ast.parse(path.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
                yield f"{path.relative_to(ROOT)}:{node.lineno} {node.name}", node


def test_a_function_is_a_verb() -> None:
    """A participle leaves open whether it makes, finds, tells or asks: `measured` stood for all of them."""
    found = [place for place, one in top_level() if PARTICIPLE.match(one.name) and one.name not in NO_PARTICIPLES]
    assert not found, f"say what the function does to what, as measure_growth: {'; '.join(found)}"


def test_a_question_is_a_flag() -> None:
    """A function that says whether something is so reads as a statement: `is_stiff`, `has_ended`, `takes_a_jacobian`."""
    found = [
        place
        for place, one in top_level()
        if isinstance(one.returns, ast.Name)
        and one.returns.id == "bool"
        and (ast.get_docstring(one) or "Whether").startswith("Whether")
        and not FLAG.match(one.name)
    ]
    assert not found, f"begin with is_, has_, are_, can_ or a verb in the third person: {'; '.join(found)}"
