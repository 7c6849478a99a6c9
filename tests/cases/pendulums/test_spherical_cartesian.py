"""The formulation of the spherical pendulum in Cartesian coordinates has the motion of that in angles."""

from fractions import Fraction

import numpy as np
import pytest
from gnomon.cases.core.arithmetic import mpmath_arithmetic, rebind
from gnomon.cases.core.registry import get
from gnomon.reference.numerics.precision import working


@pytest.mark.parametrize("variant", [None, "near_pole", "upper_half"])
@pytest.mark.parametrize("t", ["0.3", "2.1"])
def test_encoded_exact_states_move_by_the_equations_and_decode(variant: str | None, t: str) -> None:
    case = get("spherical_pendulum", variant).rounded()
    (cartesian,) = case.formulations
    (form,) = cartesian.forms
    h = Fraction(1, 10**25)
    with working(100) as mp:
        parameters = tuple(mp.mpf(v) for v in case.parameter_values())
        before, here, after = (
            cartesian.encode(mp, [mp.mpf(x) for x in case.exact(Fraction(t) + d, 90)], parameters) for d in (-h, 0, h)
        )
        slopes = rebind(form.equations, mpmath_arithmetic(mp))(mp.mpf(0), here, parameters)
        # Differences over 1e-25 have an error of 1e-50 times third derivatives.
        for a, b, slope in zip(after, before, slopes, strict=True):
            assert abs((a - b) / (2 * mp.mpf(h)) - slope) < mp.mpf(10) ** -42
    state = [float(x) for x in case.exact(t)]
    decoded = cartesian.decode(np.array([[float(x) for x in here]]), [float(v) for v in case.parameter_values()])[0]
    # Rounded coordinates change an angle by an ulp over the sine of the tilt, the azimuth modulo a turn.
    tilt = np.sin(state[0])
    turns = (decoded[2] - state[2]) / (2 * np.pi)
    assert decoded[:2] == pytest.approx(state[:2], rel=1e-14 / tilt, abs=1e-14 / tilt)
    assert turns == pytest.approx(round(turns), abs=1e-14 / tilt)
