import mpmath
import pytest
from gnomon.cases import get


def test_a_compound_pendulum_swings_as_the_simple_one_of_its_reduced_length():
    body = get("rotation_fixed_axis_compound_pendulum")
    length = body.parameters["I"] / (body.parameters["m"] * body.parameters["l"])
    simple = get("pendulum_simple", L=length, span=body.span)
    with mpmath.workdps(45):
        pairs = zip(body.exact(7, 40), simple.exact(7, 40), strict=True)
        assert max(abs(a - b) for a, b in pairs) < mpmath.mpf("1e-38")
    assert float(body.quantities(30)["center_of_percussion"]) == float(length)


def test_reactions_at_rest_carry_the_weight():
    found = get("rotation_fixed_axis_compound_pendulum", initial_state=(0, 0)).quantities(30)
    assert float(found["reaction_along"]) == pytest.approx(9.81)
    assert found["reaction_across"] == 0


def test_a_sphere_that_rolls_swings_slower_than_one_that_slides():
    rolling = get("rolling_sphere_in_bowl", initial_state=("0.001", 0)).quantities()["period"]
    sliding = get("pendulum_simple", initial_state=("0.001", 0), L="0.9").quantities()["period"]
    assert float(rolling / sliding) == pytest.approx((7 / 5) ** 0.5, rel=1e-12)
