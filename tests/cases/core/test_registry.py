"""Each case and check is found by its name: its file is named after it, or says at its top that it is there."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

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
