"""Forces, torques and blows of a scene in PyBullet: functions of the time, called before each step.

The engine keeps what they apply constant over the step.
"""

from collections.abc import Callable
from typing import Any

from gnomon.cases.core.scene import Force, Hinge, Scene, Slider, Torque, Vector
from gnomon.harness.adapters.engines.compiled_laws import Loads
from gnomon.harness.adapters.engines.scene_run import impulses_within
from gnomon.harness.adapters.engines.vectors import ORIGIN, along, cross, dot, turn_arm

Chore = Callable[[float], None]


def chores_of(world: Any, scene: Scene) -> list[Chore]:
    """What applies the forces, torques and impulses of a scene to the bodies of a world."""
    joints = {joint.body: joint for joint in scene.joints if not joint.parent}
    if world.loads is not None and world.loads.parts.keys() <= world.bodies.keys() - world.charges.fields.keys():
        chores = [_load(world, scene, world.loads)]
    else:
        chores = [_push(world, force, joints.get(force.body)) for force in scene.forces]
        chores += [_turn(world, torque) for torque in scene.torques]
    return [*chores, _strike(world, scene)] if scene.impulses else chores


def _load(world: Any, scene: Scene, loads: Loads) -> Chore:
    """The forces and torques of compiled laws on free bodies. Named arguments would take a tenth of a microsecond a call."""
    api, client, frame, update = world.api, world.client, world.api.WORLD_FRAME, loads.update
    pose, twist, apply = api.getBasePositionAndOrientation, api.getBaseVelocity, api.applyExternalForce
    parts = [(world.bodies[name], *part) for name, part in loads.parts.items()]
    torques = bool(scene.torques)
    moving = torques or any(force.token != "position_force" for force in scene.forces)

    def load(t: float) -> None:
        for number, spin, velocity, place, attitude, _, _ in parts:
            (place[0], place[1], place[2]), turn = pose(number, client)
            if moving:
                (velocity[0], velocity[1], velocity[2]), rate = twist(number, client)
            if torques:
                attitude[1], attitude[2], attitude[3], attitude[0] = turn
                spin[0], spin[1], spin[2] = rate
        update(t)
        for number, _, _, place, _, force, torque in parts:
            apply(number, -1, force.tolist(), place.tolist(), frame, client)
            if torques:
                api.applyExternalTorque(number, -1, torque.tolist(), frame, client)

    return load


def _push(world: Any, force: Force, joint: Hinge | Slider | None) -> Chore:
    """A force. A joint on the world takes it as a force or torque of the joint, which the engine does not round."""
    law = force.law
    if force.partner:
        return _push_pair(world, force)
    if isinstance(joint, Slider):
        rail, (number, link) = joint, world.handles[force.body]
        drive = world.bound("setJointMotorControl2", number, link, world.api.TORQUE_CONTROL)

        def push_along(t: float) -> None:
            x, v, *_ = world.joint_state(number, link)
            drive(force=dot(rail.axis, law(t, along(rail.anchor, rail.axis, x), along(ORIGIN, rail.axis, v))))

        return push_along
    if isinstance(joint, Hinge):
        hinge, (number, link) = joint, world.handles[force.body]
        turn = world.bound("setJointMotorControl2", number, link, world.api.TORQUE_CONTROL)

        def push_around(t: float) -> None:
            angle, rate, *_ = world.joint_state(number, link)
            _, arm = turn_arm(hinge.axis, hinge.arm, angle)
            velocity = along(ORIGIN, cross(hinge.axis, arm), rate)
            turn(force=dot(hinge.axis, cross(arm, law(t, along(hinge.anchor, arm, 1.0), velocity))))

        return push_around
    if force.body in world.carriers:
        motion, apply = world.carriers[force.body], _make_force(world, force.body)

        def push_link(t: float) -> None:
            position, _, velocity, _ = motion()
            apply(law(t, position, velocity), position)

        return push_link
    return world.charges.push(force.body) if force.body in world.charges.fields else _push_free(world, force)


def _push_free(world: Any, force: Force) -> Chore:
    number, law, frame = world.bodies[force.body], force.law, world.api.WORLD_FRAME
    apply, static = world.bound("applyExternalForce"), force.token == "position_force"

    def push_body(t: float) -> None:
        position = world.pose(number)[0]
        velocity = ORIGIN if static else world.twist(number)[0]
        apply(number, -1, law(t, position, velocity), position, frame)

    return push_body


def _push_pair(world: Any, force: Force) -> Chore:
    """A force, and the opposite force on the partner."""
    law, here, there = force.law, world.motion_of(force.body), world.motion_of(force.partner)
    apply, apply_other = _make_force(world, force.body), _make_force(world, force.partner)

    def push(t: float) -> None:
        (place, _, velocity, _), (other, _, drift, _) = here(), there()
        pull = law(t, along(place, other, -1.0), along(velocity, drift, -1.0))
        apply(pull, place)
        apply_other(along(ORIGIN, pull, -1.0), other)

    return push


def _make_force(world: Any, body: str) -> Callable[[Vector, Vector], None]:
    """A function that applies a force at the centre of mass, whose position it is given.

    For a link the engine forms the torque with the position that it keeps, one step old: there a force has no torque.
    """
    number, link = world.handles[body]
    apply, frame = world.bound("applyExternalForce"), world.api.WORLD_FRAME
    if link < 0:
        return lambda force, position: apply(number, link, force, position, frame)
    state = world.bound("getLinkState", number, link)
    return lambda force, _position: apply(number, link, force, state()[0], frame)


def _turn(world: Any, torque: Torque) -> Chore:
    number, link = world.handles[torque.body]
    apply, frame, law = world.bound("applyExternalTorque"), world.api.WORLD_FRAME, torque.law
    motion = world.motion_of(torque.body)

    def turn(t: float) -> None:
        _, attitude, _, spin = motion()
        apply(number, link, law(t, attitude, spin), frame)

    return turn


def _strike(world: Any, scene: Scene) -> Chore:
    """A blow as a force over the step in which it falls."""
    dt, frame = world.dt, world.api.WORLD_FRAME
    struck = {impulse.body for impulse in scene.impulses}
    known = {body: (world.motion_of(body), _make_force(world, body)) for body in struck}
    twist = world.bound("applyExternalTorque")

    def strike(t: float) -> None:
        for body, linear, angular in impulses_within(scene, t, dt):
            motion, apply = known[body]
            apply(along(ORIGIN, linear, 1 / dt), motion()[0])
            twist(*world.handles[body], along(ORIGIN, angular, 1 / dt), frame)

    return strike


class Charges:
    """Charges, pushed by Boris' method (Buneman 1967; Boris 1970).

    The engine adds force times step over mass to the velocity, so the force mass (Boris' new velocity - velocity) / step
    gives Boris' new velocity. The engine's velocity belongs to a time half a step before the position. Order 2.
    """

    def __init__(self, world: Any, scene: Scene) -> None:
        self.world, self.masses = world, {body.name: body.mass for body in scene.bodies}
        self.fields = {force.body: force.fields for force in scene.forces if force.fields and world.configured}
        if self.fields:
            world.record({"charges": "pushed by Boris' method, velocities half a step before positions"})

    def push(self, body: str) -> Chore:
        world, number, frame = self.world, self.world.bodies[body], self.world.api.WORLD_FRAME
        apply, per_step = world.bound("applyExternalForce"), self.masses[body] / world.dt

        def push_charge(t: float) -> None:
            position, velocity = world.pose(number)[0], world.twist(number)[0]
            impulse = along(self.pushed(body, t, position, velocity, 1.0), velocity, -1.0)
            apply(number, -1, along(ORIGIN, impulse, per_step), position, frame)

        return push_charge

    def pushed(self, name: str, t: float, position: Vector, velocity: Vector, steps: float) -> Vector:
        """The velocity of a charge after `steps` steps in the fields at this time and position.

        The velocities of other bodies are returned unchanged.
        """
        fields = self.fields.get(name)
        if fields is None:
            return velocity
        electric, magnetic = fields(t, position)
        half = steps * self.world.dt / 2
        turn = along(ORIGIN, magnetic, half)
        v = along(velocity, electric, half)
        twice = along(ORIGIN, turn, 2 / (1 + dot(turn, turn)))
        v = along(v, cross(along(v, cross(v, turn), 1.0), twice), 1.0)
        return along(v, electric, half)
