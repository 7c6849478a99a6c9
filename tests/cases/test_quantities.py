"""Derived quantities of every case, compared with independent computations; events, compared with guard and reset.

Of the cases whose exact motions are expensive a seeded tenth runs in `make test`: each quantity is one formula and one
independent computation, and that every quantity has both is tested for all cases.
"""

from functools import cache

import independent  # noqa: F401, fills SMOOTH and HYBRID
import mpmath
import pytest
from breadth import cheap_and_tenth
from gnomon.cases import case_class, get
from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from independent_quantities import (
    DIGITS,
    HYBRID,
    SMOOTH,
    ObservedMotion,
    assert_quantities,
    default_cases,
    missing_oracle,
)

TURNING = ("pendulum_simple", "rotating_pendulum", "chain_in_circular_tube", "rotation_fixed_axis_compound_pendulum")
MORE = [*((name, "rotation") for name in TURNING), ("duffing_unforced", "soft"), ("damped_oscillator", "critical")]
MORE += [("kepler_orbit", "plunge"), ("gyrocompass", "slow_spin"), ("gyrocompass", "pole")]
MORE_WITH_EVENTS = [("bouncing_ball", "elastic"), ("bouncing_ball_incline", "elastic"), ("torpedo_firing_pin", "short")]
MORE_WITH_EVENTS += [("sliding_can", "lifts_off")]
"""Case variants with quantities that the defaults do not have."""
COUNT = 457
"""The number of quantities of all cases on their defaults."""


@cache
def resets(name: str, variant: str | None) -> set[tuple[str, str]]:
    hybrid = get(name, variant).hybrid
    return {(each.name, each.reset.__name__) for each in hybrid.transitions} if hybrid else set()


TRANSITIONS = [
    (name, variant)
    for name, _ in default_cases(hybrid=True)
    for variant in (None, *(v.name for v in case_class(name).variants if resets(name, v.name) - resets(name, None)))
]
"""Every case on its defaults, and the variants with other transitions."""


def test_no_quantity_is_lost() -> None:
    """The tests below would not see a quantity that disappears, so their number is tested; and that each has an independent
    computation."""
    found = [
        (oracles, name, label)
        for oracles, hybrid in ((SMOOTH, False), (HYBRID, True))
        for name, _ in default_cases(hybrid)
        for label in get(name).quantities(10)
    ]
    assert len(found) >= COUNT
    for oracles, name, label in found:
        assert {f"{name}.{label}", label} & set(oracles), missing_oracle(name, label)


@pytest.mark.parametrize(("name", "variant"), cheap_and_tenth([*default_cases(hybrid=False), *MORE]))
def test_every_quantity_of_a_smooth_motion_is_what_it_names(name: str, variant: str | None) -> None:
    assert_quantities(SMOOTH, name, variant)


@pytest.mark.parametrize(("name", "variant"), cheap_and_tenth([*default_cases(hybrid=True), *MORE_WITH_EVENTS]))
def test_every_quantity_of_a_motion_with_events_is_what_it_names(name: str, variant: str | None) -> None:
    assert_quantities(HYBRID, name, variant)


@pytest.mark.parametrize(("name", "variant"), cheap_and_tenth(TRANSITIONS))
def test_events_satisfy_guard_and_reset(name: str, variant: str | None) -> None:
    """At the first events the guard is zero, and the reset maps the state before the event onto the state after it."""
    case = get(name, variant)
    assert case.hybrid is not None
    sizes = max(case.scales().values())
    with mpmath.workdps(DIGITS):
        observed = ObservedMotion(case)
        parameters = tuple(vars(observed.p).values())
        for event in case.events(25)[:4]:
            if event.name == "limit":
                continue
            named = [transition for transition in case.hybrid.transitions if transition.name == event.name]
            assert named, event.name
            satisfied = []
            for transition in named:
                constants = case.hybrid.mode(transition.mode).constants
                landed, gap = (
                    rebind(function, mpmath_arithmetic(mpmath.mp))(event.time, event.before, (*parameters, *constants))
                    for function in (transition.reset, transition.guard)
                )
                off = max(abs(a - b) for a, b in zip(landed, event.after, strict=True))
                satisfied.append(off < sizes * mpmath.mpf("1e-20") and abs(gap[0]) < mpmath.mpf("1e-18") * (1 + sizes))
            assert any(satisfied), event
