"""Frequencies, decay rates, equilibria and limits of stability, computed independently: from Jacobians of the equations."""

from typing import Any

import mpmath
from gnomon.cases import get
from independent_quantities import SMOOTH, ObservedMotion, angle_at_rest, close, oracle, swing
from mpmath import cos, pi, sin, sqrt


@oracle("small_swing_period")
def about_hanging(observed: ObservedMotion, value: Any) -> Any:
    return 2 * pi / swing(observed, angle_at_rest(observed, 0))


@oracle("small_swing_frequency")
def about_the_rest_angle(observed: ObservedMotion, value: Any) -> Any:
    return swing(observed, angle_at_rest(observed, observed.found["rest_angle"]))


@oracle("rest_angle", "tilted_equilibrium")
def force_vanishes(observed: ObservedMotion, value: Any) -> bool:
    assert value != 0 or observed.case.name == "chain_in_circular_tube"
    rest = angle_at_rest(observed, value)
    return abs(observed.equations(rest)[1]) < 1e-20 and observed.jacobian(rest)[1, 0] < 0


@oracle("balance")
def rates_vanish(observed: ObservedMotion, value: Any) -> bool:
    return bool(abs(observed.equations([value, mpmath.mpf(0)])[1]) < 1e-20)


@oracle("small_frequency")
def about_where_it_rests(observed: ObservedMotion, value: Any) -> Any:
    return swing(observed, angle_at_rest(observed, observed.found.get("tilted_equilibrium", 0)))


@oracle("small_angle_period")
def without_the_square_of_the_earths_rate(observed: ObservedMotion, value: Any) -> bool:
    """The exact period differs by terms in the square of the Earth's rate, which vanish for a slower Earth."""
    gaps = []
    for slower in (1, 10):
        there = ObservedMotion(get(observed.case.name, Om=observed.case.parameters["Om"] / slower))
        gaps.append(swing(there, angle_at_rest(there, 0)) * there.found["small_angle_period"] / (2 * pi) - 1)
    return abs(gaps[0]) < 0.1 and abs(gaps[1]) < abs(gaps[0]) / 9


def frequency_at_constant_momentum(observed: ObservedMotion, rest: Any, steady: Any) -> Any:
    """Frequency in the first coordinate at constant momentum of the second, ignorable one."""
    spin = observed.names[3]
    momentum = "momentum" if "momentum" in observed.case.invariants else "angular_momentum"

    def held(x: Any) -> Any:
        def off(w: Any) -> Any:
            there = [x, *observed.state(0)[1:2], mpmath.mpf(0), w]
            return observed.invariant(momentum, 0, there) - observed.invariant(momentum, 0, [rest, *there[1:3], steady])

        w = mpmath.findroot(off, steady)
        return observed.equations({observed.names[0]: x, observed.names[2]: mpmath.mpf(0), spin: w})[2]

    h = mpmath.mpf("1e-10")
    return sqrt(-(held(rest + h) - held(rest - h)) / (2 * h))


def steady_spin(observed: ObservedMotion, angle: Any) -> Any:
    spin = observed.names[3]

    def off(w: Any) -> Any:
        there = [angle, mpmath.mpf(0), mpmath.mpf(0), w]
        return observed.invariant("momentum", 0, there) - observed.invariant("momentum")

    return mpmath.findroot(off, getattr(observed.at(0), spin))


@oracle("steady_angle")
def turns_at_constant_angle(observed: ObservedMotion, value: Any) -> bool:
    spin = steady_spin(observed, value)
    return bool(abs(observed.equations([value, mpmath.mpf(0), mpmath.mpf(0), spin])[2]) < 1e-17)


@oracle("rotating_pendulum_free_hoop.small_frequency", "engineering_design_analysis.small_frequency")
def about_the_steady_angle(observed: ObservedMotion, value: Any) -> bool:
    angle = observed.found["steady_angle"]
    return close(value, frequency_at_constant_momentum(observed, angle, steady_spin(observed, angle)), 15)


@oracle("circle_rate")
def on_a_parallel_circle(observed: ObservedMotion, value: Any) -> bool:
    """By the equations the height stays constant."""
    return bool(abs(observed.equations({observed.names[2]: mpmath.mpf(0), observed.names[3]: value})[2]) < 1e-20)


@oracle("circle_vibration")
def about_the_parallel_circle(observed: ObservedMotion, value: Any) -> bool:
    return close(
        value, frequency_at_constant_momentum(observed, observed.state(0)[0], observed.found["circle_rate"]), 15
    )


def eigenvalues(observed: ObservedMotion, rest: Any) -> list[Any]:
    return list(mpmath.eig(observed.jacobian(rest), left=False, right=False))


@oracle(
    *(f"frequency_{i}" for i in (1, 2, 3)),
    *(f"decay_{i}" for i in (1, 2)),
    *("slow_frequency", "fast_frequency", "swing_frequency", "spring_frequency", "natural_frequency"),
    *("larger_rate", "smaller_rate", "slow_rate", "fast_rate"),
)
def eigenvalue(observed: ObservedMotion, value: Any) -> bool:
    """The values, sorted, are the real or imaginary parts of the eigenvalues of the equations, each once."""
    ours = {n: v for n, v in observed.found.items() if SMOOTH.get(n) is eigenvalue}
    rest = {n: mpmath.mpf(0) for n in observed.names} | {"y": -observed.found.get("hanging_length", mpmath.mpf(0))}
    found = eigenvalues(observed, rest)
    swings = sorted(x.imag for x in found if x.imag > 1e-15)
    decays = sorted({round(-x.real, 20) for x in found if abs(x.imag) > 1e-15}, key=float)
    plain = sorted((x.real for x in found), reverse=True)
    if observed.case.name == "rayleigh_dissipation_mdof":
        pairs = sorted((x.imag, -x.real) for x in found if x.imag > 0)
        return all(
            close(ours[f"frequency_{i}"], w) and close(ours[f"decay_{i}"], d) for i, (w, d) in enumerate(pairs, 1)
        )
    if observed.case.name == "slider_rotating_slot":
        sorted_ours = [observed.found["larger_rate"], observed.found["smaller_rate"]]
        return all(close(a, b, 10) for a, b in zip(sorted_ours, plain, strict=True))
    if observed.case.name == "forced_oscillator":
        return close(observed.found["natural_frequency"] ** 2, abs(found[0] * found[1]))
    if "slow_rate" in ours:
        return all(close(a, -b, 10) for a, b in zip((ours["slow_rate"], ours["fast_rate"]), plain, strict=True))
    assert not decays or max(map(abs, decays)) < 1e-15
    return all(close(a, b, 10) for a, b in zip(sorted(ours.values()), swings, strict=True))


@oracle("damping_ratio")
def half_the_trace_over_the_root_of_the_determinant(observed: ObservedMotion, value: Any) -> Any:
    found = observed.jacobian([mpmath.mpf(0), mpmath.mpf(0)])
    return -found[1, 1] / (2 * sqrt(-found[1, 0]))


@oracle("undamped_period")
def without_the_trace(observed: ObservedMotion, value: Any) -> Any:
    return 2 * pi / sqrt(-observed.jacobian([mpmath.mpf(0), mpmath.mpf(0)])[1, 0])


@oracle("overshoot_time")
def passes_through_zero(observed: ObservedMotion, value: Any) -> bool:
    before = [observed.at(value * k / 16).x for k in range(16)]
    return abs(observed.at(value).x) < 1e-18 and len({x > 0 for x in before}) == 1


@oracle("pendulum_length", "string_length")
def of_a_pendulum_with_the_same_small_swings(observed: ObservedMotion, value: Any) -> Any:
    return observed.p.g / swing(observed, angle_at_rest(observed, 0)) ** 2


@oracle("modulus_squared")
def of_the_period(observed: ObservedMotion, value: Any) -> bool:
    """K(m) gives the period: 4 K/w of a pendulum, 2 sqrt(m) K/w of one that turns over, 4 K/sqrt(a + b A^2) of Duffing's."""
    if observed.case.name == "duffing_unforced":
        # the modulus for a softening spring is the modulus of sn
        soft = 2 if observed.p.beta < 0 else 1
        stiff = sqrt(observed.p.alpha + observed.p.beta * observed.found["largest_x"] ** 2 / soft)
        return close(observed.found["period"], 4 * mpmath.ellipk(value) / stiff)
    rest = observed.found.get("rest_angle", 0)
    w = swing(observed, angle_at_rest(observed, rest))
    if "turn_time" in observed.found:
        return close(observed.found["turn_time"], 2 * sqrt(value) * mpmath.ellipk(value) / w) or close(
            observed.found["turn_time"], 2 * mpmath.ellipk(1 / value) / (w * sqrt(value))
        )
    return close(observed.found["period"], 4 * mpmath.ellipk(value) / w)


@oracle("one_minus_modulus_squared")
def complement(observed: ObservedMotion, value: Any) -> Any:
    return 1 - observed.found["modulus_squared"]


@oracle("hanging_length", "static_deflection")
def where_it_hangs(observed: ObservedMotion, value: Any) -> bool:
    rest = {n: mpmath.mpf(0) for n in observed.names}
    if "y" not in rest:  # x is measured downward from the unstretched springs
        return bool(abs(observed.equations([value, mpmath.mpf(0)])[1]) < 1e-20)
    return bool(abs(observed.equations(rest | {"y": -value})[3]) < 1e-20)


@oracle("stiffness_in_series")
def of_the_vibration(observed: ObservedMotion, value: Any) -> Any:
    return observed.p.m * swing(observed, [mpmath.mpf(0)] * 2) ** 2


@oracle("stiffness_in_parallel")
def of_stretched_together(observed: ObservedMotion, value: Any) -> Any:
    return observed.p.k1 + observed.p.k2


@oracle("critical_rate", "bifurcation_time")
def bottom_loses_stability(observed: ObservedMotion, value: Any) -> bool:
    """The restoring force at the lowest point vanishes at that time, when the hoop has the critical rate."""
    time = observed.found["bifurcation_time"]
    assert close(observed.found["critical_rate"], observed.p.Om + observed.p.sweep * time)
    return bool(abs(observed.jacobian(angle_at_rest(observed, 0), time)[1, 0]) < 1e-18)


@oracle("sleeping_spin")
def upright_loses_stability(observed: ObservedMotion, value: Any) -> bool:
    """With b = a a small tilt grows below the limit and not above it."""
    slopes = []
    for share in ("0.999", "1.001"):
        spin = value * mpmath.mpf(share)
        tilt = mpmath.mpf("1e-6")
        slopes.append(observed.equations([tilt, 0, 0, 0], a=spin, b=spin)[1])
    return bool(slopes[0] > 0 > slopes[1])


@oracle("slow_precession", "fast_precession")
def regular_precession(observed: ObservedMotion, value: Any) -> bool:
    """At the initial tilt, with b such that phi' is this rate, theta'' vanishes."""
    theta = observed.at(0).theta
    b = observed.p.I1 * value * sin(theta) ** 2 + observed.p.a * cos(theta)
    assert abs(observed.found["slow_precession"]) < abs(observed.found["fast_precession"])
    if "b" in vars(observed.p):
        rates = observed.equations([theta, mpmath.mpf(0), mpmath.mpf(0), mpmath.mpf(0)], b=b)
        return close(rates[2], value) and abs(rates[1]) < 1e-18
    weight, a = observed.p.W, observed.p.a
    return bool(abs(observed.p.I1 * value**2 * cos(theta) - a * value + weight) < 1e-18)


@oracle("lagrange_top_small_nutation.nutation_rate")
def of_the_small_nutation(observed: ObservedMotion, value: Any) -> Any:
    return abs(max(x.imag for x in eigenvalues(observed, [observed.p.tilt, 0, 0, 0])))


@oracle("gyrocompass_tilting.nutation_rate")
def of_the_free_axis(observed: ObservedMotion, value: Any) -> Any:
    """With a slow Earth and a light weight the higher of the two frequencies."""
    found = observed.jacobian([mpmath.mpf(0)] * 4)
    coupling = -found[2, 3] * found[3, 2]
    return bool(abs(sqrt(coupling) / value - 1) < 2 * observed.p.Om / observed.p.s)


@oracle("level_tilt")
def points_north_at_rest(observed: ObservedMotion, value: Any) -> bool:
    rates = observed.equations([mpmath.mpf(0), value, mpmath.mpf(0), mpmath.mpf(0)])
    return max(map(abs, rates)) < 1e-18 and 0 < value < observed.p.lat


@oracle("rolling_limit", "spinning_limit")
def upright_disc_loses_stability(observed: ObservedMotion, value: Any) -> bool:
    """Tilt and rates grow exponentially below the limit and not above it."""
    spin = {"w3": value} if value is observed.found["rolling_limit"] else {"w2": value}
    growth = []
    for share in ("0.999", "1.001"):
        rest = {n: mpmath.mpf(0) for n in observed.names} | {"theta": pi / 2}
        rest |= {n: v * mpmath.mpf(share) for n, v in spin.items()}
        full, kept = observed.jacobian(rest), [observed.names.index(n) for n in ("theta", "w1", "w2", "w3")]
        part = mpmath.matrix([[full[i, j] for j in kept] for i in kept])
        growth.append(max(x.real for x in mpmath.eig(part, left=False, right=False)))
    return bool(growth[0] > 1e-3 and growth[1] < 1e-9)


@oracle("circle_spin")
def inclination_stays(observed: ObservedMotion, value: Any) -> bool:
    """With this w3 the rates of the tilt vanish: theta' = w1 = 0 and w1' = 0."""
    rates = dict(zip(observed.names, observed.equations({"w1": mpmath.mpf(0), "w3": value}), strict=True))
    return bool(abs(rates["w1"]) < 1e-18 and abs(rates["w2"]) < 1e-18)


@oracle("routh")
def routh_parameter(observed: ObservedMotion, value: Any) -> Any:
    masses = [observed.p.m1, observed.p.m2, observed.p.m3]
    return mpmath.mpf(27) / 2 * (1 - sum(m * m for m in masses) / sum(masses) ** 2)


@oracle("growth_a_turn")
def growth_by_rouths_quartic(observed: ObservedMotion, value: Any) -> Any:
    companion = mpmath.matrix([[0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [-observed.found["routh"] / 4, 0, -1, 0]])
    roots = mpmath.eig(companion, left=False, right=False)
    return mpmath.exp(2 * pi * max(x.real for x in roots))
