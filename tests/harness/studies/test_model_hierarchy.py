"""Errors of the levels of model hierarchies, compared with values derived from the models."""

import math
from pathlib import Path

import pandas as pd
import pytest
from gnomon.harness.studies import model_hierarchy
from gnomon.harness.studies.model_hierarchy import cost, hierarchies, model_errors, times_of
from gnomon.reference.storage import diskcache

from gnomon import cases


def test_each_level_of_the_pendulum_is_nearer_to_it() -> None:
    swing = cases.get("pendulum_simple", initial_state=("0.1", 0))
    levels = pd.DataFrame(model_errors(swing))
    assert levels["model"].tolist() == ["harmonic_oscillator", "duffing_unforced"]
    assert levels["error"].is_monotonic_decreasing
    assert (levels["early"] <= levels["error"]).all()


def test_the_linear_pendulum_lags_by_amplitude_squared_over_16() -> None:
    """Its period is too short by A^2/16 of itself: after N swings it is ahead by a phase of 2 pi N A^2/16."""
    amplitude = 0.1
    swing = cases.get("pendulum_simple", initial_state=(str(amplitude), 0))
    swings = float(swing.span) / float(swing.quantities()["period"])
    lag = 2 * math.pi * swings * amplitude**2 / 16
    # The sample nearest the largest slope is 1 % below it; the next term of the period is A^4.
    assert model_errors(swing)[0]["error"] == pytest.approx(lag, rel=0.05)
    # After one period, where the speed changes fastest.
    assert model_errors(swing)[0]["early"] == pytest.approx(2 * math.pi * amplitude**2 / 16, rel=0.05)


def test_the_quartic_pendulum_lags_by_amplitude_to_the_fourth_over_384() -> None:
    """Period over the period of small swings: 1 + A^2/16 + 33 A^4/9216 for the pendulum, 57 A^4/9216 in the model."""
    amplitude, span = 0.2, 40
    swing = cases.get("pendulum_simple", initial_state=(str(amplitude), 0), span=span)
    lag = math.sqrt(9.81) * span * amplitude**4 * (57 - 33) / 9216
    # The sample nearest the largest slope is 1 % below it; the next term of the periods is smaller by a factor A^2.
    assert model_errors(swing)[1]["error"] == pytest.approx(lag, rel=0.06)


def test_a_throw_is_the_orbit_in_its_own_axes() -> None:
    """Over a short time gravity is uniform to h/R. With interchanged axes the error would be as large as the throw."""
    throw = cases.get("kepler_orbit", "throw")
    (row,) = model_errors(throw)
    # in 61 s the height changes by some 20 km of 6371
    assert row["error"] < 0.02


def test_cost_is_per_characteristic_time_and_a_ratio_to_the_full_model() -> None:
    fixed = {"variant": "", "formulation": "", "target": 1e-6, "machine": "one"}
    times = [("full", "a", 8.0), ("full", "b", 4.0), ("full", "c", 1.0), ("model", "a", 1.0), ("model", "b", 2.0)]
    equal = pd.DataFrame([{"case": case, "integrator_id": name, "seconds": t, **fixed} for case, name, t in times])
    spans = [{"case": "full", "span": 40.0, "time_scale": 10.0}, {"case": "model", "span": 6.0, "time_scale": 3.0}]
    found = cost("full", "model", times_of(equal, pd.DataFrame(spans).assign(variant="")))
    # a: (1/2) / (8/4), b: (2/2) / (4/4)
    assert found["ratio"] == pytest.approx((0.25 + 1) / 2)
    assert (found["integrators"], found["fastest"], found["seconds"]) == (2, "a", 0.5)


def test_the_shortest_time_of_third_parties_stands_beside_the_shortest_of_all() -> None:
    """Neither gnomon's own methods nor one that a user gave are third parties, however fast they are."""
    fixed = {"case": "full", "variant": "", "formulation": "", "target": 1e-6, "machine": "one"}
    times = [("gnomon:a", 1.0), ("mine:b", 2.0), ("scipy:c", 8.0), ("heyoka:d", 4.0)]
    equal = pd.DataFrame([{"integrator_id": name, "seconds": t, **fixed} for name, t in times])
    spans = pd.DataFrame([{"case": "full", "span": 2.0, "time_scale": 1.0, "variant": ""}])
    found = cost("full", "full", times_of(equal, spans))
    assert (found["fastest"], found["seconds"]) == ("gnomon:a", 0.5)
    assert (found["third"], found["third_seconds"]) == ("heyoka:d", 2.0)
    without = cost("full", "full", times_of(equal[:2], spans))
    assert without["third"] == ""
    assert math.isnan(without["third_seconds"])


def test_the_rows_of_a_hierarchy_end_with_the_full_model() -> None:
    """A level that is the case itself with other parameters has an error, but no time: it was not run."""
    full = cases.get("torpedo_firing_pin")
    fixed = {
        "machine": "one", "variant": "", "formulation": "", "target": 1e-6, "case": full.name, "integrator_id": "a",
    }  # fmt: skip
    spans = pd.DataFrame([{"case": full.name, "span": 4.0, "time_scale": 2.0, "variant": ""}])
    level, last = hierarchies([full], pd.DataFrame([fixed | {"seconds": 3.0}]), spans).to_dict("records")
    assert level["model"] == level["hierarchy"] == last["model"] == full.name
    assert level["lacks"] == "the full model"
    assert level["error"] > 0
    assert (level["integrators"], level["fastest"]) == (0, "")
    assert math.isnan(level["ratio"])
    assert math.isnan(level["seconds"])
    assert (last["error"], last["early"], last["lacks"]) == (0.0, 0.0, "")
    assert (last["ratio"], last["integrators"], last["seconds"]) == (1.0, 1, 1.5)


def test_levels_of_one_case_are_numbered() -> None:
    turning = "free_fall_rotating_earth"
    labels = [row["label"] for row in model_errors(cases.get("free_fall_rotating_frame_centrifugal"))]
    assert labels == [f"{turning} (1)", "free_fall_first_order", f"{turning} (2)"]


def test_the_error_over_the_span_includes_the_first_period() -> None:
    """64 samples of the first period may show a peak between the samples of the span."""
    (level,) = model_errors(cases.get("rotating_pendulum"))
    assert level["error"] >= level["early"] > 1


@pytest.mark.parametrize("name", [name for name in cases.names() if cases.get(name).hierarchy])
def test_every_level_is_projected_to_the_coordinates_of_its_case(name: str) -> None:
    full = cases.get(name).rounded()
    times = full.times[:2]  # enough for the shape; the motion of a level over a long span costs seconds
    for level in full.hierarchy:
        model = level.case.with_span(times[-1].item())
        projected = level.project(model.sample(times))
        assert projected.shape == (len(times), len(full.state))


def test_errors_of_models_are_computed_once(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """Else every report takes half a minute for them. Other numbers are another entry."""
    monkeypatch.setattr(diskcache, "folder", lambda: tmp_path / "kept")
    full = cases.get("torpedo_firing_pin")
    first = model_errors(full)
    monkeypatch.setattr(model_hierarchy, "_model_errors", lambda _: pytest.fail("computed again"))
    assert model_errors(full) == first
    other = full.with_numbers(full.initial_state, dict(full.parameters) | {"k": 2100})
    with pytest.raises(pytest.fail.Exception, match="computed again"):
        model_errors(other)
