"""Motions in a potential well: energy, rate, turning points, and the period by an independent quadrature."""

import mpmath
import pytest
from gnomon.reference.guided.curve_sliding import Catenary, Parabola, Quartic
from gnomon.reference.numerics.precision import exact
from gnomon.reference.orbits.central_force import HangingMass, Logarithmic, SpringDumbbell
from gnomon.reference.oscillators.rubber_tube_thick import ThickTube
from gnomon.reference.pendulums.light_cart import LightCart
from gnomon.reference.pendulums.pendulum_on_cart import CartPendulum


def made(kind, *numbers):
    return kind(*map(exact, numbers))


G = "9.81"
MOTIONS = {
    "tube": made(ThickTube, 3, 2, 2, 1),
    "tube under pressure": made(ThickTube, 3, 2, 1, 0, 2),
    "thin tube": made(ThickTube, "1e-6", 2, 2, 0),
    "parabola": made(Parabola, G, "0.5", 1, 1),
    "quartic": made(Quartic, G, 2, 1, 0),
    "catenary": made(Catenary, G, "0.5", 1, 0),
    "hanging mass": made(HangingMass, 1, 0, "0.5", 3, G, 1, 1),
    "logarithmic": made(Logarithmic, 1, 0, "0.5", "0.8", 1),
    "spring": made(SpringDumbbell, "1.4", 0, 0, 3, 20, 1),
    "cart": made(CartPendulum, G, 1, 2, 1, 0, 2, 0, 0),
}
CASES = [pytest.param(motion, id=name) for name, motion in MOTIONS.items()]


@pytest.mark.parametrize("motion", CASES)
def test_period_by_gauss_legendre_on_each_half(motion):
    """T = 2 int sqrt(M/(2 (E - V))) dx with x = low + y^2 and high - y^2, in mpmath, to 25 digits."""
    with mpmath.workdps(70):
        low, high = motion._edges(mpmath.mp)
        energy, middle = motion._energy(mpmath.mp), (low + high) / 2

        def integrand(edge, side):
            def of(y):
                with mpmath.workdps(70):  # E - V cancels at the ends
                    x = edge + side * y * y
                    left = energy - motion._potential(mpmath.mp, x)
                    return 2 * y * mpmath.sqrt(motion._mass(mpmath.mp, x) / (2 * left))

            return of

        with mpmath.workdps(30):
            root = mpmath.sqrt(middle - low)
            halves = [
                mpmath.quad(integrand(edge, side), [0, root / 2, root], method="gauss-legendre")
                for edge, side in ((low, 1), (high, -1))
            ]
        assert abs(2 * sum(halves) / motion.period(40) - 1) < mpmath.mpf(10) ** -25


@pytest.mark.parametrize("motion", CASES)
def test_the_energy_is_constant_and_the_rate_is_the_derivative(motion):
    """The derivative by differences over 1e-25 s."""
    with mpmath.workdps(80):
        t, step = exact("1.7"), exact("1e-25")
        index = 1 if isinstance(motion, CartPendulum) else 0
        before, here, after = (motion.state(s, 75) for s in (t - step, t, t + step))
        x, v = here[index], here[len(here) // 2 + index]
        size = abs(motion._energy(mpmath.mp)) + 1
        assert abs((after[index] - before[index]) / (2 * mpmath.mpf("1e-25")) - v) < mpmath.mpf(10) ** -44 * size
        energy = motion._mass(mpmath.mp, x) * v**2 / 2 + motion._potential(mpmath.mp, x)
        assert abs(energy - motion._energy(mpmath.mp)) < mpmath.mpf(10) ** -68 * size


def test_a_circular_motion_keeps_its_radius_exactly():
    assert made(HangingMass, 1, 0, 0, 2, 10, "2.5", 1).rests
    r, theta, _, omega = made(HangingMass, 1, 0, 0, 2, 10, "2.5", 1).state(1000)
    assert (r, theta, omega) == (1, 2000, 2)


def test_thin_tube_is_isochronous():
    """For gam -> 0 the period is pi/w but for terms of size gam."""
    with mpmath.workdps(30):
        assert abs(MOTIONS["thin tube"].period(20) * 2 / mpmath.pi - 1) < 1e-5


def test_a_tube_under_sudden_pressure_stretches_until_the_energies_are_equal():
    """From rest at x = 1 to w^2 ln(x^2 (1 + gam)/(x^2 + gam)) = p, so x^2 = gam q/(1 + gam - q), q = e^(p/w^2)."""
    motion = made(ThickTube, 3, 2, 1, 0, 2)
    with mpmath.workdps(40):
        grown = mpmath.exp(mpmath.mpf(2) / 4)
        least, largest = motion.turning_points(38)
        assert least == 1
        assert abs(largest - mpmath.sqrt(3 * grown / (4 - grown))) < mpmath.mpf("1e-36")
        assert 1 < motion.balance(38) < largest
    assert made(ThickTube, 3, 2, 1, 0, "5.545").holds
    assert not made(ThickTube, 3, 2, 1, 0, "5.546").holds


def test_a_light_cart_by_quadrature_from_the_turning_point():
    """The motion without a cosine series; for lighter carts, energy and centre of mass."""
    for start in ((0, 2, "0.3", 0), (0, "0.5", 0, "-1.5"), (0, "-0.5", 1, "1.5"), (0, "-0.5", 1, "-1.5"), (0, 0, 0, 1)):
        numbers = [exact(x) for x in (G, 1, "0.5", 1, *start)]
        one, other = LightCart(*numbers), CartPendulum(*numbers)
        for t in ("0.3", "2.3", "7.7"):
            for a, b in zip(one.state(t, 40), other.state(t, 40), strict=True):
                assert abs(a - b) < mpmath.mpf("1e-38")
        assert abs(one.period(40) - other.period(40)) < mpmath.mpf("1e-38")
    bare = LightCart(*(exact(x) for x in (G, 1, "1e-8", 1, 0, 2, "0.3", 0)))
    with mpmath.workdps(50):
        for t in ("0.5", "1.3", "4"):
            x, theta, vx, omega = bare.state(t, 50)
            light = mpmath.mpf("1e-8")
            energy = (1 + light) * vx**2 / 2 + omega**2 / 2 + vx * omega * mpmath.cos(theta)
            energy -= mpmath.mpf(G) * mpmath.cos(theta)
            start = (1 + light) * mpmath.mpf("0.3") ** 2 / 2 - mpmath.mpf(G) * mpmath.cos(2)
            assert abs(energy - start) < mpmath.mpf("1e-42") * (1 + omega**2)
            place = (1 + light) * (x - mpmath.mpf("0.3") * mpmath.mpf(t)) + mpmath.sin(theta)
            assert abs(place - mpmath.sin(2)) < mpmath.mpf("1e-45")
