"""Numbers given to a case: exact numbers are taken exactly, others are refused with the name of the number."""

import math
import random
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from cProfile import Profile
from decimal import Decimal
from fractions import Fraction
from functools import partial
from typing import Any

import mpmath
import numpy as np
import pytest
from gnomon.cases import Case, case_class, check_class, check_names, get, names
from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.cases.core.integrated import IntegratedCase, integrate
from gnomon.cases.core.numbers import OutOfReachError, Range, show
from gnomon.harness.running.plan import FOUNDATION
from gnomon.harness.system.supervisor import within
from gnomon.reference.numerics import certified
from gnomon.reference.numerics.motion import Motion
from gnomon.reference.numerics.precision import exact, working

IMPOSSIBLE = (
    10**400, -(10**400), "1e400", "1e-400", 5e-324, 1.797e308, "1e100000000", "1e1_000_000_00", "-1e-100000000",
    "9" * 5000, Decimal("1e100000000"), mpmath.mpf("1e100000000"),
    "nan", "-inf", float("nan"), float("inf"), mpmath.inf, Decimal("nan"), "1/0", "two", "", None, 1j, [1],
    True, np.bool_(False), np.array(2.0), np.array(3),
)  # fmt: skip


def places(name: str) -> Iterator[str]:
    """The name of every number that a case takes."""
    kind = case_class(name)
    yield from (parameter.name for parameter in kind.parameter_list)
    yield from (coordinate.name for coordinate in kind.state)
    yield "span"


def given(name: str, place: str, value: Any) -> Case:
    """A case with one number other than its defaults."""
    kind = case_class(name)
    labels = [coordinate.name for coordinate in kind.state]
    if place == "span":
        return get(name, span=value)
    if place in labels:
        return get(name, initial_state=[value if n == place else x for n, x in zip(labels, kind.default_state)])  # noqa: B905
    return get(name, **{place: value})


def outside(allowed: Range) -> Iterator[Fraction]:
    """Numbers beyond the ends of a range, and an end that does not belong to it."""
    for end, step, is_open in ((allowed.low, -1, allowed.low_open), (allowed.high, 1, allowed.high_open)):
        if not math.isinf(end):
            yield Fraction(end) + step
            yield from [Fraction(end)] * is_open


@pytest.mark.parametrize("name", names())
def test_an_impossible_number_is_refused_by_case_name_and_range_wherever_it_is_given(name: str) -> None:
    for place in places(name):
        allowed = case_class(name).domain.ranges.get(place, Range(0, low_open=True) if place == "span" else Range())
        for value in (*IMPOSSIBLE, *(outside(allowed) if place != "span" else ())):
            if place == "span" and value is None:
                continue  # the natural span
            with pytest.raises(ValueError, match="=") as refusal:
                given(name, place, value)
            told = str(refusal.value)
            assert told.startswith(f"{name}: {place} = "), (value, told)
            assert str(allowed) in told, (value, told)
            assert len(told) < 400


@pytest.mark.parametrize("name", check_names())
def test_an_impossible_number_of_a_check_is_refused_by_name(name: str) -> None:
    for parameter in check_class(name).parameter_list:
        for value in IMPOSSIBLE:
            with pytest.raises(ValueError, match=f"^{name}: {parameter.name} = "):
                check_class(name)(**{parameter.name: value})


@pytest.mark.parametrize(
    ("value", "wanted"),
    [
        (Decimal("0.1"), Fraction(1, 10)),
        (np.float32(0.1), Fraction(float(np.float32(0.1)))),
        (np.longdouble(1) + np.finfo(np.longdouble).eps, 1 + Fraction(float(np.finfo(np.longdouble).eps))),
        (np.int64(2**60 + 1), Fraction(2**60 + 1)),
        (" 1/3 ", Fraction(1, 3)),
        ("1_0e-1_0", Fraction(1, 10**9)),
        ("1e-9999", Fraction(1, 10**9999)),
        (10**400, Fraction(10**400)),
        (mpmath.mpf(2) ** 2000, Fraction(2**2000)),
    ],
)  # fmt: skip
def test_a_number_is_taken_exactly_whatever_type_it_has(value: Any, wanted: Fraction) -> None:
    """float() would change each of these, or fail."""
    assert exact(value) == wanted


OUT_OF_REACH = (
    ("curve_sliding_small", "p", "1e-6", "the bead rises by at most 2000 p"),
    ("curve_sliding_quartic", "a", "1e-12", "the bead rises by at most 50000 a"),
    ("curve_sliding_catenary", "c", "1e-6", "the bead rises by at most 40 c"),
    ("ignorable_coordinates", "alpha", "1e-6", "usual: 0.3 to 1.2"),
    ("central_force_logarithmic", "k", "1e12", "usual: 0.8 to 1.5"),
    ("central_force_logarithmic", "k", "1e-12", "usual: 0.8 to 1.5"),
    ("central_force_hanging_mass", "g", "1e-12", "usual: 1 to 10"),
    ("dumbbell_spring", "l", "1e6", "usual: 0.5 to 1"),
    ("three_ball_chain", "m2", "1e-6", "at most 100 impacts"),
    ("restitution_impact_1d_2d", "m2", "1e12", "at most 10,000 impacts"),
    ("foucault_pendulum_nonlinear", "Om", "1e6", "give at most 0.00035 s"),
    ("spring_pendulum", "m", "1e-12", "give at most 0.000158114 s"),
    ("swinging_atwood", "mu", "1e12", "give at most 0.00021285 s"),
    (
        "central_force_fifth_power",
        "span",
        "0.785398",
        "falls into the centre at 0.7853981634 s; give at most 0.7853966654",
    ),
    ("double_pendulum", "w2", "1e6", "Taylor steps, the most that are taken, reach t = "),
    ("rigid_body_stokes_medium_torque", "R33", "1e6", "Taylor steps, the most that are taken, reach t = "),
    ("foucault_pendulum_nonlinear", "vx", "-1", "the bob moves along its sphere"),
    ("chain_quarter_circle", "s", "1e-300", "s >= 1e-30 R"),
    ("billiard_ball_attitude", "R", "1e6", "more than 8192"),
    ("billiard_ball_attitude", "wz", "1e300", "more than 8192"),
    ("bouncing_ball_table", "A", "1e-6", "impacts without end"),
    ("pendulum_quadratic_damping", "v", "1e300", "over the top more than 150 times"),
    ("pendulum_quadratic_damping", "theta", "1e30", "[-1e+09, 1e+09]"),
    ("pendulum_quadratic_damping", "theta", "1e-30", "w2 theta^2 + v^2 >= 1e-30 w2"),
    ("bouncing_ball_table", "e", "1e-6", "impacts without end"),
    ("bead_leaving_sphere", "theta", "1e-300", "at most 138 e-foldings"),
    ("stick_slip_belt", "span", "1e6", "at most 10,000 are listed"),
    ("planet_tunnel", "span", "1e12", "at most 10,000 are listed"),
    ("work_energy_spring_block", "span", "1e300", "at most 10,000 are listed"),
    ("pendulum_quadratic_damping", "span", "1e6", "at most 500 are listed"),
    ("projectile_quadratic_drag", "span", "1e6", "the fall is vertical"),
    ("relativistic_charge", "span", "1e300", "more than 1e40 times"),
    ("free_fall_rotating_frame_centrifugal", "span", "1e300", "exceeds 1e60 times"),
    ("damped_oscillator", "k", "1e-300", "natural span, 3.9999999999999996e+300 s"),
)


def at_the_end(case: Case) -> tuple[Any, ...]:
    """The state at the last sample of the rounded case, which an integrator is given."""
    case = case.rounded()
    return case.exact(case.times[-1])


@pytest.mark.parametrize(("name", "parameter", "value", "limit"), OUT_OF_REACH)
def test_an_exact_motion_out_of_reach_names_the_case_the_number_and_the_limit(
    name: str, parameter: str, value: str, limit: str
) -> None:
    """The inner reason is about series and balls, which the caller does not know; the message names the number too."""
    with pytest.raises(ValueError, match=f"^{name}: ") as refusal:
        at_the_end(given(name, parameter, value))
    shown = {show(Fraction(value)), show(Fraction(float(value)))}
    assert any(f"{parameter} = {number}" in str(refusal.value) for number in shown)
    assert limit in str(refusal.value)


@pytest.mark.parametrize(
    ("name", "parameter", "value"),
    [("curve_sliding_small", "p", "0.0112"), ("central_force_hanging_mass", "g", "1e6")],
)
def test_just_inside_the_limit_the_exact_motion_is_computed(name: str, parameter: str, value: str) -> None:
    """A motion that is not refused has enough terms for 30 digits: energy is constant to 30 digits."""
    case = get(name, **{parameter: value})  # type: ignore[arg-type]
    energy = case.invariants["energy"]
    with working(60) as mp:
        function = rebind(energy.function, mpmath_arithmetic(mp))
        numbers = tuple(mp.mpf(x) for x in case.parameter_values())
        start, end = (
            function(t, tuple(mp.mpf(x) for x in case.exact(t, 30)), numbers)[0] for t in (0, case.span * 2 / 3)
        )
        assert abs(end / start - 1) < mp.mpf(10) ** -28


@pytest.mark.parametrize("light", ["1e60", "1e300"])
def test_a_charge_far_below_the_speed_of_light_moves_as_if_there_were_none(light: str) -> None:
    """At c = 1e300 m/s the exponential once took a thousand squarings a step, and minutes."""
    slow, slower = (get("relativistic_charge", c=c, span="1e-9") for c in (light, "1e40"))
    with mpmath.workdps(30):
        for a, b in zip(slow.exact("1e-9", 25), slower.exact("1e-9", 25), strict=True):
            assert abs(a - b) <= abs(b) * mpmath.mpf(10) ** -24


@pytest.mark.parametrize("begin", ["1e-6", "1e-12"])
def test_a_chain_that_hardly_hangs_over_takes_the_time_of_its_quadrature(begin: str) -> None:
    """It creeps at first; places half a natural time apart would be millions."""
    case = given("chain_quarter_circle", "s", begin)
    with mpmath.workdps(40):
        g, length, radius = (mpmath.mpf(x.numerator) / x.denominator for x in case.parameter_values())
        first, quarter = mpmath.mpf(begin), mpmath.pi * radius / 2

        def pace(sigma: Any) -> Any:
            """dt/d sigma, s = first + sigma^2, from v^2 = (2 g R/L) (way - R (sin(s/R) - sin(first/R)))."""
            way = sigma * sigma
            turned = 2 * mpmath.sin(way / (2 * radius)) * mpmath.cos((first + way / 2) / radius)
            return 2 * sigma / mpmath.sqrt(2 * g * radius / length * (way - radius * turned))

        edges = [mpmath.mpf(0)]
        while edges[-1] < mpmath.sqrt(quarter - first):
            edges.append(min(max(2 * edges[-1], mpmath.sqrt(first) / 2), mpmath.sqrt(quarter - first)))
        with mpmath.workdps(60):
            wanted = mpmath.quad(pace, edges)
        assert abs(case.motion().event_times(20)[0] / wanted - 1) < mpmath.mpf(10) ** -18


@pytest.mark.parametrize("mass", ["1e-300", "1e-30"])
def test_huge_numbers_of_half_cycles_are_counted(mass: str) -> None:
    """Friction this weak allows 1e29 half cycles or more: bisection counts them; the first are as without friction."""
    weak = get("coulomb_friction_oscillator", m=mass)
    free = get("harmonic_oscillator", m=mass, k=20, initial_state=("0.5", 0), span=weak.span)
    time = weak.span / 3
    with mpmath.workdps(30):
        for a, b in zip(weak.exact(time, 25), free.exact(time, 25), strict=True):
            assert abs(a - b) < abs(b) * mpmath.mpf(10) ** -24


class Undefined(Motion):
    """A motion whose formula gives nan."""

    def _state(self, mp: Any, t: Fraction) -> tuple[Any, ...]:
        return mp.mpf(t), mp.nan


def test_a_state_that_is_not_finite_is_refused() -> None:
    with pytest.raises(ArithmeticError, match=r"no finite state at t = 2 s"):
        Undefined().state(2)


def test_after_a_long_slide_the_attitude_is_a_rotation() -> None:
    """Low friction: 800 rad before it rolls, composed from halves, each of them a rotation."""
    case = get("billiard_ball_attitude", mu="0.01")
    with mpmath.workdps(35):
        turn = mpmath.matrix(3, 3)
        for i, x in enumerate(case.exact(case.span / 2, 30)[7:]):
            turn[i // 3, i % 3] = x
        assert mpmath.mnorm(turn * turn.T - mpmath.eye(3)) < mpmath.mpf(10) ** -28


def test_an_integration_that_would_take_hours_is_refused_with_its_span() -> None:
    with pytest.raises(OutOfReachError, match=r"^double_pendulum: .*span = 1e\+06 s .* give at most 172\.791 s"):
        get("double_pendulum", span="1e6")


def test_a_formula_that_loses_a_million_digits_is_refused_with_its_span() -> None:
    """On a separatrix two digits a second cancel: the state at the end would take years."""
    case = get("duffing_unforced", "homoclinic", span="1e6")
    with pytest.raises(OutOfReachError, match=r"^duffing_unforced: .*span = 1000000 s: it needs 2e\+06 digits"):
        at_the_end(case)


def test_a_span_that_ends_just_after_an_impact_is_refused() -> None:
    """Samples must be 1e-3 of the flight away from the impact; here the flight lasts 1e174 s."""
    with pytest.raises(OutOfReachError, match=r"span = 168 s: its samples cannot stay clear of its last event"):
        _ = get("bouncing_ball", initial_state=(1, "-5.6e174"), span=168).times


def test_a_state_that_has_decayed_is_a_start() -> None:
    """An exact motion can be restarted from its own states even if they are very small: 1e-434294 here."""
    case = get("projectile_stokes_drag", "stiff")
    halfway = case.exact(case.span / 2, 40)
    assert 0 < min(abs(x) for x in halfway if x) < mpmath.mpf(10) ** -1000
    rest = case.with_numbers(halfway, case.parameters).exact(case.span / 2, 15)
    whole = case.exact(case.span, 15)
    assert all(abs(a - b) <= abs(b) * mpmath.mpf(10) ** -13 for a, b in zip(rest, whole, strict=True))


WIDE = ("0", "-1", "-1e-300", *(f"1e{sign}{size}" for size in (6, 12, 30, 300) for sign in ("", "-")))
MOST_CALLS = 30_000_000
"""Calls of Python functions for one number; the most expensive integrations make 12 million."""
ENDED_SECONDS = 1000.0
"""Processor time after which a number that computes for ever fails its test; none takes 30 s on a quiet machine."""


class EndlessError(BaseException):
    """A BaseException, so that no code under test catches it."""


@contextmanager
def limited_work() -> Iterator[None]:
    """The block makes at most MOST_CALLS calls of Python functions, which is its work on any machine."""
    profile = Profile(builtins=False)
    try:
        with within(ENDED_SECONDS, EndlessError()), profile:
            yield
    finally:
        assert sum(entry.callcount for entry in profile.getstats()) < MOST_CALLS


def what_is_wrong(numbers: Mapping[str, str], name: str, make: Callable[[], Case]) -> str | None:
    """The fault of the exact motion for these numbers; None if it is computed, or refused by case, name and value."""
    try:
        with limited_work():
            case = make().rounded()
            states = [case.exact(case.times[i]) for i in (0, 31, 63)]
    except ValueError as refusal:
        told = str(refusal)
        named = told.startswith(f"{name}: ") and any(f"{place} = " in told for place in numbers)
        return None if named and "\n" not in told else told
    return None if all(mpmath.isfinite(x) for state in states for x in state) else f"no finite states: {states}"


def wrong(drawn: list[tuple[str, str, str]]) -> dict[tuple[str, str, str], str]:
    found = {one: what_is_wrong({one[1]: one[2]}, one[0], partial(given, *one)) for one in drawn}
    return {one: reason for one, reason in found.items() if reason}


INTEGRATED = [name for name in names() if issubclass(case_class(name), IntegratedCase)]
EVERY = [(name, place, value) for name in names() for place in places(name) for value in WIDE]


@pytest.fixture
def _tenth(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Integrations may take a tenth of their work."""
    for name in INTEGRATED:
        monkeypatch.setattr(case_class(name), "most_work", case_class(name).most_work // 10)
    yield
    certified._scout.cache_clear()
    certified._path.cache_clear()


@pytest.mark.usefixtures("_tenth")
def test_any_number_of_any_case_is_computed_or_refused_by_name() -> None:
    assert not wrong(random.Random(1).sample(EVERY, 20))


@pytest.mark.slow
@pytest.mark.parametrize("name", names())
def test_any_number_is_computed_or_refused_by_name(name: str) -> None:
    """A seeded eighth of all numbers; an error other than ValueError fails the test."""
    mine = [one for one in EVERY if one[0] == name]
    assert not wrong(random.Random(name).sample(mine, len(mine) // 8))


class BeginsError(Exception):
    """The integration that was not refused begins."""


def begins(*_: Any) -> None:
    raise BeginsError


def drawn(name: str, chance: random.Random) -> Callable[[], Case]:
    """A case of usual numbers, of which one to three (or the span) are anything from 1e-12 to 1e12, or 0."""
    kind = case_class(name)
    parameters, labels = [p.name for p in kind.parameter_list], [c.name for c in kind.state]
    numbers = kind.domain.draw([*parameters, *labels], chance.random)
    span = None
    for place in chance.sample([*parameters, *labels, "span"], chance.randint(1, 3)):
        value = 10 ** chance.uniform(-12, 12)
        if place == "span":
            span = value
        else:
            numbers[place] = value * chance.choice((1, 1, 1, -1, -1, 0))
    return lambda: get(
        name, initial_state=[numbers[x] for x in labels], span=span, **{p: numbers[p] for p in parameters}
    )


def refused_or_begun(name: str, draws: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(certified, "Path", begins)
    chance = random.Random(name)
    for _ in range(draws):
        make = drawn(name, chance)
        try:
            case = make().rounded()
            case.exact(case.times[-1])
        except BeginsError:
            continue
        except ValueError as refusal:
            told = str(refusal)
            assert told.startswith(f"{name}: ")
            assert " = " in told
            assert "\n" not in told


@pytest.mark.parametrize("name", INTEGRATED)
def test_an_integration_begins_or_is_refused_by_name_before_it_does(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    refused_or_begun(name, 2, monkeypatch)


@pytest.mark.slow
@pytest.mark.parametrize("name", INTEGRATED)
def test_each_of_many_integrations_begins_or_is_refused(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    refused_or_begun(name, 500, monkeypatch)


@pytest.mark.slow
@pytest.mark.parametrize("name", INTEGRATED)
def test_what_is_begun_takes_as_many_steps_as_was_counted(name: str) -> None:
    """The steps of a Taylor method are shares of the radius of convergence: steps of orders 7 and 30 are much alike."""
    for variant in (None, *(v.name for v in case_class(name).variants)):
        case = get(name, variant).rounded()
        motion = integrate(case)
        scout = certified.Scout(motion.rates, motion.start, False, motion.most_work)
        scout.reach(case.span)
        coarse = certified.Path(motion.rates, motion.start, certified.COARSE, False)
        coarse.value(case.span)
        assert certified.OVERRUN * scout.steps > len(coarse.series) > scout.steps / 4


@pytest.mark.slow
@pytest.mark.parametrize("name", FOUNDATION)
def test_any_two_numbers_are_computed_or_refused_by_name(name: str) -> None:
    """200 seeded pairs of extreme numbers of each case of the standard suite."""
    chance, kind = random.Random(name), case_class(name)
    labels = [coordinate.name for coordinate in kind.state]
    for _ in range(200):
        numbers = {place: chance.choice(WIDE) for place in chance.sample(list(places(name)), 2)}
        start = [numbers.get(n, x) for n, x in zip(labels, kind.default_state, strict=True)]
        parameters: dict[str, Any] = {n: x for n, x in numbers.items() if n not in (*labels, "span")}
        make = partial(get, name, initial_state=start, span=numbers.get("span"), **parameters)
        assert what_is_wrong(numbers, name, make) is None, numbers
