"""Invariants of hybrid motions at events: constant ones stay so to the digits asked for, decaying ones do not grow."""

import itertools

import mpmath
import pytest
from gnomon.cases import case_class, get, names
from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.harness.certification.agreement import sizes
from gnomon.reference.numerics.precision import exact

ASKED = 45
HYBRID_VARIANTS = [
    pytest.param(name, variant, marks=pytest.mark.slow if variant else ())
    for name in names()
    if get(name).hybrid is not None and get(name).invariants and not name.startswith("bouncing_ball")
    for variant in (None, *(v.name for v in case_class(name).variants))
]


@pytest.mark.parametrize(("name", "variant"), HYBRID_VARIANTS)
def test_invariants_hold_through_events(name: str, variant: str | None) -> None:
    case = get(name, variant)
    times = [case.span * k / 7 for k in range(8)]
    with mpmath.workdps(ASKED + 10):
        parameters = tuple(mpmath.mpf(v.numerator) / v.denominator for v in case.parameter_values())
        for label, invariant in case.invariants.items():
            function = rebind(invariant.function, mpmath_arithmetic(mpmath.mp))
            values = [
                function(mpmath.mpf(t.numerator) / t.denominator, case.exact(t, ASKED), parameters)[0] for t in times
            ]
            # errors in the last digits of coordinates change terms that are quadratic in the sizes and cancel
            large = max(abs(v) for v in values) + sum(x * x for x in sizes(case)) * max(map(abs, parameters))
            allowed = large * mpmath.mpf(10) ** (5 - ASKED)
            if invariant.law == "constant":
                assert max(values) - min(values) <= allowed, label
            else:
                assert all(b - a <= allowed for a, b in itertools.pairwise(values)), label


@pytest.mark.parametrize("name", ["bouncing_ball", "bouncing_ball_incline"])
def test_the_energy_of_a_ball_is_lost_at_impacts_alone(name: str) -> None:
    """The energy is constant in the flights before and after the first impact."""
    case = get(name)
    function = rebind(case.invariants["energy"].function, mpmath_arithmetic(mpmath.mp))
    first, second = (event.time for event in case.events(ASKED)[:2])
    with mpmath.workdps(ASKED + 10):
        parameters = tuple(mpmath.mpf(v.numerator) / v.denominator for v in case.parameter_values())

        def energy(t: mpmath.mpf) -> mpmath.mpf:
            return function(t, case.exact(exact(t), ASKED), parameters)[0]

        before = [energy(first * k / 4) for k in range(4)]
        after = [energy(first + (second - first) * k / 4) for k in range(1, 4)]
        allowed = mpmath.mpf(10) ** (5 - ASKED) * max(map(abs, (*before, *after)))
        assert max(before) - min(before) <= allowed
        assert max(after) - min(after) <= allowed
        assert after[0] < before[0]
