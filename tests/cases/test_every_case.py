"""Properties of every case over its whole domain; a new case is tested here without further code."""

import math
import os
from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
from breadth import EXPENSIVE, cheap_and_tenth
from gnomon.cases import Case, case_class, get, names
from gnomon.cases.core.forms import FirstOrder
from gnomon.cases.core.numbers import Range
from gnomon.harness.certification import agreement, certify
from gnomon.reference.numerics.precision import exact, nearest_double, working
from hypothesis import assume, given, settings
from hypothesis import strategies as st

NAMES = names()
SMOOTH = tuple(name for name in NAMES if get(name).hybrid is None)
AUTONOMOUS = tuple(name for name in SMOOTH if case_class(name).autonomous)
REVERSIBLE = tuple(name for name in SMOOTH if get(name).reversed(get(name).initial_state) is not None)
AGREED = 40
"""Digits demanded of a random draw, below the 45 of the certificates: errors may grow more over its span."""
SHORT = 30
"""Digits of certified integrations, which are tested to fewer digits, over a shorter span, with fewer examples."""
fractions = st.fractions(min_value=0, max_value=1, max_denominator=997)


@st.composite
def cases(draw: st.DrawFn, name: str) -> Case:
    """A case with numbers from its domain."""
    kind = case_class(name)
    labels = [p.name for p in kind.parameter_list] + [c.name for c in kind.state]
    numbers = {}
    for label in labels:
        low, high = kind.domain.ranges.get(label, Range()).typical
        number = draw(st.floats(low, high))
        # Closer to zero an exact motion is correct too, but may need thousands of digits.
        numbers[label] = number if abs(number) > 1e-15 else 0.0
    assume(kind.domain.admits({label: Fraction(value) for label, value in numbers.items()}))
    state = [numbers.pop(c.name) for c in kind.state]
    try:
        case = get(name, initial_state=state, **numbers)
        return case if case.certified_digits > SHORT else case.with_span(case.time_scale)
    except ValueError as error:
        if "span" in str(error):
            assume(False)
        raise


def enough(case: Case) -> int:
    return min(AGREED, case.certified_digits)


def examples(name: str) -> Any:
    """How many draws: in `make test` five, or two of an expensive motion. The first has always the simplest numbers and t = 0."""
    integrated = case_class(name).certified_digits <= SHORT
    if "HYPOTHESIS_PROFILE" not in os.environ:
        return settings(max_examples=2 if integrated or name in EXPENSIVE else 5)
    return settings(max_examples=3) if integrated else settings()


def agreed(first: Any, second: Any, case: Case) -> float:
    """Digits in which two states agree, relative to the size of the motion."""
    with working(3 * agreement.DIGITS) as mp:
        return agreement.count_agreed_digits(
            (mp.mpf(a) - mp.mpf(b), size) for a, b, size in zip(first, second, agreement.sizes(case), strict=True)
        )


@pytest.mark.parametrize("name", NAMES)
def test_the_first_state_is_the_initial_state_to_the_last_bit(name: str) -> None:
    """A formula in high precision gives 1e-57 in place of a zero, which no digits of it confirm."""
    for variant in (None, *(each.name for each in case_class(name).variants)):
        case = get(name, variant)
        start = [float(x) for x in case.initial_state]
        assert case.sample(np.array([0.0, -0.0])).tolist() == [start] * 2
        assert [nearest_double(x) for x in case.exact(0, 40)] == start


@pytest.mark.parametrize("name", NAMES)
def test_exact_motion_has_its_digits_satisfies_the_equations_and_keeps_its_invariants(name: str) -> None:
    """All three on each draw: to compute a drawn motion takes longer than what is asked of it."""

    @examples(name)
    @given(cases(name), fractions)
    def holds(case: Case, share: Fraction) -> None:
        t = case.span * share
        assert certify.rounding(case, [t]) >= enough(case)
        if case.hybrid is not None:
            return
        assert agreement.residual(case, agreement.first_order_equations(case), t) >= enough(case)
        assert certify.start(case) >= enough(case)
        if any(invariant.law == "constant" for invariant in case.invariants.values()):
            assert certify.invariants(case, [t]) >= enough(case)

    holds()


@pytest.mark.parametrize("name", NAMES)
def test_decaying_invariants_do_not_grow(name: str) -> None:
    @examples(name)
    @given(cases(name), fractions, fractions)
    def holds(case: Case, one: Fraction, other: Fraction) -> None:
        parameters = tuple(float(v) for v in case.parameter_values())
        for label, invariant in case.invariants.items():
            if invariant.law != "decays":
                continue
            values = []
            for t in sorted((case.span * one, case.span * other)):
                state = tuple(float(x) for x in case.exact(t, 20))
                values.append(invariant.function(float(t), state, parameters)[0])
            # evaluated in binary64: a few roundings of its terms
            assert values[1] <= values[0] + 1e-13 * (abs(values[0]) + sum(x * x for x in agreement.sizes(case))), label

    holds()


@pytest.mark.parametrize("name", cheap_and_tenth(AUTONOMOUS))
def test_motions_compose(name: str) -> None:
    """x(t + s) is the state after s of the motion that starts in x(t), taken to 100 digits. A tenth of the expensive motions
    in `make test`: of these each has its equations, digits and invariants tested there."""

    @examples(name)
    @given(cases(name), fractions)
    def holds(case: Case, share: Fraction) -> None:
        t = case.span * share
        halfway = [exact(x) for x in case.exact(t, 120 if case.certified_digits > SHORT else 44)]
        try:
            rest = case.with_numbers(halfway, case.parameters)
        except ValueError:
            return  # rounding moves a start at the edge of the domain out of it
        assert agreed(
            rest.exact(case.span - t, agreement.find_asked_digits(case)),
            case.exact(case.span, agreement.find_asked_digits(case)),
            case,
        ) >= enough(case)

    holds()


@pytest.mark.parametrize("name", cheap_and_tenth(REVERSIBLE))
def test_the_reversed_motion_retraces_it(name: str) -> None:
    """A tenth of the expensive motions in `make test`, as above."""

    @examples(name)
    @given(cases(name), fractions)
    def holds(case: Case, share: Fraction) -> None:
        t = case.span * share
        there = case.reversed([exact(x) for x in case.exact(t, 120 if case.certified_digits > SHORT else 44)])
        assert there is not None
        back = case.with_numbers(*there)
        returned = back.reversed(back.exact(t, agreement.find_asked_digits(case)))
        assert returned is not None
        assert agreed(returned[0], case.initial_state, case) >= enough(case)

    holds()


@pytest.mark.parametrize("name", NAMES)
def test_equations_read_the_state_and_parameters_that_the_case_declares(name: str) -> None:
    case = get(name).rounded()
    state = tuple(map(float, case.initial_state))
    parameters = tuple(map(float, case.parameter_values()))
    for form in case.all_forms():
        if isinstance(form, FirstOrder):
            rates = form.equations(0.0, state, parameters)
            assert len(rates) == len(case.state)
            assert all(map(math.isfinite, map(float, rates)))


@pytest.mark.parametrize("name", cheap_and_tenth(NAMES))
def test_every_variant_can_be_built_rounded_and_sampled(name: str) -> None:
    # Errors of an integration are followed over its whole span, for seconds: `make test-all` waits for it.
    is_short = case_class(name).certified_digits <= SHORT and "HYPOTHESIS_PROFILE" not in os.environ
    stresses = set()
    for variant in case_class(name).variants:
        case = get(name, variant.name).rounded()
        assert all(Fraction(float(value)) == value for value in case.numbers.values())
        assert len(case.times) == 64
        moved = case.with_span(case.time_scale) if is_short else case
        assert all(map(mpmath.isfinite, moved.exact(float(moved.times[-1]))))
        assert variant.stresses
        stresses.add(variant.stresses)
    assert len(stresses) == len(case_class(name).variants)


@pytest.mark.parametrize("name", NAMES)
def test_bad_numbers_are_refused_by_name(name: str) -> None:
    """`core/test_numbers.py` tests that numbers outside their ranges are refused by name too."""
    with pytest.raises(ValueError, match="no parameter 'wrong'"):
        get(name, wrong=1)
    with pytest.raises(ValueError, match="no variant 'wrong'"):
        get(name, "wrong")
    with pytest.raises(ValueError, match="initial state"):
        get(name, initial_state=[1])
    for span in (-1, 0):
        with pytest.raises(ValueError, match=r"span = .* is not positive"):
            get(name, span=span)
