from fractions import Fraction

import mpmath
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.taylor import integrate
from gnomon.reference.rigid_bodies.dynamics_of_free_rigid_body_in_gravity import FreeBody
from gnomon.reference.rigid_bodies.euler_top import EulerTop
from mpmath import mpf


def test_the_thrown_body_moves_as_integrated():
    g, moments = Fraction("9.81"), (Fraction(1), Fraction(2), Fraction("2.8"))
    top = EulerTop(moments, (Fraction("0.001"), Fraction(5), Fraction("0.001")))
    motion = FreeBody(g, (Fraction(0), Fraction(0), Fraction(1)), (Fraction(3), Fraction(0), Fraction(8)), top)

    def field(t, state):
        i, w, R = [ball(x) for x in moments], state[6:9], state[9:]
        rates = [*state[3:6], 0 * w[0], 0 * w[0], 0 * w[0] - ball(g)]
        rates += [((i[k - 2] - i[k - 1]) * w[k - 2] * w[k - 1]) / i[k] for k in range(3)]
        for x, y, z in (R[:3], R[3:6], R[6:]):
            rates += [y * w[2] - z * w[1], z * w[0] - x * w[2], x * w[1] - y * w[0]]
        return tuple(rates)

    start = (*motion.position, *motion.velocity, *top.rates, *top.attitude)
    (state,) = integrate(field, start, (Fraction(1),), 60)
    with mpmath.workdps(60):
        pairs = zip(motion.state(1, 55), state, strict=True)
        assert max(abs(a - mpf(b.numerator) / b.denominator) for a, b in pairs) < mpf("1e-50")
