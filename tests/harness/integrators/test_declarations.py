"""Declarations are complete, and cheap to import: numba is loaded by `prepare` alone."""

from __future__ import annotations

import subprocess
import sys

import pytest
from gnomon.harness.integrators import dop853, explicit, gauss, lie, splitting

ALL = [
    method
    for module in (explicit, splitting, gauss, dop853, lie)
    for method in module.INTEGRATORS  # type: ignore[attr-defined]
]
MODULES = "explicit, splitting, gauss, dop853, lie"


def test_importing_declarations_loads_no_numba() -> None:
    program = f"import sys; from gnomon.harness.integrators import {MODULES}; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0


@pytest.mark.parametrize("method", ALL, ids=lambda method: method.name)
def test_a_declaration_says_what_it_is(method: type) -> None:
    assert method.order >= 1
    assert f"Order {method.order}." in " ".join((method.__doc__ or "").split())
    assert method.accepts
    assert set(method.conserves) <= {"symplectic", "reversible", "momentum", "attitude"}


def test_names_are_unique() -> None:
    names = [method().id for method in ALL]
    assert len(set(names)) == len(names)
