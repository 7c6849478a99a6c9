"""Numbers in the names and texts of variants, compared with the exact motion."""

import math
from collections.abc import Callable
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from gnomon.cases import Case, case_class, get, names
from gnomon.cases.core.forms import FirstOrder


def smallest_tilt(case: Any) -> float:
    """The smallest tilt from the vertical, up or down, from the heights between which the axis nutates."""
    low, high = case.exact_motion.heights(30)
    return math.sqrt(2 * float(min(1 + low, 1 - high)))


def last(case: Case, name: str) -> float:
    return float(case.exact(case.span)[[c.name for c in case.state].index(name)])


def spread(case: Case, name: str) -> tuple[float, float]:
    column = case.sample(case.times)[:, [c.name for c in case.state].index(name)]
    return float(column.min()), float(column.max())


def ratio_of_spins(case: Case) -> float:
    low, high = spread(case, "spin")
    return high / low


def farthest_lean(case: Case) -> float:
    times = np.linspace(0.0, float(case.span), 300)
    return math.degrees(np.abs(case.sample(times)[:, 2] - math.pi / 2).max())


def growth_of_a_shift(case: Case) -> float:
    shift = Fraction(1, 10**20)
    beside = case.with_numbers((case.initial_state[0] + shift, case.initial_state[1]), case.parameters)
    return abs(float(case.exact(case.span, 32)[0] - beside.exact(case.span, 32)[0])) / float(shift)


def fast_over_slow(case: Any) -> float:
    """The ratio of the frequencies of small motions about equilibrium: its tilt by Newton's method, then the Jacobian."""
    parameters = tuple(map(float, case.parameter_values()))

    def rates(y: Any) -> Any:
        return np.array(case.equations_of_motion(0.0, tuple(y), parameters))

    def slopes(y: Any, step: float = 1e-6) -> Any:
        return np.array([(rates(y + step * e) - rates(y - step * e)) / (2 * step) for e in np.eye(4)]).T

    place = np.array([0.0, 0.5, 0.0, 0.0])
    for _ in range(20):
        place = place - np.linalg.solve(slopes(place), rates(place))
    turning = np.abs(np.linalg.eigvals(slopes(place)).imag)
    return float(turning.max() / turning.min())


def rod_over_crank(case: Case) -> float:
    x, y, slider = (float(value) for value in case.initial_state[:3])
    return math.hypot(slider - x, y) - math.hypot(x, y)


def crank_from_below(case: Case) -> float:
    """The largest angle of a crank about the origin from the downward vertical, up to 90 degrees."""
    first, second = (float(value) for value in case.initial_state[:2])
    return math.asin(spread(case, case.state[0].name)[1] / math.hypot(first, second))


def quantity(name: str) -> Callable[[Case], float]:
    return lambda case: float(case.quantities()[name])


def spring_over_swing(case: Case) -> float:
    return quantity("spring_frequency")(case) / quantity("swing_frequency")(case)


def eccentricity(case: Case) -> float:
    """From initial energy and angular momentum, for two bodies of the relative motion."""
    x, y, u, v = (float(value) for value in case.initial_state[:4])
    mu = float(case.parameters["mu"])
    energy, momentum = (u * u + v * v) / 2 - mu / math.hypot(x, y), x * v - y * u
    return math.sqrt(max(0.0, 1 + 2 * energy * momentum**2 / mu**2))


def below_escape(case: Case) -> float:
    """The relative difference of the initial speed from the escape speed, exactly: 0 for a parabola."""
    x, y, u, v = case.initial_state
    assert y == u == 0
    return float(1 - v / Fraction(math.isqrt(int(2 * case.parameters["mu"] / x))))


def beside_the_middle_axis(case: Case) -> float:
    w = [abs(float(value)) for value in case.initial_state[:3]]
    return max(w[0], w[2]) / w[1]


def ratio_of_rates(case: Case) -> float:
    """The largest over the smallest rate of the Jacobian of the first-order equations at the start."""
    form = next(form for form in case.all_forms() if isinstance(form, FirstOrder))
    parameters, size = tuple(map(float, case.parameter_values())), len(case.state)
    columns = [
        form.equations(0.0, tuple(row), parameters) for row in np.eye(size)
    ]  # the equations are linear, so these are the columns
    rates = np.abs(np.linalg.eigvals(np.array(columns).T))
    return float(rates.max() / rates.min())


def turns(name: str, period: Callable[[Case], float] | None = None) -> Callable[[Case], float]:
    """The span in units of a quantity, a period (s)."""
    return lambda case: float(case.span) / (quantity(name)(case) if period is None else period(case))


def cycles(name: str) -> Callable[[Case], float]:
    """The span in cycles of a quantity, a rate (rad/s)."""
    return lambda case: float(case.span) * quantity(name)(case) / math.tau


PERIODS = {
    "pendulum_simple": ("long_1e3", "long_1e4", "long_1e6"),
    "harmonic_oscillator": ("long_1e6",),
    "duffing_unforced": ("long_1e3", "long_1e4"),
    "damped_oscillator": ("long_1e5",),
    "kepler_orbit": ("orbits_1e3", "orbits_1e4", "orbits_1e6", "orbits_1e6_e09"),
    "planet_tunnel": ("long_1e5",),
    "planet_tunnel_rotating": ("long_1e5",),
    "rotating_pendulum": ("long_1e4",),
    "rotating_pendulum_free_hoop": ("long_1e4",),
    "two_body": ("orbits_1e5",),
    "chain_in_circular_tube": ("long_1e4",),
    "moment_of_momentum_pendulum": ("long_1e4",),
    "work_energy_spring_block": ("long_1e3",),
    "rubber_tube_thin": ("long_1e5",),
    "chain_smooth_curve": ("long_1e5",),
    "curve_sliding_small": ("long_1e4",),
    "central_force_conservation": ("long_1e5",),
    "pendulum_on_cart": ("long_1e4",),
    "two_mass_spring": ("long_1e5",),
    "center_of_mass_motion": ("long_1e5",),
    "holonomic_constraint_dae": ("long_1e3",),
    "ignorable_coordinates": ("long_1e4",),
    "particle_on_paraboloid": ("long_1e4",),
    "particle_on_torus": ("long_1e3", "long_1e4"),
    "rotation_fixed_axis_compound_pendulum": ("long_1e4",),
    "rolling_sphere_in_bowl": ("long_1e4",),
    "engineering_design_analysis": ("long_1e4",),
}
"""Variants whose name ends with the number of periods in their span."""

NAMED: dict[str, tuple[Callable[[Any], float], float]] = {
    **{
        f"{case}/{name}": (turns("period"), float(name.split("_")[1]))
        for case, names_ in PERIODS.items()
        for name in names_
    },
    "duffing_unforced/saddle_1e_8": (quantity("least_x"), 1e-8),
    "duffing_unforced/saddle_1e_12": (quantity("least_x"), 1e-12),
    "damped_oscillator/stiff_1e6": (ratio_of_rates, 1e6),
    "damped_oscillator/stiff_1e9": (ratio_of_rates, 1e9),
    "damped_oscillator/stiff_1e12": (ratio_of_rates, 1e12),
    "kepler_orbit/e09": (eccentricity, 0.9),
    "kepler_orbit/e0999": (lambda case: 1 - eccentricity(case), 1e-3),
    "kepler_orbit/e0999999": (lambda case: 1 - eccentricity(case), 1e-6),
    "kepler_orbit/speed_e06": (eccentricity, 0.6),
    "kepler_orbit/speed_e099": (lambda case: 1 - eccentricity(case), 0.01),
    "kepler_orbit/near_parabolic_bound": (below_escape, 1e-12),
    "kepler_orbit/near_parabolic_unbound": (below_escape, -1e-12),
    "euler_top/flips_1e6": (beside_the_middle_axis, 1e-6),
    "euler_top/flips_1e12": (beside_the_middle_axis, 1e-12),
    "euler_top/revolutions_1e3": (turns("body_period"), 1e3),
    "euler_top/revolutions_1e4": (turns("body_period"), 1e4),
    "euler_top/revolutions_1e5": (turns("body_period"), 1e5),
    "charge_in_E_and_B/long_1e5": (turns("gyration_period"), 1e5),
    "relativistic_charge/gamma_1e6": (quantity("gamma"), 1e6),
    "forced_oscillator/long_1e5": (lambda case: float(case.span * case.parameters["w"]) / math.tau, 1e5),
    "inertial_straight_line/turns_1e5": (lambda case: float(case.span * case.parameters["Om"]) / math.tau, 1e5),
    "bouncing_ball/elastic_1e6": (lambda case: float(case.span) / quantity("period")(case), 1e6),
    "bouncing_ball/engines_e1": (lambda case: float(case.parameters["e"]), 1.0),
    "bouncing_ball/engines_e08": (lambda case: float(case.parameters["e"]), 0.8),
    "small_vibrations_3dof_chain/long_1e3": (cycles("frequency_1"), 1e3),
    "small_vibrations_3dof_chain/long_1e4": (cycles("frequency_1"), 1e4),
    "small_vibrations_mdof/stiff_1e12": (lambda case: (ratio_of_rates(case)) ** 2, 2e12),
    "two_body/e0999": (lambda case: 1 - quantity("pericentre")(case) / quantity("semi_major_axis")(case), 0.999),
    "equilateral_three_body/e09": (
        lambda case: (
            (1 - quantity("shortest_side")(case) / quantity("longest_side")(case))
            / (1 + quantity("shortest_side")(case) / quantity("longest_side")(case))
        ),
        0.9,
    ),
    "impulse_instantaneous/short_1e-3": (lambda case: float(case.parameters["T"]), 1e-3),
    "impulse_instantaneous/short_1e-9": (lambda case: float(case.parameters["T"]), 1e-9),
    "restitution_impact_1d_2d/ratio_1e4": (lambda case: float(case.parameters["m2"] / case.parameters["m1"]), 1e4),
    "restitution_impact_1d_2d/ratio_1e6": (lambda case: float(case.parameters["m2"] / case.parameters["m1"]), 1e6),
    "rubber_tube_thin/squeezed_1e-2": (lambda case: float(case.initial_state[0]), 1e-2),
    "rubber_tube_thin/squeezed_1e-4": (lambda case: float(case.initial_state[0]), 1e-4),
    "man_on_cart/long_1e5": (lambda case: float(case.span * case.parameters["w"]) / math.tau, 1e5),
    "lagrange_top/precessions_1e4": (
        lambda case: turns("nutation_period")(case) * quantity("precession_per_nutation")(case) / math.tau,
        1e4,
    ),
    "lagrange_top_attitude/precessions_1e4": (
        lambda case: turns("nutation_period")(case) * quantity("precession_per_nutation")(case) / math.tau,
        1e4,
    ),
    "lagrange_top_small_nutation/long_1e4": (cycles("nutation_rate"), 1e4),
    "spherical_pendulum/long_1e3": (turns("polar_period"), 1e3),
    "spherical_pendulum/long_1e4": (turns("polar_period"), 1e4),
    "symmetric_top_torque_free/turns_1e5": (cycles("precession_rate"), 1e5),
    "stiff_spring_pendulum/ratio_100": (spring_over_swing, 100),
    "stiff_spring_pendulum/ratio_1000": (spring_over_swing, 1000),
    "fermi_pasta_ulam/omega_200": (lambda case: float(case.parameters["w"]), 200),
    "fermi_pasta_ulam/omega_1000": (lambda case: float(case.parameters["w"]), 1000),
    "car_axis/stiff_1e6": (lambda case: float(case.parameters["k"]), 1e6),
    "knife_edge_incline/long_1e4": (lambda case: float(case.span * case.parameters["w"]) / math.tau, 1e4),
}
"""For each variant with a number in its name, a function that measures it, and the number."""

CLAIMS: dict[str, tuple[Callable[[Any], float], float]] = {
    "central_force_hanging_mass/near_hole: passes 0.1 m": (quantity("least"), 0.1),
    "central_force_hanging_mass/light: to 47 m": (quantity("largest"), 46.85),
    "central_force_shortened_string/slow: 1,568 turns": (lambda case: last(case, "theta") / math.tau, 1568),
    "particle_on_torus/thin: 420 swings": (lambda case: math.pi / quantity("apsidal_angle")(case), 420),
    "chain_quarter_circle/just_longer: L = 1.00004": (
        lambda case: float(case.parameters["L"] / case.parameters["R"]) * 2 / math.pi - 1,
        4e-5,
    ),
    "engineering_design_analysis/light_spindle: the rate doubles": (ratio_of_spins, 2),
    "dynamics_of_free_rigid_body_in_gravity/high: 43 turns": (
        lambda case: quantity("precession_rate")(case) * float(case.span) / math.tau,
        43,
    ),
    "stick_slip_belt/many: 1,389 cycles": (lambda case: len(case.events()) / 2, 1389),
    "stick_slip_falling_friction/many: 1,315 cycles": (lambda case: len(case.events()) / 2, 1315.5),
    "stick_slip_falling_friction/slope_near_zero: 3e-8 m/s, for 1.6e-4 s": (
        lambda case: 2 * quantity("stick_time")(case),
        1.66e-4,
    ),
    "stick_slip_falling_friction/stiff_spring: slips of 6 ms": (lambda case: 1e3 * quantity("slip_time")(case), 6.06),
    "stick_slip_falling_friction/spirals_out: 23 growing swings": (lambda case: case.exact_motion.turns, 23),
    "spherical_pendulum/near_pole: passes 3e-7 rad": (smallest_tilt, 3.3e-7),
    "gyrocompass_tilting/fast_spin: 246 times": (fast_over_slow, 246),
    "lagrange_top/near_vertical: passes 2e-6 rad": (smallest_tilt, 2.3e-6),
    "lagrange_top/fast: a million times": (
        lambda case: math.tau / quantity("precession_per_nutation")(case),
        1e6,
    ),
    "lagrange_top_sleeping_separatrix/from_vertical: 18 s of exponential growth, to 9e-3": (
        lambda case: last(case, "theta"),
        9.4e-3,
    ),
    "rolling_disc/straight_slow: to 65 degrees": (farthest_lean, 65),
    # 1 slug, 0.1963495 ft^2, drag coefficient 0.1; the density at sea level is 1.225 kg/m^3
    "vertical_quadratic_drag/nasa_sphere: the sphere of the check cases": (
        lambda case: float(case.parameters["k"]) / (1.225 * 0.1 * 0.1963495 * 0.3048**2 / (2 * 14.5939)),
        1,
    ),
    "tippe_top/strong_friction: decays in 1 ms": (lambda case: 1e3 * case.time_scale, 0.927),
    "tippe_top/nearly_upright: two million times": (lambda case: 1e6 * math.acos(last(case, "ez") / 0.3), 2.23e6),
    "bouncing_ball_table/chaotic: 3e12-fold": (growth_of_a_shift, 3.35e12),
    "chattering_ball/hard_bounces: 101 bounces": (lambda case: case.counts[0][0], 101),
    "chattering_ball/many: 30 chatters": (lambda case: sum(e.name == "release" for e in case.events()), 30),
    "impact_oscillator/chaotic: 1.5e8-fold": (growth_of_a_shift, 1.48e8),
    "slider_crank/near_fold: rod 1 cm longer": (rod_over_crank, 0.0099),
    "slider_crank/small_swings: swings of 0.067 rad": (crank_from_below, 0.0673),
    "four_bar_linkage/small_swings: swings of 0.067 rad": (crank_from_below, 0.0676),
    "four_bar_linkage/parallelogram: swings to 79 degrees": (lambda case: math.degrees(crank_from_below(case)), 79.4),
}


@pytest.mark.parametrize("claim", CLAIMS)
def test_what_a_variant_says_is_so(claim: str) -> None:
    name, _, words = claim.partition(": ")
    case = get(*name.split("/"))
    stresses = next(v.stresses for v in case.variants if v.name == case.variant)
    assert words in stresses
    measure, stated = CLAIMS[claim]
    # The texts have two digits.
    assert measure(case) == pytest.approx(stated, rel=0.02)


@pytest.mark.parametrize("variant", NAMED)
def test_a_variant_is_as_hard_as_its_name_says(variant: str) -> None:
    """A variant that is easier than its name says (1e-6 for 1e-12) would run as well and not test the hard case."""
    measure, stated = NAMED[variant]
    # A name has one digit, and spans are deliberately not whole periods.
    assert measure(get(*variant.split("/"))) == pytest.approx(stated, rel=0.05)


def test_every_variant_with_a_number_in_its_name_is_measured() -> None:
    named = {
        f"{name}/{variant.name}"
        for name in names()
        for variant in case_class(name).variants
        if any(letter.isdigit() for letter in variant.name)
    }
    lost = ", ".join(sorted(named - set(NAMED)))
    assert not lost, f"{lost}: write how the number is measured into PERIODS or NAMED of tests/cases/test_stresses.py"
