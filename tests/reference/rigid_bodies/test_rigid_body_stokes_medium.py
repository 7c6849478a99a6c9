from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.precision import exact
from gnomon.reference.numerics.taylor import integrate
from gnomon.reference.rigid_bodies.rigid_body_stokes_medium import StokesBody
from mpmath import mpf

SKEWED = tuple(map(Fraction, ("1.1", "0.2", 0, "-0.3", "0.9", "0.4", 0, "0.1", 2)))


def body(nu, moments, rates, *attitude):
    return StokesBody(exact(nu), tuple(map(exact, moments)), tuple(map(exact, rates)), *attitude)


BODIES = {
    "general": body("0.1", (2, 3, 4), (1, "0.6", "0.3")),
    "strong, skewed": body(5, (2, 3, 4), (1, "-0.6", "0.3"), SKEWED),
    "separatrix": body("0.25", (1, 2, "2.25"), (3, 1, 4)),
    "rod": body("0.1", ("1e-9", 1, 1), (0, 1, "0.5")),
    "symmetric": body("0.1", (2, 2, 3), (1, "0.6", "0.8")),
    "no medium": body(0, (2, 3, 4), (1, "0.6", "0.3")),
}


@pytest.mark.parametrize("name", BODIES)
def test_the_body_moves_as_integrated(name):
    motion = BODIES[name]

    def field(t, state):
        i, nu = [ball(x) for x in motion.moments], ball(motion.nu)
        w, R = state[:3], state[3:]
        rates = [((i[k - 2] - i[k - 1]) * w[k - 2] * w[k - 1]) / i[k] - nu * w[k] for k in range(3)]
        for x, y, z in (R[:3], R[3:6], R[6:]):
            rates += [y * w[2] - z * w[1], z * w[0] - x * w[2], x * w[1] - y * w[0]]
        return tuple(rates)

    (state,) = integrate(field, (*motion.rates, *motion.attitude), (Fraction(2),), 60)
    with mpmath.workdps(60):
        pairs = zip(motion.state(2, 55), state, strict=True)
        assert max(abs(a - mpf(b.numerator) / b.denominator) for a, b in pairs) < mpf("1e-50")


def test_momentum_in_space_decays_and_keeps_its_direction():
    motion = BODIES["general"]
    with mpmath.workdps(70):

        def momentum(state):
            spin = [mpf(int(i)) * w for i, w in zip(motion.moments, state[:3], strict=True)]
            return [sum(state[3 + 3 * k + j] * spin[j] for j in range(3)) for k in range(3)]

        first, later = momentum(motion.state(0, 60)), momentum(motion.state(500, 60))
        fading = mpmath.exp(-50)
        # The attitude, of size 1, has 60 digits, and the rates are 1e-22.
        assert max(abs(a * fading - b) for a, b in zip(first, later, strict=True)) < mpf("1e-57")


def test_the_total_rotation_is_finite():
    motion = BODIES["strong, skewed"]
    with mpmath.workdps(50):
        end = motion.free.state(exact(motion.final_turn(60)), 40)
        assert max(abs(a - b) for a, b in zip(motion.state(100, 40)[3:], end[3:], strict=True)) < mpf("1e-37")
