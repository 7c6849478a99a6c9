"""Pinocchio's articulated body algorithm gives the accelerations of the cases: a second engine, without integration."""

from typing import Any

import numpy as np
import pytest
from gnomon.cases import get, names
from gnomon.cases.core.forms import first_order
from gnomon.cases.core.scene import Hinge, Readings, Scene

pin: Any = pytest.importorskip("pinocchio", reason="pin is not installed")

JOINTED = [
    name
    for name in names()
    if (case := get(name)).hybrid is None
    and case.scene is not None
    and case.scene.needs & {"hinge", "slider"}
    and case.scene.needs <= {"hinge", "slider", "linked_joint", "position_force", "velocity_force", "time_force"}
]


def accelerations(scene: Scene) -> dict[str, float]:
    model, numbers = pin.Model(), {"": 0}
    model.gravity.linear = np.array(scene.gravity)
    bodies, levers = {body.name: body for body in scene.bodies}, {}
    for joint in sorted(scene.joints, key=lambda joint: bool(joint.parent)):
        hinge, body = isinstance(joint, Hinge), bodies[joint.body]
        lever = np.array(joint.arm if isinstance(joint, Hinge) else (0.0, 0.0, 0.0))
        kind = (pin.JointModelRevoluteUnaligned if hinge else pin.JointModelPrismaticUnaligned)(np.array(joint.axis))
        place = pin.SE3(np.eye(3), np.array(joint.anchor) + levers.get(joint.parent, 0.0))
        number = model.addJoint(numbers[joint.parent], kind, place, joint.name)
        model.appendBodyToJoint(number, pin.Inertia(body.mass, lever, np.diag(body.inertia)), pin.SE3.Identity())
        numbers[joint.body], levers[joint.body] = number, lever
    ordered = sorted(scene.joints, key=lambda joint: bool(joint.parent))
    q = np.array([joint.angle if isinstance(joint, Hinge) else joint.position for joint in ordered])
    v, data = np.array([joint.rate for joint in ordered]), model.createData()
    pin.forwardKinematics(model, data, q, v)
    outer = [pin.Force.Zero() for _ in range(model.njoints)]
    for force in scene.forces:
        number, lever = numbers[force.body], levers[force.body]
        turn, velocity = data.oMi[number].rotation, data.v[number]
        moving = turn @ (velocity.linear + np.cross(velocity.angular, lever))
        pull = turn.T @ np.array(force.law(0.0, tuple(data.oMi[number].act(lever)), tuple(moving)))
        outer[number] += pin.Force(pull, np.cross(lever, pull))
    found = pin.aba(model, data, q, v, np.zeros(model.nv), outer)
    return dict(zip((joint.name for joint in ordered), found, strict=True))


@pytest.mark.parametrize("name", JOINTED)
def test_accelerations_are_the_equations(name: str) -> None:
    case = get(name).rounded()
    state, parameters = tuple(map(float, case.exact(case.times[2].item()))), tuple(map(float, case.parameter_values()))
    form = next(found for found in map(first_order, case.all_forms()) if found is not None)
    expected = np.array(form.equations(0.0, state, parameters), float)
    assert case.scene is not None
    scene = case.scene.build(state, parameters)
    # The readings are linear in the joints: those of the rates are the rates of the state, without any step.
    rates = {
        joint.name: (joint.rate, change) for joint in scene.joints for change in [accelerations(scene)[joint.name]]
    }
    at_rest = np.array(case.scene.observe(Readings({joint.name: (0.0, 0.0) for joint in scene.joints}), parameters))
    found = np.array(case.scene.observe(Readings(rates), parameters)) - at_rest
    scale = max(float(np.max(np.abs(expected))), max(map(abs, state)) / case.time_scale)
    assert found == pytest.approx(expected, rel=1e-9, abs=1e-9 * scale)
