"""Hybrid cases: events, samples away from them, the metric at a jump, conditioning."""

import math
from fractions import Fraction

import mpmath
import numpy as np
import pytest
from gnomon.cases import Case, case_class, get
from gnomon.reference.numerics.precision import exact as exact_number

ALL = [
    (name, variant)
    for name in ("bouncing_ball", "block_incline_friction")
    for variant in (None, *(v.name for v in case_class(name).variants))
    if variant != "elastic_1e6"  # a million events take seconds to list, and `elastic` has elastic impacts too
]
every = pytest.mark.parametrize(("name", "variant"), ALL, ids=lambda x: x or "default")


@every
def test_samples_stay_away_from_every_event(name: str, variant: str | None) -> None:
    case = get(name, variant).rounded()
    if variant and variant.startswith("engines"):
        return  # engines are sampled at decimal times, which are fixed
    events = [0.0, *(float(event.time) for event in case.events(20))]
    gaps = np.diff(events)
    for event, before, after in zip(events[1:], gaps, [*gaps[1:], *gaps[-1:]], strict=True):
        assert np.min(np.abs(case.times - event)) >= 0.999e-3 * min(before, after)
    assert abs(case.times[-1] / float(case.span) - 1) < 1e-3


@every
def test_scales_are_the_largest_norms(name: str, variant: str | None) -> None:
    case = get(name, variant).rounded()
    end = float(case.times[-1])
    # too few to make a table of the motion
    early = np.linspace(0, min(end, 6 * case.time_scale), 250)[1:]
    states = np.abs(case.sample(np.union1d(np.linspace(0, end, 250)[1:], early)))
    for peak, scale in zip(states.max(axis=0), case.scales().values(), strict=True):
        assert peak <= scale * (1 + 1e-12)
        assert peak > 0.98 * scale or peak == 0  # samples miss the peaks slightly


def test_a_late_impact_is_a_small_error() -> None:
    """A motion that is 1e-3 s late at an impact has the error of 1e-3 s of motion, not of the velocity's jump."""
    case = get("bouncing_ball", e=1).rounded()
    first = float(case.quantities()["first_impact"])
    times = np.array([first - 1e-4, first + 3e-4, first + 0.2])
    late = case.sample(times - 1e-3)
    plain = np.max(list(case.metric.by_group(late, case.sample(times)).values()), axis=0)
    distance = case.metric.distance(late, case.sample(times))
    assert plain[1] > 1.9
    assert np.all(distance < 1e-3 * 4.5 * 1.5)  # the largest rate is u = 4.43 heights per second
    assert np.all(distance > 1e-3)


def test_a_state_below_the_plane_that_never_reaches_it_has_a_distance() -> None:
    case = get("bouncing_ball").rounded()
    exact = case.sample(case.times)
    assert np.all(np.isfinite(case.metric.distance(exact - [10.0, 0.0], exact)))


def test_only_position_is_scored_at_crowded_times() -> None:
    limit = get("bouncing_ball", "zeno").rounded().quantities()["t_inf"]
    case = get("bouncing_ball", e="0.999", span=float(limit) * (1 - 2.0**-30)).rounded()
    times = case.times
    assert len(case.metric.crowded) == 1
    assert times[-1] in case.metric.crowded
    exact = case.sample(times)
    wrong = exact + np.array([0.0, 0.5])
    assert case.metric.distance(wrong, exact, times)[-1] == 0
    assert case.metric.distance(wrong, exact, times)[0] > 0.01
    assert case.metric.distance(wrong, exact)[-1] > 0.01
    assert not get("bouncing_ball").rounded().metric.crowded


@pytest.mark.parametrize(("variant", "held"), [("limit_above", True), ("limit_below", False)])
def test_one_double_decides_whether_the_block_holds(variant: str, held: bool) -> None:
    case = get("block_incline_friction", variant).rounded()
    mu_s = float(case.parameters["mu_s"])
    with mpmath.workdps(40):
        tangent = mpmath.tan(mpmath.mpf(float(case.parameters["alpha"])))
        assert (mpmath.mpf(mu_s) > tangent) == held
        other = math.nextafter(mu_s, 0 if held else 1)
        assert (mpmath.mpf(other) > tangent) != held
    assert (case.exact(case.span)[1] == 0) == held
    hybrid = case.hybrid
    assert hybrid is not None
    parameters = tuple(map(float, case.parameter_values()))
    stop = hybrid.transitions[0]
    assert stop.lands(1.0, (1.0, 0.0), parameters) == ("stick" if held else "down")
    assert stop.lands(1.0, (1.0, 0.0), tuple(map(mpmath.mpf, parameters))) == ("stick" if held else "down")
    # a rounding across the limit gives another motion, which does not measure conditioning
    assert case.conditioning(case.times).max() < 1e-14


def test_quantities_of_the_ball() -> None:
    found = get("bouncing_ball", "before_limit").quantities(30)
    assert (found["t_inf"], found["first_impact"], found["bounces"]) == (7, 1, 48)
    assert get("bouncing_ball").quantities()["bounces"] == mpmath.inf
    assert "t_inf" not in get("bouncing_ball", "elastic").quantities()
    zeno = get("bouncing_ball", "zeno").events(30)
    assert sorted(zeno, key=lambda event: event.time) == [*zeno]
    assert (zeno[-1].name, zeno[-1].after) == ("limit", (0, 0))
    tenth = [event.time for event in get("bouncing_ball", "engines_e08").events(30)]
    assert len(tenth) == 10


def test_the_elastic_ball_retraces_its_motion() -> None:
    case: Case = get("bouncing_ball", e=1, initial_state=(1, 2))
    t = Fraction(41, 7)
    there = case.reversed([exact_number(x) for x in case.exact(t, 40)])
    assert there is not None
    back = case.with_numbers(*there).exact(t, 40)
    assert abs(back[0] - 1) < 1e-36
    assert abs(back[1] + 2) < 1e-36
    assert get("bouncing_ball").reversed((1, 2)) is None


def test_the_torque_is_the_rate_of_moment_of_momentum_about_both_points() -> None:
    """About a point at rest it is r x F; about the accelerated support its acceleration enters (6.10)."""
    case = get("moment_of_momentum_pendulum", span=3)
    with mpmath.workdps(60):
        g, length, ax, ay = (mpmath.mpf(v.numerator) / v.denominator for v in case.parameter_values())

    def motion(t: mpmath.mpf) -> tuple[mpmath.mpf, ...]:
        """Position and velocity of the bob in space, its arm, and the components x and y of the tension."""
        theta, omega = case.exact(t, 50)
        s, c = mpmath.sin(theta), mpmath.cos(theta)
        arm, swing = (length * s, -length * c), (length * omega * c, length * omega * s)
        place = (arm[0] + ax * t**2 / 2, arm[1] + ay * t**2 / 2)
        return (*place, swing[0] + ax * t, swing[1] + ay * t, *arm, *swing)

    with mpmath.workdps(60):
        t, h = mpmath.mpf("1.3"), mpmath.mpf("1e-20")

        def fixed(time: mpmath.mpf) -> mpmath.mpf:
            x, y, vx, vy, *_ = motion(time)
            return x * vy - y * vx

        def carried(time: mpmath.mpf) -> mpmath.mpf:
            *_, u, w, su, sw = motion(time)
            return u * sw - w * su

        x, y, _vx, _vy, u, w, *_ = motion(t)
        before, after = motion(t - h), motion(t + h)
        acceleration = [(b - a) / (2 * h) for a, b in zip(before[2:4], after[2:4], strict=True)]
        pull = (acceleration[0], acceleration[1] + g)  # tension of the rod over the mass
        about_rest = (fixed(t + h) - fixed(t - h)) / (2 * h)
        assert abs(about_rest - (x * pull[1] - y * pull[0] - x * g)) < mpmath.mpf("1e-25")
        about_support = (carried(t + h) - carried(t - h)) / (2 * h)
        # the rod's tension passes through the support
        assert abs(u * pull[1] - w * pull[0]) < mpmath.mpf("1e-25")
        assert abs(about_support - (-u * g - (u * ay - w * ax))) < mpmath.mpf("1e-25")
