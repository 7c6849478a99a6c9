from fractions import Fraction

import mpmath
import pytest
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.precision import exact
from gnomon.reference.numerics.taylor import integrate
from gnomon.reference.rigid_bodies.flywheels import BeltDrive, CoastDown, Flywheel
from mpmath import mpf


def difference(found, state):
    with mpmath.workdps(70):
        return max(abs(a - mpf(b.numerator) / b.denominator) for a, b in zip(found, state, strict=True))


@pytest.mark.parametrize("start", [(100, 0), (0, 50)])
def test_the_belt_drive_obeys_the_balances_of_momentum_and_energy(start):
    """I1 w1/r1 + I2 w2/r2 grows by M t/r1, slipping or not; the energy lost is F times the distance slipped."""
    drive = BeltDrive(*map(exact, ("0.5", 2, "0.1", "0.25", 60, 4)), *map(exact, start))
    with mpmath.workdps(60):

        def momentum(state):
            return mpf("0.5") * state[0] / mpf("0.1") + 2 * state[1] / mpf("0.25")

        for t in (drive.grip_time / 2, drive.grip_time, 2 * drive.grip_time):
            time = mpf(t.numerator) / t.denominator
            gained = momentum(drive.state(t, 50)) - momentum(drive.state(0, 50))
            assert abs(gained - 4 * time / mpf("0.1")) < mpf("1e-44")
        first, second = drive.state(drive.grip_time, 50)
        assert abs(first * mpf("0.1") - second * mpf("0.25")) < mpf("1e-48")
        end = drive.grip_time
        turned = (exact(start[0]) + drive.gripped[0]) / 2 * end  # of the first pulley, under the torque
        energies = [Fraction(1, 4) * w1**2 + w2**2 for w1, w2 in (map(exact, start), drive.gripped)]
        assert energies[0] + 4 * turned - energies[1] == drive.belt_energy_loss


@pytest.mark.parametrize("drag", ["0.5", 0])
def test_the_flywheel_turns_as_integrated(drag):
    inertia, c, torque, share, rate = map(exact, (10, drag, 20, "1.5", 6))
    wheel = Flywheel(inertia, c, torque, share, rate, Fraction(0), Fraction(30))

    def field(t, state):
        return state[1], (ball(torque) * (1 + ball(share) * (ball(rate) * t).cos()) - ball(c) * state[1]) / ball(
            inertia
        )

    (state,) = integrate(field, (Fraction(0), Fraction(30)), (Fraction(5),), 60)
    assert difference(wheel.state(5, 55), state) < mpf("1e-50")


def test_the_fluctuation_is_that_of_the_steady_state():
    wheel = Flywheel(*map(exact, (10, 5, 20, 1, 6, 0, 4)))
    rates = [float(wheel.state(100 + Fraction(k, 500))[1]) for k in range(1000)]
    # Sampled at 500 a second: the top of a cosine of 6 rad/s is missed by 2e-5 of the amplitude at most.
    assert (max(rates) - min(rates)) / 2 == pytest.approx(float(wheel.fluctuation()), rel=1e-4)


@pytest.mark.parametrize(("c", "torque"), [("0.05", 2), (0, 2), (1, "1e-9")])
def test_coasting_down_as_integrated_until_the_stop(c, torque):
    wheel = CoastDown(Fraction(10), exact(c), exact(torque), Fraction(0), Fraction(30))

    def field(t, state):
        return state[1], -(ball(wheel.M) + ball(wheel.c) * state[1]) / ball(wheel.inertia)

    stop = exact(wheel.stop_time(60))
    (state,) = integrate(field, (Fraction(0), Fraction(30)), (stop,), 60)
    assert difference((wheel.stop_angle(55), mpf(0)), state) < mpf("1e-46")
    assert wheel.state(2 * stop, 40) == (wheel.stop_angle(40), 0)
