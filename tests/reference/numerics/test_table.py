"""Sampling by table gives the same doubles as high precision, near zeros, at late times and in thin layers."""

import math
from dataclasses import dataclass
from fractions import Fraction

import numpy as np
import pytest
from gnomon.reference.flight.gyration import Charge
from gnomon.reference.numerics import table
from gnomon.reference.numerics.linear import Strobed
from gnomon.reference.numerics.motion import MANY, Motion
from gnomon.reference.numerics.precision import exact
from gnomon.reference.oscillators.damped_oscillator import DampedMotion
from gnomon.reference.oscillators.duffing_unforced import DuffingMotion
from gnomon.reference.oscillators.forced_oscillators import Coasting, ForcedLinear, SwitchedOff
from gnomon.reference.oscillators.harmonic_oscillator import HarmonicMotion
from gnomon.reference.pendulums.cycloidal_pendulum import CycloidalMotion
from gnomon.reference.pendulums.foucault_pendulum_centrifugal import FoucaultCentrifugal
from gnomon.reference.pendulums.foucault_pendulum_linear import Foucault
from gnomon.reference.pendulums.holonomic_constraint_dae import CartesianPendulum
from gnomon.reference.pendulums.light_cart import HalfSwings, LightCart
from gnomon.reference.pendulums.pendulum_simple import Pendulum
from gnomon.reference.rigid_bodies.euler_top import EulerTop
from gnomon.reference.storage import diskcache


def made(kind, *numbers):
    return kind(*(exact(x) for x in numbers))


MOTIONS = {
    "swing": made(Pendulum, 9.81, 1, 2.5, 0),
    "rotation backwards": made(Pendulum, 9.81, 1, 7.5, -8),
    "separatrix": made(Pendulum, 9.81, 9.81, 0, 2),
    "1e-12 below the separatrix": made(Pendulum, 9.81, 9.81, 0, 1.999999999999),
    "harmonic": made(HarmonicMotion, 1, 4, 1, 0.5),
    "underdamped": made(DampedMotion, 1, 0.4, 20, 0.5, 0),
    "critical": made(DampedMotion, 1, 4, 4, 1, 1),
    "stiff": made(DampedMotion, 1, 10**12 + 1, 10**12, 1, 0),
    "double well": made(DuffingMotion, -1, 1, 1.2, 0.1),
    "near the cusp": made(CycloidalMotion, 0.25, 9.81, 3.141492653589793, 0),
}


@pytest.fixture(autouse=True)
def fresh_cache(tmp_path, monkeypatch):
    """Each test builds its tables; the cache of the user is not read."""
    monkeypatch.setattr(diskcache, "folder", lambda: tmp_path)
    monkeypatch.setattr(table, "_kept", {})
    monkeypatch.setattr(table, "_too_expensive", {})


@pytest.mark.parametrize("motion", [pytest.param(motion, id=name) for name, motion in MOTIONS.items()])
def test_every_value_is_the_nearest_double(motion):
    source = np.random.default_rng(7)
    periodic = table.cycle_of(motion) is not None
    # A table has some tens of cells a cycle: so many times are in most of them.
    far = source.uniform(0, 3e4, 50) if periodic else source.uniform(30, 40, 20)
    times = np.concatenate(
        [source.uniform(0, 30, 100), far, 10 ** source.uniform(-18, 0, 30), source.uniform(-10, 0, 20), [0.0]]
    )
    assert np.array_equal(table.sample(motion, times), motion.sample_each(times))


def test_values_next_to_zeros_are_nearest_doubles_too(singly):
    """x = cos t around its zeros, down to the doubles nearest to them."""
    motion = made(HarmonicMotion, 1, 1, 1, 0)
    zeros = (np.arange(40) + 0.5) * np.pi
    times = np.concatenate([zeros, *(zeros + d for d in (1e-9, -1e-6, 1e-3))])
    found = table.sample(motion, times)
    # The error of the table is at most 2^-78 of the amplitude: values above 2^-18 are always proved, 2^-53 never.
    assert 40 <= len(times) - len(singly) <= 120
    assert np.array_equal(found, motion.sample_each(times))


def test_a_million_periods_out():
    motion = MOTIONS["swing"]
    times = np.random.default_rng(3).uniform(0, 3.3e6, 200)
    assert np.array_equal(table.sample(motion, times), motion.sample_each(times))


def test_the_table_proves_nearly_all_values(singly):
    """The probability of an unproved value is about the error bound in ulps, 2**-25."""
    motion = MOTIONS["swing"]
    table.sample(motion, np.random.default_rng(1).uniform(0.1, 1e4, 200_000))
    assert len(singly) < 5


def fractions(*numbers):
    return tuple(exact(x) for x in numbers)


SKEW = fractions(1, 0.5, 0, 0, 1, 0.25, -0.5, 0, 2)
TURNING = {
    "plane of swing": made(Foucault, 9.81, 67, 7.3e-5, 0.85, 1, 0, 0, 0.1),
    "plane of swing, not isotropic": Strobed(
        FoucaultCentrifugal(*fractions(9.81, 67, 7.3e-3, 0.85), fractions(1, 0, 0, 0.1)), exact(16.4)
    ),
    "charge pulled along the field": Strobed(
        Charge(fractions(1, 2, 3), fractions(1, 0, 0.5), exact(1e5), fractions(0.25, 0, 1), fractions(0, 0, 1)),
        exact(6.3e-5),
    ),
    "forced vibration": Strobed(ForcedLinear(*fractions(5e-6, 1, 0, 1, 0, 1.3, 0, 1, 0)), exact(4.8)),
    "skew body": EulerTop(fractions(1, 2, 3), fractions(0.1, 1, 0.3), SKEW),
    "symmetric body": EulerTop(fractions(2, 2, 3), fractions(0.5, 0, 1), SKEW),
    "steady body": EulerTop(fractions(1, 2, 3), fractions(0, 0, 1.5), SKEW),
    "drifting charge": Charge(
        fractions(1, 2, 3), fractions(1, 0, 0.5), exact(1.5), fractions(0.25, 0, 0), fractions(0, 1, 2)
    ),
    "pendulum on a light cart": HalfSwings(made(LightCart, 9.81, 1, 0.25, 1, 0, 2, 0.3, -0.1)),
    "pendulum on a circle": made(CartesianPendulum, 9.81, 3, -4, 4, 3),
}


@pytest.mark.parametrize("motion", [pytest.param(motion, id=name) for name, motion in TURNING.items()])
def test_cycles_that_turn_and_drift_are_composed_correctly(motion, singly):
    """Before the start and up to 1e5 cycles away, nearly all from the table of one cycle."""
    period = float(table.cycle_of(motion).period)
    source = np.random.default_rng(8)
    times = np.concatenate([source.uniform(-3, 5, 20), source.uniform(0, 1e5, 20)]) * period
    found = table.sample(motion, times)
    assert len(singly) <= 2
    for t, row in zip(times.tolist(), found.tolist(), strict=True):
        expected = [exact(x) for x in motion.state(t, 40)]
        for value, x in zip(row, expected, strict=True):
            if abs(x) > max(map(abs, expected)) * Fraction(1, 10**27):  # below there are no digits to compare
                assert abs(Fraction(value) - x) <= Fraction(51, 100) * Fraction(math.ulp(value))


def test_a_small_part_of_a_cycle_has_a_table_of_its_own(singly):
    """In a weak field the gyration is much longer than the span, and much larger than the path."""
    zero = fractions(0, 0, 0)
    motion = Charge(zero, fractions(1, 2, 0), exact(1e-9), zero, fractions(0, 0, 1))
    times = np.linspace(0.01, 10, 40)
    found = table.sample(motion, times, 10.0)
    assert len(singly) == 0
    assert np.array_equal(found, motion.sample_each(times))


def test_a_force_that_ends_is_sampled_before_and_after_its_end(singly):
    """2.4e5 periods of the force before its end at the double nearest to 1.5, which belongs to the second part."""
    driven = ForcedLinear(*fractions(0, 0, 0, 0, 2, 1e6, 0, 0, 0))
    motion = SwitchedOff(driven, exact(1.5) - Fraction(1, 10**30))
    times = np.append(np.linspace(1.4, 1.6, 3 * MANY), 1.5)
    found = motion.sample(times)
    assert len(singly) < MANY / 10
    assert np.array_equal(found, motion.sample_each(times))
    assert np.array_equal(found[-1], Coasting(motion).sample_each(times[-1:])[0])


def test_powers_of_a_decay_are_those_of_high_precision():
    motion = made(DampedMotion, 1, "1e-3", 1, 1, 0)
    times = np.concatenate([np.linspace(1, 2e5, 400), np.linspace(1.4e6, 1.6e6, 20)])
    assert np.array_equal(table.sample(motion, times), motion.sample_each(times))


def test_times_that_are_not_finite_are_refused():
    with pytest.raises(ValueError, match="finite"):
        table.sample(MOTIONS["swing"], np.array([0.0, np.nan]))


def test_damaged_table_is_built_anew(tmp_path, monkeypatch):
    motion = MOTIONS["harmonic"]
    times = np.linspace(0, 10, 50)
    first = table.sample(motion, times)
    (path,) = tmp_path.glob("*.bin")
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    path.write_bytes(content)
    monkeypatch.setattr(table, "_kept", {})
    assert np.array_equal(table.sample(motion, times), first)


def test_second_process_reads_the_table(tmp_path, monkeypatch):
    """With the table on disk only unproved states are computed."""
    motion = MOTIONS["swing"]
    times = np.linspace(0.1, 10, 50)
    first = table.sample(motion, times)
    monkeypatch.setattr(table, "_kept", {})
    monkeypatch.setattr(Pendulum, "_state", None)
    assert np.array_equal(table.sample(motion, times), first)


@dataclass(frozen=True)
class Sawtooth(Motion):
    """Not smooth: no polynomial is accurate, so that a table costs more than it saves."""

    slope: Fraction

    def _state(self, mp, t):
        return (mp.mpf(self.slope * (t - round(t))), mp.sin(mp.mpf(t)))


def test_motion_without_a_table_is_evaluated_one_by_one(singly, monkeypatch):
    motion = Sawtooth(Fraction(1, 3))
    times = np.linspace(0.01, 1e4, MANY)
    found = motion.sample(times)
    assert len(singly) == MANY
    monkeypatch.setattr(table, "build", None)  # not tried again with the same budget
    assert np.array_equal(motion.sample(times), found)
    assert np.array_equal(found, motion.sample_each(times))


def test_that_a_table_is_too_expensive_is_kept_on_disk(monkeypatch):
    motion = Sawtooth(Fraction(2, 3))
    times = np.linspace(0.01, 1e4, 5)
    first = table.sample(motion, times)
    monkeypatch.setattr(table, "_too_expensive", {})
    monkeypatch.setattr(table, "build", None)
    assert np.array_equal(table.sample(motion, times), first)


def test_few_times_need_no_table(tmp_path):
    MOTIONS["swing"].sample(np.linspace(0, 1, 10))
    assert not list(tmp_path.glob("*.bin"))
