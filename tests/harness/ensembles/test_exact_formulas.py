"""Exact states come from the exact motion of the case where its formula does not know them."""

import numpy as np
import pytest
from gnomon.cases import get
from gnomon.harness.ensembles.exact_formulas import FORMULAS, NO_EXACT_STATE, OUTSIDE, exact_states, formula

from gnomon import cases


@pytest.mark.parametrize("name", FORMULAS)
def test_states_are_those_of_the_case(name: str) -> None:
    """Parameters and components in the order of the case: for its own numbers and the numbers of its variants."""
    kind = cases.case_class(name)
    for variant in (None, *(v.name for v in kind.variants if not v.name.startswith(("long", "orbits")))):
        case = get(name, variant).rounded()
        parameters = np.array([list(map(float, case.parameter_values()))])
        starts = np.array([list(map(float, case.initial_state))])
        times = case.times[[0, 40, 63]]
        states, reasons = exact_states(case, parameters, starts, times)
        right = case.sample(times)
        assert reasons == [""]
        tolerance = np.spacing(np.abs(right)) + 2.0**-58 * np.max(np.abs(right))  # both are within 0.51 ulp
        assert np.all(np.abs(states[0] - right) <= tolerance), variant


def test_what_the_formula_does_not_know_comes_from_the_exact_motion() -> None:
    """The separatrix; a swing so small that the low parts of its products underflow."""
    case = get("pendulum_simple", "separatrix").rounded()
    parameters = np.tile([float(x) for x in case.parameter_values()], (2, 1))
    starts = np.array([[0.0, 2.0], [0.0, 1e-160]])
    states, reasons = exact_states(case, parameters, starts, np.array([3.0]))
    assert reasons == ["", ""]
    assert states[0, 0, 0] == pytest.approx(np.pi - 4 * np.arctan(np.exp(-3.0)), rel=1e-15)
    assert states[1, 0].tolist() == pytest.approx([1e-160 * np.sin(3.0), 1e-160 * np.cos(3.0)], rel=1e-15)


def test_what_is_outside_the_domain_has_no_state() -> None:
    """A range, a joint rule, a collision within the span, and numbers out of reach exclude samples."""
    pendulum, kepler = get("pendulum_simple").rounded(), get("kepler_orbit").rounded()
    _, reasons = exact_states(pendulum, np.array([[-1.0, 1.0], [1.0, 1.0]]), np.ones((2, 2)), np.array([1.0]))
    assert reasons == [OUTSIDE, ""]
    starts = np.array([[0.0, 0, 1, 1], [1.0, 0, 0, 0], [1.0, 0, 0, 1]])
    _, reasons = exact_states(kepler, np.ones((3, 1)), starts, np.array([1.0]))
    assert reasons == [OUTSIDE, OUTSIDE, ""]


def test_an_exact_motion_out_of_reach_is_a_status_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    case = get("duffing_unforced").rounded()

    def out_of_reach(self: object, times: object) -> None:
        raise cases.core.numbers.OutOfReachError("too long")

    monkeypatch.setattr(type(case), "sample", out_of_reach)
    own = np.array([[float(x) for x in case.parameter_values()]])
    _, reasons = exact_states(case, own, np.ones((1, len(case.state))), np.array([1.0]))
    assert reasons == [NO_EXACT_STATE]


def test_a_case_of_a_user_has_no_formula() -> None:
    """Though it has the name of one that has: its equations may be others."""

    class Own(cases.case_class("pendulum_simple")):  # type: ignore[misc]
        pass

    assert formula(get("pendulum_simple")) is not None
    assert formula(Own()) is None
