"""Methods that are declared exact by construction on a case are, and a declaration names nothing that does not exist."""

from itertools import product

import pytest
from gnomon.harness.contract.declared import read_declared
from gnomon.harness.registry import lookup
from gnomon.harness.registry.families import exact_reason, fits
from on_cases import solved

from gnomon import cases

DECLARED = read_declared("registry", "families.toml")["exact"]
PAIRS = [
    (name, case)
    for row in DECLARED
    for name, case in product(lookup.own(), row["cases"])
    if any(fits(name, pattern) for pattern in row["methods"])
]
STEPS = 2
"""Few from sample to sample: a method that is not exact shows its error."""
ROUND_OFF = 1e-9
"""Of Kepler's equation over ten turns; a symplectic corrector solves it dozens of times at each sample, over long times."""


@pytest.mark.parametrize(("name", "case"), PAIRS)
def test_what_is_declared_exact_has_the_error_of_round_off_at_long_steps(name: str, case: str) -> None:
    method = lookup.own()[name]
    if (why := lookup.missing(method)) is not None:
        pytest.skip(why)
    assert solved(method, cases.get(case).rounded(), steps=STEPS).error < ROUND_OFF


def test_long_steps_show_the_error_of_a_method_that_is_not_exact() -> None:
    """On forced_oscillator the rest of the equations depends on time, so that its exponential method is not declared."""
    name = "gnomon:Exponential Runge-Kutta 4"
    assert exact_reason(name, "forced_oscillator") is None
    assert solved(lookup.own()[name], cases.get("forced_oscillator").rounded(), steps=STEPS).error > 100 * ROUND_OFF


def test_each_declaration_names_methods_and_cases_that_exist() -> None:
    for row in DECLARED:
        assert set(row["cases"]) <= set(cases.names())
        for pattern in row["methods"]:
            assert any(fits(name, pattern) for name in lookup.own()), pattern
        assert row["reason"]
