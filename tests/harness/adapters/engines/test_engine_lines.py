"""The lines of code of an engine set what its adapter records: they run in the engine, which then has the values."""

from collections.abc import Iterator
from functools import cache
from typing import Any

import numpy as np
import pytest
from gnomon.cases import get, names
from gnomon.cases.core.case import Case
from gnomon.cases.core.scene import SceneForm
from gnomon.harness.adapters.engine_lines import DT, code, line_of, on_scene, record_options, setting_lines
from gnomon.harness.adapters.engines import jsbsim, mujoco, pymunk
from gnomon.harness.adapters.engines.bullet import pybullet
from gnomon.harness.adapters.engines.scene_run import TIGHTER, SceneIntegrator
from gnomon.harness.contract.declared import read_declared
from gnomon.harness.contract.integrator import Refused
from gnomon.harness.contract.problem import problem_of

SUITE = {name: get(*name.split("/")) for name in read_declared("running", "suites.toml")["engines"]["cases"]}
FEW = {
    name: get(*name.split("/"))
    for name in (
        "euler_top/engines", "charge_in_E_and_B/engines", "pendulum_simple/engines", "spherical_pendulum", "swinging_atwood",
        "bouncing_ball/engines_e08", "block_incline_friction/engines_slide", "flywheel_coast_down", "man_on_cart",
        "bouncing_ball_table", "ink_jet_printer",
    )
}  # fmt: skip
"""Scenes of each kind, and those with options of their own: friction of a hinge, a driven body, a moving plane, glue."""
MODULES = {"pybullet": pybullet, "mujoco": mujoco, "pymunk": pymunk, "jsbsim": jsbsim}
every = pytest.mark.parametrize("library", MODULES)


def lines_of(policy: type[SceneIntegrator], cases: dict[str, Case]) -> Iterator[tuple[str, str, Any]]:
    """(option, line, recorded value) on the scenes that the engine takes, each line once."""
    seen, one = set(), policy()
    for case in cases.values():
        options = on_scene(one, case)
        if options is None:
            continue
        values = record_options(one, case, DT)
        for option, value in options.items():
            line = line_of(one, option, value)
            if line not in seen:
                seen.add(line)
                yield option, line, values[option]


@cache
def few_lines(policy: type[SceneIntegrator]) -> tuple[tuple[str, str, Any], ...]:
    """The lines on FEW, for which each engine builds and runs these scenes: once for all tests."""
    return tuple(lines_of(policy, FEW))


def held(target: Any, value: Any) -> bool:
    """Whether the engine has a value that was computed with six digits."""
    return bool(np.allclose(target, value, rtol=1e-5, atol=1e-15))


@every
def test_every_option_has_a_line(library: str) -> None:
    pytest.importorskip(library)
    for policy in MODULES[library].INTEGRATORS:
        for option, line, _ in few_lines(policy):
            assert option.partition(" (")[0] in policy.lines, option
            assert "..." not in line


@pytest.mark.slow
@every
def test_every_option_of_every_scene_has_a_line(library: str) -> None:
    pytest.importorskip(library)
    cases = SUITE | {name: get(name) for name in names() if get(name).scene is not None}
    test = [option for policy in MODULES[library].INTEGRATORS for option, _, _ in lines_of(policy, cases)]
    assert {option.partition(" (")[0] for option in test} <= set(MODULES[library].INTEGRATORS[0].lines)


MUJOCO = """<mujoco><worldbody>
<geom name="floor" type="plane" size="1 1 1"/>
<body name="ball"><inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/><joint name="a" type="slide"/><joint name="b" type="slide"/>
<geom name="skin" size="0.1"/></body></worldbody><contact><pair name="pair" geom1="floor" geom2="skin"/></contact>
<equality><joint joint1="a" joint2="b"/></equality></mujoco>"""


def test_lines_of_mujoco_set_the_values() -> None:
    engine = pytest.importorskip("mujoco")
    for policy in mujoco.INTEGRATORS:
        for option, line, value in few_lines(policy):
            model = engine.MjModel.from_xml_string(MUJOCO)
            exec(line, {"mujoco": engine, "model": model, "pair": 0, "equality": 0, "dof": 0, "dt": DT})
            kind, _, name = option.partition(" (")[0].rpartition(".")
            place = {"equality": "eq", "friction": "dof"}.get(kind, "pair")
            if name == "autoreset":
                assert model.opt.disableflags & engine.mjtDisableBit.mjDSBL_AUTORESET
            elif name in ("cone", "integrator"):
                kinds = {"cone": (engine.mjtCone, "mjCONE_"), "integrator": (engine.mjtIntegrator, "mjINT_")}
                enumeration, prefix = kinds[name]
                assert enumeration(getattr(model.opt, name)).name == prefix + value.upper()
            elif kind:
                assert held(getattr(model, f"{place}_{name}")[0][: len(value)], value), line
            else:
                assert held(model.dof_armature[0] if name == "armature" else getattr(model.opt, name), value), line


def test_lines_of_pymunk_set_the_values() -> None:
    engine = pytest.importorskip("pymunk")
    for policy in pymunk.INTEGRATORS:
        for option, line, value in few_lines(policy):
            space = engine.Space()
            constraint = engine.PinJoint(space.static_body, engine.Body(1.0, 1.0))
            exec(line, {"space": space, "constraint": constraint, "dt": DT})
            assert held(getattr(constraint if option == "error_bias" else space, option), value), line


def test_lines_of_pybullet_are_calls_with_the_values(monkeypatch: pytest.MonkeyPatch) -> None:
    """The engine reports few of its options: the arguments that it takes are noted, and it refuses unknown ones."""
    engine = pytest.importorskip("pybullet")
    client = engine.connect(engine.DIRECT)
    shape = engine.createCollisionShape(engine.GEOM_SPHERE, radius=0.1)
    link = {"linkMasses": [1.0], "linkCollisionShapeIndices": [-1], "linkVisualShapeIndices": [-1]}
    link |= {"linkPositions": [(0, 0, 0)], "linkInertialFramePositions": [(0, 0, 0)], "linkParentIndices": [0]}
    link |= {"linkOrientations": [(0, 0, 0, 1)], "linkInertialFrameOrientations": [(0, 0, 0, 1)]}
    link |= {"linkJointTypes": [engine.JOINT_REVOLUTE], "linkJointAxis": [(0, 0, 1)]}
    body, other = (engine.createMultiBody(1.0, shape, **link) for _ in range(2))
    gear = engine.createConstraint(body, 0, other, 0, engine.JOINT_GEAR, (0, 0, 1), (0, 0, 0), (0, 0, 0))
    known = {"p": engine, "body": body, "link": 0, "joint": 0, "gear": gear, "mass": 1.0, "shape": shape, "rate": 0.0}
    told: list[Any] = []

    def noted(original: Any) -> Any:
        def call(*arguments: Any, **named: Any) -> Any:
            told.extend((*arguments, *named.items()))
            return original(*arguments, **named)

        return call

    for name in (
        "changeDynamics",
        "setPhysicsEngineParameter",
        "setJointMotorControl2",
        "changeConstraint",
        "createMultiBody",
    ):
        monkeypatch.setattr(engine, name, noted(getattr(engine, name)))
    arguments = {"velocityMotorForce": "force", "motorForce": "force", "gearForce": "maxForce"}
    for policy in pybullet.INTEGRATORS:
        for option, line, value in few_lines(policy):
            engine.resetJointState(body, 0, 0.0)
            told.clear()
            exec(line, dict(known))
            if option == "movingPlaneMass":
                assert told[0] == value
            elif option != "charges":  # no option of the engine, but a way to call it
                assert (arguments.get(option, option), value) in told, line
            says = engine.getPhysicsEngineParameters()
            assert says.get(option, value) == value
    engine.disconnect(client)


def test_values_that_depend_on_the_step_are_expressions_of_it() -> None:
    assert code((2e-3, 1.0), (1e-3, 1.0), 1e-3) == "2 * dt, 1.0"
    assert code(-1e4, -4e4, 1e-3) == "-0.01 / dt**2"
    assert code(-3.0, -6.0, 1e-3) == "-0.003 / dt"
    assert code(1.0, 1.7, 1e-3) == "..."


def test_lines_are_grouped_by_the_scenes_that_need_them() -> None:
    pytest.importorskip("pymunk")
    chosen = {"bouncing_ball": ("impact", get("bouncing_ball")), "kepler_orbit": ("free", get("kepler_orbit"))}
    chosen |= {
        "pendulum_simple": ("joints", get("pendulum_simple")),
        "spherical_pendulum": ("joints", get("spherical_pendulum")),
    }
    own = {one.id: one for one in (kind() for kind in pymunk.INTEGRATORS)}
    text = "\n".join(line.partition("  #")[0] for line in setting_lines(own, "pymunk", chosen))
    assert "# impact\nspace.collision_bias = 1.0" in text
    assert (
        "# joints\nconstraint.error_bias = 0.0" in text
        or "# joints (pendulum_simple)\nconstraint.error_bias = 0.0" in text
    )


@pytest.mark.parametrize("library", ["pybullet", "mujoco", "pymunk"])
def test_a_tighter_solver_runs_where_the_engine_iterates_alone(library: str) -> None:
    """It has the options of its configured twin, but for the solver's, of which the iterations are ten times as many."""
    pytest.importorskip(library)
    policies = [kind for kind in MODULES[library].INTEGRATORS if kind.policy == TIGHTER]
    assert policies
    assert all(not kind.primary and kind.tight for kind in policies)
    solver = {"numSolverIterations", "solverResidualThreshold", "iterations", "tolerance"}
    defaults = {"pybullet": 50, "mujoco": 100, "pymunk": 10}
    count = "numSolverIterations" if library == "pybullet" else "iterations"
    for kind in policies:
        (twin,) = (one for one in MODULES[library].INTEGRATORS if (one.name, one.policy) == (kind.name, "configured"))
        assert kind().unsupported(get("kepler_orbit").scene) is not None  # type: ignore[arg-type]
        for case in SUITE.values():
            form = case.scene
            assert isinstance(form, SceneForm)
            if kind().unsupported(form) is not None:
                continue
            try:
                own, other = record_options(kind(), case, DT), record_options(twin(), case, DT)
            except Refused:
                continue
            assert {k: v for k, v in own.items() if k not in solver} == {
                k: v for k, v in other.items() if k not in solver
            }
            assert own[count] == 10 * other.get(count, defaults[library])


def test_a_world_that_is_built_again_keeps_its_iterations() -> None:
    pytest.importorskip("pybullet")
    pytest.importorskip("pymunk")
    for kind in (pybullet.PyBulletTight, pymunk.PymunkTight):
        case = get("bouncing_ball").rounded()
        run = kind().prepare(problem_of(case, kind.accepts), float(case.times[0]))
        before = dict(run.options)  # type: ignore[union-attr]
        run.world.build(run.at_zero)  # type: ignore[union-attr]
        assert run.options == before  # type: ignore[union-attr]
        run.close()  # type: ignore[union-attr]
