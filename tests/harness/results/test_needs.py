"""Needs: the answers of each library, computed again from raw rows, their intervals and their reliable settings."""

import math
import statistics
from collections.abc import Sequence
from functools import cache
from typing import Any

import numpy as np
import pandas as pd
import pytest
from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.registry import lookup, selection
from gnomon.harness.results import analysis, rankings
from gnomon.harness.results.advice import needs
from gnomon.harness.results.advice.needs import SUBJECTS, Answer, Measurements
from gnomon.harness.results.time_ratios import UNMEASURED

from gnomon import cases

SMOOTH = "Forces of position and time alone"
EVENTS = "Impact, friction and changing contact"
ERROR = 1e-6
Row = dict[str, Any]


def series(
    case: str, name: str, errors: Sequence[float], seconds: Sequence[float], variant: str = "", launches: int = 3
) -> list[Row]:
    """The rows of a sweep over tolerances 1e-3, 1e-4, ...; launches take 1, 1.01 and 0.99 times the seconds."""
    return [
        {
            **{"case": case, "variant": variant, "formulation": "", "library": name.partition(":")[0]},
            **{"integrator_id": name, "status": "ok", "run": 1, "launch": launch, "setting_kind": "tolerance"},
            **{"setting": 10.0 ** -(3 + k), "error_max": error, "rhs_calls": 100.0 * (k + 1), "time_scale": 1.0},
            **{"span": 30.0, "conditioning": 1e-15},
            **{"seconds_median": time * (1, 1.01, 1 / 1.01)[launch % 3], "null_seconds": time / 100, "machine": "m"},
            **{"prepare_seconds": 0.1, "steps": 10.0, "more_seconds": math.nan, "delay_seconds": 0.0},
        }
        for launch in range(1, launches + 1)
        for k, (error, time) in enumerate(zip(errors, seconds, strict=True))
    ]


def constant(case: str, name: str, seconds: float, error: float = 1e-7, **more: Any) -> list[Row]:
    """A sweep of two settings with one error and one time."""
    return series(case, name, [error, error], [seconds, seconds], **more)


def measurements(rows: Sequence[Row], kind: str = SMOOTH) -> Measurements:
    frame = pd.DataFrame(rows)
    equal = rankings.rank_methods(analysis.equal_error(frame), UNMEASURED)
    return Measurements(equal, frame, dict.fromkeys(frame["case"], kind))


def answer(
    rows: Sequence[Row], library: str = "scipy", subject: str = "smooth", kind: str = SMOOTH, margin: float = 1.0
) -> Answer:
    (need,) = needs.needs(measurements(rows, kind), [SUBJECTS[subject]], [ERROR], margin)
    return next(one for one in need.answers if one.library == library)


def drawn_rows(rng: np.random.Generator, count: int) -> list[Row]:
    """Sweeps of scipy:DOP853 with errors that fall, not evenly; some end above the error."""
    rows: list[Row] = []
    for k in range(count):
        size = 1e-2 if k % 5 else 1e2
        errors = size * np.cumprod(rng.uniform(0.01, 0.3, 6))
        errors[2] = errors[1] * rng.uniform(0.5, 2)  # not monotone
        rows += series(f"case {k}", "scipy:DOP853", errors.tolist(), (1e-3 * np.cumsum(rng.uniform(1, 2, 6))).tolist())
    return rows


def independent(rows: Sequence[Row]) -> tuple[int, float, float, float, float, set[str]]:
    """By other code: systems, median seconds, least, most, median evaluations, and the cases at a median setting."""
    times, calls, settings = {}, {}, {}
    for case in {row["case"] for row in rows}:
        own = [row for row in rows if row["case"] == case]
        sizes = {row["setting"]: row["error_max"] for row in own if row["launch"] == 1}
        order = sorted(sizes, reverse=True)
        second = sorted(sizes.values())[1]
        order = order[: max(k for k, s in enumerate(order) if sizes[s] <= 3 * second) + 1]
        held = [max(sizes[s] for s in order[k:]) for k in range(len(order))]
        good = [k for k, size in enumerate(held) if size <= ERROR]
        if not good:
            continue

        def at(column: str, launch: int, k: int = good[0], own: list[Row] = own, held: list[float] = held) -> float:
            of = [row[column] for row in sorted(own, key=lambda r: -r["setting"]) if row["launch"] == launch]
            if k == 0:
                return min(of[: len(held)])
            share = math.log(held[k - 1] / ERROR, held[k - 1] / held[k])
            return min([of[k - 1] * (of[k] / of[k - 1]) ** share, *of[k : len(held)]])

        times[case] = statistics.median(at("seconds_median", launch) for launch in (1, 2, 3))
        calls[case] = at("rhs_calls", 1)
        settings[case] = order[good[0]]
    middle = sorted(settings.values(), reverse=True)[len(settings) // 2]
    at_middle = {case for case, setting in settings.items() if setting == middle}
    seconds = list(times.values())
    return (
        len(times),
        statistics.median(seconds),
        min(seconds),
        max(seconds),
        statistics.median(calls.values()),
        at_middle,
    )


@pytest.mark.parametrize("seed", range(5))
def test_an_answer_is_the_one_that_other_code_finds_in_the_rows(seed: int) -> None:
    rows = drawn_rows(np.random.default_rng(seed), 11)
    found, (systems, seconds, low, high, calls, median_cases) = answer(rows), independent(rows)
    assert (found.tried, found.systems) == (11, systems)
    assert 0 < systems < 11, "the rows do not test what is not reached"
    assert [found.seconds, found.low, found.high] == pytest.approx([seconds, low, high], rel=1e-12)
    assert found.evaluations == pytest.approx(calls, rel=1e-12)
    assert found.setting is not None
    assert found.setting.case in median_cases
    assert found.setting.error <= ERROR


def test_few_systems_are_answered_with_a_wide_interval() -> None:
    found = answer([row for k in range(4) for row in constant(f"case {k}", "scipy:DOP853", 1e-3)])
    assert (found.why, found.systems, found.tried) == ("", 4, 4)
    assert found.recommended
    assert found.share[0] == pytest.approx(0.51, abs=0.005)


def test_what_reaches_no_system_says_which_error_half_of_them_reach() -> None:
    """Of four systems two reach 1e-4: that, and no more, is true of half of them."""
    least = (1e-5, 1e-4, 1e-3, 1e-2)
    rows = [row for k, error in enumerate(least) for row in constant(f"case {k}", "scipy:DOP853", 1e-3, error)]
    found = answer(rows)
    assert (found.why, found.systems, found.recommended) == ("", 0, False)
    assert found.best_error == 1e-4
    assert answer([row | {"status": "timeout", "error_max": math.nan} for row in rows]).tried == 4
    assert math.isnan(answer([row | {"status": "timeout", "error_max": math.nan} for row in rows]).best_error)


def stairs(case: str, first: float, name: str = "scipy:DOP853", **more: Any) -> list[Row]:
    """Errors that fall tenfold from below `first` with the tolerances 1e-3 to 1e-9, which take 1, 2, 3, ... ms."""
    return series(case, name, [0.9 * first * 10.0**-k for k in range(7)], [1e-3 * (k + 1) for k in range(7)], **more)


def test_the_reliable_setting_holds_on_all_systems_with_the_margin_and_has_its_cost() -> None:
    """Of three systems, whose tolerances are 1e-5, 1e-6 and 1e-7, all need 1e-7, and a margin of .1 takes 1e-8."""
    rows = [row for case, first in (("a", 1e-4), ("b", 1e-3), ("c", 1e-2)) for row in stairs(case, first)]
    plain, wider = answer(rows), answer(rows, margin=0.1)
    for found, setting, seconds in ((plain, 1e-7, 5e-3), (wider, 1e-8, 6e-3)):
        (one,) = found.reliable
        assert one.relative == pytest.approx(setting)
        assert (one.integrator, one.systems, one.of) == ("scipy:DOP853", 3, 3)
        assert one.seconds == pytest.approx(seconds)
        for row in rows:
            assert row["error_max"] <= ERROR or row["setting"] > one.relative * (1 + 1e-9)
    assert plain.setting is not None
    assert plain.setting.value == pytest.approx(1e-6), "the median setting is looser"
    # No tolerance is tighter than the tightest one of the method.
    assert answer(rows, margin=1e-9).reliable[0].relative == pytest.approx(1e-9)


def test_a_reliable_setting_stops_where_round_off_or_a_time_limit_would_break_it() -> None:
    """With a margin of 1e-2 the setting would be 1e-9, where system c was not measured and d has its round-off."""
    rows = [row for case, first in (("b", 1e-3), ("c", 1e-2)) for row in stairs(case, first)]
    rows += series("d", "scipy:DOP853", [*(1e-3 * 10.0**-k for k in range(6)), 1e-5], [1e-3] * 7)
    kept = [row for row in rows if not (row["case"] == "c" and row["setting"] < 5e-9)]
    (one,) = answer(kept, margin=1e-2).reliable
    assert (one.systems, one.of) == (3, 3)
    assert one.relative == pytest.approx(1e-8)


def test_no_margin_is_taken_of_steps_whose_reliable_value_is_over_the_time_scale() -> None:
    rows = [row | {"setting_kind": "step"} for case, first in (("a", 1e-4), ("b", 1e-3)) for row in stairs(case, first)]
    rows = [row | ({"setting": 5 * row["setting"], "time_scale": 5.0} if row["case"] == "b" else {}) for row in rows]
    (one,) = answer(rows, margin=1e-3).reliable
    assert (one.kind, one.systems) == ("step", 2)
    assert one.relative == pytest.approx(1e-6)


def test_each_method_has_its_own_reliable_setting_and_epsilon_is_not_called_a_tolerance() -> None:
    """The settings of two methods are not numbers of one kind: IAS15's epsilon bounds a term of its series."""
    rows = [row for case in ("kepler_orbit", "two_body") for row in stairs(case, 1e-1, "rebound:IAS15")]
    rows += [row for case in ("a", "b", "c") for row in stairs(case, 1e-4, "rebound:BS [ODE mode]")]
    measured = measurements(rows)
    measured.kind |= dict.fromkeys(("kepler_orbit", "two_body"), "Bodies under gravitation")
    (need,) = needs.needs(measured, [SUBJECTS["smooth"]], [ERROR])
    found = next(one for one in need.answers if one.library == "rebound")
    many, few = found.reliable
    assert (many.integrator, many.name, many.of) == ("rebound:BS [ODE mode]", "rtol", 3)
    assert (few.integrator, few.name, few.of) == ("rebound:IAS15", "epsilon", 2)
    assert (many.relative, few.relative) == pytest.approx((1e-5, 1e-8))
    assert found.setting is not None
    assert found.setting.integrator == many.integrator
    assert found.tightest == pytest.approx(1e-5)
    assert found.rests_on is not None
    assert found.rests_on.eccentricity == pytest.approx(
        max(float(cases.get(name).quantities()["eccentricity"]) for name in ("kepler_orbit", "two_body"))
    )


def test_an_answer_rests_on_the_systems_that_are_reached() -> None:
    rows = [row | {"span": 100.0, "conditioning": 1e-9} for row in constant("a", "scipy:DOP853", 1e-3)]
    rows += [row | {"span": 20.0, "time_scale": 2.0} for row in constant("b", "scipy:DOP853", 1e-3)]
    rows += [row | {"span": 1e6} for row in constant("c", "scipy:DOP853", 1e-3, error=1e-2)]
    found = answer(rows).rests_on
    assert found is not None
    assert (found.shortest, found.longest, found.conditioning) == (10.0, 100.0, 1e-9)
    assert math.isnan(found.eccentricity)


def test_variants_of_one_case_are_one_system() -> None:
    """Three variants of the damped oscillator count once, with their median, and only if all that were tried are reached."""
    name, variants = "damped_oscillator", {"stiff_1e6": 1e-3, "stiff_1e9": 2e-3, "stiff_1e12": 7e-3}
    rows = [row for one, time in variants.items() for row in constant(name, "scipy:Radau", time, variant=one)]
    assert answer(rows, subject="stiff").systems == 1
    assert answer(rows, subject="stiff").high == pytest.approx(2e-3)
    rows += constant("forced_oscillator", "scipy:Radau", 1e-3, variant="stiff")
    assert answer(rows, subject="stiff").systems == 2
    rows += constant("projectile_stokes_drag", "scipy:Radau", 1e-3, error=1e-2, variant="stiff")
    assert (answer(rows, subject="stiff").systems, answer(rows, subject="stiff").tried) == (2, 3)


def test_what_was_not_run_is_not_a_failure() -> None:
    """A page of an unfinished run must not read "not reached" for what is still to come."""
    rows = [row for k in range(6) for row in constant(f"case {k}", "scipy:DOP853", 1e-3)]
    for status in ("interrupted", "unsupported", "not_installed"):
        rows += [
            row | {"status": status, "error_max": math.nan} for row in constant(f"no {status}", "scipy:DOP853", 1e-3)
        ]
    found = answer(rows)
    assert (found.tried, found.systems) == (6, 6)
    (need,) = needs.needs(measurements(rows), [SUBJECTS["smooth"]], [ERROR])
    assert need.systems == 6
    assert answer(rows, "heyoka").why == "not run"


def test_a_tie_names_no_other_method_and_a_separated_one_is_the_best_of_those_compared() -> None:
    rng = np.random.default_rng(1)
    rows: list[Row] = []
    for k in range(12):
        rows += constant(f"case {k}", "scipy:DOP853", 1e-3)
        rows += constant(f"case {k}", "scipy:RK45", 1e-3 * float(np.exp(0.1 * rng.standard_normal())))
    assert answer(rows).better is None
    faster = [row for k in range(12) for row in constant(f"case {k}", "scipy:LSODA", 3e-4)]
    found = answer(rows + faster).better
    assert found is not None
    assert (found.methods, found.among) == (("scipy:LSODA",), 3)
    assert "0.3 of the time" in found.how
    # The sample is the systems: one launch on each of twelve is enough, and on one system no scatter is known.
    once = answer([row for row in rows + faster if row["launch"] == 1]).better
    assert once is not None
    assert once.methods == ("scipy:LSODA",)
    few = [row for row in rows + faster if row["case"] in ("case 1", "case 2", "case 3", "case 4")]
    some = answer(few).better
    assert some is not None
    assert some.methods == ("scipy:LSODA",), "four systems are enough if their ratios agree"
    assert answer([row for row in few if row["case"] == "case 1"]).better is None


def test_a_method_that_reaches_the_error_on_more_systems_is_better_even_in_one_launch() -> None:
    rows: list[Row] = []
    for k in range(20):
        rows += constant(f"case {k}", "scipy:DOP853", 1e-3, 1e-7 if k < 6 else 1e-2, launches=1)
        rows += constant(f"case {k}", "scipy:LSODA", 5e-3, launches=1)
    found = answer(rows).better
    assert found is not None
    assert found.methods == ("scipy:LSODA",)
    assert "14 more of 20" in found.how
    # A faster method that reaches fewer systems is not better.
    lossy: list[Row] = []
    for k in range(20):
        lossy += constant(f"case {k}", "scipy:DOP853", 1e-3)
        lossy += constant(f"case {k}", "scipy:RK45", 1e-5, 1e-7 if k else 1e-2)
    assert answer(lossy).better is None


def test_a_method_that_is_exact_by_construction_is_not_better_and_an_accurate_one_counts() -> None:
    """As WHFast on two bodies: that it is exact there says nothing about other systems, while IAS15 has steps and errors."""
    rows: list[Row] = []
    for case in ("kepler_orbit", "two_body", "radial_fall_inverse_square"):
        rows += constant(case, "rebound:IAS15", 1e-3, error=1e-14)
        rows += constant(case, "rebound:WHFast", 1e-4, error=1e-14)
    found = answer(rows, "rebound", "gravitation", "Bodies under gravitation")
    assert found.better is None
    assert found.systems == 3
    measured = measurements(rows, "Bodies under gravitation")
    assert measured.exact(("two_body", ""), "rebound:WHFast")
    assert not measured.exact(("two_body", ""), "rebound:IAS15")


def test_identical_methods_are_hardly_ever_separated() -> None:
    """Of forty in-house methods as fast as the representative, the fastest by chance is not better."""
    rng, wrong = np.random.default_rng(7), 0
    for _ in range(10):
        rows: list[Row] = []
        for k in range(10):
            for name in ("gnomon:DOP853", *(f"gnomon:same {n}" for n in range(40))):
                rows += constant(f"case {k}", name, 1e-3 * float(np.exp(0.24 * rng.standard_t(3))))
        wrong += answer(rows, "gnomon").better is not None
    assert wrong <= 1


def test_divisions_are_third_parties_then_a_users_own_then_gnomon() -> None:
    rows = [row for name in ("scipy:DOP853", "mine:midpoint", "gnomon:DOP853") for row in constant("case", name, 1e-3)]
    (need,) = needs.needs(measurements(rows), [SUBJECTS["smooth"]], [ERROR])
    assert [(one.library, one.division) for one in need.answers] == [
        *((library, needs.THIRD) for library, one in LIBRARIES.items() if one.suite is None),
        ("mine", needs.YOURS),
        ("gnomon", needs.OWN),
    ]
    assert next(one for one in need.answers if one.library == "mine").methods == ("mine:midpoint",)


def test_the_kind_of_each_case_has_its_own_representative() -> None:
    rows = constant("case", "scipy:DOP853", 1e-3) + constant("ball", "scipy:DOP853 [events]", 1e-3)
    assert answer(rows, subject="events", kind=EVENTS).methods == ("scipy:DOP853 [events]",)
    assert "drives none" in answer(rows, "heyoka", subject="events", kind=EVENTS).why
    assert answer(constant("case", "scipy:RK45", 1e-3), subject="rough").methods == ("scipy:RK45",)


def test_the_costs_of_stiff_methods_rise_by_decades_and_show_what_fails() -> None:
    rows = constant("damped_oscillator", "scipy:BDF", 1e-3, variant="stiff_1e6")
    rows += constant("damped_oscillator", "scipy:BDF", 1e-2, error=1e-2, variant="stiff_1e9")
    rows += constant("damped_oscillator", "scipy:DOP853", 1e-2, error=1e-2, variant="stiff_1e9")
    (need,) = needs.needs(measurements(rows), [SUBJECTS["stiff"]], [ERROR])
    assert [(one.integrator, one.variant, math.isnan(one.seconds)) for one in need.costs] == [
        ("scipy:BDF", "stiff_1e6", False),
        ("scipy:BDF", "stiff_1e9", True),
    ]
    assert need.costs[0].decays < need.costs[1].decays
    assert {"scipy:BDF", "scipy:Radau", "sksundae:CVODE BDF [native]"} <= lookup.STIFF


@pytest.mark.parametrize("subject", [one for one in SUBJECTS.values() if not one.kinds], ids=lambda one: one.key)
def test_problems_that_are_named_exist(subject: needs.Subject) -> None:
    names = list(subject.problems or subject.decays)
    assert len(names) == len(set(names)) > 0
    for name in names:
        case, _, variant = name.partition("/")
        assert (variant or selection.DEFAULT) in selection.variants_of(case), name


@pytest.mark.parametrize("subject", SUBJECTS.values(), ids=lambda one: one.key)
def test_each_subject_has_six_independent_systems(subject: needs.Subject) -> None:
    """Variants of one case are one system."""
    of_kind = [name for name, kind in needs.kind_of(forms()).items() if kind in subject.kinds]
    named = [name.partition("/")[0] for name in (*subject.problems, *subject.decays)]
    assert len({*of_kind, *named}) >= 6


@cache
def forms() -> dict[str, set[str]]:
    """The forms that each case offers."""
    return {name: {type(form).__name__ for form in cases.get(name).all_forms()} for name in cases.names()}


def test_long_times_are_thousands_of_time_scales() -> None:
    for name in SUBJECTS["long"].problems:
        case = cases.get(*name.split("/"))
        assert float(case.span) / case.time_scale > 1e3, name


@pytest.mark.parametrize(("name", "decays"), SUBJECTS["stiff"].decays.items())
def test_the_decays_of_a_stiff_problem_are_those_of_its_linearised_equations(name: str, decays: float) -> None:
    """The integral of the fastest rate of decay over the span, by differences of the equations along the exact motion."""
    case = cases.get(*name.split("/"))
    equations = next(form.equations for form in case.all_forms() if hasattr(form, "equations"))
    parameters = tuple(float(x) for x in case.parameter_values())
    times = np.concatenate([[0.0], np.geomspace(1e-9, 1.0, 30)]) * float(case.span)
    rates = []
    for time, state in zip(times, case.sample(times.tolist()), strict=True):
        columns = []
        for k, value in enumerate(state):
            shift = np.zeros(len(state))
            shift[k] = 1e-6 * max(abs(value), 1e-3)
            up, down = (np.array(equations(time, tuple(state + s), parameters)) for s in (shift, -shift))
            columns.append((up - down) / (2 * shift[k]))
        rates.append(-np.linalg.eigvals(np.transpose(columns)).real.min())
    assert np.trapezoid(rates, times) == pytest.approx(decays, rel=0.1)
