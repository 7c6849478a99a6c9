"""Changes of the code that must make tests fail, each with the tests that reach it.

Each is a fault that no test found before, seen in a review or while the tests for it were written; but for those drawn at
random, at the end.
"""

from __future__ import annotations

from pathlib import Path

from mutate import Mutation

METHODS, CASES = "harness/integrators", "cases"
ON_METHODS, ON_CASES, ON_REFERENCE = "tests/harness/integrators", "tests/cases", "tests/reference"
ON_RUNNING = "tests/harness/running"
STAGES = f"{ON_METHODS}/test_stage_equations.py"
USED = "test_the_options_recorded_are_the_options_used"
FOLLOW = "test_equations_follow_from_points_and_forces"
ARM = "test_an_arm_is_rotated_with_its_attitude_also_with_a_part_along_the_axis"
CLOSURE = f"{ON_REFERENCE}/storage/test_import_closure.py"

STEPPING = (
    Mutation(
        "splitting: the time does not advance within a step",
        f"{METHODS}/geometric/splitting.py",
        "splitting_step",
        "now += drift",
        "now += 0.0 * drift",
        (f"{ON_METHODS}/geometric/test_splitting.py::test_time_drifts_with_the_position",),
    ),
    Mutation(
        "splitting: symplectic Euler drifts before it kicks",
        f"{METHODS}/geometric/splitting.py",
        "SymplecticEuler.coefficients",
        "[[mp.mpf(1)], [mp.mpf(1)]]",
        "[[mp.mpf(0), mp.mpf(1)], [mp.mpf(1), mp.mpf(0)]]",
        (
            f"{ON_METHODS}/geometric/test_splitting.py::test_symplectic_euler_kicks_with_the_old_position_and_drifts_with_the_new_velocity",
        ),
    ),
    Mutation(
        "stormer: one acceleration fewer for the velocity",
        f"{METHODS}/multistep_extrapolation/stormer.py",
        "Stormer.coefficients",
        "adams_weights(cls.order + 1)",
        "[*adams_weights(cls.order), Fraction(0)]",
        (
            f"{ON_METHODS}/multistep_extrapolation/test_stormer.py::test_the_velocity_is_exact_for_one_power_of_time_more_than_the_place",
        ),
    ),
    Mutation(
        "adaptive: sums are not compensated",
        f"{METHODS}/base/step_control.py",
        "integrate",
        "compensation[i] = change[i] - (end[i] - y[i])",
        "compensation[i] = 0.0",
        (f"{ON_METHODS}/base/test_step_control.py::test_sums_are_compensated",),
    ),
    Mutation(
        "embedded: the trial step does not look at the motion",
        f"{METHODS}/base/sizes.py",
        "trial_step",
        "min(TRIAL * most, 0.01 * slowest) if slowest > 0.0 else TRIAL * most",
        "TRIAL * most",
        (f"{ON_METHODS}/base/test_step_control.py::test_the_trial_step_is_short_beside_the_motion",),
    ),
    Mutation(
        "embedded: the trial step is a hundred times the time of the slowest group",
        f"{METHODS}/base/sizes.py",
        "trial_step",
        "0.01 * slowest",
        "100.0 * slowest",
        (f"{ON_METHODS}/base/test_step_control.py::test_the_trial_step_is_short_beside_the_motion",),
    ),
    Mutation(
        "adaptive: the first step does not look at how the motion turns",
        f"{METHODS}/base/step_control.py",
        "first_step",
        "turning_time(y, rates, later, h, groups, most)",
        "most",
        (
            f"{ON_METHODS}/base/test_step_control.py::test_the_first_step_is_a_part_of_the_time_in_which_the_motion_turns",
        ),
    ),
    Mutation(
        "embedded: the absolute rule looks at one end of a step",
        f"{METHODS}/base/sizes.py",
        "one_over",
        "max(abs(y[i]), abs(end[i]))",
        "abs(y[i])",
        (f"{ON_METHODS}/base/test_step_control.py::test_the_absolute_rule_takes_the_larger_of_both_ends",),
    ),
    Mutation(
        "embedded: sizes of the start are kept",
        f"{METHODS}/base/step_control.py",
        "integrate",
        "enlarge(end, groups, sizes) or t == 0.0",
        "t == 0.0",
        (f"{ON_METHODS}/base/test_step_control.py::test_a_motion_that_grows_is_measured_by_the_size_that_it_has",),
    ),
    Mutation(
        "events: a guard just met, below zero by round-off, fires again",
        f"{METHODS}/events/event_stepping.py",
        "run",
        "(value == 0.0 or (g == where[FIRED] and value < 0.0))",
        "value == 0.0",
        (f"{ON_METHODS}/events/test_hybrid.py::test_a_flight_that_starts_a_rounding_below_the_floor_ends_on_it",),
    ),
    Mutation(
        "events: a guard of the next mode that is zero on arrival is missed",
        f"{METHODS}/events/event_stepping.py",
        "run",
        "(value == 0.0 or (g == where[FIRED] and value < 0.0))",
        "(g == where[FIRED] and value <= 0.0)",
        (f"{ON_METHODS}/events/test_hybrid.py::test_a_guard_of_the_next_mode_that_is_zero_on_arrival_counts",),
    ),
    Mutation(
        "events: the step after an event is like any other",
        f"{METHODS}/events/event_stepping.py",
        "run",
        "state = EVENT",
        "state = SMOOTH",
        (f"{ON_METHODS}/events/test_event_stepping.py::test_the_changes_of_state_are_those_of_the_diagram",),
    ),
    Mutation(
        "events: steps grow sixty times",
        f"{METHODS}/events/event_stepping.py",
        "run",
        "min(6.0, 0.9 * max(error, 1e-10) ** (-1 / 8))",
        "min(60.0, 0.9 * max(error, 1e-10) ** (-1 / 8))",
        (f"{ON_METHODS}/base/test_step_control.py::test_a_step_without_error_is_followed_by_one_six_times_as_long",),
    ),
    Mutation(
        "events: steps do not grow",
        f"{METHODS}/events/event_stepping.py",
        "run",
        "min(6.0, 0.9 * max(error, 1e-10) ** (-1 / 8))",
        "min(1.0, 0.9 * max(error, 1e-10) ** (-1 / 8))",
        (f"{ON_METHODS}/base/test_step_control.py::test_a_step_without_error_is_followed_by_one_six_times_as_long",),
    ),
)

IMPLICIT = (
    Mutation(
        "gauss: stages are accepted with any residual",
        f"{METHODS}/gauss/gauss_steps.py",
        "settled",
        "if change == 0.0:",
        "if change <= 1e-3:",
        (f"{STAGES}::test_linear_steps_are_those_of_the_stability_function[ImplicitMidpoint]",),
    ),
    Mutation(
        "gauss: a cycle of rounds counts as round-off",
        f"{METHODS}/gauss/gauss_steps.py",
        "settled",
        "if iteration == 0 or not change < NOISE * roundoff:",
        "if iteration == 0:",
        (f"{STAGES}::test_a_large_change_is_never_accepted", f"{STAGES}::test_a_cycle_of_rounds_is_no_solution"),
    ),
    Mutation(
        "gauss: no absolute floor in rounds of first order",
        f"{METHODS}/gauss/gauss_steps.py",
        "gauss_step",
        "if h * distance > SMALLEST and",
        "if h * distance > 0.0 and",
        (f"{STAGES}::test_rounds_come_to_rest_below_the_smallest_number",),
    ),
    Mutation(
        "gauss: no absolute floor in rounds of second order",
        f"{METHODS}/gauss/gauss_steps.py",
        "gauss_nystrom_step",
        "if h * distance > SMALLEST and",
        "if h * distance > 0.0 and",
        (f"{STAGES}::test_rounds_come_to_rest_below_the_smallest_number",),
    ),
    Mutation(
        "gauss: no absolute floor in Newton's iteration",
        f"{METHODS}/gauss/gauss_steps.py",
        "newton_step",
        "if difference > SMALLEST:",
        "if difference > 0.0:",
        (f"{STAGES}::test_what_decays_beyond_the_smallest_number_comes_to_rest",),
    ),
    Mutation(
        "rattle: a position is accepted with any residual of the constraint",
        f"{METHODS}/geometric/rattle.py",
        "onto_constraint",
        "if settled(iteration, change, least, stalled, roundoff):",
        "if change <= 1e-3:",
        (f"{STAGES}::test_steps_on_a_circle_end_at_the_near_root_or_fail_by_name",),
    ),
    Mutation(
        "radau: stages are accepted with any residual",
        f"{METHODS}/gauss/radau_steps.py",
        "newton",
        "if norm <= 1e-3 * enough or (iteration > 1 and rate < 1.0 and rate / (1.0 - rate) * norm <= enough):",
        "if iteration > 1:",
        (f"{STAGES}::test_adaptive_radau_solves_its_stages_to_a_part_of_its_tolerance",),
    ),
    Mutation(
        "radau: stages are accepted at thirty times the residual",
        f"{METHODS}/gauss/radau_steps.py",
        "newton",
        "enough = max(rest, min(0.03, sqrt(tolerance)))",
        "enough = max(30.0 * rest, min(0.9, 30.0 * sqrt(tolerance)))",
        (f"{STAGES}::test_adaptive_radau_solves_its_stages_to_a_part_of_its_tolerance",),
    ),
    Mutation(
        "radau: changes that do not shrink count as round-off",
        f"{METHODS}/gauss/radau_steps.py",
        "newton",
        "if iteration > 1 and rate >= 1.0 and norm <= rest:",
        "if iteration > 1 and rate >= 1.0 and norm <= enough:",
        (f"{ON_METHODS}/gauss/test_radau.py::test_changes_that_do_not_shrink_are_no_solution",),
    ),
    Mutation(
        "radau: a sample is the end of its step",
        f"{METHODS}/gauss/radau_steps.py",
        "integrate",
        "out[m, sample, i] = y[i] + (compensation[i] + between(part, table, z, i))",
        "out[m, sample, i] = y[i] + (compensation[i] + z[2, i])",
        (f"{ON_METHODS}/gauss/test_radau.py::test_stiffness_takes_no_more_steps",),
    ),
    Mutation(
        "radau: every sample is a value of its step's polynomial",
        f"{METHODS}/gauss/radau_steps.py",
        "integrate",
        "not smooth(step, table, weight, start, z, norm)",
        "norm < 0.0",
        (f"{ON_METHODS}/gauss/test_radau.py::test_a_sample_is_as_good_as_a_step",),
    ),
    Mutation(
        "radau: step sizes are not predicted",
        f"{METHODS}/gauss/radau_steps.py",
        "integrate",
        "scale *= min(1.0, step / reach * scale)",
        "scale *= 1.0",
        (f"{ON_METHODS}/gauss/test_radau.py::test_steps_follow_the_predictive_controller",),
    ),
    Mutation(
        "gauss fast: stiff equations are handed over at a thousand times the tolerance",
        f"{METHODS}/gauss/gauss_fast.py",
        "stiffly",
        "radau.prepared(problem, max(tolerance, finest), 0.0)",
        "radau.prepared(problem, max(1000 * tolerance, finest), 0.0)",
        (
            f"{ON_METHODS}/test_gauss_fast_scale.py::test_stiff_motion_is_handed_over_with_the_tolerance_that_was_asked_for",
        ),
    ),
    Mutation(
        "gauss fast: small components are handed over at a thousand times the tolerance",
        f"{METHODS}/gauss/gauss_fast.py",
        "stiffly",
        "max(tolerance * smallest, finest)",
        "max(1000 * tolerance * smallest, finest)",
        (
            f"{ON_METHODS}/test_gauss_fast_scale.py::test_stiff_motion_is_handed_over_with_the_tolerance_that_was_asked_for",
        ),
    ),
    Mutation(
        "gauss fast: the iteration of an ensemble may leave a hundred times as much",
        f"{METHODS}/gauss/gauss_fast_constants.py",
        "",
        "iteration_share_of_ensemble: float = 0.1",
        "iteration_share_of_ensemble: float = 10.0",
        (f"{ON_METHODS}/test_gauss_fast_scale.py::test_an_ensembles_iteration_leaves_a_part_of_the_tolerance",),
    ),
)

RUNNING = (
    Mutation(
        "heyoka: a hundred times the tolerance that is recorded",
        "harness/adapters/heyoka.py",
        "Taylor.prepare",
        "heyoka.taylor_adaptive(equations, [0.0] * problem.dimension, **options)",
        'heyoka.taylor_adaptive(equations, [0.0] * problem.dimension, **(options | {"tol": 100 * setting}))',
        (f"tests/harness/adapters/test_heyoka.py::{USED}",),
    ),
    Mutation(
        "heyoka: an ensemble at a hundred times the tolerance that is recorded",
        "harness/adapters/heyoka.py",
        "Taylor.prepare",
        "heyoka.taylor_adaptive_batch(equations, start, **options)",
        'heyoka.taylor_adaptive_batch(equations, start, **(options | {"tol": 100 * setting}))',
        (f"tests/harness/adapters/test_heyoka.py::{USED}",),
    ),
    *(
        Mutation(
            f"{name}: a hundred times the tolerance that is recorded",
            f"harness/adapters/{file}.py",
            function,
            before,
            after,
            (f"tests/harness/adapters/{tests}",),
        )
        for name, file, function, before, after, tests in (
            (
                "rebound",
                "rebound_nbody",
                "Native.prepare",
                "name, value)",
                "name, 100 * value)",
                f"test_rebound.py::{USED}",
            ),
            (
                "rebound ODE",
                "rebound_ode",
                "OdeMode.prepare",
                "name, value)",
                "name, 100 * value)",
                f"test_rebound.py::{USED}",
            ),
            (
                *("scipy events", "scipy_events", "trajectory", "events=side.guards, **options,"),
                *(
                    'events=side.guards, **(options | {"rtol": 100 * options["rtol"]}),',
                    "test_scipy.py::test_the_options_recorded_with_events_are_those_of_each_segment",
                ),
            ),
        )
    ),
    Mutation(
        "pybullet: other damping, other limits than are recorded",
        "harness/adapters/pybullet_world.py",
        "World._extra",
        "**values)",
        "**{name: value + 1 for name, value in values.items()})",
        (f"tests/harness/adapters/test_pybullet.py::{USED}",),
    ),
    Mutation(
        "compare: a single setting may be worse by any factor",
        "harness/results/regression.py",
        "",
        "if ratio > SINGLE_FACTOR:",
        "if ratio > np.inf:",
        ("tests/harness/results/test_regression.py::test_a_much_larger_error_at_any_one_setting_is_a_regression",),
    ),
    *(
        Mutation(f"cache: {name}", "reference/storage/import_closure.py", function, before, after, (CLOSURE,))
        for name, function, before, after in (
            ("the key of sources is a constant", "closure", "hashlib.sha256(", 'hashlib.sha256(b"" and '),
            (
                "the sources of imported modules are left out",
                "sources",
                "if _is_followed(",
                "if False and _is_followed(",
            ),
            ("relative imports are not followed", "_imports", "ast.ImportFrom)", "ast.ImportFrom) and not node.level"),
            ("imports inside functions are not followed", "_imports", "ast.walk(tree)", "tree.body"),
            ("packages that act are left out", "_acts", "_read(package).acts", "not _read(package).acts"),
            ("code loaded before an edit counts as edited", "_source", "and module in sys.modules", "and False"),
            ("the functions of a motion are left out", "modules_of", "found.add(value.__module__)", "pass"),
        )
    ),
)

EXACT = (
    Mutation(
        "metric: angles more than half a turn off are not wrapped",
        f"{CASES}/core/metric.py",
        "Group.difference",
        "np.remainder(raw + math.pi, 2 * math.pi) - math.pi",
        "raw",
        (f"{ON_CASES}/core/test_metric.py::test_angles_alone_are_compared_modulo_a_turn",),
    ),
    Mutation(
        "metric: lengths are wrapped like angles",
        f"{CASES}/core/metric.py",
        "Metric.scaled",
        'wrapped = case.state[members[0]].kind == "angle"',
        "wrapped = True",
        (f"{ON_CASES}/core/test_metric.py::test_angles_alone_are_compared_modulo_a_turn",),
    ),
    *(
        Mutation(
            f"sizes: {file}, {text}, twice as large",
            f"{CASES}/{file}.py",
            function,
            text,
            f"2 * ({text})",
            (f"{ON_CASES}/test_scales.py::test_scales_are_those_of_the_motion[{Path(file).name}]",),
        )
        for file, function, text in (
            (
                "contact/coulomb_friction_oscillator",
                "CoulombFrictionOscillator.scales",
                "max(abs(float(self.x)), first)",
            ),
            ("contact/coulomb_friction_oscillator", "CoulombFrictionOscillator.scales", "float(motion.fastest())"),
            ("pendulums/foucault_pendulum_linear", "FoucaultLinear.scales", "p + q"),
            ("pendulums/foucault_pendulum_linear", "FoucaultLinear.scales", "p * faster + q * slower"),
            ("pendulums/pendulum_on_cart", "PendulumOnCart.scales", "abs(vx + arm * omega * cos(theta)) + arm * rate"),
        )
    ),
    *(
        Mutation(
            f"time scales: {file}, ten times as long",
            f"{CASES}/{file}.py",
            f"{kind}.time_scale",
            f"return {text}",
            f"return 10 * {text}",
            (f"{ON_CASES}/test_scales.py::test_time_scales_are_those_of_the_equations[{Path(file).name}]",),
        )
        for file, kind, text in (
            (
                "contact/coulomb_friction_oscillator",
                "CoulombFrictionOscillator",
                "math.sqrt(float(self.m / self.k))",
            ),
            (
                "pendulums/foucault_pendulum_linear",
                "FoucaultLinear",
                "1 / max(abs(float(rate)) for rate in self.exact_motion.circles()[2:])",
            ),
            ("pendulums/foucault_pendulum_nonlinear", "FoucaultNonlinear", "min(math.sqrt(length / g)"),
        )
    ),
    Mutation(
        "variants: near_parabolic_bound is a thousand times easier",
        f"{CASES}/orbits/kepler_orbit.py",
        "KeplerOrbit",
        "2 * (1 - 1e-12)",
        "2 * (1 - 1e-9)",
        (
            f"{ON_CASES}/test_stresses.py::test_a_variant_is_as_hard_as_its_name_says[kepler_orbit/near_parabolic_bound]",
        ),
    ),
    Mutation(
        "variants: flips_1e12 is flips_1e6",
        f"{CASES}/rigid_bodies/euler_top.py",
        "EulerTopCase",
        'spinning("1e-12", 1, "1e-12")',
        'spinning("1e-6", 1, "1e-6")',
        (f"{ON_CASES}/test_stresses.py::test_a_variant_is_as_hard_as_its_name_says[euler_top/flips_1e12]",),
    ),
    *(
        Mutation(
            f"tables: values may be wrong by {ulp} of an ulp",
            "reference/numerics/tablekernel.py",
            "",
            "DOUBT = 2.0**-7",
            f"DOUBT = {ulp}",
            (f"{ON_REFERENCE}/numerics/test_tablekernel.py",),
        )
        for ulp in ("2.0**-5", "2.0**-1")
    ),
    Mutation(
        "equations: the gyrocompass is damped twice as much",
        f"{CASES}/rigid_bodies/gyrocompass_nonlinear.py",
        "damped_at_any_angle",
        "c * omega / across",
        "2 * c * omega / across",
        (f"{ON_CASES}/test_equations.py::test_equations_follow_from_points_and_forces[gyrocompass_damped_nonlinear]",),
    ),
    Mutation(
        "equations: the Earth turns about the other horizontal axis in Foucault's pendulum",
        f"{CASES}/pendulums/foucault_pendulum_nonlinear.py",
        "foucault_sphere",
        "oy, oz = rate * cos(lat)",
        "oy, oz = -rate * cos(lat)",
        (f"{ON_CASES}/test_equations.py::test_equations_follow_from_points_and_forces[foucault_pendulum_nonlinear]",),
    ),
    Mutation(
        "scenes: the top's weight has no arm",
        f"{CASES}/scenes/top.py",
        "standing",
        "place = (arm * r[2], arm * r[5], arm * r[8])",
        "place = (0.0, 0.0, 0.0)",
        ("tests/harness/adapters/test_scene_accelerations.py::test_a_body_on_a_ball_joint[lagrange_top]",),
    ),
    Mutation(
        "scenes: the top's weight has half its arm",
        f"{CASES}/scenes/top.py",
        "standing",
        "Scene((0.0, 0.0, -weight / arm)",
        "Scene((0.0, 0.0, -weight / (2 * arm))",
        ("tests/harness/adapters/test_scene_accelerations.py::test_a_body_on_a_ball_joint[lagrange_top]",),
    ),
    Mutation(
        "scenes: the Earth turns about the other horizontal axis in Foucault's pendulum",
        f"{CASES}/pendulums/foucault_pendulum_nonlinear.py",
        "bob_scene",
        "oy, oz = rate * cos(lat)",
        "oy, oz = -rate * cos(lat)",
        (
            "tests/harness/adapters/test_scene_accelerations.py::test_a_body_on_a_ball_joint[foucault_pendulum_nonlinear]",
        ),
    ),
    Mutation(
        "hierarchies: small swings of Foucault's pendulum are projected to above the support",
        f"{CASES}/pendulums/foucault_pendulum_nonlinear.py",
        "FoucaultNonlinear.hierarchy",
        "height = -np.sqrt",
        "height = np.sqrt",
        (
            f"{ON_CASES}/test_hierarchies.py::test_a_projected_motion_starts_at_the_start_and_its_positions_change_at_its_rates[foucault_pendulum_nonlinear]",
        ),
    ),
    Mutation(
        "hierarchies: small swings of Foucault's pendulum fall where they should rise",
        f"{CASES}/pendulums/foucault_pendulum_nonlinear.py",
        "FoucaultNonlinear.hierarchy",
        "-(x * u + y * w) / height",
        "(x * u + y * w) / height",
        (
            f"{ON_CASES}/test_hierarchies.py::test_a_projected_motion_starts_at_the_start_and_its_positions_change_at_its_rates[foucault_pendulum_nonlinear]",
        ),
    ),
)

POOL = (
    Mutation(
        "pool: the time limit of a call has no grace",
        "harness/running/pool.py",
        "Pool._handle",
        'self._stage(slot, "run", limit + GRACE_SECONDS)',
        'self._stage(slot, "run", limit)',
        ("tests/harness/running/test_pool.py",),
    ),
    Mutation(
        "pool: a compilation keeps the deadline of the call",
        "harness/running/pool.py",
        "Pool._handle",
        '                slot.interrupted = (slot.stage, slot.seconds)\n            self._stage(slot, "prepare", self.prepare_seconds)',
        "                slot.interrupted = (slot.stage, slot.seconds)",
        ("tests/harness/running/test_pool.py",),
    ),
    Mutation(
        "pool: after a compilation the deadline of the preparation stays",
        "harness/running/pool.py",
        "Pool._handle",
        "self._stage(slot, *slot.interrupted)",
        "pass",
        ("tests/harness/running/test_pool.py",),
    ),
    Mutation(
        "pool: a trial with a short limit is tried once",
        "harness/running/pool.py",
        "Pool._late",
        "slot.tries >= TRIES",
        "slot.tries >= 1",
        ("tests/harness/running/test_pool.py",),
    ),
    Mutation(
        "pool: waits for the processor do not extend a deadline",
        "harness/running/pool.py",
        "Pool._late",
        "slot.deadline += waited\n",
        "slot.deadline += 0.0\n",
        ("tests/harness/running/test_pool.py",),
    ),
    Mutation(
        "pool: a signal from outside counts as a crash",
        "harness/running/pool.py",
        "Pool._died",
        "if code in OUTSIDE else",
        "if code in () else",
        ("tests/harness/running/test_pool.py",),
    ),
    Mutation(
        "pool: a lost server costs the trial at once",
        "harness/running/pool.py",
        "Pool._died",
        "code == LOST and not slot.again",
        "False",
        ("tests/harness/running/test_pool.py",),
    ),
    Mutation(
        "pool: a refusal ends the worker",
        "harness/running/pool.py",
        "Pool._handle",
        "status not in ANSWERS",
        "True",
        ("tests/harness/running/test_pool.py",),
    ),
    Mutation(
        "pool: answers to earlier requests count",
        "harness/running/pool.py",
        "Pool._drain",
        "message.request == slot.request.number and not",
        "not",
        ("tests/harness/running/test_pool.py",),
    ),
    Mutation(
        "pool: an interruption leaves the workers",
        "harness/running/pool.py",
        "Pool.run",
        "for slot in list(self._slots):\n                self._end(slot)",
        "pass",
        ("tests/harness/running/test_pool.py",),
    ),
    Mutation(
        "pool: a worker may take all of the memory",
        "harness/running/pool.py",
        "Pool._launch",
        "worker_bytes(self.workers)",
        "2**50",
        ("tests/harness/running/test_pool.py",),
    ),
)

RECORDS = (
    Mutation(
        "sweep: later launches store states",
        "harness/running/sweep.py",
        "Sweep.done",
        "states if self.launch == 1 else None",
        "states",
        (f"{ON_RUNNING}/test_sweep.py::test_later_launches_measure_times_alone",),
    ),
    Mutation(
        "sweep: later launches solve from turned starts",
        "harness/running/sweep.py",
        "Sweep._request",
        "suite.turned and self.launch == 1 and",
        "suite.turned and",
        (f"{ON_RUNNING}/test_sweep.py::test_later_launches_measure_times_alone",),
    ),
    Mutation(
        "sweep: counts that fell predict lower ones",
        "harness/running/sweep.py",
        "Sweep._predicted",
        "max(min(ratios), 1.0)",
        "min(ratios)",
        (f"{ON_RUNNING}/test_sweep.py::test_a_count_that_fell_predicts_none_below_it",),
    ),
    Mutation(
        "sweep: a missing library is tried at every setting",
        "harness/running/sweep.py",
        "Sweep._note",
        "known.status in CANNOT_RUN",
        "False",
        (f"{ON_RUNNING}/test_sweep.py::test_what_cannot_run_ends_the_series_and_a_crash_does_not",),
    ),
    Mutation(
        "sweep: one timeout ends a series",
        "harness/running/sweep.py",
        "Sweep._note",
        "len(self._timeouts) == TIMEOUTS_IN_A_ROW",
        "self._timeouts",
        (f"{ON_RUNNING}/test_sweep.py::test_a_timeout_does_not_end_a_series_and_three_in_a_row_do",),
    ),
    Mutation(
        "sweep: the slowest cost predicts",
        "harness/running/sweep.py",
        "Sweep._note",
        "min(self._fastest, ",
        "max(self._fastest if math.isfinite(self._fastest) else 0.0, ",
        (f"{ON_RUNNING}/test_sweep.py::test_the_fastest_cost_decides",),
    ),
    Mutation(
        "score: the reason does not say where the integrator stopped",
        "harness/scoring/score.py",
        "Scorer.measure",
        "f\"{outcome.stopped}; {row['reason']}\"",
        "row['reason']",
        ("tests/harness/scoring/test_score.py::test_where_an_integrator_stopped_stands_before_what_it_led_to",),
    ),
    Mutation(
        "compare: counts of right-hand sides may not differ between builds",
        "harness/results/regression.py",
        "",
        "CALLS_FACTOR = 1.1",
        "CALLS_FACTOR = 1.001",
        ("tests/harness/results/test_regression.py::test_differences_between_builds_are_no_regression",),
    ),
    Mutation(
        "compare: errors may not differ between builds",
        "harness/results/regression.py",
        "",
        "ERROR_FACTOR = 2.0",
        "ERROR_FACTOR = 1.2",
        ("tests/harness/results/test_regression.py::test_differences_between_builds_are_no_regression",),
    ),
    Mutation(
        "status: a higher limit does not repeat what was skipped",
        "harness/contract/status.py",
        "",
        "STOPPED = (Status.TIMEOUT, Status.SKIPPED)",
        "STOPPED = (Status.TIMEOUT,)",
        ("tests/harness/results/test_store.py::test_what_a_limit_ended_runs_again_under_a_higher_one",),
    ),
    Mutation(
        "registry: an integrator that two names select is taken twice",
        "harness/registry/lookup.py",
        "find_all",
        "{id(one): one for one in named}",
        "{len(found) + n: one for n, one in enumerate(named)}",
        ("tests/harness/registry/test_lookup.py::test_an_integrator_that_several_names_select_is_taken_once",),
    ),
    Mutation(
        "kernels: machine code is used with another version of numba",
        "harness/kernels/numba_cache.py",
        "machine",
        "numba {numba.__version__} ",
        "",
        ("tests/harness/kernels/test_machine_code.py::test_another_compiler_or_python_does_not_use_files_of_this_one",),
    ),
    Mutation(
        "cache: a reference solution is that of another formulation",
        "harness/scoring/reference_solution.py",
        "_key",
        "for name in spec.__dataclass_fields__]",
        "for name in [*spec.__dataclass_fields__][:-1]]",
        (
            "tests/harness/scoring/test_reference_solution.py"
            "::test_the_key_of_a_reference_solution_has_every_number_the_variant_and_the_formulation",
        ),
    ),
    Mutation(
        "cache: a table is that of other pieces",
        "reference/numerics/table.py",
        "_cells",
        "{[(str(a), str(b)) for a, b in pieces]} ",
        "",
        (f"{CLOSURE}::test_a_table_is_that_of_its_pieces_and_its_numbers",),
    ),
    Mutation(
        "cache: states are those of other times",
        "reference/numerics/certified.py",
        "CertifiedMotion.sample",
        "np.ascontiguousarray(times).tobytes()",
        'b""',
        (f"{CLOSURE}::test_kept_states_are_those_of_their_times",),
    ),
    Mutation(
        "gauss: the iteration starts from the slopes of the last step",
        f"{METHODS}/gauss/gauss_steps.py",
        "start_stages",
        "weighted_sum(table, stages + j, store, stages + 1, i, back)",
        "store[stages + j + 1, i]",
        (f"{ON_METHODS}/gauss/test_gauss.py::test_the_iteration_starts_from_a_polynomial_of_the_last_steps",),
    ),
)

ON_ADAPTERS, ON_REPORT = "tests/harness/adapters", "tests/harness/reporting"
ON_CERTIFICATES = "tests/harness/certification"
EVERY_CASE, EQUATIONS = f"{ON_CASES}/test_every_case.py", f"{ON_CASES}/test_equations.py::{FOLLOW}"
SPAN = "how long a motion is sampled is a choice; its states are tested at any time"
DRAWN = tuple(
    Mutation(f"drawn: {function} of {file}", file, function, before, after, tests, SPAN * ("natural_span" in function))
    for file, function, before, after, tests in (
        (
            "reference/rotating_frames/planet_tunnel.py",
            "PlanetTunnel._passage",
            "2 * flint.arb.atan2(",
            "3 * flint.arb.atan2(",
            (f"{ON_REFERENCE}/rotating_frames/test_planet_tunnel.py",),
        ),
        (
            "reference/flight/quadratic_drag.py",
            "QuadraticDragPlane.apex",
            "self.vy < 0",
            "self.vy < 1",
            (f"{ON_REFERENCE}/flight/test_quadratic_drag.py",),
        ),
        (
            "reference/rotating_frames/inertial_straight_line.py",
            "StraightLine._balls",
            "self.x + vx * t",
            "self.x - vx * t",
            (f"{ON_REFERENCE}/rotating_frames/test_inertial_straight_line.py",),
        ),
        (
            "reference/pendulums/foucault_pendulum_centrifugal.py",
            "FoucaultCentrifugal._system",
            "[east, 0, 0, 2 * turn]",
            "[east, 1, 0, 2 * turn]",
            (f"{EVERY_CASE}::test_exact_motion_satisfies_the_equations[foucault_pendulum_centrifugal]",),
        ),
        (
            "reference/oscillators/duffing_unforced.py",
            "DuffingMotion._turning_points",
            "self.alpha))\n            return -reach, reach",
            "self.alpha))\n            return reach, reach",
            (f"{ON_REFERENCE}/oscillators/test_duffing_unforced.py",),
        ),
        (
            "reference/rotating_frames/tower_drop.py",
            "TowerDrop._elements",
            "2 / r0 - dot(velocity, velocity)",
            "2 / r0 + dot(velocity, velocity)",
            (f"{ON_REFERENCE}/rotating_frames/test_tower_drop.py",),
        ),
        (
            "reference/orbits/conic.py",
            "Conic.conic",
            "self._gap > 0",
            "self._gap >= 0",
            (f"{ON_REFERENCE}/orbits/test_kepler_orbit.py::test_conic_is_decided_exactly",),
        ),
        (
            "reference/guided/chains_over_edge.py",
            "SlidingChain.rests",
            "self.s0 == self.centre",
            "self.s0 != self.centre",
            (f"{ON_REFERENCE}/guided/test_chains_over_edge.py",),
        ),
        (
            "reference/numerics/theta.py",
            "Jacobi.shifted",
            "1 - self.m * s * s",
            "1 + self.m * s * s",
            (f"{ON_REFERENCE}/numerics/test_theta.py",),
        ),
        (
            "reference/flight/gyration.py",
            "Charge.gyroradius",
            "self.q_m**2 * square",
            "self.q_m**2 / square",
            (f"{ON_REFERENCE}/flight/test_gyration.py::test_drift_and_gyroradius",),
        ),
        (
            f"{CASES}/contact/bouncing_ball_incline.py",
            "incline_energy",
            "(vx * vx + vy * vy) / 2",
            "(vx * vx - vy * vy) / 2",
            (f"{ON_CASES}/test_hybrid_invariants.py::test_the_energy_of_a_ball_is_lost_at_impacts_alone",),
        ),
        (
            f"{CASES}/orbits/kepler_orbit.py",
            "KeplerOrbit.formulations",
            "without_clock, 4,",
            "without_clock, 3,",
            (f"{ON_CASES}/orbits/test_kepler_orbit.py::test_sundman_formulation_carries_time",),
        ),
        (
            f"{CASES}/oscillators/forced_oscillators.py",
            "second_order_matrix",
            "return 0, 1, -c",
            "return 0, 2, -c",
            (f"{ON_CASES}/test_structured_forms.py",),
        ),
        (
            f"{CASES}/rigid_bodies/dynamics_of_free_rigid_body_in_gravity.py",
            "thrown_scene",
            "-parameters[0]",
            "-parameters[1]",
            (f"{ON_ADAPTERS}/test_scene_accelerations.py",),
        ),
        (
            f"{CASES}/rigid_bodies/rigid_body_stokes_medium_loaded.py",
            "falling_in_medium",
            "-nu * i1 * w1",
            "nu * i1 * w1",
            (f"{EQUATIONS}[rigid_body_stokes_medium_falling]",),
        ),
        (
            f"{CASES}/orbits/two_body.py",
            "centre_start_y",
            "state[1] - state[5] * t",
            "state[0] - state[5] * t",
            (f"{EVERY_CASE}::test_constant_invariants_stay_constant[two_body]",),
        ),
        (
            f"{CASES}/flight/charges.py",
            "newtonian_push",
            "sqrt(1 - (",
            "sqrt(1 + (",
            (f"{ON_ADAPTERS}/test_scene_accelerations.py::test_one_tiny_step_of_an_engine[relativistic_charge]",),
        ),
        (
            f"{CASES}/rigid_bodies/euler_top.py",
            "momentum_z",
            "state[10] * i2",
            "state[11] * i2",
            (f"{EVERY_CASE}::test_constant_invariants_stay_constant[euler_top]",),
        ),
        (
            f"{CASES}/core/case.py",
            "Case.natural_span",
            "UNITS[span.unit] * self.time_scale",
            "UNITS[span.unit] / self.time_scale",
            (f"{ON_CASES}/core/test_sampling.py",),
        ),
        (
            f"{CASES}/contact/sliding_can.py",
            "SlidingCanCase.natural_span",
            "0.97 * self.time_scale",
            "1.97 * self.time_scale",
            (f"{ON_CASES}/core/test_sampling.py",),
        ),
        (
            "harness/reporting/report_card.py",
            "card",
            "TARGETS[1]",
            "TARGETS[0]",
            (f"{ON_REPORT}/test_report_card.py",),
        ),
        (
            "harness/reporting/report_benchmarks.py",
            "_times",
            "ratio < 9.95",
            "ratio < 99.5",
            (f"{ON_REPORT}/test_report_words.py",),
        ),
        (
            f"{METHODS}/taylor/taylor.py",
            "integrate",
            "end = times[-1] if t + h >= times[-1]",
            "end = times[-1] if t + h < times[-1]",
            (f"{ON_METHODS}/taylor/test_taylor.py",),
        ),
        (
            "harness/certification/agreement.py",
            "sizes",
            "k / SIZE_TIMES",
            "k * SIZE_TIMES",
            (f"{ON_CERTIFICATES}/test_certify.py", f"{EVERY_CASE}::test_the_digits_asked_for_are_right"),
        ),
        (
            f"{METHODS}/gauss/gauss_steps.py",
            "settled",
            "change < CLOSE * roundoff",
            "change > CLOSE * roundoff",
            (STAGES,),
        ),
        (
            "harness/certification/independent_particles.py",
            "work_special",
            "-weight * 2 * math.pi",
            "weight * 2 * math.pi",
            (f"{ON_CERTIFICATES}/test_independent_checks.py::test_paths_and_particles",),
        ),
        (
            "harness/reporting/figures_work.py",
            "drawn",
            "if value > 0]",
            "if value > 1]",
            (f"{ON_REPORT}/test_report.py",),
        ),
        (
            "harness/adapters/pybullet_world.py",
            "World.advance",
            "self.steps += steps",
            "self.steps -= steps",
            (f"{ON_ADAPTERS}/test_pybullet.py",),
        ),
        (
            "harness/adapters/scipy_events.py",
            "Guard.unlatch",
            "self.latched = 0.0",
            "self.latched = 1.0",
            (f"{ON_ADAPTERS}/test_scipy.py::test_a_guard_at_zero_where_a_segment_starts",),
        ),
        (
            "harness/adapters/pybullet_world.py",
            "_cross",
            "a[1] * b[2]",
            "a[0] * b[2]",
            (f"{ON_ADAPTERS}/test_pybullet.py::{ARM}",),
        ),
        (
            "harness/adapters/rebound_nbody.py",
            "Native.advances",
            "FIRST_STEP * problem.time_scale",
            "FIRST_STEP / problem.time_scale",
            (f"{ON_ADAPTERS}/test_rebound.py",),
        ),
        (
            "harness/adapters/pybullet_world.py",
            "_turned",
            "cos(angle / 2))",
            "cos(angle * 2))",
            (f"{ON_ADAPTERS}/test_pybullet.py",),
        ),
        (
            "harness/adapters/heyoka.py",
            "system",
            "u**-1.5",
            "u**-0.5",
            (f"{ON_ADAPTERS}/test_heyoka.py::test_one_over_u_times_its_root_is_one_power_in_the_fast_policy",),
        ),
        (
            "harness/adapters/pybullet_world.py",
            "_along",
            "start[0] + length",
            "start[0] - length",
            (f"{ON_ADAPTERS}/test_pybullet.py::{ARM}",),
        ),
        (
            "harness/adapters/scipy_events.py",
            "set_latch",
            "value == 0 or",
            "value != 0 or",
            (f"{ON_ADAPTERS}/test_scipy.py::test_a_guard_at_zero_where_a_segment_starts",),
        ),
    )
)
"""Functions drawn at random from all that compute, about as many from each part: reference, cases, harness, adapters. In each, a
number, sign, comparison or index that was drawn too. Left out were those that change no number of an ordinary result:
digits that a motion adds until its balls prove it, default values, and shapes of arrays."""

MUTATIONS = (*STEPPING, *IMPLICIT, *RUNNING, *POOL, *EXACT, *RECORDS, *DRAWN)
