"""gnomon: exact motions to verify and compare the integrators of classical mechanics.

    case(name)                      a case: its exact motion, equations, derived quantities, a chart
    list_cases(pattern)             the names of cases
    list_integrators(pattern)       the ids of integrators
    solve(fun, t_span, y0, method)  your equations with any integrator, called as SciPy's solve_ivp
    compare(cases, integrators)     errors and times of integrators on cases, or on your equations
    check(case, times, states)      a trajectory of any program against the exact motion
    verify.verify(integrator)       the claims about an integrator of your own
    verify.from_step(step)          an integrator from a function that makes one step
    verify.from_solve(solve)        an integrator from a function that solves
    verify.from_command(command)    an integrator from a program in any language
    verify.from_engine(engine)      an integrator from a physics engine
    verify.parametrize(integrator)  the claims as tests of your own pytest
    verify.assert_follows(...)      one test: the exact motion is followed at one setting
    load(run)                       the results of `gnomon run` as a table of pandas
    load_ensemble(folder)           the samples of `gnomon ensemble` as a table of pandas
    sliding_friction(...)           a body with dry friction, for solve
    right_hand_side(problem)        in an integrator of your own: compiled equations
    each_start(problem, solve_one)  in an integrator of your own: one start after the other

For example:

    import gnomon

    gnomon.case("pendulum_simple", L=2).exact(1.5, digits=30)
    gnomon.solve(lambda t, y: [y[1], -y[0]], (0, 10), [1, 0], "scipy:Radau")
    gnomon.compare("pendulum_simple", ["gnomon:DOP853", "scipy:DOP853"])
    gnomon.compare(lambda t, y: [y[1], -y[0]], (0, 10), [1, 0], "scipy:*").best(1e-9)

The package `gnomon.cases` declares cases. `__init__.pyi` has all names of this module; each is loaded on first use.
"""

import re
from importlib import import_module
from pathlib import Path
from typing import Any

_STUB = Path(__file__).with_name("__init__.pyi").read_text(encoding="utf-8")
_MODULES = {name: module for module, name in re.findall(r"^from (gnomon\.\S+) import (\w+) as ", _STUB, re.M)}
__all__ = [*_MODULES, "cases", "verify"]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        return import_module("importlib.metadata").version("gnomon")
    if name in ("cases", "verify"):
        return import_module(f"gnomon.{name}")
    if name not in _MODULES:
        raise AttributeError(f"module 'gnomon' has no attribute {name!r}")
    attribute = globals()[name] = getattr(import_module(_MODULES[name]), name)
    return attribute


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
