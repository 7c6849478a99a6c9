"""What PyBullet lacks, shown on the engine itself: the reasons of the scenes that it is not given."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from gnomon.cases import get, names
from gnomon.cases.core.scene import TOKENS
from gnomon.harness.adapters.engines.bullet.pybullet import PyBullet

pybullet = pytest.importorskip("pybullet", reason="pybullet has wheels up to CPython 3.11 only")

Call = Callable[..., Any]
DT = 1e-3


@pytest.fixture
def call() -> Iterator[Call]:
    """Calls the engine in a world without gravity, at the settings that the adapter uses for contacts."""
    client = pybullet.connect(pybullet.DIRECT)

    def made(name: str, *arguments: Any, **named: Any) -> Any:
        return getattr(pybullet, name)(*arguments, physicsClientId=client, **named)

    made(
        "setPhysicsEngineParameter", fixedTimeStep=DT, numSubSteps=0, contactBreakingThreshold=0.02, contactSlop=0.0,
        contactERP=0.0, solverResidualThreshold=0.0, numSolverIterations=100,
    )  # fmt: skip
    yield made
    pybullet.disconnect(physicsClientId=client)


def ball(call: Call, place: tuple[float, float, float], radius: float, moment: float = 1.0, **dynamics: float) -> int:
    number = int(call("createMultiBody", 1.0, call("createCollisionShape", pybullet.GEOM_SPHERE, radius=radius)))
    call("changeDynamics", number, -1, mass=1.0, localInertiaDiagonal=(moment,) * 3)
    call("changeDynamics", number, -1, linearDamping=0.0, angularDamping=0.0, maxJointVelocity=1e9, **dynamics)
    call("resetBasePositionAndOrientation", number, place, (0, 0, 0, 1))
    return number


def plane(call: Call) -> int:
    number = int(call("createMultiBody", 0.0, call("createCollisionShape", pybullet.GEOM_PLANE)))
    call("changeDynamics", number, -1, lateralFriction=1.0)
    return number


def velocity(call: Call, number: int) -> tuple[Any, Any]:
    return call("getBaseVelocity", number)  # type: ignore[no-any-return]


def test_all_scenes_run_except_those_that_need_what_is_lacking() -> None:
    scenes = {name: scene for name in names() if (scene := get(name).scene) is not None}
    taken = {name for name, scene in scenes.items() if PyBullet().unsupported(scene) is None}
    assert {name for name, scene in scenes.items() if not scene.needs & PyBullet.lacks.keys()} == taken
    assert len(taken) >= 100
    assert set(PyBullet.lacks) <= set(TOKENS)


def test_there_is_one_coefficient_of_friction(call: Call) -> None:
    """A block on a slope has no more hold at rest than in motion, and no argument gives it one."""
    number = ball(call, (0, 0, 1), 0.1)
    for argument in ("staticFriction", "kineticFriction", "lateralStaticFriction"):
        with pytest.raises(TypeError, match="invalid keyword"):
            call("changeDynamics", number, -1, **{argument: 0.5})


@pytest.mark.parametrize("spin", [0.0, 10.0, 300.0])
def test_friction_of_a_sliding_ball_does_not_depend_on_its_spin(call: Call, spin: float) -> None:
    """Of a contact patch it does: its friction has the share slip/(slip + rho spin) of mu g."""
    call("setGravity", 0, 0, -9.81)
    plane(call)
    number = ball(call, (0, 0, 0.03), 0.03, 3.6e-4, lateralFriction=0.2, spinningFriction=1e-3)
    call("resetBaseVelocity", number, (2, 0, 0), (0, 0, spin))
    for _ in range(50):
        call("stepSimulation")
    (vx, _, _), (_, _, wz) = velocity(call, number)
    assert 2 - vx == pytest.approx(0.2 * 9.81 * 0.05, rel=1e-9)
    assert spin - wz == pytest.approx(1e-3 * 9.81 * 0.05 / 3.6e-4 if spin else 0.0, rel=1e-6)


def test_contacts_do_not_stick(call: Call) -> None:
    """After an impact without rebound a pull of 1 N parts the balls at once."""
    one, two = (ball(call, (x, 0, 0), 0.1, restitution=0.0) for x in (0.0, 0.25))
    call("resetBaseVelocity", one, (1, 0, 0))
    for _ in range(200):
        call("stepSimulation")
    together = velocity(call, one)[0][0], velocity(call, two)[0][0]
    for _ in range(200):
        call(
            "applyExternalForce",
            two,
            -1,
            (1, 0, 0),
            call("getBasePositionAndOrientation", two)[0],
            pybullet.WORLD_FRAME,
        )
        call("stepSimulation")
    assert together == pytest.approx((0.5, 0.5), abs=1e-9)
    assert velocity(call, one)[0][0] == pytest.approx(0.5, abs=1e-9)
    assert velocity(call, two)[0][0] == pytest.approx(0.7, abs=1e-9)


def test_a_bullet_passes_through_a_block_between_two_steps(call: Call) -> None:
    """At 400 m/s it moves by 0.4 m in a step; the two touch within 0.2 m."""
    bullet, block = (ball(call, (x, 0, 0), 0.1) for x in (0.03, 10.0))
    call("resetBaseVelocity", bullet, (400, 0, 0))
    for _ in range(50):
        call("stepSimulation")
    assert velocity(call, bullet)[0] == (400.0, 0.0, 0.0)
    assert velocity(call, block)[0] == (0.0, 0.0, 0.0)


def test_no_constraint_is_a_curve_a_blade_a_string_a_belt_or_a_rolling_wheel() -> None:
    """createConstraint takes these kinds; its manual lists no others."""
    kinds = {name for name in dir(pybullet) if name.startswith("JOINT_") and "FEEDBACK" not in name}
    assert kinds == {
        "JOINT_FIXED", "JOINT_GEAR", "JOINT_PLANAR", "JOINT_POINT2POINT", "JOINT_PRISMATIC", "JOINT_REVOLUTE",
        "JOINT_SPHERICAL",
    }  # fmt: skip


def test_friction_in_one_direction_needs_a_normal_force(call: Call) -> None:
    """So it is no blade: the scenes of blades have no weight, and the engine's friction then does nothing."""
    plane(call)
    number = ball(call, (0, 0, 0.1), 0.1, lateralFriction=1e6)
    call("changeDynamics", number, -1, anisotropicFriction=[0, 1, 0])
    call("resetBaseVelocity", number, (1, 1, 0))
    for _ in range(100):
        call("stepSimulation")
    assert velocity(call, number)[0] == pytest.approx((1, 1, 0), abs=1e-12)


def disc(call: Call, height: float) -> int:
    shape = call("createCollisionShape", pybullet.GEOM_CYLINDER, radius=0.25, height=height)
    number = int(call("createMultiBody", 1.0, shape))
    call("changeDynamics", number, -1, mass=1.0, localInertiaDiagonal=(1 / 64, 1 / 64, 1 / 32))
    call("changeDynamics", number, -1, lateralFriction=10.0, linearDamping=0.0, angularDamping=0.0)
    return number


def test_a_tilted_disc_touches_with_the_lower_edge_of_its_thickness(call: Call) -> None:
    """A disc of 1 cm stands half its thickness times the cosine of the tilt too high."""
    ground, number = plane(call), disc(call, 1e-2)
    call("resetBasePositionAndOrientation", number, (0, 0, 1), pybullet.getQuaternionFromEuler((1.0, 0, 0)))
    lowest = 1 - call("getClosestPoints", number, ground, 10.0)[0][8]
    assert lowest - 0.25 * np.sin(1.0) > 2e-3


def test_a_thin_disc_does_not_roll_straight(call: Call) -> None:
    """Upright, at 1 m/s, 1 mm thick: it leaves its line by 2 cm in 1 s, where the motion is straight."""
    call("setGravity", 0, 0, -9.81)
    plane(call)
    number = disc(call, 1e-3)
    call("resetBasePositionAndOrientation", number, (0, 0, 0.25), pybullet.getQuaternionFromEuler((np.pi / 2, 0, 0)))
    call("resetBaseVelocity", number, (1, 0, 0), (0, 4, 0))
    for _ in range(1000):
        call("stepSimulation")
    assert abs(call("getBasePositionAndOrientation", number)[0][1]) > 1e-3


def test_a_curved_surface_is_made_of_flat_triangles(call: Call) -> None:
    """A ball that lies in a bowl z = (x^2 + y^2)/2 made of cells of 10 cm touches a flat cell above the surface."""
    side = np.linspace(-1, 1, 21)
    points = [(x, y, (x * x + y * y) / 2) for y in side for x in side]
    cells = [(21 * j + i, 21 * j + i + 1, 21 * j + i + 21) for j in range(20) for i in range(20)]
    cells += [(21 * j + i + 1, 21 * j + i + 22, 21 * j + i + 21) for j in range(20) for i in range(20)]
    shape = call(
        "createCollisionShape", pybullet.GEOM_MESH, vertices=points, indices=[n for cell in cells for n in cell],
        flags=pybullet.GEOM_FORCE_CONCAVE_TRIMESH,
    )  # fmt: skip
    bowl = call("createMultiBody", 0.0, shape)
    above = []
    for x in (0.5, 0.55):  # at a corner of the cells, and in the middle of an edge
        hit = call("rayTest", (x, 0.0, 2.0), (x, 0.0, -1.0))[0]
        assert hit[0] == bowl
        above.append(hit[3][2] - x * x / 2)
    assert above[0] == pytest.approx(0.0, abs=1e-6)
    assert above[1] == pytest.approx(0.05**2 / 2, rel=1e-3)


@pytest.mark.parametrize(
    ("name", "number"), [("belt_driven_machine", "F"), ("yo_yo", "r")], ids=["force of a belt", "radius of a string"]
)
def test_a_scene_does_not_tell_what_a_gear_needs(name: str, number: str) -> None:
    """The engine has a gear with a ratio and a largest force: the scene is the same for any force or radius."""
    case = get(name)
    form = case.scene
    assert form is not None
    scenes = [
        form.build((1.0, 0.5), tuple(map(float, other.parameter_values())))
        for other in (case, get(name, **{number: 2 * float(case.parameters[number])}))
    ]
    one, two = (replace(scene, torques=()) for scene in scenes)
    assert one == two


def test_worlds_have_no_rotating_frame() -> None:
    """The only field of a world is a constant gravity: no function sets a rotation of the frame."""
    fields = {name for name in dir(pybullet) if name.startswith("set") and ("Gravity" in name or "Frame" in name)}
    assert fields == {"setGravity"}


@pytest.mark.parametrize(("together", "moment"), [(True, 0.0), (False, 0.5)])
def test_the_inertia_of_a_link_is_lost_if_set_together_with_damping(call: Call, together: bool, moment: float) -> None:
    """The adapter sets mass and inertia in a call of their own."""
    number = call(
        "createMultiBody", linkMasses=[1], linkCollisionShapeIndices=[-1], linkVisualShapeIndices=[-1],
        linkPositions=[(0, 0, 0)], linkOrientations=[(0, 0, 0, 1)], linkInertialFramePositions=[(0, 0, 0)],
        linkInertialFrameOrientations=[(0, 0, 0, 1)], linkParentIndices=[0],
        linkJointTypes=[pybullet.JOINT_REVOLUTE], linkJointAxis=[(0, 0, 1)],
    )  # fmt: skip
    inertia, undamped = {"mass": 1, "localInertiaDiagonal": (0.5, 0.5, 0.5)}, {"linearDamping": 0, "angularDamping": 0}
    for settings in [inertia | undamped] if together else [inertia, undamped]:
        call("changeDynamics", number, 0, **settings)
    assert call("getDynamicsInfo", number, 0)[2] == pytest.approx((moment,) * 3)
