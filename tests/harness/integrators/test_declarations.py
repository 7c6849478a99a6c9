"""Declarations are complete and quick to import: only `prepare` loads numba."""

import subprocess
import sys

import pytest
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.registry.lookup import IN_HOUSE, in_house


def test_importing_declarations_loads_no_numba() -> None:
    program = f"import sys, {', '.join(IN_HOUSE)}; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0


@pytest.mark.parametrize("method", in_house(), ids=lambda method: method.name)
def test_a_declaration_is_complete(method: Integrator) -> None:
    assert method.order is not None
    assert method.order >= 1
    assert f"Order {method.order}." in " ".join((method.__doc__ or "").split())
    assert method.accepts
    assert set(method.conserves) <= {"symplectic", "volume", "reversible", "momentum", "attitude", "constraint"}
