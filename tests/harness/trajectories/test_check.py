"""`gnomon check`: errors are those that an independent computation gives, and nothing that was not checked passes."""

import json
import math
import re
import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from command_line import gnomon as command
from gnomon.harness.system import extras
from gnomon.harness.trajectories import check_report
from gnomon.harness.trajectories.columns import states_of
from gnomon.harness.trajectories.comparison import compare
from motion_files import WRITERS, Floats, accurate, as_csv, euler, integrated, leapfrog, midpoint, orbit, pendulum, rk4

import gnomon

SWING, ORBIT = gnomon.case("pendulum_simple"), gnomon.case("kepler_orbit")
METHODS: dict[str, tuple[Callable[..., Floats], float, int]] = {
    "Euler": (euler, 0.001, 20),
    "midpoint": (midpoint, 0.005, 10),
    "RK4": (rk4, 0.02, 4),
    "leapfrog": (leapfrog, 0.004, 10),
}
"""Method, step (s), steps between two rows."""
RIGHT = [
    (method, system, form)
    for number, method in enumerate(METHODS)
    for system, forms in (("pendulum", ("csv", "spreadsheet", "npz")), ("orbit", ("fortran", "json lines", "mat")))
    for form in (forms if number % 2 else forms[::-1])[:3]
]


@pytest.mark.parametrize(("method", "system", "form"), RIGHT, ids=lambda each: each)
def test_the_error_of_a_right_file_is_the_one_that_an_independent_solution_gives(
    method: str, system: str, form: str, tmp_path: Path
) -> None:
    """Twenty-four files: four methods, two systems, six formats. The bound just above the error passes, just
    below fails; none of the mistakes that people make is named."""
    case, rates, names = (
        (SWING, pendulum, ("theta", "omega")) if system == "pendulum" else (ORBIT, orbit, ("x", "y", "vx", "vy"))
    )
    step, h, every = METHODS[method]
    times, states = integrated(step, rates, case.start.tolist(), h, 60, every)
    ending, write, needs = WRITERS[form]
    pytest.importorskip(needs)
    write(tmp_path / f"a{ending}", {"t": times, **dict(zip(names, states.T, strict=True))})
    found = gnomon.check(case, tmp_path / f"a{ending}")
    assert found.comparison is not None
    true = states - accurate(rates, case.start.tolist(), times)
    assert np.allclose(found.comparison.differences, true, atol=1e-9)
    assert found.error > 1e-9
    assert found.within(1.01 * found.error)
    assert not found.within(0.99 * found.error)
    assert not found.comparison.limits
    if form in ("csv", "fortran"):  # the states are those of the other formats
        assert not found.causes, "plain integration error has no other cause"


def test_a_file_of_a_simulator_with_seven_digits(tmp_path: Path) -> None:
    """Explicit Euler of 1 ms, every 50th row, names with dots: the worst angle and its time, and an error far above its digits."""
    times, states = integrated(euler, pendulum, [2, 0], 0.001, 100, 50)
    rows = [f"{t:.7g},{a:.7g},{b:.7g}" for t, (a, b) in zip(times.tolist(), states.tolist(), strict=True)]
    (tmp_path / "fmu.csv").write_text("\n".join(["time,pendulum.phi,pendulum.w", *rows]))
    found = gnomon.check("pendulum_simple", tmp_path / "fmu.csv", columns="phi=theta,w=omega").comparison
    assert found is not None
    right = accurate(pendulum, [2, 0], times)[:, 0]
    worst = int(np.argmax(np.abs(states[:, 0] - right)))
    error, place = found.largest["theta"]
    assert (abs(error), found.times[place]) == (
        pytest.approx(abs(states[worst, 0] - right[worst]), abs=1e-6),
        times[worst],
    )
    assert 1e-7 < found.digits_effect < 1e-6
    assert not found.limits


@pytest.mark.parametrize("digits", [5, 8, 11])
def test_the_digits_of_a_file_that_limit_its_result_are_told(digits: int, tmp_path: Path) -> None:
    """An exact motion that is printed with few digits has an error, which is theirs."""
    times = 0.05 * np.arange(80)
    np.savetxt(
        tmp_path / "a.csv",
        np.column_stack([times, SWING.sample(times)]),
        f"%.17g,%.{digits}f,%.{digits}f",
        header="t,theta,omega",
        comments="",
    )
    found = gnomon.check(SWING, tmp_path / "a.csv").comparison
    assert found is not None
    assert 0.1 * found.digits_effect < found.error <= found.digits_effect
    assert any("digits of the file" in limit for limit in found.limits)


def test_rounded_time_stamps_that_limit_the_result_are_told(tmp_path: Path) -> None:
    times = np.arange(90) / 30
    rows = [f"{t:.3f},{a!r},{b!r}" for t, (a, b) in zip(times.tolist(), SWING.sample(times).tolist(), strict=True)]
    (tmp_path / "a.csv").write_text("\n".join(["t,theta,omega", *rows]))
    found = gnomon.check(SWING, tmp_path / "a.csv").comparison
    assert found is not None
    assert found.error > 1e-4
    assert any("digits of the times" in limit for limit in found.limits)


# Phase, period, drift


@pytest.mark.parametrize("late", [1e-7, 1e-4, -1e-4])
def test_a_motion_that_is_late_has_that_phase_and_no_wrong_shape(late: float) -> None:
    times = np.linspace(0.2, 10, 200)
    found = gnomon.check(SWING, times, SWING.sample(times - late)).comparison
    assert found is not None
    assert found.latest is not None
    assert found.latest[1] == pytest.approx(late, rel=1e-3)
    assert found.phase_and_shape is not None
    assert found.phase_and_shape[1] < 1e-3 * found.phase_and_shape[0]


@pytest.mark.parametrize("longer", [1e-8, 1e-5, 0.01])
def test_the_fitted_period_is_the_one_that_the_motion_has(longer: float) -> None:
    """Within its own margin, for errors that are small and for errors of the whole size."""
    times = np.linspace(0, 26, 800)
    found = gnomon.check(SWING, times, SWING.sample(times / (1 + longer))).comparison
    assert found is not None
    assert found.period is not None
    right = float(SWING.quantities(17)["period"]) * (1 + longer)
    assert found.period.exact == pytest.approx(right / (1 + longer), rel=1e-14)
    assert abs(found.period.found - right) <= max(found.period.margin, 1e-12)
    assert found.period.margin < 0.2 * longer * right


def test_the_drift_of_an_invariant_is_its_own() -> None:
    """A swing whose speed is too large by a share has the kinetic energy of that share, and no other drift counts."""
    times = np.linspace(0, 10, 300)
    states = SWING.sample(times) * [1, 1.001]
    found = gnomon.check(SWING, times, states).comparison
    assert found is not None
    kinetic, whole = 0.5 * np.max(SWING.sample(times)[:, 1] ** 2), 2 * 9.81 * math.sin(1) ** 2
    assert found.drifts["energy"][0] == pytest.approx((1.001**2 - 1) * kinetic / whole, rel=1e-6)


# Events

BALL = gnomon.case("bouncing_ball", e="0.9")
ROWS = np.linspace(0, 2.2, 221)


def bounces(states: Floats, times: Floats = ROWS) -> Any:
    found = gnomon.check(BALL, times, states).comparison
    assert found is not None
    assert found.events is not None
    return found.events


@pytest.mark.parametrize(
    "name",
    ["bouncing_ball", "bouncing_ball_incline", "stick_slip_belt", "coulomb_friction_oscillator", "impact_oscillator",
     "planet_tunnel", "newtons_cradle", "rocking_block", "exploding_projectile"],
)  # fmt: skip
def test_the_events_of_a_right_motion_are_all_found(name: str) -> None:
    """And no others: impacts, sticking, borders, a burst; up to the time from which they follow faster than the rows."""
    case = gnomon.case(name)
    times = np.linspace(0, case.times[-1], 128)
    found = gnomon.check(case, times, case.sample(times)).comparison
    assert found is not None
    events = found.events
    assert events is not None
    assert not events.missed
    assert not events.extra
    exact = [float(event.time) for event in case.case.events() if event.time <= events.until and event.name != "limit"]
    assert [time for time, _, _ in events.late] == exact
    assert events.latest is not None
    assert abs(events.latest[1]) < 1e-6 * case.case.time_scale
    assert events.until == times[-1] or "are not told" in str(gnomon.check(case, times, case.sample(times)))


def test_late_events_are_late_by_as_much() -> None:
    """The same motion 3 ms later: after the first bounce all times are later."""
    late = np.where(ROWS > 0.02, np.maximum(ROWS - 0.003, 0.0), 0.0)
    found = bounces(BALL.sample(late))
    assert [seconds for _, seconds, _ in found.late] == pytest.approx([0.003] * len(found.late), abs=1e-6)
    assert found.late


def test_a_ball_that_falls_through_the_plane_misses_its_bounce() -> None:
    times = np.linspace(0, 0.8, 81)
    fallen = np.column_stack([1 - 9.81 / 2 * times**2, -9.81 * times])
    found = bounces(fallen, times)
    assert [name for _, name in found.missed] == ["bounce"]
    assert not found.late


def test_a_ball_that_bounces_in_the_air_has_an_extra_event() -> None:
    times = np.linspace(0, 0.44, 45)
    states = BALL.sample(times)
    bounced = times > 0.295
    height, speed = 1 - 9.81 / 2 * 0.295**2, 0.9 * 9.81 * 0.295
    since = times[bounced] - 0.295
    states[bounced] = np.column_stack([height + speed * since - 9.81 / 2 * since**2, speed - 9.81 * since])
    found = bounces(states, times)
    assert [name for _, name in found.extra] == ["bounce"]
    assert found.extra[0][0] == pytest.approx(0.295, abs=0.01)


# Not checked

UNCHECKED: dict[str, tuple[Callable[[Floats, Floats], tuple[Floats, Floats]], str]] = {
    "one row": (lambda t, y: (t[:1], y[:1]), "only one row"),
    "no rows": (lambda t, y: (t[:0], y[:0]), "no rows"),
    "only the start": (lambda t, y: (np.linspace(0, 0.01, 9), SWING.sample(np.linspace(0, 0.01, 9))), "only the start"),
    "falling": (lambda t, y: (t[[0, 2, 1]], y[[0, 2, 1]]), "row 3 is earlier"),
    "repeated": (lambda t, y: (t[[0, 1, 1]], y[[0, 1, 1]]), "row 3 is repeated"),
    "nan": (lambda t, y: (t, np.where(np.arange(len(t))[:, None] == 4, np.nan, y)), "row 5"),
    "infinite": (lambda t, y: (t, np.where(np.arange(len(t))[:, None] == 4, np.inf, y)), "row 5"),
    "time nan": (lambda t, y: (np.where(np.arange(len(t)) == 4, np.nan, t), y), "row 5"),
    "sparse": (lambda t, y: (t[::30], y[::30]), "--sparse"),
}


@pytest.mark.parametrize("kind", UNCHECKED)
def test_what_was_not_checked_is_no_pass(kind: str) -> None:
    """Each of these rows is exact, so that only the reason can keep them from passing."""
    change, reason = UNCHECKED[kind]
    times = np.linspace(0, 20, 200)
    found = gnomon.check(SWING, *change(times, SWING.sample(times)), within=0.1)
    assert found.verdict.code == 2
    assert not found.within({"theta": 0.1})
    assert "not checked" in str(found).splitlines()[-1]
    assert reason in found.verdict.text


def test_less_than_the_wanted_span_is_not_checked() -> None:
    times = np.linspace(1, 5, 80)
    states = SWING.sample(times)
    assert gnomon.check(SWING, times, states, within=1e-9, span=(1, 5)).verdict.code == 0
    assert gnomon.check(SWING, times, states, within=1e-9, span=(None, 5.1)).verdict.code == 2
    assert gnomon.check(SWING, times, states, within=1e-9, span=(0.9, None)).verdict.code == 2


@pytest.mark.parametrize(
    ("rows", "span", "told"),
    [
        (slice(0, 20), (None, None), "from t = 0 s to 3.8 s of the span of 20 s"),
        (slice(30, None), (None, None), "from t = 6 s to 20 s of the span of 20 s"),
        (slice(30, None), (None, 20), "from t = 6 s to 20 s of the span of 20 s"),
        (slice(0, 20), (None, 3.8), None),
        (slice(30, 60), (6, 11.8), None),
        (slice(None), (None, None), None),
        (slice(1, -1), (None, None), None),
    ],
)
def test_a_pass_says_which_part_of_the_span_the_rows_leave_out_unasked(
    rows: slice, span: tuple[float | None, float | None], told: str | None
) -> None:
    """A solver that stopped early is within the bound where it came; a program may leave out the first row or the last."""
    swing = gnomon.case("pendulum_simple", span=20)
    times = np.linspace(0, 20, 101)[rows]
    found = gnomon.check(swing, times, swing.sample(times), within=1e-9, span=span)
    assert found.verdict
    assert (told in found.verdict.text) if told else ("only" not in found.verdict.text)
    assert check_report.as_dictionary(found)["is_part"] == bool(told)
    turns = (times[-1] - times[0]) / float(SWING.quantities(17)["period"])
    assert f", {turns:.3g} periods of " in str(found)


@pytest.mark.parametrize("name", ["vertical_quadratic_drag", "block_incline_friction"])
def test_the_time_of_a_return_is_not_a_period(name: str) -> None:
    case = gnomon.case(name)
    assert "return_time" in case.quantities(17)
    assert "return" not in str(gnomon.check(case, case.times, case.sample(case.times)))


def test_whole_turns_of_an_angle_do_not_count_and_are_told() -> None:
    times = np.linspace(0, 20, 201)
    states = SWING.sample(times)
    assert "modulo" not in str(gnomon.check(SWING, times, states + 1e-3, within=1))
    states[times >= 5, 0] += 4 * math.pi
    found = gnomon.check(SWING, times, states, within=1e-9)
    assert found.verdict
    assert "modulo 2 pi; +12.6 rad at t = 5 s with whole turns" in str(found)
    states[:, 0] += 3.2 - 4 * math.pi * (times >= 5)  # less than a whole turn, but the shorter way round is the other
    found = gnomon.check(SWING, times, states)
    assert found.comparison is not None
    assert found.comparison.largest["theta"][0] == pytest.approx(3.2 - 2 * math.pi)
    assert found.comparison.with_turns["theta"][0] == pytest.approx(3.2)


def test_an_error_without_a_known_cause_is_told_as_such() -> None:
    """Of the method, not of a file that is right, lacks digits, or has a cause."""
    told = "no common mistake"
    times, states = integrated(euler, pendulum, [2, 0], 0.01, 400, 1)
    assert told in str(gnomon.check(SWING, times, states, within=1e-6))
    assert told not in str(gnomon.check(SWING, times, states, within=10))
    assert told not in str(gnomon.check(SWING, times, np.degrees(SWING.sample(times)), within=1e-6))
    assert told not in str(gnomon.check(SWING, times, SWING.sample(times)))


def test_rows_outside_the_wanted_span_do_not_count() -> None:
    times = np.linspace(0, 5, 101)
    states = SWING.sample(times)
    states[times > 4] += 1
    states[times < 1] += 1
    assert not gnomon.check(SWING, times, states).within({"theta": 0.01})
    assert gnomon.check(SWING, times, states, span=(1, 4)).within(1e-12)


def test_rows_are_sorted_and_gaps_accepted_on_request() -> None:
    times = np.linspace(0, 20, 200)
    states = SWING.sample(times)
    assert gnomon.check(SWING, times[::-1], states[::-1], accept=["unsorted"]).within(1e-12)
    assert gnomon.check(SWING, times[::30], states[::30], accept=["sparse"]).within(1e-12)
    assert gnomon.check(SWING, times[::30], 2 * states[::30], within=0.1).verdict.code == 1, "an error is an error"


def test_the_two_rows_of_an_event_are_both_right() -> None:
    """Modelica tools write the state before and after an event with one time."""
    event = BALL.case.events()[0]
    time = float(event.time)
    before, after = (np.array([float(x) for x in each]) for each in (event.before, event.after))
    times = np.array([0.1, 0.3, time, time, time + 0.1])
    states = np.vstack([BALL.sample(times[:2]), before, after, BALL.sample(times[4:])])
    assert gnomon.check(BALL, times, states, accept=["unsorted"]).within(1e-9)


def test_more_rows_than_are_compared_are_thinned_and_this_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    from gnomon.harness.trajectories import comparison

    monkeypatch.setattr(comparison, "MOST_COMPARED", 50)
    times = np.linspace(0, 20, 1000)
    found = compare(SWING.case, states_of(SWING.case, times, SWING.sample(times)))
    assert len(found.times) == 50
    assert (found.times[0], found.times[-1]) == (0, 20)
    assert any("50 of 1000 rows" in note for note in found.trajectory.notes)


def test_the_bound_of_a_coordinate_is_its_own() -> None:
    times = np.linspace(0, 5, 101)
    states = SWING.sample(times) + np.array([0, 1e-5])
    assert gnomon.check(SWING, times, states).within({"theta": 1e-9, "omega": 1.1e-5})
    failed = gnomon.check(SWING, times, states).within({"theta": 1e-9, "omega": 0.9e-5})
    assert failed.code == 1
    assert "omega" in failed.text
    with pytest.raises(ValueError, match="no such coordinate"):
        gnomon.check(SWING, times, states).within({"phi": 1})
    with pytest.raises(ValueError, match="give a positive error"):
        gnomon.check(SWING, times, states, within=0)


def test_a_part_of_the_coordinates_is_compared_only_on_request() -> None:
    times = np.linspace(0, 5, 101)
    columns = {"t": times, "theta": SWING.sample(times)[:, 0]}
    with pytest.raises(ValueError, match=r"no column for omega .* --partial"):
        gnomon.check(SWING, columns)
    found = gnomon.check(SWING, columns, accept=["partial"])
    assert found.within(1e-12)
    assert "not compared, without a column: omega" in str(found)
    assert not gnomon.check(SWING, columns | {"theta": columns["theta"] + 1e-3}, accept=["partial"]).within(1e-6)
    assert gnomon.check(SWING, columns, accept=["partial"]).within({"omega": 1}).code == 1


@pytest.mark.parametrize(
    ("times", "states", "told"),
    [
        ([0, 1], [[1, 2], [3]], "arrays of numbers"),
        ([0, 1], [[1, 2, 3], [1, 2, 3]], r"\(2, 3\)"),
        ([-1, 1], [[1, 2], [1, 2]], "starts at 0"),
        ([0, 1], None, "states: missing"),
    ],
)
def test_arrays_of_another_shape_are_refused(times: Any, states: Any, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        gnomon.check(SWING, times, states)


def test_a_frame_needs_no_file() -> None:
    pandas = pytest.importorskip("pandas")
    times = np.linspace(0, 5, 101)
    states = SWING.sample(times)
    frame = pandas.DataFrame({"t": times, "phi": np.degrees(states[:, 0]), "w": states[:, 1]})
    found = gnomon.check(SWING, frame, columns={"phi": "theta:deg", "w": "omega"})
    assert found.within(1e-14)
    assert gnomon.check("pendulum_simple", times, frame[["phi", "w"]], columns="phi=theta:deg,w=omega").within(1e-14)


# The command


@pytest.fixture
def swing_file(tmp_path: Path) -> Path:
    times, states = integrated(rk4, pendulum, [2, 0], 0.02, 100, 4)
    as_csv(tmp_path / "swing.csv", {"t": times, "theta": np.degrees(states[:, 0]), "omega": states[:, 1]})
    return tmp_path / "swing.csv"


@pytest.mark.parametrize(("more", "code"), [(["--within", "1e-5"], 0), (["--within", "1e-9"], 1), ([], 2)])
def test_the_exit_code_is_the_verdict(
    more: list[str], code: int, swing_file: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = swing_file.parent
    written = [part for kind in ("json", "junit", "markdown") for part in (f"--{kind}", str(folder / kind))]
    arguments = ["--case", "pendulum_simple", "--columns", "theta=theta:deg", *more, *written]
    assert command("check", str(swing_file), *arguments) == code
    told = capsys.readouterr().out
    assert "theta is theta (deg)" in told
    (found,) = json.loads((folder / "json").read_text())["checks"]
    assert 1e-9 < found["error"] < 1e-5
    assert found["verdict"] == {0: "passed", 1: "failed", 2: "no bound"}[code]
    suite = ElementTree.fromstring((folder / "junit").read_text())
    assert (suite.get("failures"), suite.get("errors")) == (str(int(code == 1)), str(int(code == 2)))
    assert str(swing_file.name) in (folder / "markdown").read_text()


def test_files_at_several_steps_give_the_order(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = []
    for step in (0.01, 0.005, 0.0025):
        times, states = integrated(rk4, pendulum, [2, 0], step, 25, round(0.04 / step))
        as_csv(tmp_path / f"{step}.csv", {"t": times, "theta": states[:, 0], "omega": states[:, 1]})
        arguments += ["--step", str(step), str(tmp_path / f"{step}.csv")]
    assert (
        command("check", *arguments, "--case", "pendulum_simple", "--json", str(tmp_path / "j"), "--within", "1") == 0
    )
    found = json.loads((tmp_path / "j").read_text())["order"]
    assert found["order"] == pytest.approx(4, abs=0.2)
    assert abs(found["order"] - 4) < found["margin"] + 0.2
    assert "order of all" in capsys.readouterr().out


def test_a_step_whose_error_its_digits_limit_is_left_out_of_the_order() -> None:
    results, steps = [], (0.01, 0.005, 0.0025)
    for step in steps:
        times, states = integrated(rk4, pendulum, [2, 0], step, 25, round(0.04 / step))
        trajectory = states_of(SWING.case, times, states)
        if step == 0.0025:
            trajectory = replace(trajectory, states=np.round(states, 3), half_units=np.full_like(states, 5e-4))
        results.append(gnomon.TrajectoryCheck(SWING.case, trajectory, compare(SWING.case, trajectory)))
    found = check_report.fit_files(results, steps)
    assert found is not None
    assert found.left_out == (0.0025,)
    assert found.order == pytest.approx(4, abs=0.2)


def test_the_template_is_enough_to_make_a_file_that_passes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A program that reads nothing else: parameters, start, times and columns are in it."""
    assert command("check", "--template", "pendulum_simple", "--set", "L=2,theta=1") == 0
    text = capsys.readouterr().out
    found = tomllib.loads(text)
    g, length = found["parameters"]["g"], found["parameters"]["L"]
    times = np.array([0.0, *found["times"]["rows"]])
    states = accurate(lambda t, y: np.array([y[1], -g / length * np.sin(y[0])]), [*found["start"].values()], times)
    as_csv(tmp_path / "a.csv", dict(zip(found["columns"], (times, *states.T), strict=True)))
    assert (
        command("check", str(tmp_path / "a.csv"), "--case", found["case"], "--set", "L=2,theta=1", "--within", "1e-8")
        == 0
    )
    assert command("check", str(tmp_path / "a.csv"), "--case", found["case"], "--within", "1e-8") == 1


@pytest.mark.parametrize("name", ["pendulum_simple", "pendulum_simple/long_1e3", "euler_top", "damped_oscillator"])
def test_rows_are_as_far_apart_as_the_template_says(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Its own rows are accepted by its own command; of others, a gap just above its number is not, one just below is."""
    assert command("check", "--template", name) == 0
    text = capsys.readouterr().out
    (gap,) = map(float, re.findall(r"rows more than (\S+) s apart need --sparse", text))
    case, rows = gnomon.case(*name.split("/")), np.array(tomllib.loads(text)["times"]["rows"])
    accepted = ["sparse"] * (" --sparse\n" in text)
    assert gnomon.check(case, rows, case.sample(rows), accept=accepted).within(1e-9)
    for factor, code in ((0.99, 0), (1.01, 2)):
        times = factor * gap * np.arange(4)
        assert gnomon.check(case, times, case.sample(times), within=1e-9).verdict.code == code
    for periods, period in re.findall(r"# s, (\S+) \S*periods of (\S+) s", text):
        assert float(period) == pytest.approx(float(case.quantities(17)["period"]), rel=1e-5)
        assert float(periods) * float(period) == pytest.approx(case.times[-1], rel=0.01)


WRONG = [
    [],
    ["a.csv"],
    ["a.csv", "--case", "pendulum_simpel"],
    ["a.csv", "--case", "com_rigid_body"],
    ["nothing.csv", "--case", "pendulum_simple"],
    ["a.csv", "b.csv", "--case", "pendulum_simple"],
    ["a.csv", "--case", "pendulum_simple", "--step", "0.1", "--step", "0.2"],
    ["a.csv", "--case", "pendulum_simple", "--step", "0"],
    ["a.csv", "--case", "pendulum_simple", "--set", "L=2,5"],
    ["a.csv", "--case", "pendulum_simple", "--set", "L=2m"],
    ["a.csv", "--case", "pendulum_simple", "--within", "small"],
    ["a.csv", "--case", "pendulum_simple", "--within", "-1"],
    ["a.csv", "--case", "pendulum_simple", "--within", "thet=1"],
    ["a.csv", "--case", "pendulum_simple", "--within", "theta=1,theta=2"],
    ["a.csv", "--case", "pendulum_simple", "--from", "5", "--to", "1"],
    ["a.csv", "--case", "pendulum_simple", "--columns", "x=theta"],
    ["a.csv", "--case", "pendulum_simple", "--picture", "a.gif"],
    ["a.csv", "--template", "pendulum_simple"],
]


@pytest.mark.parametrize("arguments", WRONG, ids=" ".join)
def test_wrong_usage_is_one_line(
    arguments: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for name in ("a.csv", "b.csv"):
        (tmp_path / name).write_text("t,theta,omega\n0,2,0\n0.1,1.9,-1\n")
    assert command("check", *arguments) == 2
    told = capsys.readouterr()
    assert not told.out
    (line,) = told.err.strip().splitlines()
    assert line.startswith("error: ")


def test_the_picture_shows_motion_error_and_bound(swing_file: Path) -> None:
    pytest.importorskip("altair")
    found = gnomon.check(SWING, swing_file, columns="theta=theta:deg", within=1e-5)
    drawn = json.dumps(found.plot().to_dict(validate=False))
    for text in ("theta", "omega", "allowed", "Error by time"):
        assert text in drawn
    assert "<svg" in found._repr_html_()


def test_a_notebook_without_the_extra_shows_the_text(swing_file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(extras, "lacking", lambda extra: "altair")
    shown = gnomon.check(SWING, swing_file, columns="theta=theta:deg", within=1)._repr_html_()
    assert shown.startswith("<pre>")
    assert "<svg" not in shown


def test_under_github_actions_a_failure_is_an_annotation(
    swing_file: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("GITHUB_ACTIONS", "true")
    words = "check", str(swing_file), "--case", "pendulum_simple", "--columns", "theta=theta:deg", "--within"
    command(*words, "1e-12")
    assert "::error title=gnomon check::" in capsys.readouterr().out
    command(*words, "1e-5")
    assert "::warning title=gnomon check::" in capsys.readouterr().out, "the file ends early"
    command(*words, "1e-5", "--to", "8")
    assert "::" not in capsys.readouterr().out
