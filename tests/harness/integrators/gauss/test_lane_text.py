"""The notation of the fast Gauss method's text; its tuned numbers stand in one structure alone; one function for all uses."""

import ast
from dataclasses import FrozenInstanceError, fields
from functools import cache
from typing import Any

import pytest
from gnomon.cases.core.registry import get
from gnomon.harness.contract.problem import problem_of
from gnomon.harness.integrators.gauss import gauss_fast_constants
from gnomon.harness.integrators.gauss.gauss_fast import GaussFast
from gnomon.harness.integrators.gauss.gauss_fast_constants import TUNING, Tuning
from gnomon.harness.integrators.gauss.gauss_fast_ensemble import EnsembleText
from gnomon.harness.integrators.gauss.gauss_fast_layout import FIRST_ORDER, SECOND_ORDER, Layout, layout
from gnomon.harness.integrators.gauss.gauss_fast_stepping import SingleText
from gnomon.harness.integrators.gauss.lane_text import LaneText

STRUCTURE = {0, 1, 2, 3, 4, 5, 6, 7, 8, 10, 64, 0.125, 1e15}
"""Numbers that are not chosen: of stages, powers of the tolerance in the error, the mean of eight, the largest whole
number of steps."""

CASES = ("kepler_orbit", "rubber_tube_thin", "lagrange_top", "kepler_orbit in Sundman time")
"""Their equations have derivatives; poles; angles and velocities; groups and components that never change."""


class Example(LaneText):
    def __init__(self, kind: int, frozen: tuple[int, ...] = ()) -> None:
        super().__init__(Layout(kind, (0.0, 0.0), (), 1, 4 if kind == SECOND_ORDER else 2 + len(frozen), frozen))

    def outer(self) -> str:
        return """
            def outer():
                {inside}
                return ({pair})
        """

    def inside(self) -> str:
        return """
            a@ = y[&]  #? second_order
            a@ = y[@]  #? first_order
            if exactly:  #? second_order
                for j in range(8):
                    {sum_of_stages}
            b% = out[~]  #? first_order and not groups
            c = groups  #? first_order and groups
        """

    def sum_of_stages(self) -> str:
        return "s@ = s@ + r$"

    def pair(self) -> str:
        return "<|a@, |>"

    def missing(self) -> str:
        return "{nowhere}"


def test_a_line_is_repeated_where_it_has_an_index_and_left_out_where_its_condition_is_false() -> None:
    lines = Example(FIRST_ORDER, (1,)).written("outer").splitlines()
    assert lines == [
        "def outer():", "    a0 = y[0]", "    a1 = y[1]", "    b0 = out[0]", "    b1 = out[2]", "    return (a0, a1, )"
    ]  # fmt: skip


def test_a_part_is_indented_as_the_line_in_whose_place_it_is() -> None:
    lines = Example(SECOND_ORDER).written("outer").splitlines()
    sums = [f"            s{i} = s{i} + r{j}" for i in range(2) for j in range(1, 8)]
    start = ["def outer():", "    a0 = y[2]", "    a1 = y[3]", "    if exactly:", "        for j in range(8):"]
    assert lines == [*start, *sums, "    return (a0, a1, )"]


def test_a_part_that_does_not_exist_is_an_error() -> None:
    with pytest.raises(AttributeError, match="nowhere"):
        Example(FIRST_ORDER).written("missing")


def arguments(name: str) -> tuple[Any, int, int]:
    """The equations of a case, as the method takes them."""
    case = get(name.partition(" in ")[0]).rounded()
    problem = problem_of(case, GaussFast.accepts, case.formulations[0] if " in " in name else None)
    return getattr(problem.form, "source", None) or problem.form, len(problem.parameters), problem.dimension


@cache
def texts() -> tuple[ast.Module, ...]:
    """The functions of both modules for each of CASES."""
    return tuple(
        ast.parse(text.written(part))
        for given in map(arguments, CASES)
        for text, part in ((SingleText(layout(*given)), "single"), (EnsembleText(layout(*given, False)), "ensemble"))
    )


def test_numbers_that_were_tuned_stand_in_their_structure_alone() -> None:
    """Every number in the text of the method's functions is a name of a constant, or part of the structure."""
    for text in texts():
        functions = ast.Module([one for one in text.body if isinstance(one, ast.FunctionDef)], [])
        indices = {one.slice for one in ast.walk(functions) if isinstance(one, ast.Subscript)}
        found = {one.value for one in ast.walk(functions) if isinstance(one, ast.Constant) and one not in indices}
        assert {one for one in found if isinstance(one, int | float)} <= STRUCTURE


ELSEWHERE = "most_derivatives fewest_grouped most_groups usual_width width_exponent most_width loosest ensemble chunk"
"""Fields of the structure that Python reads, not the generated text."""


def test_every_tuned_number_is_used_and_cannot_be_changed() -> None:
    used = {
        one.id
        for text in texts()
        for one in ast.walk(text)
        if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Load)
    }
    for field in fields(Tuning):
        assert field.name in ELSEWHERE.split() or field.name.upper() in used, f"{field.name} is not used"
    with pytest.raises(FrozenInstanceError):
        TUNING.hold = 2.0  # type: ignore[misc]


def test_a_tuned_number_goes_into_the_text(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(gauss_fast_constants, "TUNING", Tuning(hold=2.5))
    assert "\nHOLD = 2.5\n" in SingleText(layout(*arguments("kepler_orbit"))).written("single")
