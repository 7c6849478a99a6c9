"""What a rung of a ladder is worth, against numbers that follow from the models themselves."""

from __future__ import annotations

import math

import pandas as pd
import pytest
from gnomon.harness.ladders import worth

from gnomon import cases


def test_each_rung_of_the_pendulum_is_nearer_to_it() -> None:
    swing = cases.get("pendulum_simple", initial_state=("0.1", 0))
    rungs = pd.DataFrame(worth(swing))
    assert rungs["model"].tolist() == ["harmonic_oscillator", "duffing_unforced"]
    assert rungs["error"].is_monotonic_decreasing
    assert (rungs["early"] <= rungs["error"]).all()


def test_the_linear_pendulum_lags_by_amplitude_squared_over_16() -> None:
    """Its period is short by A^2/16, so after N swings it is ahead by 2 pi N A^2/16, at most a phase of the whole."""
    amplitude = 0.1
    swing = cases.get("pendulum_simple", initial_state=(str(amplitude), 0))
    swings = float(swing.span) / float(swing.quantities()["period"])
    lag = 2 * math.pi * swings * amplitude**2 / 16
    # The sample nearest the largest slope misses it by 1 %; the next term of the period is A^4.
    assert worth(swing)[0]["error"] == pytest.approx(lag, rel=0.05)
