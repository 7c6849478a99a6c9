"""The hinges and sliders of a scene in PyBullet: each tree of joints is a multibody, a governor too."""

from dataclasses import replace
from functools import partial
from typing import Any

from gnomon.cases.core.scene import Body, Hinge, Scene, Slider, Vector
from gnomon.harness.adapters.engines.bullet.pybullet_joints import Link, Multibody
from gnomon.harness.adapters.engines.scene_tree import branches
from gnomon.harness.adapters.engines.vectors import ORIGIN

Joints = list[Hinge | Slider]


def grow(world: Any, scene: Scene) -> None:
    """Create the joints of a scene and enter them, with their bodies, in the tables of the world."""
    bodies = {body.name: body for body in scene.bodies}
    trees: dict[str, tuple[Vector, list[Link], Joints]] = {}
    roots: dict[str, str] = {}
    for branch in branches(scene):
        joint, body = branch.joint, bodies[branch.joint.body]
        if body.name in world.planes:
            continue
        root = roots[joint.name] = roots.get(branch.before, joint.name)
        _, links, joints = trees.setdefault(root, (branch.place, [], []))
        before = next((index for index, each in enumerate(joints) if each.name == branch.before), -1)
        place = branch.place if links else ORIGIN
        links.append(Link(joint.axis, isinstance(joint, Slider), before, place, branch.arm, body.mass, body.inertia))
        joints.append(joint)
    sleeve = next((body for body in scene.bodies if body.name not in {joint.body for joint in scene.joints}), None)
    for base, links, joints in trees.values():
        if "linkage" in world.needs and sleeve:
            _governor(world, base, links, joints, sleeve)
        else:
            _enter(world, Multibody(world, links, base), joints)


def _enter(world: Any, multibody: Multibody, joints: Joints) -> None:
    for index, joint in enumerate(joints):
        world.jointed[joint.name] = world.handles[joint.body] = multibody.number, index
        world.carriers[joint.body] = partial(multibody.motion, index)
        if isinstance(joint, Slider) and joint.drive:
            world.chores.append(multibody.driven(index, joint.drive))
        if isinstance(joint, Hinge) and joint.friction:  # a motor that stops the joint with at most this torque
            mode = world.api.VELOCITY_CONTROL
            world.call("setJointMotorControl2", multibody.number, index, mode, force=joint.friction)


def _governor(world: Any, base: Vector, links: list[Link], joints: Joints, sleeve: Body) -> None:
    """A governor as one arm of twice the mass, with the sleeve at the end of a link of the same length.

    Both arms have the same angle, so their masses may be on one. A gear gives the link twice the arm's angle, the other way:
    its end stays on the axis.
    """
    end = len(links)
    arm = replace(links[-1], mass=2 * links[-1].mass)
    hung = [Link(arm.axis, before=end - 1, place=arm.arm, arm=arm.arm, mass=sleeve.mass)] if sleeve.mass else []
    multibody = Multibody(world, [*links[:-1], arm, *hung], base)
    _enter(world, multibody, joints)
    if hung:
        multibody.gear(end, multibody, end - 1, 2.0)
        world.sleeve = multibody.number, end
        world.measured[sleeve.name] = partial(multibody.motion, end)


def place_joints(world: Any, scene: Scene) -> None:
    """Set the coordinates and rates of the joints at the start."""
    for joint in scene.joints:
        if joint.name in world.jointed:
            coordinate = joint.angle if isinstance(joint, Hinge) else joint.position
            world.call("resetJointState", *world.jointed[joint.name], coordinate, joint.rate)
    if world.sleeve:
        arm = scene.hinges[-1]
        world.call("resetJointState", *world.sleeve, -2 * arm.angle, -2 * arm.rate)
