"""States of many oscillators equal the states of each exact motion."""

import numpy as np
from gnomon.reference.oscillators.harmonic_ensemble import states
from gnomon.reference.oscillators.harmonic_oscillator import HarmonicMotion
from many_motions import worst_ulps


def test_random_and_fast_oscillators() -> None:
    """In binary64 the phase after a thousand radians would be wrong by hundreds of ulps."""
    random = np.random.default_rng(1)
    parameters, starts = random.uniform(0.1, 10, (30, 2)), random.uniform(-5, 5, (30, 2))
    parameters[:3] = [(1, 1e10), (1, 4), (1e-8, 1e8)]
    starts[:3] = [(1, 0), (0, 0.5), (1, 1)]
    worst, known = worst_ulps(states, HarmonicMotion, parameters, starts, np.array([0.0, 1e-9, 22.3, 5000.25]))
    assert known.sum() == 29  # 5e11 rad are too many
    assert worst <= 0.51
