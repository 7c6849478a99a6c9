"""Elliptic motions lie in the balls of their enclosures; a motion with a small error does not."""

from dataclasses import replace
from fractions import Fraction

import pytest
from gnomon.harness.certification.enclosures import enclosure
from gnomon.reference.numerics.motion import Motion
from gnomon.reference.numerics.precision import exact
from gnomon.reference.orbits.kepler_orbit import Kepler
from gnomon.reference.pendulums.pendulum_simple import Pendulum
from gnomon.reference.rigid_bodies.euler_top import EulerTop
from gnomon.reference.rigid_bodies.lagrange_top import LagrangeTop, SphericalPendulum
from gnomon.reference.rigid_bodies.lagrange_top_attitude import TopAttitude

F = Fraction
G = F("9.81")
MOTIONS = {
    "swing": Pendulum(G, F(1), F(2), F("0.3")),
    "swing, turns away": Pendulum(G, F(1), F(15), F(-1)),
    "rotation backwards": Pendulum(G, F(1), F("0.5"), F(-7)),
    "separatrix": Pendulum(G, G, F(0), F(-2)),
    "rest": Pendulum(G, F(1), F(0), F(0)),
    "body": EulerTop((F(2), F(3), F(4)), (F(1), F("0.6"), F("0.3"))),
    "body, odd order of axes": EulerTop((F(3), F(2), F(4)), (F("-0.1"), F("0.6"), F("-0.9"))),
    "body about its least axis": EulerTop((F(2), F(3), F(4)), (F(-1), F("0.1"), F("0.1"))),
    "body on the separatrix": EulerTop((F(1), F(2), F("2.25")), (F(-3), F(1), F(4))),
    "disc": EulerTop((F(2), F(2), F(3)), (F(1), F("0.6"), F("0.8"))),
    "steady": EulerTop((F(1), F(2), F(3)), (F(0), F(2), F(0))),
    "top": LagrangeTop(F("0.02"), F("0.01"), F("0.5"), F("0.6"), F("0.52"), F("0.6"), F(0), F(0), F(0)),
    "top, from the lower turn": LagrangeTop(F(1), F(1), F(1), F(2), F(1), F(2), F(0), F(1), F(-1)),
    "top, rising": LagrangeTop(F(1), F(1), F(1), F(2), F(-1), F(2), F(-1), F(0), F(0)),
    "top as a body, R(0) no rotation": TopAttitude(
        F(1), F(2), F(1), (F("0.3"), F(-1), F(2)), tuple(map(F, ("1.1", 0, "0.2", 0, 1, 0, "0.4", "-0.3", "0.9")))
    ),
    "spherical pendulum": SphericalPendulum(G, F(1), F("0.5"), F(1), F(0), F(0)),
    "spherical pendulum backwards": SphericalPendulum(G, F(1), F(-1), F("2.5"), F(1), F(3)),
}


def bound(motion: Motion, t: F) -> F:
    """The largest error of the state that the enclosure does not exclude."""
    enclosed = enclosure(motion, t, 45)
    assert enclosed is not None
    state = [exact(x) for x in motion.state(t, 40)]
    return max(abs(x - middle) + radius for x, (middle, radius) in zip(state, enclosed, strict=True))


@pytest.mark.parametrize("t", [F("0.37"), F("5.3")])
@pytest.mark.parametrize("name", MOTIONS)
def test_the_state_lies_in_its_ball(name: str, t: F) -> None:
    # 40 digits of angles up to about 100
    assert bound(MOTIONS[name], t) < F(1, 10**37)


def test_another_motion_does_not_lie_in_the_balls() -> None:
    class Off(Pendulum):
        def _state(self, mp, t):  # type: ignore[no-untyped-def]
            theta, omega = super()._state(mp, t)
            return theta, omega + mp.mpf(10) ** -20

    swing = MOTIONS["swing"]
    assert isinstance(swing, Pendulum)
    enclosed = enclosure(swing, F(3), 45)
    assert enclosed is not None
    wrong = Off(swing.g, swing.length, swing.theta0, swing.omega0).state(F(3), 40)
    assert abs(exact(wrong[1]) - enclosed[1][0]) > F(1, 10**21)
    other = enclosure(replace(swing, theta0=swing.theta0 + F(1, 10**30)), F(3), 45)
    assert other is not None
    assert abs(other[0][0] - enclosed[0][0]) > F(1, 10**32)


def test_special_and_other_motions_have_no_enclosure() -> None:
    passing = LagrangeTop(F(1), F(1), F(1), F(2), F(2), F(1), F(0), F(0), F(0))
    assert enclosure(passing, F(1), 30) is None
    orbit = Kepler.__new__(Kepler)
    assert enclosure(orbit, F(1), 30) is None
