"""`gnomon show NAME` names the files in which a case or check and its exact motion are written."""

import ast
import io
from pathlib import Path

import pytest
from gnomon.harness.commands.show_case import describe, describe_check
from gnomon.harness.registry.selection import source_file
from rich.console import Console

from gnomon import cases

ROOT = Path(__file__).parents[3]


def defines(path: str, name: str) -> bool:
    return any(
        isinstance(node, ast.ClassDef) and node.name == name for node in ast.parse((ROOT / path).read_text()).body
    )


@pytest.mark.parametrize("name", cases.names())
def test_a_case_and_its_motion_are_in_the_files_that_are_shown(name: str) -> None:
    case = cases.get(name)
    assert defines(source_file(type(case)), type(case).__name__)
    assert defines(source_file(type(case.motion())), type(case.motion()).__name__)
    assert source_file(type(case.motion())).startswith("reference/")


@pytest.mark.parametrize("name", cases.check_names())
def test_a_check_is_in_the_file_that_is_shown(name: str) -> None:
    kind = cases.check_class(name)
    assert defines(source_file(kind), kind.__name__)


def test_show_prints_the_files() -> None:
    out = io.StringIO()
    describe(cases.get("gyrocompass_damped"), Console(file=out, width=80))
    describe_check(cases.get_check("capstan_belt"), Console(file=out, width=80))
    lines = out.getvalue().splitlines()
    assert "Case: cases/rigid_bodies/gyrocompass_damped.py" in lines
    assert "Exact motion: reference/oscillators/damped_oscillator.py" in lines
    assert "Check: cases/checks/capstan_belt.py" in lines
