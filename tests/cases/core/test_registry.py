"""Each case and check is found by its name: its file is named after it, or says at its top that it is there."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from gnomon.cases.core.registry import SEQUENCE, entry

from gnomon import cases


@pytest.mark.parametrize("name", [*cases.names(), *cases.check_names()])
def test_a_name_leads_to_its_file(name: str) -> None:
    kind = cases.check_class(name) if name in cases.check_names() else cases.case_class(name)
    stem = kind.__module__.rpartition(".")[2]
    listed = re.findall(r"\w+", sys.modules[kind.__module__].__doc__ or "")
    assert name == kind.name
    assert name == stem or name in listed, f"{kind.__module__} neither has the name {name} nor lists it"


def test_no_public_name_of_cases_is_hidden_by_a_folder() -> None:
    """Importing `gnomon.cases.checks.inertia` makes the folder an attribute of the package, over a function so named."""
    folders = {path.parent.name for path in Path(cases.__file__).parent.glob("*/__init__.py")}
    assert not folders & set(cases.__all__)


@pytest.mark.parametrize("name", [*cases.names(), *cases.check_names()])
def test_the_text_of_a_file_says_as_much_as_its_class(name: str) -> None:
    kind = cases.check_class(name) if name in cases.check_names() else cases.case_class(name)
    found = entry(name)
    assert found.path == f"{kind.__module__}:{kind.__qualname__}"
    assert (found.title, found.variants) == (kind.title, tuple(variant.name for variant in kind.variants))


def test_every_name_of_the_sequence_is_a_case_or_a_check() -> None:
    """No name stands twice: the sequence decides which case comes first, in lists and random draws."""
    listed = SEQUENCE.read_text().split()
    assert len(listed) == len({*listed})
    assert {*listed} <= {*cases.names(), *cases.check_names()}


def test_names_are_listed_without_importing_a_case() -> None:
    code = (
        "import sys; from gnomon import cases; cases.names(); cases.check_names();"
        "print([m for m in sys.modules if m == 'numpy' or m.startswith('gnomon.cases.pendulums')])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]", done.stdout
