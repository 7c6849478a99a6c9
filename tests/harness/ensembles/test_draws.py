"""Draws: the bits of a sample do not depend on the part in which it is drawn, and the points are Sobol's."""

import numpy as np
import pytest
from gnomon.cases import get
from gnomon.harness.ensembles import draws
from gnomon.harness.ensembles.draws import Varied


@pytest.mark.parametrize("dimension", [1, 2, 5])
def test_parts_have_the_bits_of_the_whole(dimension: int) -> None:
    """The sequence of parts does not matter. Five numbers need two counters of Philox a sample."""
    whole = draws.unit(7, dimension, 0, 1024)
    for first, count in ((0, 256), (256, 512), (3, 5), (600, 100), (1023, 1), (0, 1024)):
        assert np.array_equal(draws.unit(7, dimension, first, count), whole[first : first + count])


def test_points_are_spread_as_sobol_points_are() -> None:
    """Each interval of length 2^-10 has one of the first 2^10 points (they are a (0, m, 1) net in each dimension), and
    one of the next 2^10. The bits that Philox adds move no point to another interval."""
    for first in (0, 1024):
        for column in draws.unit(1, 4, first, 1024).T:
            assert np.array_equal(np.sort(np.floor(column * 1024)), np.arange(1024))


def test_numbers_have_all_53_bits() -> None:
    """The last bit is 1 in about half of them, in each dimension and without relation to the others."""
    bits = draws.unit(1, 5, 0, 4096) * 2.0**53 % 2
    share = bits.mean(axis=0)
    assert np.all(np.abs(share - 0.5) < 5 * 0.5 / 64)  # five standard deviations
    both = (bits[:, 0] == bits[:, 1]).mean()
    assert abs(both - 0.5) < 5 * 0.5 / 64


def test_another_seed_gives_other_points() -> None:
    assert not np.any(draws.unit(1, 2, 0, 64) == draws.unit(2, 2, 0, 64))


def test_numbers_are_in_their_limits() -> None:
    found = draws.numbers(draws.unit(1, 2, 0, 1024), (Varied("a", -3.0, -1.0), Varied("b", 0.0, 1e-300)))
    assert np.all((found[:, 0] >= -3) & (found[:, 0] <= -1))
    assert np.all((found[:, 1] >= 0) & (found[:, 1] <= 1e-300))


def test_by_default_the_start_varies_in_its_typical_range() -> None:
    case = get("pendulum_simple")
    assert draws.choose_varied(case) == (Varied("theta", -7.0, 7.0), Varied("omega", -8.0, 8.0))
    assert draws.choose_varied(case, ["L", "omega=-1:2"]) == (Varied("L", 0.1, 10.0), Varied("omega", -1.0, 2.0))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("thet=0:1", "did you mean theta"), ("theta=1:0", "LOW below HIGH"), ("theta=0", "write NAME=LOW:HIGH"),
        ("theta=a:b", "write NAME=LOW:HIGH"), ("theta=nan:1", "finite"), ("theta=-1e308:1e308", "finite"),
    ],
)  # fmt: skip
def test_what_is_no_range_is_named(text: str, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        draws.choose_varied(get("pendulum_simple"), [text])
