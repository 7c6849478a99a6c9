"""MuJoCo, PyBullet and Drake read the files: the same doubles, and motions that converge to the exact one.

The first order of an engine's step: half the step, half the error. A wrong mass, moment, axis, place or rate leaves an
error that does not fall. A sixteenth of the span of a case, over which no motion is chaotic.
"""

import csv
import json
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gnomon.cases import Case, get, names
from gnomon.cases.core.scene import Scene, Vector
from gnomon.cases.scenes.attitude import matrix
from gnomon.harness.scene_files.tree import Link, Tree, tree_of
from gnomon.harness.scene_files.written import Written, list_unstated, write

CONTACT = {"rigid_impact", "coulomb_isotropic"}
SOME = ["pendulum_simple", "double_pendulum", "euler_top", "projectile_parabola", "lagrange_top", "pendulum_on_cart"]
SAMPLES = 4
LARGEST_RATIO = 0.55
"""Half the step halves the error, but for the second order, which is below a tenth of it at these steps."""


NEEDS = {name: each.needs for name in names() if (each := get(name).scene) is not None}


def stated(form: str, smooth: bool = False) -> list[str]:
    return [
        name for name, needs in NEEDS.items() if not list_unstated(needs, form) and not (smooth and needs & CONTACT)
    ]


def some(form: str) -> list[str]:
    return [name for name in SOME if name in stated(form)]


def written(name: str, form: str, folder: Path) -> tuple[Tree, Written]:
    case: Case = get(name).rounded()
    return tree_of(case), write(case, form, folder)


class Motion:
    """The table and the manifest, as a program without gnomon reads them."""

    def __init__(self, files: Written) -> None:
        with files.motion.open() as file:
            self.rows = [{name: float(x) for name, x in row.items()} for row in csv.DictReader(file)][: SAMPLES + 1]
        self.manifest = json.loads(files.manifest.read_text())
        self.interval = self.rows[1]["t"]
        self.joints: Mapping[str, Any] = self.manifest["start"]["joints"]
        self.bodies: Mapping[str, Any] = self.manifest["start"]["bodies"]

    def distance(
        self, row: Mapping[str, float], joint: Callable[[str], float], pose: Callable[[str], tuple[Any, Any]]
    ) -> float:
        """The largest difference of a coordinate, a place (m) and an entry of an attitude; `pose`: place and matrix of a link."""
        found = [abs(joint(name) - row[f"joint.{name}.position"]) for name in self.joints]
        for name, start in self.bodies.items():
            place, turned = pose(name)
            point = place + turned @ start["point"]
            found.append(np.abs(point - [row[f"body.{name}.{axis}"] for axis in "xyz"]).max())
            if f"body.{name}.qx" in row:
                q = tuple(row[f"body.{name}.q{axis}"] for axis in "xyzw")
                found.append(np.abs(turned - rotation(q)).max())
        return float(max(found))


def rotation(q: Any) -> Any:
    return np.array(matrix(tuple(q))).reshape(3, 3)


def assert_halves(error: Callable[[int], float], steps: int) -> None:
    coarse, fine = error(steps), error(2 * steps)
    assert 0 < fine < LARGEST_RATIO * coarse, (coarse, fine)


# MuJoCo


@pytest.mark.parametrize("name", stated("mjcf"))
def test_mujoco_reads_the_same_doubles(name: str, tmp_path: Path) -> None:
    mujoco = pytest.importorskip("mujoco")
    tree, files = written(name, "mjcf", tmp_path)
    model = mujoco.MjModel.from_xml_path(str(files.scene))
    assert tuple(model.opt.gravity) == tree.gravity
    for link in tree.links:
        body = model.body(link.name)
        assert (body.mass[0], *body.pos, *body.ipos) == (link.mass, *link.place, *link.centre)
        # MuJoCo sorts the principal moments and turns the inertial frame.
        assert sorted(body.inertia) == sorted(link.inertia)
        frame = rotation(np.roll(body.iquat, -1))
        assert np.abs(frame @ np.diag(body.inertia) @ frame.T - np.diag(link.inertia)).max() <= 4e-16 * max(
            link.inertia
        )
        if link.joint in ("hinge", "slider"):
            # It scales axes to length one.
            assert np.abs(model.joint(link.joint_name).axis - link.axis).max() <= 2.0**-52
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    mujoco.mj_forward(model, data)
    for link in tree.links:
        if link.joint in ("hinge", "slider"):
            joint = data.joint(link.joint_name)
            assert (joint.qpos[0], joint.qvel[0]) == (link.coordinate, link.rate)
        else:
            assert_moves_as(link, *velocity_of(mujoco, model, data, link))
    assert model.npair == len(tree.touches)


def velocity_of(mujoco: Any, model: Any, data: Any, link: Link) -> tuple[Any, Any]:
    """Velocity of the link's point and angular velocity in space."""
    found, body = np.zeros(6), data.body(link.name)
    mujoco.mj_objectVelocity(model, data, mujoco.mjtObj.mjOBJ_XBODY, body.id, found, 0)
    arm = body.xmat.reshape(3, 3) @ link.point
    return found[3:] + np.cross(found[:3], arm), found[:3]


def assert_moves_as(link: Link, velocity: Any, spin: Any) -> None:
    size = 1 + max(map(abs, (*link.velocity, *link.spin)))
    assert np.abs(velocity - np.array(link.velocity)).max() <= 16 * 2.0**-52 * size
    assert np.abs(spin - np.array(link.spin)).max() <= 16 * 2.0**-52 * size


def mujoco_error(files: Written, steps: int, integrator: str = "mjINT_EULER") -> float:
    mujoco = pytest.importorskip("mujoco")
    motion, model = Motion(files), mujoco.MjModel.from_xml_path(str(files.scene))
    model.opt.timestep, model.opt.integrator = motion.interval / steps, getattr(mujoco.mjtIntegrator, integrator)
    data = mujoco.MjData(model)
    mujoco.mj_resetDataKeyframe(model, data, 0)
    worst = 0.0
    for row in motion.rows[1:]:
        mujoco.mj_step(model, data, steps)
        mujoco.mj_kinematics(model, data)
        here = motion.distance(
            row,
            lambda name: data.joint(name).qpos[0],
            lambda name: (data.body(name).xpos, data.body(name).xmat.reshape(3, 3)),
        )
        worst = max(worst, here)
    return worst


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=() if name in SOME else pytest.mark.slow) for name in stated("mjcf", smooth=True)]
)
def test_mujoco_follows_the_motion(name: str, tmp_path: Path) -> None:
    """With its Runge-Kutta method to nine digits: what replaces a point mass moves in the same way, and no number is off."""
    pytest.importorskip("mujoco")
    _, files = written(name, "mjcf", tmp_path)
    assert_halves(lambda steps: mujoco_error(files, steps), 50)
    assert mujoco_error(files, 200, "mjINT_RK4") < 1e-9


# PyBullet


@pytest.fixture
def bullet() -> Any:
    pybullet = pytest.importorskip("pybullet")
    client = pybullet.connect(pybullet.DIRECT)
    # It keeps the text of files by their names.
    pybullet.setPhysicsEngineParameter(enableFileCaching=0, physicsClientId=client)
    yield pybullet
    pybullet.disconnect(client)


def loaded(bullet: Any, files: Written, tree: Tree) -> tuple[int, dict[str, int]]:
    """The number of the multibody, and that of each link; -1 for its base."""
    jointed = tree.links[0].joint != "free"
    number = bullet.loadURDF(str(files.scene), flags=bullet.URDF_USE_INERTIA_FROM_FILE, useFixedBase=jointed)
    if not jointed:
        return number, {tree.links[0].name: -1}
    found = {bullet.getJointInfo(number, j)[12].decode(): j for j in range(bullet.getNumJoints(number))}
    return number, found


@pytest.mark.parametrize("name", stated("urdf"))
def test_pybullet_reads_the_same_doubles(name: str, tmp_path: Path, bullet: Any) -> None:
    tree, files = written(name, "urdf", tmp_path)
    number, indices = loaded(bullet, files, tree)
    assert set(indices) == {link.name for link in tree.links}
    for link in tree.links:
        mass, _, inertia, centre, *_ = bullet.getDynamicsInfo(number, indices[link.name])
        assert (mass, *inertia, *centre) == (link.mass, *link.inertia, *link.centre)
        if link.joint != "free":
            info = bullet.getJointInfo(number, indices[link.name])
            assert info[1].decode() == link.joint_name
            assert np.abs(np.array(info[13]) - link.axis).max() <= 2.0**-52
            parent = link_named(tree, link.parent)
            # The place in the frame of the parent's centre of mass: one subtraction.
            assert np.abs(np.array(info[14]) + parent - link.place).max() <= 2.0**-52 * (1 + max(map(abs, link.place)))


def link_named(tree: Tree, name: str) -> Vector:
    """The centre of mass of a link; of space, the origin."""
    return next((link.centre for link in tree.links if link.name == name), (0.0, 0.0, 0.0))


@pytest.mark.parametrize("name", some("urdf"))
def test_pybullet_follows_the_motion(name: str, tmp_path: Path, bullet: Any) -> None:
    tree, files = written(name, "urdf", tmp_path)
    motion = Motion(files)

    def error(steps: int) -> float:
        bullet.resetSimulation()
        bullet.setGravity(*motion.manifest["gravity"])
        bullet.setPhysicsEngineParameter(fixedTimeStep=motion.interval / steps, numSubSteps=0)
        number, indices = loaded(bullet, files, tree)
        index = {link.joint_name: indices[link.name] for link in tree.links}
        for link in (-1, *indices.values()):
            bullet.changeDynamics(number, link, linearDamping=0, angularDamping=0, jointDamping=0, maxJointVelocity=1e9)
        for joint, start in motion.joints.items():
            bullet.setJointMotorControl2(number, index[joint], bullet.VELOCITY_CONTROL, force=0)
            bullet.resetJointState(number, index[joint], start["position"], start["rate"])
        for start in motion.bodies.values():
            bullet.resetBasePositionAndOrientation(number, start["frame"], start["quaternion"])
            bullet.resetBaseVelocity(number, start["velocity"], start["angular_velocity"])
        worst = 0.0
        for row in motion.rows[1:]:
            for _ in range(steps):
                bullet.stepSimulation()
            place, attitude = bullet.getBasePositionAndOrientation(number)
            here = place, rotation(attitude)
            worst = max(
                worst,
                motion.distance(
                    row, lambda joint: bullet.getJointState(number, index[joint])[0], lambda _, here=here: here
                ),
            )
        return worst

    assert_halves(error, 100)


# Drake


FOR_DRAKE = [(name, form) for form in ("sdf", "urdf", "mjcf") for name in some(form)]
PARSED = [*FOR_DRAKE, *(("bouncing_ball", form) for form in ("sdf", "urdf", "mjcf"))]


def plant_of(files: Written, step: float = 0.0) -> Any:
    plant = pytest.importorskip("pydrake.multibody.plant").MultibodyPlant(step)
    pytest.importorskip("pydrake.multibody.parsing").Parser(plant).AddModels(str(files.scene))
    plant.Finalize()
    return plant


@pytest.mark.parametrize(("name", "form"), PARSED)
def test_drake_reads_the_same_doubles(name: str, form: str, tmp_path: Path) -> None:
    """But for moments about the link's frame, which Drake keeps in their place: they round once more."""
    tree, files = written(name, form, tmp_path)
    plant = plant_of(files)
    for link in tree.links:
        body = plant.GetBodyByName(link.name)
        assert (body.default_mass(), *body.default_com()) == (link.mass, *link.centre)
        spatial = body.default_spatial_inertia()
        central = spatial.Shift(body.default_com()).CalcRotationalInertia().CopyToFullMatrix3()
        size = max(link.inertia) + link.mass * float(np.dot(link.centre, link.centre))
        assert np.abs(central - np.diag(link.inertia)).max() <= 8 * 2.0**-52 * size
        if link.joint == "hinge":
            assert np.abs(plant.GetJointByName(link.joint_name).revolute_axis() - link.axis).max() <= 2.0**-52
        if link.joint == "slider":
            assert np.abs(plant.GetJointByName(link.joint_name).translation_axis() - link.axis).max() <= 2.0**-52


@pytest.mark.parametrize("form", ["sdf", "urdf", "mjcf"])
def test_a_link_is_placed_on_its_parent(form: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A double pendulum whose pivot is not the origin."""
    case = get("double_pendulum")
    scene = case.scene
    assert scene is not None

    def build(state: tuple[float, ...], parameters: tuple[float, ...]) -> Scene:
        found = scene.build(state, parameters)
        upper, lower = found.hinges
        return replace(found, hinges=(replace(upper, anchor=(0.5, 2.0, 1.0)), replace(lower, anchor=(0.0, 0.25, 0.5))))

    monkeypatch.setattr(type(case), "scene", replace(scene, build=build))
    plant = plant_of(write(case, form, tmp_path))
    context = plant.CreateDefaultContext()
    places = [
        plant.EvalBodyPoseInWorld(context, plant.GetBodyByName(name)).translation().tolist()
        for name in ("upper", "lower")
    ]
    assert places == [
        [0.5, 2.0, 1.0],
        [0.5, 2.25, 1.5 - float(case.l1)],
    ]  # the lower anchor is relative to the upper mass


@pytest.mark.parametrize(("name", "form"), [each for each in FOR_DRAKE if each[1] != "mjcf"])
def test_drake_follows_the_motion(name: str, form: str, tmp_path: Path) -> None:
    analysis = pytest.importorskip("pydrake.systems.analysis")
    velocities = pytest.importorskip("pydrake.multibody.math")
    math = pytest.importorskip("pydrake.math")
    _, files = written(name, form, tmp_path)
    motion = Motion(files)

    def error(steps: int) -> float:
        plant = plant_of(files, motion.interval / steps)
        plant.mutable_gravity_field().set_gravity_vector(motion.manifest["gravity"])
        simulator = analysis.Simulator(plant)
        context = simulator.get_mutable_context()
        for joint, start in motion.joints.items():
            coordinate = plant.GetJointByName(joint)
            state = context.get_mutable_discrete_state_vector()
            state[coordinate.position_start()] = start["position"]
            state[plant.num_positions() + coordinate.velocity_start()] = start["rate"]
        for body, start in motion.bodies.items():
            turned = rotation(start["quaternion"])
            if start["joint"] == "ball":
                plant.GetJointByName(f"{body}_joint").set_angular_velocity(
                    context, turned.T @ start["angular_velocity"]
                )
                continue
            link = plant.GetBodyByName(body)
            pose = math.RigidTransform(math.RotationMatrix(turned), start["frame"])
            plant.SetFreeBodyPose(context, link, pose)
            spatial = velocities.SpatialVelocity(start["angular_velocity"], start["velocity"])
            plant.SetFreeBodySpatialVelocity(context, link, spatial)

        def coordinate_of(joint: str) -> float:
            return float(plant.GetPositions(context)[plant.GetJointByName(joint).position_start()])

        def pose_of(body: str) -> tuple[Any, Any]:
            pose = plant.EvalBodyPoseInWorld(context, plant.GetBodyByName(body))
            return pose.translation(), pose.rotation().matrix()

        worst = 0.0
        for row in motion.rows[1:]:
            simulator.AdvanceTo(row["t"])
            worst = max(worst, motion.distance(row, coordinate_of, pose_of))
        return worst

    assert_halves(error, 50)
