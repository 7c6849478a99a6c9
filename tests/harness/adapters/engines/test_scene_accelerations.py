"""A scene gives the same rates of change of the state as the equations of its case, at a moving state.

An engine's motion over many steps hides a wrong force that is small at the start, and scenes that no engine here takes
are not run at all. So this takes one tiny step of each engine for all scenes without events that it accepts, accelerations
of engines without a step, and for a body on a ball joint Euler's equations about its fixed point.
"""

from dataclasses import replace

import numpy as np
import pytest
from breadth import tenth
from gnomon.cases import Case, get, names
from gnomon.cases.core.forms import first_order
from gnomon.cases.core.scene import Hinge, Readings, Scene
from gnomon.harness.adapters.engines.bullet.pybullet import PyBullet
from gnomon.harness.adapters.engines.bullet.pybullet_accelerations import MODELLED, joint_accelerations
from gnomon.harness.adapters.engines.dart import Dart
from gnomon.harness.adapters.engines.drake import DrakeSap
from gnomon.harness.adapters.engines.jsbsim import JsbsimEuler
from gnomon.harness.adapters.engines.mujoco import Euler
from gnomon.harness.adapters.engines.pymunk import Pymunk
from gnomon.harness.adapters.engines.scene_run import SceneIntegrator
from gnomon.harness.contract.integrator import Floats, Refused
from gnomon.harness.contract.problem import problem_of
from on_cases import exact_state
from scipy.spatial.transform import Rotation

SCENES = {name: case.scene for name in names() if (case := get(name)).scene is not None and case.hybrid is None}
SMOOTH = list(SCENES)
ENGINES: tuple[type[SceneIntegrator], ...] = (PyBullet, Euler, Dart, DrakeSap, Pymunk, JsbsimEuler)
LATE = {Dart: {"rope", "driven_axis"}}
"""Needs of scenes in which an engine gives a body the velocity that its leader, or its drive, had in the last step."""
CORRECTED = {
    "pendulum_on_cart", "man_on_cart", "wedge_block_energy_momentum", "double_pendulum", "holonomic_constraint_dae",
    "free_fall_first_order",
}  # fmt: skip
"""Scenes whose first step in pymunk has other rates: its correction of a joint is a velocity, half the centripetal
acceleration times the step, and its forces are those at the end of the step. test_pymunk shows their order."""


def takes(engine: type[SceneIntegrator], name: str) -> bool:
    form = SCENES[name]
    if form is None or engine().unsupported(form) is not None or form.needs & LATE.get(engine, set()):
        return False
    return not (engine is Pymunk and name in CORRECTED)


TAKEN = {engine: [(engine, name) for name in SMOOTH if takes(engine, name)] for engine in ENGINES}
BALL_JOINT = {"ball_joint", "gyroscopic", "position_force", "velocity_force"}
ON_A_BALL_JOINT = [name for name in SMOOTH if "ball_joint" in (needs := get(name).scene.needs) and needs <= BALL_JOINT]  # type: ignore[union-attr]

STRONGER = {"foucault_pendulum_nonlinear": "turntable"}
"""Variants in which a force is not lost in the rounding of the others: the Earth's turning is a few 1e-10 of them."""


def moving_state(case: Case) -> Floats:
    """The state of the third sample, where in general no rate is zero."""
    return exact_state(case, 2)


def rates_of_the_equations(case: Case, state: Floats) -> Floats:
    values, parameters = tuple(state.tolist()), tuple(map(float, case.parameter_values()))
    if (hybrid := case.hybrid) is not None:
        mode = hybrid.mode(hybrid.start(0.0, values, parameters))
        equations, parameters = mode.equations, (*parameters, *mode.constants)
    else:
        equations = next(found for found in map(first_order, case.all_forms()) if found is not None).equations
    return np.array(equations(0.0, values, parameters), dtype=float)


def assert_same_rates(case: Case, state: Floats, found: Floats, share: float) -> None:
    """Relative to the size of the group of each coordinate, or to its change in one time scale."""
    expected = rates_of_the_equations(case, state)
    for group in dict.fromkeys(coordinate.group for coordinate in case.state):
        members = [i for i, coordinate in enumerate(case.state) if coordinate.group == group]
        size = max(np.linalg.norm(expected[members]), np.linalg.norm(state[members]) / case.time_scale)
        assert np.linalg.norm((found - expected)[members]) <= share * size, (group, found, expected)


@pytest.mark.parametrize(
    ("engine", "name"), [row for one in ENGINES for row in (TAKEN[one] if one is PyBullet else tenth(TAKEN[one]))]
)
def test_one_tiny_step_of_an_engine(engine: type[SceneIntegrator], name: str) -> None:
    """The first step errs by its length over the time scale, times the change of the rates in a time scale: a few 1e-5."""
    pytest.importorskip(engine.library, reason="not every engine has wheels for every Python")
    case = get(name).rounded()
    state, step = moving_state(case), 1e-5 * case.fastest_time
    problem = replace(problem_of(case, engine.accepts), times=np.array([step]))
    try:
        run = engine().prepare(problem, step)
    except Refused as refusal:
        pytest.skip(f"depends on the numbers: {refusal}")
    try:
        end = run(state[None]).states[0, 0]
    finally:
        run.close()
    change, angles = end - state, [coordinate.kind == "angle" for coordinate in case.state]
    change[angles] = np.remainder(change[angles] + np.pi, 2 * np.pi) - np.pi  # whole turns are ignored
    assert_same_rates(case, state, change / step, 1e-3)


@pytest.mark.parametrize("name", tenth(name for _, name in TAKEN[Euler]))
def test_accelerations_of_mujoco(name: str) -> None:
    """The equations of motion, where no soft constraint acts; one yields by 1e-4 of the accelerations without it.

    The readings are differentiated along a curve with the engine's velocities and accelerations, with an error of h^4.
    """
    mujoco = pytest.importorskip("mujoco")
    case = get(name).rounded()
    form, parameters, state = case.scene, tuple(map(float, case.parameter_values())), moving_state(case)
    assert form is not None
    world = Euler().world(form, 1e-3 * case.fastest_time)
    world.build(form.build((0.0,) * len(state), parameters))
    world.place(form.build(tuple(state.tolist()), parameters))
    data, change = world.data, world.accelerations()
    q, v, h = data.qpos.copy(), data.qvel.copy(), 3e-4 * case.fastest_time

    def along_the_motion(time: float) -> Floats:
        data.qpos, data.qvel = q, v + time * change
        mujoco.mj_integratePos(world.model, data.qpos, v, time)
        return np.array(form.observe(world.read(), parameters))

    near, far = (along_the_motion(x) - along_the_motion(-x) for x in (h, 2 * h))
    angles = [coordinate.kind == "angle" for coordinate in case.state]
    near[angles], far[angles] = (np.remainder(x[angles] + np.pi, 2 * np.pi) - np.pi for x in (near, far))
    soft = form.needs & {"rope", "linkage"} and "driven_axis" not in form.needs
    assert_same_rates(case, state, (8 * near - far) / (12 * h), 1e-3 if soft else 1e-9)


ON_JOINTS = [
    name for name in names() if (form := get(name).scene) is not None and form.needs and form.needs <= MODELLED
]


@pytest.mark.parametrize("name", [name for name in ON_JOINTS if get(name).scene.needs & {"hinge", "slider"}])  # type: ignore[union-attr]
def test_accelerations_of_joints_without_a_step(name: str) -> None:
    """The state is linear in the joints, so a difference over 1 s of their rates and accelerations has no error of its own."""
    pytest.importorskip("pybullet", reason="pybullet has wheels up to CPython 3.11 only")
    case = get(name).rounded()
    form, parameters, state = case.scene, tuple(map(float, case.parameter_values())), moving_state(case)
    assert form is not None
    scene = form.build(tuple(state.tolist()), parameters)
    found = joint_accelerations(form, scene)
    places = {each.name: each.angle if isinstance(each, Hinge) else each.position for each in scene.joints}
    ahead, behind = (
        form.observe(
            Readings({x.name: (places[x.name] + h * x.rate, x.rate + h * found[x.name]) for x in scene.joints}),
            parameters,
        )
        for h in (0.5, -0.5)
    )
    assert_same_rates(case, state, np.subtract(ahead, behind), 1e-9)


def turned_about_the_origin(scene: Scene, h: float) -> Readings:
    """The readings of the only body after a short time h, by Euler's equations about the fixed point."""
    (body,) = scene.bodies
    r, v = np.array(body.position), np.array(body.velocity)
    attitude = Rotation.from_quat(body.quaternion)
    matrix = attitude.as_matrix()
    inertia = matrix @ np.diag(body.inertia) @ matrix.T + body.mass * (r @ r * np.eye(3) - np.outer(r, r))
    # A point mass has no spin about its own arm, and no inertia against it.
    spin = np.array(body.angular_velocity) if any(body.inertia) else np.cross(r, v) / (r @ r)
    force = body.mass * np.array(scene.gravity)
    for acting in scene.forces:
        force = force + np.array(acting.law(0.0, body.position, body.velocity))
    change = np.linalg.lstsq(inertia, np.cross(r, force) - np.cross(spin, inertia @ spin), rcond=1e-12)[0]
    turn = Rotation.from_rotvec(h * spin + h * h / 2 * change)
    place, rate = turn.apply(r), spin + h * change
    found = (place, (turn * attitude).as_quat(), np.cross(rate, place), rate)
    return Readings({}, {body.name: tuple(tuple(x.tolist()) for x in found)})  # type: ignore[dict-item]


@pytest.mark.parametrize("name", ON_A_BALL_JOINT)
def test_a_body_on_a_ball_joint(name: str) -> None:
    """Central differences of 1e-5 time scales err by 1e-10 of the rates, and by some ulp over 1e-5."""
    case = get(name, STRONGER.get(name)).rounded()
    form, parameters = case.scene, tuple(map(float, case.parameter_values()))
    assert form is not None
    state, h = moving_state(case), 1e-5 * case.time_scale
    scene = form.build(tuple(state.tolist()), parameters)
    (body,) = scene.bodies
    if any(body.inertia):
        assert np.cross(body.angular_velocity, body.position) == pytest.approx(body.velocity, abs=1e-12)
    ahead, behind = (np.array(form.observe(turned_about_the_origin(scene, x), parameters)) for x in (h, -h))
    assert_same_rates(case, state, (ahead - behind) / (2 * h), 1e-6)
