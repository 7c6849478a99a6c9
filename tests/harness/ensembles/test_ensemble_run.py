"""Ensembles: the same bits for any partition, statuses, starts that reproduce their errors, ended processes."""

from pathlib import Path
from typing import Any

import numpy as np
import planted_ensembles
import pytest
from gnomon.cases import get
from gnomon.harness.ensembles import ensemble_run, samples
from gnomon.harness.ensembles.distribution import as_data
from gnomon.harness.ensembles.draws import Varied
from gnomon.harness.ensembles.ensemble_run import Job
from gnomon.harness.ensembles.samples import BLOCK, Ensemble
from gnomon.harness.registry import lookup

BOTH = (Varied("theta", -7.0, 7.0), Varied("omega", -8.0, 8.0))


def ensemble(name: str = "Off", **changes: Any) -> Ensemble:
    given = {"vary": BOTH, "setting": 1e-9, **changes}
    return Ensemble("pendulum_simple", f"planted_ensembles:{name}", **given)


def everything(job: Job, *arguments: Any) -> Any:
    found = ensemble_run.run(job, *arguments)
    return as_data(found), found.worst, found.failed


@pytest.mark.parametrize("name", ["SharesSteps", "Fails"])
def test_parts_have_the_bits_of_the_whole(name: str) -> None:
    """Though the answer from a start depends on the others of its call, or one start makes the call of all fail."""
    ready = ensemble(name).prepared
    whole = ready.measured(0, 8 * BLOCK)
    parts = [ready.measured(first * BLOCK, count * BLOCK) for first, count in ((0, 1), (1, 4), (5, 3))]
    assert np.array_equal(whole.errors, np.concatenate([one.errors for one in parts]), equal_nan=True)
    assert whole.statuses == [status for one in parts for status in one.statuses]


def test_workers_and_their_number_change_no_bit() -> None:
    job = Job(ensemble("SharesSteps"), 3000, keep=5, sides=(0, 1))
    alone = everything(job)
    assert everything(job, lambda job, firsts: ensemble_run.one_by_one(job, reversed(firsts))) == alone
    assert everything(job, ensemble_run.in_processes(3)) == alone
    assert everything(Job(ensemble("SharesSteps", seed=2), 3000, keep=5, sides=(0, 1))) != alone


def test_the_lanes_of_the_fast_gauss_method_keep_their_neighbours() -> None:
    """Eight trajectories share their steps; a block that began elsewhere would have other bits."""
    gauss = Ensemble("pendulum_simple", "gnomon:Gauss 8-stage SIMD", 1e-6, BOTH)
    whole = gauss.prepared.measured(0, 2 * BLOCK).errors
    assert np.array_equal(gauss.prepared.measured(BLOCK, BLOCK).errors, whole[BLOCK:])
    assert 1e-12 < np.median(whole) < 1e-4


def test_statuses_are_those_of_single_starts() -> None:
    """A start that raises makes only its own sample fail, not the call of 256."""
    found = ensemble("Fails").prepared.measured(0, 2048)
    theta, omega = found.numbers.T
    expected = np.where(
        theta > 6, "refused", np.where(theta < -6, "crashed", np.where(np.abs(omega) > 7, "diverged", "ok"))
    )
    assert [str(status) for status in found.statuses] == expected.tolist()
    assert np.array_equal(np.isnan(found.errors), expected != "ok")


def test_samples_outside_the_domain_are_counted_and_not_drawn_again() -> None:
    """A length below zero: half of the samples. Each of the others has a problem of its own, prepared for its length."""
    ready = ensemble(vary=(Varied("L", -1.0, 1.0), Varied("theta", -1.0, 1.0))).prepared
    found = ready.measured(0, 256)
    assert [status == "outside" for status in found.statuses] == (found.numbers[:, 0] <= 0).tolist()
    inside = found.numbers[:, 0] > 0
    off = 10 ** (-10 + 4 * (found.numbers[inside, 1] + 7) / 7)
    (scale,) = (group.scale for group in ready.metric.groups if group.name == "angular velocity")
    assert found.errors[inside] == pytest.approx(off / scale, rel=1e-4, abs=1e-15)


def test_errors_are_in_the_metric_of_the_case() -> None:
    found, ready = ensemble().prepared.measured(0, 1024), ensemble().prepared
    (scale,) = (group.scale for group in ready.metric.groups if group.name == "angular velocity")
    right = 10 ** (-10 + 4 * (found.numbers[:, 0] + 7) / 7) / scale
    assert found.errors == pytest.approx(right, rel=1e-4)  # the last digits of omega + 1e-10 are lost


def test_the_worst_starts_reproduce_their_errors() -> None:
    """As the lines of code are printed, and by the exact motion of the case, not by the formula for many."""
    job = Job(ensemble(), 2048, keep=4)
    found = ensemble_run.run(job)
    names: dict[str, Any] = {}
    exec("from gnomon.harness.ensembles.samples import Ensemble, Varied", names)
    exec(f"ensemble = {job.ensemble!r}", names)
    for start in found.worst:
        numbers = dict(zip(("theta", "omega"), start.numbers, strict=True))
        assert eval(f"ensemble.error({numbers!r})", names) == pytest.approx(start.error, rel=1e-8)
    angles = [start.numbers[0] for start in found.worst]
    assert angles == sorted(angles, reverse=True)
    assert angles[-1] > 6.9


def test_a_fault_in_a_hundredth_of_the_starts_shows_in_the_tail() -> None:
    """In the start that `gnomon run` takes, and in the median, the method is right."""
    found = ensemble_run.run(Job(ensemble("WrongBackwards"), 2**14))
    by_level = {row["level"]: row["error"] for row in found.quantiles()}
    assert by_level[0.5] < 1e-11
    assert by_level[0.999] > 1e-4
    assert dict(found.tail())[1e-3] == pytest.approx(2**14 * 0.01, abs=2)  # Sobol points: nearly exact
    assert all(start.numbers[1] < -7.84 for start in found.worst)


def test_more_times_find_larger_errors() -> None:
    """The last of eight times is the only one of the other ensemble."""
    step = samples.setting_for(ensemble().prepared.case, lookup.find_one("gnomon:RK4"), 8, 0.1)
    rk4 = {"case": "pendulum_simple", "integrator": "gnomon:RK4", "setting": step, "vary": BOTH}
    once, often = (Ensemble(**rk4, times=times).prepared.measured(0, 64).errors for times in (1, 8))
    assert np.all(often >= once * (1 - 1e-9))
    assert np.median(often) > 1.05 * np.median(once)


def test_what_a_killed_process_had_under_way_runs_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing is lost and nothing is counted twice."""
    monkeypatch.chdir(tmp_path)
    found = everything(Job(ensemble("EndsOnce"), 4096, sides=(0, 1)), ensemble_run.in_processes(2))
    assert Path(planted_ensembles.MARK).exists()
    assert found == everything(Job(ensemble(), 4096, sides=(0, 1)))


def test_parts_answered_out_of_sequence_are_kept_when_a_process_ends(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The process of the first part ends after another part was answered: exactly the others run again."""
    monkeypatch.chdir(tmp_path)
    job = Job(ensemble("EndsLate"), 8 * BLOCK)
    Path(planted_ensembles.FIRST).write_text(float(job.ensemble.prepared.drawn(0, 1)[1][0, 0]).hex())
    answered = []
    for first, _ in ensemble_run.in_processes(2)(job, job.firsts):
        answered.append(first)
        Path(planted_ensembles.ANSWERED).touch()
    assert Path(planted_ensembles.MARK).exists()
    assert answered[0] != 0
    assert sorted(answered) == list(job.firsts)


def test_a_method_that_ends_every_process_ends_the_run_with_its_samples_named() -> None:
    with pytest.raises(ChildProcessError, match="ended 3 times, with one of the first samples 0 to"):
        ensemble_run.run(Job(ensemble("EndsAlways"), 1024), ensemble_run.in_processes(1))


def test_the_cost_says_where_exact_states_come_from() -> None:
    cost = ensemble_run.probe(ensemble())
    assert cost.by_formula
    assert not cost.prepares_each
    assert ensemble_run.probe(ensemble(vary=(Varied("L", 1.0, 2.0),))).prepares_each
    assert cost.seconds(200, 2) == pytest.approx(100 * (cost.integration + cost.exact))


def test_parts_are_whole_blocks_and_depend_on_the_number_alone() -> None:
    assert [Job(ensemble(), n).part for n in (1, 1000, 2**17, 10**6, 2**30)] == [256, 256, 2048, 8192, 16384]
    assert all(first % BLOCK == 0 for first in Job(ensemble(), 10**6).firsts)


def test_parameters_of_a_case_with_events_do_not_vary() -> None:
    ball = Ensemble("bouncing_ball", "gnomon:DOP853 [events]", 1e-9, (Varied("g", 1.0, 2.0),))
    with pytest.raises(ValueError, match="bouncing_ball has events"):
        _ = ball.prepared


def test_a_step_divides_the_interval() -> None:
    """By default into a power of two; a tolerance stays as it is."""
    case, rk4 = get("pendulum_simple").rounded(), lookup.find_one("gnomon:RK4")
    interval, usual = samples.short_interval(float(case.times[-1]) / 3), samples.setting_for(case, rk4, 3)
    assert interval / usual == 2 ** round(np.log2(interval / usual))
    assert case.time_scale / 128 < usual <= case.time_scale / 64
    given = samples.setting_for(case, rk4, 3, 0.01)
    assert interval / given == pytest.approx(np.ceil(interval / 0.01), rel=1e-15)
    assert samples.setting_for(case, lookup.find_one("gnomon:DOP853"), 1) == 1e-9
    assert samples.setting_for(case, lookup.find_one("gnomon:DOP853"), 1, 1e-7) == 1e-7
