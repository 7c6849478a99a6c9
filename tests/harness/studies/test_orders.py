"""The published orders: every in-house method is measured, and its order is the declared one."""

import json
from collections import Counter
from dataclasses import replace
from pathlib import Path

import pytest
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.integrators.geometric import splitting
from gnomon.harness.integrators.runge_kutta import explicit, explicit_pairs
from gnomon.harness.registry.lookup import in_house
from gnomon.harness.studies import growth, orders
from gnomon.harness.studies.orders import SUBJECTS, WITHIN, Subject, measure_row

IN_HOUSE = {method.id.removeprefix("gnomon:"): method for method in in_house()}
FORMULA_OF_ANOTHER = {"DOP853 [events]": "DOP853"}
"""Measured with the same formula on the same problem: once is enough here."""
IN_TEST_ALL = {
    "DOP853": "test_tableau shows its order over all trees",
    "Higuera-Cary": "test_boris measures its order in uniform fields and in a magnetic bottle",
    "Störmer 12": "test_stormer shows the polynomials up to its order, and Störmer 8 is measured here",
}
"""Measured for 4 to 7 s, and why `make test` need not."""


def test_every_in_house_method_is_a_subject_once() -> None:
    listed = Counter(subject.integrator for subject in SUBJECTS)
    for name in IN_HOUSE:
        assert listed[name] == 1, (
            f'{name}: write one line {{ integrators = ["{name}"], ... }} into harness/studies/orders.toml'
        )
    assert set(listed) == set(IN_HOUSE)


@pytest.mark.parametrize("base", [explicit_pairs.DormandPrince5, explicit.RK4, splitting.Yoshida8])
def test_a_new_method_that_no_line_names_is_a_subject(base: type[Integrator]) -> None:
    """Orders and growth are measured where methods of its class and order are."""

    class New(base):  # type: ignore[misc, valid-type]
        name = "New"

    (order,), (growing,) = orders.subjects_of([New()]), growth.subjects_of([New()])
    assert order == replace(orders.subjects_of([base()])[0], integrator="New")
    assert growing == replace(growth.subjects_of([base()])[0], integrator="gnomon:New")


@pytest.mark.parametrize(
    "subject",
    [pytest.param(one, marks=pytest.mark.slow if one.integrator in IN_TEST_ALL else ()) for one in SUBJECTS],
    ids=[one.integrator for one in SUBJECTS],
)
def test_the_measured_order_is_the_declared_one(subject: Subject) -> None:
    if subject.integrator in FORMULA_OF_ANOTHER:
        same = next(s for s in SUBJECTS if s.integrator == FORMULA_OF_ANOTHER[subject.integrator])
        assert (subject.case, subject.span, subject.counts) == (same.case, same.span, same.counts)
        return
    row = measure_row(subject)
    declared = IN_HOUSE[subject.integrator].order
    assert declared is not None
    assert row["declared"] == declared
    assert row["order"] == pytest.approx(declared, abs=WITHIN)
    assert row["points"] >= 4
    assert row["case"].split("/") == [name for name in (subject.case, subject.variant) if name]
    chooses_steps = IN_HOUSE[subject.integrator].sweep.kind == "tolerance"
    assert row["at_fixed_steps"] == chooses_steps, "the page shows this column"
    assert declared <= 8 or row["digits"] >= 60, "binary64 has no asymptotic range above order 8"


def test_a_method_without_an_asymptotic_range_is_an_error() -> None:
    """With so few steps in an orbit the error is above 1e-2."""
    with pytest.raises(RuntimeError, match="no range of steps shows the order of RK4"):
        measure_row(Subject("RK4", case="kepler_orbit", most_steps=64))


def test_the_published_file_has_rows_and_environment(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(orders, "SUBJECTS", [Subject("RK4", span="3")])
    monkeypatch.setattr("sys.argv", ["orders", "--out", str(tmp_path / "orders.json")])
    orders.main()
    found = json.loads((tmp_path / "orders.json").read_text(encoding="utf-8"))
    (row,) = found["rows"]
    assert row == json.loads(json.dumps(measure_row(Subject("RK4", span="3"))))
    assert found["environment"]["numba"]
    assert (row["integrator"], row["case"], row["span"], row["digits"]) == ("RK4", "pendulum_simple", 3.0, 16)
    assert (row["at_fixed_steps"], row["declared"]) == (False, 4)
    assert row["keeps"] == []
