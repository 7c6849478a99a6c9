"""The equations of motion of a case as text: formulas, and LaTeX."""

from collections.abc import Iterator

from gnomon.cases import Case
from gnomon.cases.core import forms
from gnomon.harness.kernels.equation_text import EquationText, equation_text, function_text
from gnomon.harness.kernels.formula import plain
from gnomon.harness.kernels.latex import latex


def equations_in_latex(case: Case) -> Iterator[str]:
    """The equations of motion as LaTeX; for a hybrid case, the equations of each mode after a comment with its name."""
    coordinates = [x.name for x in case.state]
    for mode, text in _equations(case):
        yield (f"% mode {mode}\n" if mode else "") + latex(text, coordinates)


def _equations(case: Case) -> Iterator[tuple[str, EquationText]]:
    """The equations of motion, or the equations of each mode of a hybrid case with its name."""
    coordinates, parameters = [x.name for x in case.state], [x.name for x in case.parameter_list]
    if case.hybrid is None:
        traceable = (forms.FirstOrder, forms.SecondOrder, forms.RigidBody)
        form = next(form for form in case.all_forms() if isinstance(form, traceable))
        yield "", equation_text(form, coordinates, parameters)
        return
    for mode in case.hybrid.modes:
        names = [*parameters, *(f"({value!r})" for value in mode.constants)]
        yield mode.name, equation_text(forms.FirstOrder(mode.equations), coordinates, names)


def formulas(case: Case) -> list[str] | None:
    """The equations of motion as formulas, a line each; None if they cannot be traced, as equations that branch."""
    coordinates, parameters = ([x.name for x in each] for each in (case.state, case.parameter_list))
    lines: list[str] = []
    try:
        for mode, text in _equations(case):
            equations = plain(text, [f"{name}' =" for name in coordinates])
            lines += [f"{mode}:", *(f"  {line}" for line in equations)] if mode else equations
        for transition in case.hybrid.transitions if case.hybrid is not None else ():
            lines += _transition(transition, coordinates, parameters)
    except (ValueError, StopIteration):
        return None
    return lines


def _transition(transition: forms.Transition, coordinates: list[str], parameters: list[str]) -> Iterator[str]:
    """The condition under which a mode ends, and the numbers that change then."""
    crosses = "rises" if transition.direction > 0 else "falls"
    guard, *named = plain(function_text(transition.guard, coordinates, parameters), ["as"])
    yield f"{transition.name} ends {transition.mode}, {guard} {crosses} to 0"
    changes = plain(function_text(transition.reset, coordinates, parameters), [f"{name} ->" for name in coordinates])
    unchanged = {f"{name} -> {name}" for name in coordinates}
    yield from (f"  {line}" for line in (*named, *changes) if line not in unchanged)
