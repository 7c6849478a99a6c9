"""The matrix exponential against sums of modes, which are independent of it."""

from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.numerics.precision import exact
from gnomon.reference.oscillators.small_vibrations import Vibrations, chain

ONE, NONE = Fraction(1), Fraction(0)
STILL = chain((NONE,) * 3, (NONE,) * 2)


def fractions(*numbers):
    return tuple(map(exact, numbers))


@pytest.mark.parametrize("t", ["0.3", 77, "82103.4"])
def test_equal_chain_is_a_sum_of_three_sines(t):
    """Mode j of three masses: shape sin(i j pi/4), w_j = 2 sin(j pi/8)."""
    starts = fractions(1, 0, "-0.5"), fractions(0, "0.25", 1)
    motion = Vibrations((ONE,) * 3, chain((ONE, NONE, ONE), (ONE, ONE)), STILL, *starts)
    found = motion.state(t, 50)
    with mpmath.workdps(80):
        mp = mpmath.mp
        time = mp.mpf(t)
        right = [mp.zero] * 6
        for j in (1, 2, 3):
            w = 2 * mp.sin(j * mp.pi / 8)
            shape = [mp.sin(i * j * mp.pi / 4) / mp.sqrt(2) for i in (1, 2, 3)]
            a, b = (sum(s * mp.mpf(x.numerator) / x.denominator for s, x in zip(shape, q, strict=True)) for q in starts)
            for i, s in enumerate(shape):
                right[i] += s * (a * mp.cos(w * time) + b / w * mp.sin(w * time))
                right[3 + i] += s * (b * mp.cos(w * time) - a * w * mp.sin(w * time))
        assert all(abs(x - y) < mp.mpf(10) ** -48 for x, y in zip(found, right, strict=True))
        for j, w in enumerate(motion.frequencies(50), start=1):
            assert abs(w - 2 * mp.sin(j * mp.pi / 8)) < mp.mpf(10) ** -48


def test_beats_of_pendulums_that_differ_in_the_tenth_digit():
    """Two of three equal pendulums, coupled at 1e-10: cos(t) cos(dt) after 1e10 swings, to all digits."""
    k = Fraction(1, 10**10)
    motion = Vibrations((ONE,) * 2, chain((ONE, ONE), (k,)), chain((NONE,) * 2, (NONE,)), (ONE, NONE), (NONE, NONE))
    found = motion.state(10**10, 40)
    with mpmath.workdps(70):
        w, t = mpmath.sqrt(1 + 2 / mpmath.mpf(10) ** 10), mpmath.mpf(10) ** 10
        assert abs(found[0] - (mpmath.cos(t) + mpmath.cos(w * t)) / 2) < mpmath.mpf(10) ** -39
        assert abs(found[1] - (mpmath.cos(t) - mpmath.cos(w * t)) / 2) < mpmath.mpf(10) ** -39


@pytest.mark.parametrize(
    ("springs", "dampers", "modes"),
    [
        (("1", "12"), (2, 4), ((1, 0), (5, 0))),  # both critical: A is defective
        ((2, 4), ("0.5", "0.5"), ((Fraction(1, 4), 1), (Fraction(3, 4), 1))),  # proportional
    ],
)
def test_symmetric_pair_is_two_oscillators(springs, dampers, modes):
    """Sum and difference of two equal masses: b = c/2 and (c + 2 c2)/2, w^2 = k and k + 2 k2."""
    (k, k2), (c, c2) = fractions(*springs), fractions(*dampers)
    motion = Vibrations((ONE, ONE), chain((k, k), (k2,)), chain((c, c), (c2,)), (ONE, NONE), (NONE, -ONE))
    found = motion.state("1.7", 50)
    with mpmath.workdps(70):
        mp, parts = mpmath.mp, []
        for b, w2, v0 in ((c / 2, k, -1), (c / 2 + c2, k + 2 * k2, 1)):
            rate, square, t = (mp.mpf(x.numerator) / x.denominator for x in (b, b * b - w2, Fraction("1.7")))
            root = mp.sqrt(square)
            cosine = mp.cosh(root * t).real
            sine = (mp.sinh(root * t) / root).real if root else t
            parts.append(mp.exp(-rate * t) * (cosine + (v0 + rate) * sine))
        assert abs(found[0] - (parts[0] + parts[1]) / 2) < mp.mpf(10) ** -48
        assert abs(found[1] - (parts[0] - parts[1]) / 2) < mp.mpf(10) ** -48
    decays = sorted({float(decay) for decay, _ in motion.rates()})
    assert decays == pytest.approx([float(b) for b, _ in modes])
    assert all((w == 0) == (swings == 0) for (_, w), (_, swings) in zip(motion.rates(), modes, strict=False))


def test_triple_zero_mode_drifts():
    motion = Vibrations((ONE,) * 3, STILL, STILL, fractions(1, 2, 3), fractions(1, 0, -1))
    assert motion.state(5) == (6, 2, -2, 1, 0, -1)
    assert motion.frequencies() == (0, 0, 0)
