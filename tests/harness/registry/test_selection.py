"""Options that narrow the named cases and integrators: `gnomon list` and `gnomon run` take the same words."""

import pytest
from command_line import gnomon
from gnomon.cases.core.forms import Hybrid
from gnomon.harness.registry import lookup, selection


def test_families_are_the_folders_of_cases_and_kinds_are_forms() -> None:
    every = selection.choose(None, variants=False)
    orbits = selection.cases_of(every, ["orbits"], None)
    assert {type(case).__module__.split(".")[2] for case, _ in orbits} == {"orbits"}
    hybrid = selection.cases_of(every, None, ["hybrid"])
    assert {case.id for case, _ in hybrid} == {case.id for case, _ in every if case.hybrid is not None}
    both = selection.cases_of(every, ["pendulums", "contact"], ["Hybrid"])
    assert 0 < len(both) < len(hybrid)
    assert {case.name for case, _ in selection.cases_of(every, None, ["SecondOrder"])} >= {"pendulum_simple"}


def test_an_integrator_is_of_each_kind_that_it_runs() -> None:
    every = tuple(lookup.own().values())
    hybrid = selection.integrators_of(every, None, ["Hybrid"])
    assert hybrid == [one for one in every if issubclass(Hybrid, one.accepts)]
    impact = selection.integrators_of(every, None, ["impact"])
    assert set(impact) > set(hybrid), "those that accept any hybrid problem, and time stepping"
    assert {one.library for one in selection.integrators_of(every, ["SciPy"], ["Hybrid"])} == {"scipy"}


def test_a_list_is_narrowed(capsys: pytest.CaptureFixture[str]) -> None:
    assert gnomon("list", "--library", "scipy", "--kind", "Hybrid") == 0
    text = capsys.readouterr().out
    assert "scipy:RK45 [events]" in text
    assert "bouncing_ball" in text
    assert "gnomon:" not in text
    assert "kepler_orbit" not in text
