"""The lines that the report gives for each integrator run, and give the motion that they describe."""

import runpy
from pathlib import Path

import pytest
from gnomon.harness.registry import lookup
from gnomon.harness.results.advice.code_lines import choose_system, code_of, systems
from gnomon.harness.running.own_equations import form_names, lines
from own_motions import Floats, error_of

ALL = {one.id: one for one in lookup.everything().values() if lookup.missing(one) is None}
WITH_LINES = [name for name, one in ALL.items() if lines(one)]
QUICK = {system: next(name for name in WITH_LINES if choose_system(form_names(ALL[name])) == system) for system in
         dict.fromkeys(choose_system(form_names(ALL[name])) for name in WITH_LINES)}  # fmt: skip


def states_of(code: str, folder: Path) -> Floats:
    file = folder / "own.py"
    file.write_text(code)
    found: Floats = runpy.run_path(str(file))["found"].y.T
    return found


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name in QUICK.values() else pytest.mark.slow) for name in WITH_LINES]
)
def test_the_lines_of_every_integrator_give_the_motion(name: str, tmp_path: Path) -> None:
    system = choose_system(form_names(ALL[name]))
    assert system is not None
    one_step = (
        2.7 * 2.0**-7
    )  # the largest change of the pendulum's velocity in a step of its lines, relative to the velocity
    bound = 4 * one_step if ALL[name].order == 1 else 0.1 * one_step
    assert error_of(system, states_of(lines(ALL[name]) or "", tmp_path)) < bound


@pytest.mark.parametrize("system", systems())
def test_the_lines_of_every_system_lead_to_its_motion(system: str, tmp_path: Path) -> None:
    """With a tight setting: the equations of the lines are those of the system, in each of its forms."""
    code = code_of(system)
    assert len([line for line in code.splitlines() if line]) <= 42
    method = "gnomon:DOP853 [events]" if {"Hybrid", "Impact"} & {*systems()[system]["forms"]} else "gnomon:DOP853"
    states = states_of(code.replace("{method}", method).replace("{setting}", "rtol=1e-13"), tmp_path)
    assert error_of(system, states) < 1e-8


def test_only_engines_have_no_lines() -> None:
    without = [one for one in lookup.everything().values() if lines(one) is None]
    assert without
    assert all(kind.__name__ == "SceneForm" for one in without for kind in one.accepts)


def test_every_form_of_an_integrator_has_a_system() -> None:
    accepted = {name for one in lookup.everything().values() for name in form_names(one)}
    stated = {form for row in systems().values() for form in row["forms"]}
    assert accepted - {"Friction"} <= stated
