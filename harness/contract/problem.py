"""Make the Problem for an integrator from a case: equations in an accepted form, parameters, sample times."""

from collections.abc import Iterable
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
from gnomon.cases.core.case import Case
from gnomon.cases.core.forms import FirstOrder, Form, first_order
from gnomon.cases.core.formulation import Formulation
from gnomon.cases.core.scene import SceneForm
from gnomon.harness.contract.integrator import Floats, Integrator, Names, Problem
from gnomon.reference.numerics.precision import nearest_double, working

DIGITS = 40
"""Initial states of formulations and values of their clocks are computed to this many digits and rounded once."""


def find_accepted_form(
    case: Case, accepts: tuple[type, ...], formulation: Formulation | None = None
) -> Form | SceneForm | None:
    """The most structured form of a case, or of a formulation of it, of an accepted type; None without such a form."""
    offered: tuple[Form | SceneForm, ...] = case.all_forms() if formulation is None else _with_first_order(formulation)
    if formulation is None and case.scene is not None:
        offered = (*offered, case.scene)
    return next((form for form in offered if isinstance(form, accepts)), None)


def first_taken(integrator: Integrator, forms: Iterable[Form | SceneForm | None]) -> Any:
    """The first of several forms that an integrator takes; None if it does not take any."""
    return next((form for form in forms if form is not None and _takes_form(integrator, form)), None)


def takes(integrator: Integrator, case: Case) -> bool:
    """Whether an integrator takes the form in which it would be given a case."""
    form = find_accepted_form(case, integrator.accepts)
    return form is not None and _takes_form(integrator, form)


def _takes_form(integrator: Integrator, form: Form | SceneForm) -> bool:
    return isinstance(form, integrator.accepts) and integrator.unsupported(form) is None


def problem_of(
    case: Case, accepts: tuple[type, ...], formulation: Formulation | None = None, counted: bool = False
) -> Problem:
    """The problem that an integrator with `accepts` is given; `case` has binary64 numbers (Case.rounded).

    Raises ValueError if the case does not have an accepted form.
    """
    form = find_accepted_form(case, accepts, formulation)
    if form is None:
        names = " or ".join(kind.__name__ for kind in accepts)
        raise ValueError(f"{case.id} has no form {names}")
    parameters = np.array([float(value) for value in case.parameter_values()])
    times, scale = case.times, float(case.time_scale)
    if formulation is not None and formulation.independent is not None:
        times = np.array([nearest_double(formulation.independent(Fraction(t), DIGITS)) for t in case.times.tolist()])
        scale *= float(times[-1] / case.times[-1])
    dimension, groups = len(initial_state(case, formulation)), groups_of(case, formulation)
    return Problem(form, dimension, parameters, times, scale, counted, groups, names_of(case, formulation))


def groups_of(case: Case, formulation: Formulation | None = None) -> tuple[int, ...]:
    """The value of `Problem.groups`: the case's groups, numbered as they first appear; () for a formulation."""
    names = list(dict.fromkeys(coordinate.group for coordinate in case.state))
    return () if formulation is not None else tuple(names.index(coordinate.group) for coordinate in case.state)


def names_of(case: Case, formulation: Formulation | None = None) -> Names:
    """The value of `Problem.names`. A formulation has other coordinates, y1, y2, ..., and another case name."""
    parameters = tuple(parameter.name for parameter in case.parameter_list)
    if formulation is None:
        return Names(case.name, tuple(coordinate.name for coordinate in case.state), parameters)
    dimension = len(initial_state(case, formulation))
    coordinates = tuple(f"y{k}" for k in range(1, dimension + 1))
    return Names(f"{case.name} as {formulation.name}", coordinates, parameters)


def initial_state(case: Case, formulation: Formulation | None = None) -> Floats:
    """The initial state as the integrator gets it, shape (dim,): encoded in high precision and rounded once."""
    if formulation is None:
        return np.array([float(value) for value in case.initial_state])
    with working(DIGITS) as mp:
        state = [mp.mpf(x.numerator) / x.denominator for x in case.initial_state]
        parameters = [mp.mpf(x.numerator) / x.denominator for x in case.parameter_values()]
        return np.array([nearest_double(mp.mpf(x)) for x in formulation.encode(mp, state, parameters)])


def counting(problem: Problem) -> Problem:
    """The problem for an untimed run in which right-hand sides are counted."""
    return replace(problem, counted=True)


def _with_first_order(formulation: Formulation) -> tuple[Form, ...]:
    forms = formulation.forms
    if any(isinstance(form, FirstOrder) for form in forms):
        return forms
    implied = next((f for f in map(first_order, forms) if f is not None), None)
    return forms if implied is None else (*forms, implied)
