"""Drake moves the scenes with the order of its integrators, and reaches the errors of its best known configuration."""

import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest
from gnomon.cases import Case, get, names
from gnomon.cases.core.forms import first_order
from gnomon.cases.core.scene import TOKENS, Vector
from gnomon.harness.adapters.engines import drake_plant
from gnomon.harness.adapters.engines.drake import (
    INTEGRATORS,
    LACKS,
    LINES,
    DrakeAsShipped,
    DrakeBogackiShampine3,
    DrakeControlled,
    DrakeControlled5,
    DrakeRadau3,
    DrakeRungeKutta3,
    DrakeRungeKutta5,
    DrakeSap,
    DrakeTamsi,
)
from gnomon.harness.adapters.engines.scene_run import SceneRun
from gnomon.harness.contract.integrator import Floats, Refused
from gnomon.harness.contract.problem import initial_state, problem_of
from on_cases import exact_states, recorded

drake: Any = pytest.importorskip("pydrake.all", reason="drake is not installed")

Policy = type[DrakeRungeKutta3]
DISCRETE = (DrakeSap, DrakeTamsi)


@contextmanager
def running(policy: Policy, case: Case, dt: float, times: Floats | None = None) -> Iterator[SceneRun]:
    problem = problem_of(case, policy.accepts)
    run = policy().prepare(problem if times is None else replace(problem, times=times), dt)
    try:
        yield run
    finally:
        run.close()


def states(policy: Policy, case: Case, dt: float, times: Floats | None = None) -> Floats:
    with running(policy, case, dt, times) as run:
        return run(initial_state(case)[None]).states[0]


def errors(policy: Policy, case: Case, parts: tuple[int, ...]) -> list[float]:
    """The largest error over the path, with these numbers of steps a sample."""
    exact = exact_states(case)
    return [
        float(np.max(case.metric.distance(states(policy, case, float(case.times[0]) / n), exact, case.times)))
        for n in parts
    ]


def angle_over_the_path(policy: Policy, case: Case, dt: float) -> float:
    off = states(policy, case, dt)[:, 0] - exact_states(case)[:, 0]
    return float(np.max(np.abs(np.remainder(off + np.pi, 2 * np.pi) - np.pi)))


def position_at_the_end(policy: Policy, case: Case, dt: float) -> float:
    lengths = [i for i, coordinate in enumerate(case.state) if coordinate.kind == "length"]
    off = states(policy, case, dt)[-1] - case.sample(case.times[-1:])[0]
    return float(np.linalg.norm(off[lengths]))


def attitude_at_the_end(policy: Policy, case: Case, dt: float) -> float:
    off = states(policy, case, dt)[-1, 3:] - case.sample(case.times[-1:])[0, 3:]
    return 2 * float(np.arcsin(min(np.linalg.norm(off) / 8**0.5, 1.0)))


def time_of_the_tenth_impact(policy: Policy, case: Case, dt: float) -> float:
    times = np.arange(1, round(1.1 * float(case.span) / dt)) * dt
    v = states(policy, case, dt, times)[:, 1]
    turns = np.nonzero((v[:-1] < 0) & (v[1:] > 0))[0]
    before = turns[9]
    return abs(float(times[before] + dt * v[before] / (v[before] - v[before + 1]) - case.events()[9].time))


Measure = Callable[[Policy, Case, float], float]
PUBLISHED: tuple[tuple[Policy, str, str, Measure, dict[float, float]], ...] = (
    (DrakeSap, "pendulum_simple", "engines", angle_over_the_path, {1e-2: 0.030, 1e-3: 0.0030, 1e-4: 3e-4}),
    (DrakeSap, "euler_top", "engines", attitude_at_the_end, {1e-2: 0.48, 1e-3: 0.047, 1e-4: 0.0047}),
    (DrakeRungeKutta3, "euler_top", "engines", attitude_at_the_end, {1e-2: 7.8e-4, 1e-3: 7.9e-7}),
    (DrakeRungeKutta5, "euler_top", "engines", attitude_at_the_end, {1e-2: 1.1e-9}),
    (DrakeSap, "kepler_orbit", "engines", position_at_the_end, {1e-2: 0.31, 1e-3: 0.0032}),
    (DrakeTamsi, "billiard_ball", "engines", position_at_the_end, {1e-2: 4.3e-3, 1e-3: 4.3e-4, 1e-4: 4.5e-5}),
    (DrakeSap, "billiard_ball", "engines", position_at_the_end, {1e-2: 4.3e-3, 1e-3: 4.3e-4, 1e-4: 4.5e-5}),
    (DrakeTamsi, "block_incline_friction", "engines_stop", position_at_the_end, {1e-2: 0.015, 1e-3: 0.0015}),
    (DrakeTamsi, "block_incline_friction", "engines_slide", position_at_the_end, {1e-2: 0.012, 1e-3: 0.0012}),
    # The published figure is at a stiffness of 1e4, which is the one of this step.
    (DrakeRungeKutta3, "bouncing_ball", "engines_e1", time_of_the_tenth_impact, {1e-3: 0.45}),
)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("policy", "name", "label", "measure", "published"),
    PUBLISHED,
    ids=[f"{name}-{label}-{policy.name}" for policy, name, label, *_ in PUBLISHED],
)
def test_errors_are_those_published(
    policy: Policy, name: str, label: str, measure: Measure, published: dict[float, float]
) -> None:
    case = get(name, label).rounded()
    found = {dt: measure(policy, case, dt) for dt in published}
    assert all(published[dt] / 2 < found[dt] < 2 * published[dt] for dt in published), (found, published)


def taken(policy: Policy, hybrid: bool = False) -> list[str]:
    chosen = [case for case in map(get, names()) if case.scene is not None and (case.hybrid is not None) is hybrid]
    return [case.name for case in chosen if policy().unsupported(case.scene) is None]


SMOOTH = [
    *product([(DrakeRungeKutta3, 16)], taken(DrakeRungeKutta3)),
    *product([(DrakeRungeKutta5, 4)], taken(DrakeRungeKutta5)),
    *product([(DrakeSap, 64), (DrakeTamsi, 64)], taken(DrakeSap)),
]


def assert_order(policy: Policy, name: str, coarse: int) -> None:
    case = get(name, span=min(8 * get(name).time_scale, float(get(name).span))).rounded()
    first, second = errors(policy, case, (coarse, 2 * coarse))
    assert policy.order is not None
    # Errors near the sum of the roundings, and motions of a lower degree than the method, have no order.
    if first > 1e-11:
        assert np.log2(first / second) > policy.order - (0.1 if policy.order < 5 else 1.3), (first, second)
    assert first < 0.1


@pytest.mark.parametrize(
    ("policy", "name", "coarse"),
    [
        (DrakeRungeKutta3, "pendulum_simple", 8),
        (DrakeRungeKutta5, "double_pendulum", 4),
        (DrakeSap, "spherical_pendulum", 32),
        (DrakeTamsi, "pendulum_on_cart", 32),
    ],
)
def test_order_of_an_integrator(policy: Policy, name: str, coarse: int) -> None:
    assert_order(policy, name, coarse)


@pytest.mark.slow
@pytest.mark.parametrize(("policy", "name"), SMOOTH)
def test_scene_moves_as_its_case(policy: tuple[Policy, int], name: str) -> None:
    """The order over one halving, at least; of order 5 the steps are so coarse that higher terms lower it by 1.2."""
    assert_order(policy[0], name, policy[1])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["block_incline_friction", "rolling_bodies", "billiard_ball"])
@pytest.mark.parametrize("policy", [DrakeRungeKutta3, DrakeSap, DrakeTamsi])
def test_friction_converges(policy: Policy, name: str) -> None:
    """Order 1: stops and the ends of sliding fall within a step, so that a halving alone is irregular."""
    coarse, fine = errors(policy, get(name).rounded(), (32, 512))
    assert fine < coarse / 8


JOINTED = [
    name
    for name in taken(DrakeRungeKutta3)
    if get(name).scene.needs & {"hinge", "slider"}  # type: ignore[union-attr]
]


@pytest.mark.parametrize("name", JOINTED)
def test_the_derivatives_of_the_continuous_plant_are_the_equations(name: str) -> None:
    """Without integration: the readings are linear in the joints, so a difference of any length has no error but rounding."""
    case = get(name).rounded()
    state = np.array(list(map(float, case.exact(case.times[2].item()))))
    form = next(found for found in map(first_order, case.all_forms()) if found is not None)
    expected = np.array(form.equations(0.0, tuple(state.tolist()), tuple(map(float, case.parameter_values()))), float)
    with running(DrakeRungeKutta3, case, float(case.times[0])) as run:
        world = run.world
        world.place(run.form.build(tuple(state.tolist()), run.parameters))  # type: ignore[arg-type]
        here = world.root.get_continuous_state_vector().CopyToVector()
        rates = world.simulator.get_system().EvalTimeDerivatives(world.root).CopyToVector()
        h = 0.25 * case.fastest_time
        ends = []
        for sign in (1, -1):
            world.root.SetContinuousState(here + sign * h * rates)
            ends.append(np.array(run.form.observe(world.read(), run.parameters)))  # type: ignore[arg-type]
    scale = max(float(np.max(np.abs(expected))), float(np.max(np.abs(state))) / case.time_scale)
    assert (ends[0] - ends[1]) / (2 * h) == pytest.approx(expected, rel=1e-9, abs=1e-9 * scale)


FORCED = [
    "kepler_orbit",
    "figure_eight",
    "rigid_body_stokes_medium_torque",
    "small_vibrations_mdof",
    "time_varying_force",
]
"""Forces on one free body and between three, torques, forces on sliders, and a law that branches."""
CONTROLLED = (DrakeControlled, DrakeControlled5, DrakeBogackiShampine3, DrakeRadau3)


@pytest.mark.parametrize("policy", [DrakeRungeKutta5, DrakeSap])
@pytest.mark.parametrize("name", FORCED)
def test_expressions_give_the_forces_that_python_gives(
    policy: Policy, name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    case = get(name).rounded()
    dt = float(case.times[0]) / 8
    found = states(policy, case, dt, case.times[:2])
    monkeypatch.setattr(drake_plant.world, "symbolic_loads", lambda world: None)
    by_python = states(policy, case, dt, case.times[:2])
    # Rounding of at most 16 steps; a scale of zero is that of a component that rests.
    assert found == pytest.approx(by_python, rel=1e-11, abs=1e-11 * float(np.max(np.abs(by_python))))


def test_no_law_is_called_in_a_step() -> None:
    """A call of Python at each stage took most of the time of a step."""
    calls: list[float] = []

    class Law:
        """An object, which is traced as it is: a plain function would be copied for the trace."""

        def __call__(self, t: float, place: Vector, velocity: Vector) -> Vector:
            calls.append(t)
            return -place[0], 0.0, 0.0

    case = get("kepler_orbit").rounded()
    assert case.scene is not None
    scene = case.scene.build((1.0, 0.0, 0.0, 1.0), tuple(map(float, case.parameter_values())))
    scene = replace(scene, forces=(replace(scene.forces[0], law=Law()),))
    world = DrakeRungeKutta3().world(case.scene, 1e-3)
    world.build(scene)
    world.place(scene)
    traced = len(calls)
    world.advance(5)
    assert len(calls) == traced > 0


@pytest.mark.parametrize("symbolic", [True, False])
def test_a_singular_force_ends_the_motion(symbolic: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    """The attracting centre itself: 1/0 is an error of the motion, not of the adapter."""
    if not symbolic:
        monkeypatch.setattr(drake_plant.world, "symbolic_loads", lambda world: None)
    case = get("kepler_orbit").rounded()
    with running(DrakeRungeKutta3, case, float(case.times[0]) / 8) as run:
        found = run(np.zeros((1, 4)))
    assert found.stopped is not None
    assert np.isnan(found.states).all()


@pytest.mark.parametrize("policy", CONTROLLED)
def test_a_finer_accuracy_takes_more_steps_to_a_smaller_error(policy: Policy) -> None:
    case = get("pendulum_simple", span=32 * get("pendulum_simple").time_scale).rounded()
    exact, found = exact_states(case), []
    for accuracy in (1e-4, 1e-7):
        with running(policy, case, accuracy) as run:
            solution = run(initial_state(case)[None])
            again = run(initial_state(case)[None])
        assert np.array_equal(solution.states, again.states)
        assert solution.steps == again.steps
        found.append((solution.steps, float(np.max(case.metric.distance(solution.states[0], exact, case.times)))))
    (few, rough), (many, fine) = found
    assert few is not None
    assert many is not None
    assert many > 2 * few
    assert fine < rough / 10


@pytest.mark.parametrize("policy", CONTROLLED)
def test_error_control_is_for_smooth_scenes(policy: Policy) -> None:
    """Continuous contact is a spring that follows a fixed step."""
    assert not set(taken(policy, hybrid=True)) & {"bouncing_ball", "billiard_ball", "block_incline_friction"}
    assert policy().unsupported(get("billiard_ball").scene)
    assert policy().unsupported(get("kepler_orbit").scene) is None


def test_error_control_is_set_as_recorded() -> None:
    case = get("pendulum_simple").rounded()
    with running(DrakeControlled, case, 1e-5) as run:
        integrator = run.world.simulator.get_integrator()  # type: ignore[attr-defined]
        assert run.options.keys() == DrakeControlled.lines.keys()
        assert not integrator.get_fixed_step_mode()
        assert integrator.get_target_accuracy() == run.options["target_accuracy"] == 1e-5
        assert integrator.get_maximum_step_size() == run.options["maximum_step_size"]
    names = vars(drake) | {"simulator": drake.Simulator(drake.ConstantVectorSource([0.0])), "dt": 1.0}
    for option, line in DrakeControlled.lines.items():
        exec(line.format(run.options[option]), names)
    assert names["integrator"].get_target_accuracy() == 1e-5
    assert names["integrator"].get_maximum_step_size() == run.options["maximum_step_size"]


def test_every_token_that_is_refused_has_a_reason() -> None:
    for policy in INTEGRATORS:
        assert policy.lacks.keys() <= TOKENS.keys()
        assert all(policy.lacks.values())


@pytest.mark.parametrize(
    ("token", "fragments"),
    [
        ("driven_axis", ("Prescri", "DrivenJoint", "Mocap")),
        ("driven_frame", ("Prescri", "Rotating", "Mocap")),
        ("joint_friction", ("JointFriction", "DryFriction", "FrictionLoss")),
        ("rope", ("Rope", "Cable", "Tendon")),
        ("pulley", ("Pulley", "Capstan")),
        ("unwinding_string", ("String", "Tendon", "Winch")),
        ("belt", ("Belt", "Chain")),
        ("adhesion", ("Adhes", "Sticky", "Glue")),
        ("adhesive_contact", ("Adhes", "Sticky", "Glue")),
        ("drill_friction", ("Torsional", "Spinning", "Rolling")),
        ("moving_surface", ("SurfaceVel", "SurfaceSpeed", "Conveyor")),
        ("rolling_without_slip", ("Rolling", "NoSlip", "Nonholonomic")),
        ("curved_guide", ("Curv", "Spline", "PathJoint")),
        ("curved_surface", ("Curv", "Spline", "SurfaceJoint")),
        ("loss_of_contact", ("Curv", "Unilateral")),
        ("knife_edge", ("Nonholonomic", "VelocityConstraint", "Wheel")),
    ],
)
def test_nothing_in_the_engine_has_such_a_name(token: str, fragments: tuple[str, ...]) -> None:
    """The other reasons are in tests of their own. The search finds what there is: joints, and constraints by distance."""
    from pydrake.multibody import plant, tree

    words = {*dir(plant), *dir(tree), *dir(plant.MultibodyPlant)}
    joints = {word for word in words if not word.startswith("_")}
    assert token in LACKS
    assert any("Revolute" in word for word in joints)
    assert any("DistanceConstraint" in word for word in joints)
    known = {"get_contact_surface_representation", "set_contact_surface_representation", "GetTopologyGraphvizString"}
    known |= {"GetGraphvizString"}
    assert not [word for word in joints - known if any(part in word for part in fragments)]


def test_a_disc_has_a_thickness() -> None:
    with pytest.raises(SystemExit, match="length > 0"):
        drake.Cylinder(0.25, 0.0)


@pytest.mark.parametrize(("policy", "moves"), [(DrakeRungeKutta3, True), (DrakeTamsi, False)])
def test_a_block_at_rest_creeps_in_a_continuous_plant(policy: Policy, moves: bool) -> None:
    """At 16 degrees the limit is 16.7: what a continuous plant calls rest is slip below the tolerance."""
    case = get("block_incline_friction", "engines_stick").rounded()
    end = states(policy, case, 1e-2, np.array([0.5]))[-1]
    assert bool(abs(end[0]) > 1e-3) is moves


@pytest.mark.parametrize("policy", [DrakeRungeKutta3, DrakeSap, DrakeTamsi, DrakeAsShipped])
def test_no_contact_has_a_coefficient_of_restitution(policy: Policy) -> None:
    case = get("bouncing_ball", "engines_e08").rounded()
    with pytest.raises(Refused, match="coefficient of restitution"):
        policy().prepare(problem_of(case, policy.accepts), 1e-2)


def test_discrete_contact_loses_energy_without_dissipation(monkeypatch: pytest.MonkeyPatch) -> None:
    """Why a restitution of 1 is refused: a contact of 31 steps returns less than 0.9 of the speed."""
    case = get("bouncing_ball", "engines_e1").rounded()
    form, dt, steps = case.scene, 1e-3, 800
    assert form is not None
    scene = form.build((1.0, 0.0), tuple(map(float, case.parameter_values())))
    monkeypatch.setattr(drake_plant.contact, "STIFFNESS", 1e4)
    monkeypatch.setattr(drake_plant.contact, "DAMPED_STEPS", {False: 1e12})
    world = DrakeTamsi().world(form, dt)
    world.build(replace(scene, contacts=(replace(scene.contacts[0], restitution=0.0),)))
    world.place(scene)
    speeds = []
    for _ in range(steps):
        world.advance(1)
        speeds.append(world.read().bodies["ball"][2][2])
    assert 0.1 < max(speeds) < 0.9 * -min(speeds)


@pytest.mark.parametrize("name", ["pendulum_simple", "kepler_orbit"])
def test_as_shipped_differs_in_contact_only(name: str) -> None:
    case = get(name, span=4 * get(name).time_scale).rounded()
    dt = float(case.times[0]) / 8
    assert np.array_equal(states(DrakeAsShipped, case, dt), states(DrakeSap, case, dt))


def test_the_options_recorded_are_the_options_used() -> None:
    case = get("block_incline_friction", "engines_stop").rounded()
    with running(DrakeTamsi, case, 1e-2) as run:
        plant = run.world.plant  # type: ignore[attr-defined]
        assert run.options["discrete_contact_approximation"] == plant.get_discrete_contact_approximation().name
        assert run.options["contact_model"] == "kPoint"
        assert plant.get_contact_model() == drake.ContactModel.kPoint
    with running(DrakeRungeKutta5, case, 1e-2) as run:
        integrator = run.world.simulator.get_integrator()  # type: ignore[attr-defined]
        assert integrator.get_fixed_step_mode() is run.options["fixed_step_mode"] is True
    with running(DrakeAsShipped, case, 1e-2) as run:
        assert not run.options


def test_the_line_of_each_option_sets_it() -> None:
    """Whatever is recorded on the scenes of the suite `engines` has a line, and the engine says what the line set."""
    found = [recorded(policy) for policy in (DrakeRungeKutta5, DrakeSap, DrakeTamsi, DrakeAsShipped)]
    options = {option: value for options in found for option, value in options.items()}
    assert options.keys() == LINES.keys()
    names = vars(drake) | {"plant": drake.MultibodyPlant(1e-2), "dt": 1e-2, "properties": drake.ProximityProperties()}
    names["simulator"] = drake.Simulator(drake.ConstantVectorSource([0.0]))
    for option, line in LINES.items():
        exec(line.format(options[option]), names)
    plant, surface = names["plant"], names["properties"]
    assert plant.get_discrete_contact_approximation().name == options["discrete_contact_approximation"]
    assert plant.get_contact_model().name == options["contact_model"]
    assert names["integrator"].get_maximum_step_size() == 1e-2
    assert names["integrator"].get_fixed_step_mode()
    for option in ("point_contact_stiffness", "hunt_crossley_dissipation"):
        assert surface.GetProperty("material", option) == options[option]


def test_no_setting_makes_sap_tighter(monkeypatch: pytest.MonkeyPatch) -> None:
    """Why there is no policy with a tighter solver: 0 switches the near-rigid approximation off, and nothing changes."""
    assert not [name for name in dir(drake) if "SapSolver" in name]
    case = get("block_incline_friction", "engines_stop").rounded()
    ends = []
    for threshold in (1.0, 0.0):

        def configured(
            self: Any,
            scene: Any,
            threshold: float = threshold,
            set_plant: Any = drake_plant.contact.Contacts._set_plant,
        ) -> None:
            self.plant.set_sap_near_rigid_threshold(threshold)
            set_plant(self, scene)

        with monkeypatch.context() as patch:
            patch.setattr(drake_plant.contact.Contacts, "_set_plant", configured)
            ends.append(states(DrakeSap, case, 1e-2))
    assert np.array_equal(*ends)


def test_half_spaces_bring_no_warning(caplog: pytest.LogCaptureFixture) -> None:
    case = get("block_incline_friction", "engines_stop").rounded()
    with running(DrakeSap, case, 1e-2):
        assert not caplog.records


@pytest.mark.parametrize("policy", INTEGRATORS)
def test_runs_repeat_to_the_bit(policy: Policy) -> None:
    case = get("spherical_pendulum", span=2 * get("spherical_pendulum").time_scale).rounded()
    start = initial_state(case)
    with running(policy, case, float(case.times[0])) as run:
        first, pair = run(start[None]).states, run(np.array([start, start])).states
    assert np.array_equal(first[0], pair[0])
    assert np.array_equal(first[0], pair[1])


@pytest.mark.parametrize("policy", [DrakeRungeKutta3, DrakeSap])
def test_an_error_of_a_force_passes_through_the_engine(policy: Policy) -> None:
    case = get("kepler_orbit").rounded()
    problem = problem_of(case, policy.accepts)

    def singular(state: Any, parameters: Any) -> Any:
        scene = case.scene.build(state, parameters)  # type: ignore[union-attr]
        return replace(scene, forces=(replace(scene.forces[0], law=lambda t, x, v: (1 / 0, 0.0, 0.0)),))

    run = policy().prepare(replace(problem, form=replace(case.scene, build=singular)), float(case.times[0]))  # type: ignore[type-var, arg-type]
    found = run(initial_state(case)[None])
    run.close()
    assert found.stopped == "ZeroDivisionError: division by zero"


def test_only_prepare_imports_the_library(monkeypatch: pytest.MonkeyPatch) -> None:
    code = "import sys, gnomon.harness.adapters.engines.drake; sys.exit('pydrake' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
    monkeypatch.setitem(sys.modules, "pydrake.all", None)
    case = get("projectile_parabola").rounded()
    with pytest.raises(ImportError):
        DrakeSap().prepare(problem_of(case, DrakeSap.accepts), float(case.times[0]))
