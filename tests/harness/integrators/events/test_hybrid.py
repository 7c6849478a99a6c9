"""Events located by the step length: to round-off, in the right sequence, with the order of the method kept."""

import math
from math import sin
from typing import Any

import mpmath
import numpy as np
import pytest
from gnomon.cases import get
from gnomon.cases.core.forms import Hybrid, Mode, Transition, Values
from gnomon.harness.adapters import scipy_events
from gnomon.harness.contract.integrator import Integrator, Problem, Refused, Solution
from gnomon.harness.contract.problem import problem_of
from gnomon.harness.integrators.events.event_location import ERROR_3, ERROR_5, EventData, step_error
from gnomon.harness.integrators.events.hybrid import Dop853Events, EulerEvents, RK4Events
from gnomon.harness.measuring.events import score_events
from gnomon.reference.numerics.precision import exact
from gnomon.reference.pendulums.pendulum_simple import Pendulum
from on_cases import exact_states, solved

BALL = [None, "before_limit", "dead", "upward", "from_plane", "engines_e1", "engines_e08"]
BLOCK = [
    None, "holds", "limit_above", "limit_below", "gap", "rest_slides", "rest_sticks", "thrown_down", "end_stop",
    "engines_stop", "engines_slide", "engines_stick",
]  # fmt: skip
VARIANTS = [("bouncing_ball", v) for v in BALL] + [("block_incline_friction", v) for v in BLOCK]
EXACT_METHODS = [RK4Events, Dop853Events, scipy_events.RK45, scipy_events.DOP853, scipy_events.Radau]
"""Methods that integrate a constant acceleration exactly: their error is the error of the events."""

RESTITUTION = 0.75


def swing(t: Any, state: Values, parameters: Values) -> Values:
    theta, omega = state
    (stiffness,) = parameters
    return omega, -stiffness * sin(theta)


def height(t: Any, state: Values, parameters: Values) -> Values:
    return (state[0],)


def rebound_from_wall(t: Any, state: Values, parameters: Values) -> Values:
    theta, omega = state
    return theta, -3 * omega / 4


def swinging(t: Any, state: Values, parameters: Values) -> str:
    return "swing"


WALL = Hybrid(
    modes=(Mode("swing", swing),),
    start=swinging,
    transitions=(Transition("knock", "swing", height, -1, rebound_from_wall, swinging),),
    settle=1e-9,
)
"""A pendulum that hits a wall at the bottom of its swing and keeps 3/4 of its speed."""

START = np.array([[1.0, 0.25]])
TIMES = np.arange(1, 65) / 8
PROBLEM = Problem(WALL, 2, np.array([1.0]), TIMES, 1.0)


def knocks() -> tuple[np.ndarray, list[float]]:
    """Exact states and event times: half swings of pendulums, each released from the wall by the one before."""
    states, events = [], []
    motion = Pendulum(exact(1), exact(1), exact(1.0), exact(0.25))
    with mpmath.workdps(40):
        # to the top of the first swing, then a quarter: found by bisection on the exact motion
        low, high = mpmath.mpf(1), mpmath.mpf(3)
        for _ in range(120):
            middle = (low + high) / 2
            low, high = (middle, high) if motion.state(middle, 35)[0] > 0 else (low, middle)
        begin, end = mpmath.mpf(0), low
        for t in map(mpmath.mpf, TIMES.tolist()):
            while t >= end:
                omega = -mpmath.mpf(3) / 4 * motion.state(end - begin, 35)[1]
                events.append(float(end))
                motion = Pendulum(exact(1), exact(1), exact(0), exact(omega))
                begin, end = end, end + motion.period(35) / 2
            states.append([float(x) for x in motion.state(t - begin, 35)])
    return np.array(states), events


EXACT, KNOCKS = knocks()


def errors(kind: type[Integrator], setting: float) -> tuple[float, float, Solution]:
    """Largest error of a state and of an event time."""
    solution = kind().prepare(PROBLEM, setting)(START)
    events = solution.events or ()
    assert [name for _, name in events] == ["knock"] * len(KNOCKS)
    late = max(abs(t - true) for (t, _), true in zip(events, KNOCKS, strict=True))
    return float(np.abs(solution.states[0] - EXACT).max()), late, solution


@pytest.mark.parametrize(("kind", "coarsest"), [(EulerEvents, 2**-9), (RK4Events, 2**-3)])
def test_the_order_survives_events_in_a_curved_motion(kind: type[EulerEvents], coarsest: float) -> None:
    """Slope of the error of states and of event times over 5 halvings of the step."""
    steps = coarsest / 2.0 ** np.arange(5)
    found = np.array([errors(kind, float(h))[:2] for h in steps])
    for column in found.T:
        slope = np.polyfit(np.log(steps), np.log(column), 1)[0]
        assert abs(slope - kind.order) < 0.1


@pytest.mark.parametrize("kind", [Dop853Events, scipy_events.DOP853])
def test_events_of_a_curved_motion_are_located_to_the_tolerance(kind: type[Integrator]) -> None:
    """4 impacts and some 60 steps of an error of 1e-12 each."""
    state, late, _ = errors(kind, 1e-12)
    assert state < 1e-10
    assert late < 1e-10


def test_round_off_is_reached_at_an_impact() -> None:
    state, late, _ = errors(Dop853Events, 1e-14)
    assert late < 8 * np.spacing(8.0)  # a few ulps of the last time
    assert state < 1e-14


def rows() -> list[Any]:
    """Every method on every variant; in `make test` the variants with one method for each of the two ways to find events."""
    one_each = (RK4Events, scipy_events.RK45)
    return [
        pytest.param(
            kind,
            *variant,
            id=f"{kind.library}-{kind.name}-{'-'.join(map(str, variant))}",
            marks=() if kind in one_each or variant[1] is None else pytest.mark.slow,
        )
        for kind in EXACT_METHODS
        for variant in VARIANTS
    ]


@pytest.mark.parametrize(("kind", "name", "variant"), rows())
def test_reproduces_the_exact_events(name: str, variant: str | None, kind: type[Integrator]) -> None:
    """The motion between events is a parabola, exact for these methods: only round-off remains.

    Round-off of up to 2000 steps and 100 events, as a random walk about 100 ulp; SciPy's interpolants add theirs.
    """
    case = get(name, variant).rounded()
    found = solved(kind(), case, steps=4)
    score = score_events(found.events, case.events())
    assert (score.missing, score.extra) == (0, 0)
    assert found.error < 1e-12
    assert score.time_error < 1e-12 * float(case.span)


@pytest.mark.parametrize("variant", [None, "masse", "almost_rolling"])
@pytest.mark.parametrize("kind", EXACT_METHODS, ids=lambda kind: f"{kind.library}-{kind.name}")
def test_a_slip_whose_direction_is_lost_where_it_ends_leaves_no_trace(
    variant: str | None, kind: type[Integrator]
) -> None:
    """The sliding is a parabola too; its end is known to the root of round-off, and the rest to round-off.

    At the end of the slip s the direction errs by an ulp of the velocity over s: the guard is noise below its root.
    """
    case = get("billiard_ball", variant).rounded()
    found = solved(kind(), case, steps=4)
    assert found.error < 1e-12
    assert score_events(found.events, case.events()).time_error < 1e-8 * float(case.span)


def test_twenty_thousand_impacts_up_to_the_limit() -> None:
    """Within ten times the conditioning, the effect of half an ulp in each number on the motion."""
    case = get("bouncing_ball", "zeno").rounded()
    found = solved(RK4Events(), case, steps=1)
    score = score_events(found.events, case.events())
    assert (score.missing, score.extra) == (0, 0)
    assert score.time_error < 1e-10
    assert case.metric.distance(found.states, exact_states(case)).max() < 1e-9
    assert np.all(found.states[case.times > float(case.quantities()["t_inf"])] == 0)


@pytest.mark.parametrize("kind", [RK4Events, scipy_events.RK45])
def test_one_flight_or_many_within_a_step(kind: type[Integrator]) -> None:
    """Steps of a whole sampling interval contain several flights near the limit; none may fall through the plane."""
    case = get("bouncing_ball", span="4.5", e="0.3").rounded()
    found = solved(kind(), case, 1e-3, steps=1)
    assert found.states.min() >= -5.0  # velocities
    assert found.states[:, 0].min() >= 0
    assert found.events[-1][1] == "limit"


@pytest.mark.parametrize("kind", [RK4Events, Dop853Events, scipy_events.RK45])
def test_right_hand_sides_are_counted(kind: type[Integrator]) -> None:
    found = solved(kind(), get("bouncing_ball").rounded(), 1e-3, steps=1, counted=True)
    assert found.calls > 97 * 4  # each event needs steps of its own


def oscillate(t: Any, state: Values, parameters: Values) -> Values:
    x, v = state
    return v, -x


def near_wall(t: Any, state: Values, parameters: Values) -> Values:
    return (state[0] + parameters[0],)


def rebound(t: Any, state: Values, parameters: Values) -> Values:
    """From where it was found, a rounding to this side of the wall or to the other."""
    x, v = state
    return x, -v


GRAZED = Hybrid(
    modes=(Mode("swing", oscillate),),
    start=swinging,
    transitions=(Transition("graze", "swing", near_wall, -1, rebound, "swing"),),
    settle=1e-9,
)
"""x'' = -x released at x = 1 with an elastic wall at x = -w: it is met at 1, 3, 5, ... times arccos(-w)."""


@pytest.mark.parametrize("depth", [1e-2, 1e-4, 1e-6, -1e-6, -1e-2])
@pytest.mark.parametrize(("kind", "setting", "error"), [(RK4Events, 2.0**-5, 2e-8), (Dop853Events, 1e-10, 1e-10)])
def test_a_wall_that_is_only_grazed_within_a_step_is_met(
    kind: type[Integrator], setting: float, error: float, depth: float
) -> None:
    """A step goes from one side of the dip to the other: at both its ends the guard is positive.

    Beyond the turning point, at a negative depth, nothing happens. An `error` of the state, as it is at that step or
    tolerance, moves the time by error over speed, error / sqrt(2 depth), twice at each rebound.
    """
    problem = Problem(GRAZED, 2, np.array([1 - depth]), TIMES * 4, 1.0)
    solution = kind().prepare(problem, setting)(np.array([[1.0, 0.0]]))
    times = np.array([time for time, _ in solution.events or ()])
    with mpmath.workdps(30):
        first = float(mpmath.acos(mpmath.mpf(problem.parameters[0]) * -1)) if depth > 0 else np.inf
    wanted = [(2 * n + 1) * first for n in range(9) if (2 * n + 1) * first <= problem.times[-1]]
    assert len(times) == len(wanted)
    if wanted:
        assert np.all(np.abs(times - wanted) < error / np.sqrt(2 * depth) * (2 * np.arange(len(wanted)) + 1))


def run_on(t: Any, state: Values, parameters: Values) -> Values:
    return (1 + 0 * state[0],)


def notch(t: Any, state: Values, parameters: Values) -> Values:
    u = 8 * (state[0] - parameters[0])
    return (u * u * u * u - 1 / 16384,)


def away(t: Any, state: Values, parameters: Values) -> Values:
    return (state[0] + 10,)


@pytest.mark.parametrize("where", [0.3, 0.5, 0.7])
def test_a_dip_far_from_a_cubic_is_found(where: float) -> None:
    """A guard below zero on 1/45 of a step, about `where`: the cubic from its slopes at the ends has its minimum elsewhere,
    and the bracket must close from both sides. A uniform motion is integrated exactly."""
    transition = Transition("notch", "on", notch, -1, away, "on")
    form = Hybrid((Mode("on", run_on),), lambda t, state, parameters: "on", (transition,), settle=1e-9)
    problem = Problem(form, 1, np.array([where]), np.array([1.0]), 1.0)
    solution = RK4Events().prepare(problem, 1.0)(np.array([[0.0]]))
    ((time, name),) = solution.events or ()
    width = (1 / 16384) ** 0.25 / 8
    assert name == "notch"
    assert time == pytest.approx(where - width, abs=1e-15)


def fall(t: Any, state: Values, parameters: Values) -> Values:
    x, v = state
    return v, 0 * x - 1


def height_over_ten(t: Any, state: Values, parameters: Values) -> Values:
    return (state[0] - 10,)


def onto_the_floor(t: Any, state: Values, parameters: Values) -> Values:
    x, v = state
    return 0 * x, v


def back_from_the_floor(t: Any, state: Values, parameters: Values) -> Values:
    x, v = state
    return 0 * x, -v


@pytest.mark.parametrize("kind", [RK4Events, Dop853Events])
def test_a_guard_of_the_next_mode_that_is_zero_on_arrival_counts(kind: type[Integrator]) -> None:
    """A ball falls 1/2 m and is put on the floor, height 0, in another mode with the same floor. Thrown back it lands again
    2 s after the first second; if it keeps falling it meets the floor at once. A line above is not met."""
    for reset, wanted in ((back_from_the_floor, [1.0, 3.0]), (onto_the_floor, [1.0, 1.0])):
        form = Hybrid(
            modes=(Mode("first", fall), Mode("second", fall), Mode("third", fall)),
            start=lambda t, state, parameters: "first",
            transitions=(
                Transition("floor", "first", height, -1, reset, "second"),
                Transition("again", "second", height, -1, onto_the_floor, "third"),
                *(
                    Transition(f"{mode} line", mode, height_over_ten, -1, onto_the_floor, "third")
                    for mode in ("first", "second", "third")
                ),
            ),
            settle=1e-9,
        )  # fmt: skip
        problem = Problem(form, 2, np.zeros(0), np.arange(1, 9) / 2, 1.0)
        solution = kind().prepare(problem, 2.0**-4 if kind is RK4Events else 1e-9)(np.array([[0.5, 0.0]]))
        times, names = zip(*solution.events or (), strict=True)
        assert names == ("floor", "again")
        assert times == pytest.approx(wanted, abs=1e-12)


def test_several_trajectories_are_independent_and_keep_their_starts() -> None:
    case = get("bouncing_ball").rounded()
    problem = problem_of(case, (Hybrid,))
    starts = np.array([[1.0, 0.0], [2.0, 1.0]])
    solve = RK4Events().prepare(problem, problem.interval)
    both, second = solve(starts.copy()), solve(starts[1:].copy())
    assert np.array_equal(both.states[1], second.states[0])
    other = get("bouncing_ball", initial_state=(2, 1), span=case.span).rounded()
    assert np.abs(both.states[1] - other.sample(case.times))[:20].max() < 1e-12


def test_a_motion_that_diverges_is_reported() -> None:
    case = get("bouncing_ball").rounded()
    problem = problem_of(case, (Hybrid,))
    solution = RK4Events().prepare(problem, problem.interval)(np.array([[1e308, 1e308]]))
    assert "not finite" in str(solution.stopped)
    assert np.isnan(solution.states).any()


@pytest.mark.parametrize("setting", [0.0, -1.0])
def test_impossible_settings_are_refused(setting: float) -> None:
    with pytest.raises(Refused):
        scipy_events.RK45().prepare(PROBLEM, setting)


@pytest.mark.parametrize("dimension", [1, 3])
@pytest.mark.parametrize("ratio", [0.0, 10.0, -20.0])
def test_the_estimates_of_dop853_are_combined_as_its_authors_do(dimension: int, ratio: float) -> None:
    """|h| e5^2 / sqrt((e5^2 + 0.01 e3^2) n), in norms over n scaled components (dop853.f): e3 ten times e5 halves it."""

    def estimate(third: float, size: int) -> float:
        table = np.zeros((ERROR_3 + 1, 3))
        table[ERROR_5, 1:], table[ERROR_3, 1:] = (1e-9, 2e-9), (third * 1e-9, third * 2e-9)
        none = np.empty(0)
        data = EventData(0, none, none, table, 2, none, np.ones((2, size)), none, none, none)
        return step_error(data, 0.5, np.ones(size))

    assert estimate(ratio, dimension) == pytest.approx(estimate(0.0, 1) / np.sqrt(1 + 0.01 * ratio**2))


def third_of_height(t: Any, state: Values, parameters: Values) -> Values:
    return (state[0] / 3 - 1 / 3,)


@pytest.mark.parametrize("height_of_fall", [0.3, 0.7, 1.1, 1.9])
def test_a_flight_that_starts_a_rounding_below_the_floor_ends_on_it(height_of_fall: float) -> None:
    """Flights of one to four seconds, each a parabola, which the method follows exactly, and several within a step."""
    transition = Transition("floor", "flight", third_of_height, -1, rebound, "flight")
    form = Hybrid((Mode("flight", fall),), lambda t, state, parameters: "flight", (transition,), settle=1e-9)
    problem = Problem(form, 2, np.zeros(0), np.arange(1, 5) * 16.0, 1.0)
    solution = RK4Events().prepare(problem, 16.0)(np.array([[1 + height_of_fall, 0.0]]))
    times = [time for time, _ in solution.events or ()]
    half = math.sqrt(2 * height_of_fall)
    assert len(times) == 1 + int((64 / half - 1) // 2)
    assert times == pytest.approx((half * (1 + 2 * np.arange(len(times)))).tolist(), abs=1e-9)
