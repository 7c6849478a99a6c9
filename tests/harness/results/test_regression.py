"""The regression check reports a lower order, larger errors, more work, a worse status, and series not compared."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import synthetic
from command_line import gnomon
from gnomon.harness.contract.status import CANNOT_RUN, THROUGHOUT
from gnomon.harness.results import regression, store
from gnomon.harness.results.regression import SERIES, Verdict


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return synthetic.write(tmp_path_factory.mktemp("regression") / "results.sqlite")


@pytest.fixture(scope="module")
def base(results: Path) -> Any:
    """A few series of the base; every test changes a copy."""
    frame = store.load(results)
    few = frame["integrator"].isin(["RK4", "DOP853", "IAS15"]) & (frame["variant"] == "default")
    return frame[few & (frame["case"] != "pendulum_simple") & (frame["launch"] < 3)]


def compare(base: Any, run: Any, allow_missing: bool = False) -> Verdict:
    return regression.compare(base.to_dict("records"), run.to_dict("records"), allow_missing)


def spoiled(frame: Any, column: str, change: Any, integrator: str = "RK4") -> Any:
    frame = frame.copy()
    chosen = (frame["integrator"] == integrator) & (frame["case"] == "kepler_orbit") & (frame["variant"] == "default")
    frame.loc[chosen, column] = change(frame[chosen])
    return frame


def test_a_run_is_no_worse_than_itself(base: Any) -> None:
    verdict = compare(base, base)
    assert verdict.compared == base.groupby(SERIES).ngroups
    compared = ["ok", "inaccurate", "diverged", "unsupported"]  # IAS15 is unsupported on the bouncing ball, in both
    assert verdict.settings == (base["status"][base["launch"] == 1].isin(compared)).sum()
    assert verdict.regressions == []
    assert verdict.not_compared == {}
    assert not verdict.failed


@pytest.mark.parametrize(
    ("column", "change", "says"),
    [
        ("error_max", lambda rows: rows["error_max"] * 3, "3 times the errors of the base"),
        ("error_max", lambda rows: 0.3 * rows["setting"] ** 3, "order 4.00 became 3.00"),
        ("rhs_calls", lambda rows: rows["rhs_calls"] * 1.25, "1.25 times the right-hand sides"),
        ("status", lambda rows: "crashed", "became crashed"),
    ],
)
def test_each_regression_is_named(base: Any, column: str, change: Any, says: str) -> None:
    regressions = compare(base, spoiled(base, column, change)).regressions
    assert regressions
    assert all("kepler_orbit default standard gnomon:RK4" in line for line in regressions)
    assert any(says in line for line in regressions)


def slower(base: Any, run: Any) -> list[str]:
    return regression.slower(regression.changes(base.to_dict("records"), run.to_dict("records")))


def test_slower_is_a_note(base: Any) -> None:
    run = spoiled(base, "seconds_median", lambda rows: rows["seconds_median"] * 3)
    assert compare(base, run).regressions == []
    (note,) = slower(base, run)
    said = re.search(r"([\d.]+) \(([\d.]+) – ([\d.]+)\) times the time", note)
    assert said is not None
    factor, low, high = map(float, said.groups())
    assert low < factor < high
    assert factor == 3
    assert slower(run, base) == slower(base, base) == []


def test_times_of_another_machine_are_not_compared(base: Any) -> None:
    """Errors are: they do not depend on it."""
    other = spoiled(base, "seconds_median", lambda rows: rows["seconds_median"] * 3).assign(machine="another")
    verdict = compare(base, other)
    assert slower(base, other) == []
    assert verdict.settings == compare(base, base).settings


def test_round_off_is_no_regression(base: Any) -> None:
    def noise(rows: Any) -> Any:
        return rows["error_max"].where(rows["error_max"] > 1e-14, 9 * rows["error_max"])

    assert compare(base, spoiled(base, "error_max", noise)).regressions == []


def test_differences_between_builds_are_no_regression(base: Any) -> None:
    """Other last bits of libm change counts of right-hand sides by 0.3 %, and errors of adaptive methods."""
    run = base.assign(rhs_calls=base["rhs_calls"] * 1.003, error_max=base["error_max"] * 1.5)
    assert compare(base, run).regressions == []


def test_an_improvement_is_no_regression(base: Any) -> None:
    assert compare(base, spoiled(base, "error_max", lambda rows: rows["error_max"] / 100)).regressions == []


def test_nothing_in_common_is_an_error(base: Any) -> None:
    with pytest.raises(ValueError, match="in common"):
        compare(base, base.assign(case="another"))


def test_a_much_larger_error_at_any_one_setting_is_a_regression(base: Any) -> None:
    """The median of a series does not show it. A change that the last bits of libm can cause is not a regression."""
    rows = chosen(base)
    settings = rows["setting"][rows["error_max"] > 1e-13].tolist()  # below, errors are at the attainable error
    assert len(settings) >= 5
    for setting in settings[::2]:
        at = rows.index[rows["setting"] == setting]
        for factor, seen in ((31.0, True), (29.0, False)):
            run = base.copy()
            run.loc[at, "error_max"] *= factor
            lines = compare(base, run).regressions
            named = [line for line in lines if f"gnomon:RK4 at {setting:g}: the error is" in line]
            assert bool(named) == seen, (setting, factor, lines)


def chosen(frame: Any) -> Any:
    """One series of the base, with eleven settings of any status."""
    rows = frame[(frame["integrator"] == "RK4") & (frame["case"] == "kepler_orbit") & (frame["variant"] == "default")]
    return rows[rows["launch"] == 1].sort_values("setting", ascending=False)


def changed(frame: Any, rows: Any, **columns: Any) -> Any:
    frame = frame.copy()
    for name, value in columns.items():
        frame.loc[rows.index, name] = value
    return frame


@pytest.mark.parametrize("became", ["timeout", "skipped", "interrupted"])
def test_a_series_without_a_setting_that_is_ok_is_a_regression(base: Any, became: str) -> None:
    """For example an integrator that hangs: it has no errors that could be larger."""
    lines = compare(base, changed(base, chosen(base), status=became, error_max=np.nan)).regressions
    assert all("kepler_orbit default standard gnomon:RK4" in line for line in lines)
    assert f"gnomon:RK4: ok in the base, no setting is ok any more (11 {became})" in lines[-1]


def test_a_run_of_timeouts_only_is_a_regression(base: Any) -> None:
    lines = compare(base, base.assign(status="timeout")).regressions
    assert sum("no setting is ok any more" in line for line in lines) == base.groupby(SERIES).ngroups - 1
    with pytest.raises(ValueError, match="nothing ran in the base"):
        compare(base.assign(status="timeout"), base)


@pytest.mark.parametrize(
    ("tries", "reason", "factor", "regression"),
    [
        (3, "", 1, True),
        (3, "", 2, True),
        (2, "", 1, False),
        (None, "", 1, False),
        (3, "", 0.5, False),
        (1, THROUGHOUT, 1, True),
        (1, THROUGHOUT, 0.5, False),
    ],
)
def test_a_timeout_is_a_regression_if_no_stall_explains_it_and_the_limit_is_no_lower(
    base: Any, tries: int | None, reason: str, factor: float, regression: bool
) -> None:
    """A single one may be a stall of the machine, unless it ran all the time: that counts as not compared."""
    ok = chosen(base)
    ok = ok[ok["status"] == "ok"]
    limit = factor * ok["limit_seconds"].iloc[0]
    hung, after = ok.iloc[[-3]], ok.iloc[-2:]
    run = changed(base, hung, status="timeout", reason=reason, repeats=tries, limit_seconds=limit, error_max=np.nan)
    run = changed(run, after, status="skipped", repeats=None, limit_seconds=limit, error_max=np.nan)
    verdict = compare(base, run)
    assert [line.partition(": ")[2][:17] for line in verdict.regressions] == (
        ["ok became timeout", "ok became skipped"] if regression else []
    )
    assert verdict.not_compared.total() == (0 if regression else 3)
    assert verdict.failed
    assert compare(base, run, allow_missing=True).failed == regression


@pytest.mark.parametrize(("share", "regression"), [(0.2, True), (0.5, False)])
def test_a_setting_near_the_limit_in_the_base_may_pass_it_on_a_slower_machine(
    base: Any, share: float, regression: bool
) -> None:
    rows = chosen(base)[chosen(base)["status"] == "ok"].iloc[[-1]]
    before = changed(base, rows, seconds_median=share * rows["limit_seconds"])
    run = changed(before, rows, status="timeout", repeats=3, error_max=np.nan)
    assert bool(compare(before, run).regressions) == regression


def test_a_missing_series_is_a_regression_unless_it_is_allowed(base: Any) -> None:
    run = base.drop(chosen(base).index)
    run = run[~((run["integrator"] == "RK4") & (run["case"] == "kepler_orbit") & (run["variant"] == "default"))]
    (line,) = compare(base, run).regressions
    assert line == "1 series of the base are not in the run, the first: kepler_orbit default standard gnomon:RK4"
    verdict = compare(base, run, allow_missing=True)
    assert verdict.regressions == []
    assert verdict.notes == [line]
    assert verdict.not_compared == {"their series is not in the run": 11}
    assert not verdict.failed


def test_other_settings_are_not_compared_and_fail(base: Any) -> None:
    """Errors that grow from 1e-9 to .01 at settings that the base does not have must not pass."""
    rows = chosen(base)
    run = changed(base, rows, setting=rows["setting"] * 1.001, error_max=0.01, status="ok")
    verdict = compare(base, run)
    (line,) = verdict.regressions
    assert "gnomon:RK4: no setting can be compared (11 because the run has no such setting)" in line
    assert verdict.not_compared == {"the run has no such setting": 11}
    shifted = base.assign(setting=base["setting"] * 1.001)
    with pytest.raises(ValueError, match=r"no setting of the two runs can be compared: .* no such setting"):
        compare(base, shifted)


@pytest.mark.parametrize(
    ("columns", "reason"),
    [
        ({"turned_starts": 9}, "errors are medians over turned starts in one of the two alone"),
        ({"span": 3.0}, "the numbers of the case are others in the run"),
        ({"numbers": '{"g": "2"}'}, "the numbers of the case are others in the run"),
    ],
)
def test_only_equal_problems_are_compared(base: Any, columns: Any, reason: str) -> None:
    rows = chosen(base)
    run = changed(base, rows, error_max=rows["error_max"] * 100, **columns)
    verdict = compare(base, run)
    assert verdict.not_compared == {reason: 11}
    assert all("no setting can be compared" in line for line in verdict.regressions)
    both = changed(base, rows, **columns)
    assert any("times the errors of the base" in line for line in compare(both, run).regressions)


def test_the_exit_codes_of_compare(results: Path, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    smaller = tmp_path / "smaller.sqlite"
    with store.Store(smaller) as written:
        number = written.begin_run("standard", "gnomon run", {})
        frame = store.load(results)
        rows = frame[(frame["integrator"] == "RK4") & (frame["launch"] == 1) & (frame["case"] == "kepler_orbit")]
        trials = rows[list(store.schema.TRIAL_COLUMNS)].to_dict("records")
        written.plan(number, trials)
        kept = ["trial_key", "launch", "status", "error_max", "rhs_calls", "limit_seconds"]
        written.add_all(number, rows[kept].to_dict("records"))
    base, run = str(results), str(smaller)
    assert gnomon("compare", base, base) == 0
    assert gnomon("compare", base, run) == 1
    assert "series of the base are not in the run" in capfd.readouterr().out
    assert gnomon("compare", base, run, "--allow-missing") == 0
    printed = capfd.readouterr().out
    assert "because their series is not in the run" in printed
    assert printed.splitlines()[-1].startswith("2 series compared at ")
    with store.Store(tmp_path / "empty.sqlite") as written:
        written.begin_run("standard", "gnomon run", {})
    assert gnomon("compare", base, str(tmp_path / "empty.sqlite")) == 2
    assert capfd.readouterr().err.startswith("error: the two runs have no case and integrator in common")


def test_the_change_of_every_series_is_told_also_where_nothing_is_worse(base: Any) -> None:
    """A third of the error for twice the right-hand sides is a trade that the user decides on."""
    run = spoiled(base, "error_max", lambda rows: rows["error_max"] / 3)
    run = spoiled(run, "rhs_calls", lambda rows: rows["rhs_calls"] * 1.05)
    run = spoiled(run, "seconds_median", lambda rows: rows["seconds_median"] / 4)
    assert compare(base, run).regressions == []
    found = {one.name: one for one in regression.changes(base.to_dict("records"), run.to_dict("records"))}
    ran = base[~base["status"].isin(CANNOT_RUN)]
    assert found.keys() == {*ran.groupby(SERIES).groups}
    for name, one in found.items():
        rows = ran[(ran[SERIES] == list(name)).all(axis=1)]
        solved = rows[rows["status"] == "ok"]
        finest = solved[solved["setting"] == solved["setting"].min()]
        assert (one.setting, one.settings) == (solved["setting"].min(), solved["setting"].nunique())
        changed = name[0] == "kepler_orbit" and name[3] == "gnomon:RK4"
        for change, column, ratio in (
            (one.error, "error_max", 1 / 3),
            (one.calls, "rhs_calls", 1.05),
            (one.seconds, "seconds_median", 1 / 4),
        ):
            ratio = ratio if changed else 1.0
            assert change.base == pytest.approx(finest[column].median(), nan_ok=True)
            assert [change.run, change.ratio] == pytest.approx([ratio * change.base, ratio], nan_ok=True)
            assert column == "rhs_calls" or not np.isnan(change.ratio)


def test_ratios_are_medians_over_the_settings_that_both_solved(base: Any) -> None:
    """A setting that failed in the run has no ratio, and one outlier does not move the median."""
    rows = chosen(base)
    run = base.copy()
    run.loc[rows.index, "error_max"] *= 2
    run.loc[rows.index[0], "error_max"] *= 1e6
    run.loc[rows.index[-1], "status"] = "diverged"
    (one,) = regression.changes(rows.to_dict("records"), run.loc[rows.index].to_dict("records"))
    solved = rows[:-1][rows["status"][:-1] == "ok"]
    assert (one.settings, one.setting) == (len(solved), solved["setting"].min())
    assert one.error.ratio == pytest.approx(2)


def test_times_of_two_machines_have_no_ratio_and_of_several_launches_are_the_geometric_mean(base: Any) -> None:
    rows = base[(base["integrator"] == "DOP853") & (base["case"] == "kepler_orbit") & (base["launch"] == 1)]
    launches = [
        rows.assign(launch=n, seconds_median=rows["seconds_median"] * slow) for n, slow in ((1, 9), (2, 3), (3, 2))
    ]
    several = [row for frame in launches for row in frame.to_dict("records")]
    (one,) = regression.changes(rows.to_dict("records"), several)
    assert [one.seconds.ratio, one.error.ratio] == pytest.approx([54 ** (1 / 3), 1])
    (one,) = regression.changes(rows.to_dict("records"), rows.assign(machine="another").to_dict("records"))
    assert np.isnan(one.seconds.ratio)
    assert one.error.ratio == 1


def test_a_series_without_a_solved_setting_in_both_says_why(
    base: Any, results: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    rows = chosen(base)
    (one,) = regression.changes(rows.to_dict("records"), rows.assign(status="crashed").to_dict("records"))
    assert (one.settings, one.why) == (0, "base: ok; run: crashed")
    (one,) = regression.changes(rows.to_dict("records"), [])
    assert "no such series" in one.why
    assert gnomon("compare", str(results), str(results)) == 0
    printed = capfd.readouterr().out.split()
    assert {"kepler_orbit", "gnomon:RK4", "error", "calls", "time", "base", "run", "ratio"} <= set(printed)
