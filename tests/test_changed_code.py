"""`make test-changed` selects the tests nearest to the code that changed: by imports, and by names of cases and integrators."""

import subprocess
from collections import Counter
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import changed_code
import pytest
from changed_code import ROOT, Selection, changed_files

MANY = 50
"""Tests of a file with the name of a case: more than its examples."""
FILES = {
    "reference/swings/swing.py": "from gnomon.reference.numerics import series",
    "reference/numerics/series.py": "",
    "cases/swings/swing.py": 'from gnomon.reference.swings.swing import Swing\nclass A:\n    name = "swing"\n',
    "cases/swings/double.py": 'from gnomon.cases.swings.swing import A\nclass B:\n    name = "double"\n',
    "harness/results/merge.py": 'import json\nRULES = "rules.toml"',
    "harness/results/rules.toml": "",
    "harness/commands/merging.py": "def merging():\n    from gnomon.harness.results import merge\n",
    "harness/commands/cli.py": "from gnomon.harness.commands import (\n    merging,\n    running,\n)\n",
    "harness/integrators/steps.py": "",
    "harness/integrators/euler.py": 'from gnomon.harness.integrators import steps\nclass E:\n    name, order = "Euler", 1\n',
    "tests/helpers/line.py": "from gnomon.harness.commands import cli",
    "tests/harness/test_line.py": "from line import run",
    "tests/harness/test_steps.py": "from gnomon.harness.integrators import steps",
    "tests/harness/test_swing.py": "from gnomon.cases.swings.swing import A",
    "tests/cases/test_every.py": "parametrize = names()",
    "tests/cases/test_one.py": "get('swing')",
    "tests/reference/test_series.py": "from gnomon.reference.numerics.series import Series",
}


@pytest.fixture
def project(tmp_path: Path) -> Path:
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


@pytest.mark.parametrize(
    ("changed", "files", "names"),
    [
        ("reference/numerics/series.py", {"test_series"}, {"swing"}),
        ("cases/swings/swing.py", set(), {"swing"}),  # test_swing has it as an example, and `double` as a simpler model
        ("harness/results/merge.py", {"test_line"}, set()),
        ("harness/results/rules.toml", {"test_line"}, set()),
        ("harness/integrators/steps.py", {"test_steps"}, {"Euler"}),
        ("tests/harness/test_swing.py", {"test_swing"}, set()),
        ("tests/helpers/line.py", {"test_line"}, set()),
    ],
)
def test_of_a_changed_file(project: Path, changed: str, files: set[str], names: set[str]) -> None:
    selection = Selection({project / changed}, project)
    assert {path.stem for path in selection.files} == files
    assert selection.names == names


def item(path: Path, name: str, **parameters: object) -> Any:
    def function() -> None:
        """Reads swing."""

    return SimpleNamespace(path=path, name=name, function=function, callspec=SimpleNamespace(params=parameters))


def test_of_a_case_the_tests_with_its_name(project: Path) -> None:
    selection = Selection({project / "cases/swings/swing.py"}, project)
    every, one, line = (
        project / f"tests/{name}.py" for name in ("cases/test_every", "cases/test_one", "harness/test_line")
    )
    assert [selection.may_hold(path) for path in (every, one, line)] == [True, True, False]
    assert selection.takes(item(line, "test[swing-1]"))
    assert selection.takes(item(line, "test[case0]", case=SimpleNamespace(name="swing")))
    assert not selection.takes(item(line, "test[swinging]"))
    assert selection.takes(item(one, "test"))
    assert not selection.takes(item(line, "test"))
    series = Selection({project / "reference/numerics/series.py"}, project)
    nearest = project / "tests/reference/test_series.py"
    assert series.takes(item(nearest, "test"))
    assert not series.takes(item(nearest, "test[double]", case="double"))


def test_a_file_that_takes_many_cases_is_collected(request: pytest.FixtureRequest) -> None:
    """Of the tests that this process has collected: in `make test` these are all."""
    selection = Selection({ROOT / "cases/pendulums/pendulum_simple.py"})
    counts = Counter(one.path for one in request.session.items if set(_names(one)) & selection._cases)
    assert not {path for path, count in counts.items() if count > MANY and not selection.may_hold(path)}


def _names(one: pytest.Item) -> list[str]:
    parameters = getattr(getattr(one, "callspec", None), "params", {})
    return [word for value in parameters.values() for word in changed_code._words(value)]


def test_changed_files_are_those_that_git_names(tmp_path: Path) -> None:
    def git(*arguments: str) -> None:
        identity = ("-c", "user.name=a", "-c", "user.email=a@localhost")
        subprocess.run(["git", *identity, *arguments], cwd=tmp_path, check=True, capture_output=True)

    (tmp_path / "cases").mkdir()
    for name in ("cases/old.py", "cases/same.py", "README.md"):
        (tmp_path / name).write_text("1")
    git("init", "-q")
    git("add", ".")
    git("commit", "-qm", "first")
    for name in ("cases/old.py", "cases/new.py", "README.md"):
        (tmp_path / name).write_text("2")
    assert changed_files("HEAD", tmp_path) == {tmp_path / "cases/old.py", tmp_path / "cases/new.py"}
    with pytest.raises(pytest.UsageError, match=r"--since no_such: .*give a revision of git"):
        changed_files("no_such", tmp_path)
    git("add", ".")
    git("commit", "-qm", "second")
    assert changed_files("HEAD", tmp_path) == set()
    assert len(changed_files("HEAD~1", tmp_path)) == 2


def test_values_of_parameters_are_read_by_name_alone() -> None:
    """The text of a value may have a gigabyte, or raise."""
    assert [*changed_code._words(("a", SimpleNamespace(name="b"), 10**5000, ["c"]))] == ["a", "b", "c"]
