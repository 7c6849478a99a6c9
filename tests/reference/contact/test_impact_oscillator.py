"""Impacts on the stop: at the stop, by the law of restitution, and none of them missed at the grazing bifurcation."""

from fractions import Fraction

import mpmath
import pytest
from gnomon.cases import get
from gnomon.cases.oscillators.forced_oscillators import ForcedOscillator


def test_grazing_bifurcation():
    """The stop 1e-10 m below the peak of an arc is struck once, slowly; 1e-10 m above it, never."""
    (impact,) = get("impact_oscillator", "grazing").events(30)
    assert 0 < impact.before[1] < mpmath.mpf("2e-5")
    assert not get("impact_oscillator", "missed").events(30)


def test_without_an_impact_it_is_the_forced_oscillator():
    """Both exact motions in closed form, of two derivations."""
    missed = get("impact_oscillator", "missed")
    p = missed.parameters
    free = get(
        "forced_oscillator", m=p["m"], c=p["c"], k=p["k"], F0=p["F"], w=p["w"], initial_state=missed.initial_state
    )
    assert isinstance(free, ForcedOscillator)
    for t in (Fraction(1), Fraction(43, 10), Fraction(20)):
        for one, other in zip(missed.exact(t, 40), free.exact(t, 40), strict=True):
            assert abs(one - other) < mpmath.mpf("1e-38")


@pytest.mark.parametrize("variant", [None, "chaotic", "chatter"])
def test_no_passage_of_the_stop_between_impacts(variant):
    """Fine samples stay before the stop: the search for roots has missed none."""
    case = get("impact_oscillator", variant)
    for k in range(1, 400):
        assert case.exact(case.span * k / 400, 20)[0] <= float(case.parameters["s"])
