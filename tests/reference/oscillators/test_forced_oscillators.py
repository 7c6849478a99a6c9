from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.oscillators.forced_oscillators import ForcedLinear, SwitchedOff
from mpmath import mpf


def forced(b="0.2", c=20, h=0, cosine=2, sine=0, p=3, r=0, x="0.5", v=0):
    return ForcedLinear(*map(Fraction, (b, c, h, cosine, sine, p, r, x, v)))


def transient_and_steady(b, c, f, p, x, v, t):
    """The textbook's formula for x'' + 2b x' + c x = f cos pt, not at resonance, in complex numbers."""
    steady = f / (c - p * p + 2j * b * p)
    root = mpmath.sqrt(mpmath.mpc(b * b - c))
    fast, slow = -b - root, -b + root
    x0, v0 = x - steady.real, v - (1j * p * steady).real
    first = (v0 - fast * x0) / (slow - fast)
    place = first * mpmath.exp(slow * t) + (x0 - first) * mpmath.exp(fast * t)
    return (place + (steady * mpmath.exp(1j * p * t)).real).real


@pytest.mark.parametrize(
    ("b", "c", "p", "t"),
    [("0.2", 20, "3", 10), ("0", 9, "3.0000000001", 50), ("500000", 1000, "3", 10), ("0.2", 20, "3", "209440.3")],
)
def test_against_transient_plus_steady_motion(b, c, p, t):
    x = forced(b, c, p=p).state(Fraction(t), 50)[0]
    with mpmath.workdps(160):
        expected = transient_and_steady(mpf(b), mpf(c), mpf(2), mpf(p), mpf("0.5"), mpf(0), mpf(t))
        assert abs(x - expected) < mpf("1e-48") * abs(expected)


def test_exact_resonance_grows_with_time():
    x, v = forced("0", 9, p=3, x=0).state(50, 50)
    with mpmath.workdps(60):
        assert mpmath.almosteq(x, mpf(50) / 3 * mpmath.sin(150), mpf("1e-48"))
        assert mpmath.almosteq(v, mpmath.sin(150) / 3 + 50 * mpmath.cos(150), mpf("1e-48"))


@pytest.mark.parametrize("t", [2, 20])
def test_a_load_at_the_double_rate(t):
    x = forced(2, 4, cosine=1, p=0, r=-2, x=1, v=0).state(t, 50)[0]
    with mpmath.workdps(60):
        assert mpmath.almosteq(x, mpmath.exp(-2 * t) * (1 + 2 * mpf(t) + mpf(t) ** 2 / 2), mpf("1e-48"))


@pytest.mark.parametrize(
    "numbers", [{}, {"b": 2, "c": 3, "r": -1, "p": 0}, {"b": 0, "c": -1}, {"b": 1, "c": 5, "r": -1, "p": 2}]
)
def test_the_equation_holds(numbers, residual):
    full = {"b": "0.2", "c": 20, "h": "0.3", "cosine": 2, "sine": -1, "p": 3, "r": "-0.1"} | numbers

    def rates(m, y):
        b, c, h, cosine, sine, p, r = (m.mpf(x) for x in full.values())
        load = m.exp(3 * r) * (cosine * m.cos(3 * p) + sine * m.sin(3 * p))
        return y[1], h + load - 2 * b * y[1] - c * y[0]

    assert residual(forced(**full), rates, 3) < mpf("1e-55")


def test_steady_vibration():
    motion = forced("0.5", 4, p=2)
    assert float(motion.magnification()) == 2  # at resonance 1/(2 zeta), zeta = 1/4
    assert float(motion.steady_amplitude()) == 1
    assert float(motion.phase_lag()) == pytest.approx(mpmath.pi / 2, rel=1e-15)
    assert float(motion.transmissibility()) == pytest.approx(5**0.5, rel=1e-15)
    # After 200 decay times only the steady vibration is left.
    with mpmath.workdps(60):
        assert mpmath.almosteq(motion.state(400, 50)[0], mpmath.sin(800), mpf("1e-48"))


def test_a_force_on_a_free_mass_leaves_a_drift_and_a_velocity():
    motion = SwitchedOff(forced(0, 0, cosine=0, sine=2, x=0), Fraction("17.3"))
    with mpmath.workdps(60):
        for t in (5, mpf("17.3")):
            x, v = motion.state(t, 50)
            assert abs(x - (2 * mpf(t) / 3 - 2 * mpmath.sin(3 * mpf(t)) / 9)) < mpf("1e-48")
        end = (1 - mpmath.cos(3 * mpf("17.3"))) * 2 / 3
        assert mpmath.almosteq(motion.state(20, 50)[1], end, mpf("1e-14"))
        assert abs(motion.impulse(Fraction(1), 50) - motion.state(20, 50)[1]) < mpf("1e-48")
        assert v is not None
