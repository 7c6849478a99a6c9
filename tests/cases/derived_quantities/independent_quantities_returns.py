"""Periods, precession and advances of angles, computed independently: from states a period apart.

Rates of planes and ellipses follow from Jacobians of the equations.
"""

from typing import Any

import mpmath
from gnomon.cases import get
from independent_quantities import ObservedMotion, close, oracle
from mpmath import cos, hypot, pi, sqrt


@oracle("period", "polar_period", "nutation_period", "body_period")
def returns(observed: ObservedMotion, period: Any) -> bool:
    """Rates of change (of a top the tilt) return after a period, but not after half or a third of it."""
    kept = [i for i, n in enumerate(observed.names) if n[0] != "R"]
    top = observed.case.name == "lagrange_top_attitude"

    def rates(t: Any) -> Any:
        slopes = observed.equations(observed.state(t))
        return mpmath.matrix([observed.at(t).R33] if top else [slopes[i] for i in kept])

    start = rates(0)
    size = mpmath.norm(start)
    assert all(mpmath.norm(rates(period / part) - start) > size / 1000 for part in (2, 3))
    # a top's initial matrix is made of doubles, orthogonal to about 15 digits
    return bool(mpmath.norm(rates(period) - start) < size * mpmath.mpf("1e-13" if top else "1e-18"))


@oracle("turn_time")
def a_whole_turn(observed: ObservedMotion, value: Any) -> bool:
    angles = [getattr(observed.at(t), observed.names[0]) for t in (0, value)]
    return close(abs(angles[1] - angles[0]), 2 * pi)


@oracle("center_of_mass_motion.period")
def separation_returns(observed: ObservedMotion, period: Any) -> bool:
    def apart(t: Any) -> Any:
        s = observed.at(t)
        return mpmath.matrix([s.x2 - s.x1, s.y2 - s.y1, s.vx2 - s.vx1, s.vy2 - s.vy1])

    assert mpmath.norm(apart(period / 2) + apart(0)) < 1e-18
    return bool(mpmath.norm(apart(period) - apart(0)) < 1e-18)


@oracle("planet_tunnel_rotating.period")
def distance_returns(observed: ObservedMotion, period: Any) -> bool:
    """In rotating axes the ellipse turns; the distance returns twice in a period, and it is not constant."""
    r = [hypot(s.x, s.y) for s in map(observed.at, (0, period / 2, period, period / 4))]
    return close(r[0], r[1]) and close(r[0], r[2]) and not close(r[0], r[3], 1)


@oracle("damped_oscillator.period", "gyrocompass_damped.period")
def zeros_return(observed: ObservedMotion, period: Any) -> bool:
    """x(t + T)/x(t) is the same at all t; with T/2 it is negative. Its logarithm is the decrement."""
    x = observed.names[0]
    ratios = [getattr(observed.at(t + period), x) / getattr(observed.at(t), x) for t in (period / 9, period / 5)]
    halves = [getattr(observed.at(t + period / 2), x) / getattr(observed.at(t), x) for t in (period / 9, period / 5)]
    assert close(*halves)
    assert halves[0] < 0 < ratios[0]
    if "logarithmic_decrement" in observed.found:
        assert close(observed.found["logarithmic_decrement"], -mpmath.log(ratios[0]))
    return close(*ratios)


@oracle("logarithmic_decrement")
def decrement_from_the_period(observed: ObservedMotion, value: Any) -> bool:
    return zeros_return(observed, observed.found["period"])


@oracle("foucault_pendulum_linear.swing_period", "foucault_precession.swing_period")
def ellipse_returns(observed: ObservedMotion, period: Any) -> bool:
    """In axes that rotate with the plane of swing the ellipse is closed."""
    turn = observed.found["precession_rate"]
    z = [mpmath.mpc(s.x, s.y) * mpmath.expj(-turn * t) for t in (0, period / 2, period) for s in [observed.at(t)]]
    return bool(abs(z[1] + z[0]) < 1e-17 and abs(z[2] - z[0]) < 1e-17)


@oracle(
    "foucault_pendulum_linear.precession_rate",
    "foucault_precession.precession_rate",
    "foucault_pendulum_centrifugal.precession_rate",
    "foucault_pendulum_nonlinear.precession_rate",
)
def half_of_the_coriolis_coefficient(observed: ObservedMotion, value: Any) -> Any:
    return -jacobian_of_plane_pendulum(observed)[2][3] / 2


def jacobian_of_plane_pendulum(observed: ObservedMotion) -> list[list[Any]]:
    """The Jacobian for (east, north, their rates), hanging at rest."""
    rest = {name: mpmath.mpf(0) for name in observed.names} | {"ez": mpmath.mpf(-1)}
    full, plane = observed.jacobian(rest), [i for i, name in enumerate(observed.names) if name not in ("ez", "vz")]
    return [[full[i, j] for j in plane] for i in plane]


@oracle("foucault_pendulum_centrifugal.swing_period", "foucault_pendulum_nonlinear.small_swing_period")
def swing_period_without_rotation(observed: ObservedMotion, value: Any) -> Any:
    rest = ObservedMotion(
        get(observed.case.name, lat=0, Om=0, L=observed.case.parameters["L"], g=observed.case.parameters["g"])
    )
    return 2 * pi / sqrt(-jacobian_of_plane_pendulum(rest)[2][0])


@oracle("anisotropy")
def difference_of_stiffness(observed: ObservedMotion, value: Any) -> Any:
    found = jacobian_of_plane_pendulum(observed)
    return abs(found[2][0] - found[3][1]) / (observed.p.g / observed.p.L)


@oracle("apsidal_rate")
def precession_of_an_ellipse(observed: ObservedMotion, value: Any) -> bool:
    """3/8 ab sqrt(g/L) in units of L, up to terms of order a^2, by the spherical pendulum; zero for a plane swing."""
    s = observed.at(0)
    if s.ex * s.vy == s.ey * s.vx:
        return bool(value == 0)
    small = ObservedMotion(get("spherical_pendulum", initial_state=("0.01", 0, 0), h="0.00003", L=1, g="9.81"))
    ellipse = get(observed.case.name, initial_state=("0.01", 0, s.ez, 0, "0.003", 0), L=1, g="9.81")
    rate = (small.found["azimuth_advance"] - pi) / small.found["polar_period"]
    return close(ellipse.quantities(20)["apsidal_rate"], rate, 3)


@oracle("azimuth_advance", "azimuth", "precession_per_nutation")
def advance_in_a_period(observed: ObservedMotion, value: Any) -> Any:
    """The advance of the cyclic angle in a period; for an attitude the advance of the axis about the vertical."""
    period = next(observed.found[n] for n in ("period", "polar_period", "nutation_period") if n in observed.found)
    if hasattr(observed.at(0), "phi"):
        return observed.at(period).phi - observed.at(0).phi
    start, end = observed.at(0), observed.at(period)
    across = mpmath.mpc(start.R13, start.R23), mpmath.mpc(end.R13, end.R23)
    return abs(mpmath.expj(value) - mpmath.sign(across[1] / across[0])) < 1e-13


@oracle("apsidal_angle")
def from_the_least_to_the_largest(observed: ObservedMotion, value: Any) -> Any:
    r, angle = observed.names[:2]
    turning = observed.extremes(lambda s: getattr(s, r), 2 * observed.found["period"])[1:-1]
    (first, a), (second, b) = turning[:2]
    assert {True} == {min(abs(x - observed.found[n]) for x in (a, b)) < 1e-17 for n in ("least", "largest")}
    return abs(getattr(observed.at(second), angle) - getattr(observed.at(first), angle))


@oracle("precession_per_period")
def turn_of_the_attitude(observed: ObservedMotion, value: Any) -> bool:
    """After a period of the body rates the attitude has rotated about the momentum: its trace is 1 + 2 cos."""
    start, end = (
        mpmath.matrix(3, 3) + mpmath.matrix([[getattr(s, f"R{i}{j}") for j in (1, 2, 3)] for i in (1, 2, 3)])
        for s in (observed.at(0), observed.at(observed.found["body_period"]))
    )
    turned = end * start.T
    return close((sum(turned[i, i] for i in range(3)) - 1) / 2, cos(value)) and close(
        value, observed.found["precession_rate"] * observed.found["body_period"]
    )


@oracle(*(f"{n}.precession_rate" for n in ("euler_top", "symmetric_top_torque_free")))
@oracle("dynamics_of_free_rigid_body_in_gravity.precession_rate")
def mean_turn_about_the_momentum(observed: ObservedMotion, value: Any) -> bool:
    """After a period of its rates a body has rotated about the momentum by the rate times the period."""
    moments = (
        [getattr(observed.p, n) for n in ("I1", "I2", "I3")]
        if hasattr(observed.p, "I1")
        else [observed.p.A] * 2 + [observed.p.C]
    )
    motion = observed.case.motion()
    period = (motion if hasattr(motion, "body_period") else motion.body).body_period(35)
    spins = [[x * getattr(observed.at(t), f"w{i}") for i, x in enumerate(moments, 1)] for t in (0, period)]
    assert all(close(a, b) for a, b in zip(*spins, strict=True))
    trace = sum(
        getattr(observed.at(0), f"R{i}{j}") * getattr(observed.at(period), f"R{i}{j}")
        for i in (1, 2, 3)
        for j in (1, 2, 3)
    )
    return close((trace - 1) / 2, cos(value * period))


@oracle("flip_interval")
def intermediate_rates_change_sign(observed: ObservedMotion, value: Any) -> bool:
    before, after = ([getattr(observed.at(t), f"w{i}") for i in (1, 2, 3)] for t in (0, value))
    return sorted(close(a, b) - close(a, -b) for a, b in zip(before, after, strict=True)) == [-1, -1, 1]
