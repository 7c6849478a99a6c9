"""Trees of links in PyBullet: multibodies in joint coordinates, on a base that is fixed in space."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from gnomon.cases.core.scene import IDENTITY, Quaternion, Vector
from gnomon.harness.adapters.engines.vectors import ORIGIN, along, cross, rotate, times, turn_arm

Motion = tuple[Vector, Quaternion, Vector, Vector]
"""Position of the centre of mass, attitude, velocity and angular velocity, as in `Body`."""

FIRM = 1e12
"""The largest force of a motor that prescribes a coordinate, and of a gear (N or N m): the engine needs a number."""


@dataclass(frozen=True)
class Link:
    """A link of a multibody: it slides along `axis`, or rotates about it.

    `before` is the index of the link that carries it, -1 for the base. `place`: the joint from the joint before it; `arm`:
    the centre of mass from the joint; both at coordinate zero. A `mass` of zero is allowed where a later link has mass.
    """

    axis: Vector
    slides: bool = False
    before: int = -1
    place: Vector = ORIGIN
    arm: Vector = ORIGIN
    mass: float = 0.0
    inertia: Vector = ORIGIN


class Multibody:
    """Links on a fixed base, with their numbers in the engine. `world` calls the engine."""

    def __init__(self, world: Any, links: Sequence[Link], base: Vector = ORIGIN) -> None:
        api, call, count = world.api, world.call, len(links)
        self.world, self.links, self.place, self.attitude = world, links, base, IDENTITY
        self.number = int(
            call(
                "createMultiBody",
                basePosition=base,
                linkMasses=[link.mass for link in links],
                linkCollisionShapeIndices=[-1] * count,
                linkVisualShapeIndices=[-1] * count,
                linkPositions=[link.place for link in links],
                linkOrientations=[IDENTITY] * count,
                linkInertialFramePositions=[link.arm for link in links],
                linkInertialFrameOrientations=[IDENTITY] * count,
                linkParentIndices=[link.before + 1 for link in links],
                linkJointTypes=[api.JOINT_PRISMATIC if link.slides else api.JOINT_REVOLUTE for link in links],
                linkJointAxis=[link.axis for link in links],
            )
        )
        for index, link in enumerate(links):
            world.set_inertia(self.number, index, link.mass, link.inertia)
            if world.configured:  # the default motor locks a joint
                call("setJointMotorControl2", self.number, index, api.VELOCITY_CONTROL, force=0.0)
                world.options["velocityMotorForce"] = 0.0

    def turn_base(self, attitude: Quaternion) -> None:
        """Rotate the base, which is fixed during the steps, and with it all axes."""
        self.attitude = attitude
        self.world.call("resetBasePositionAndOrientation", self.number, self.place, attitude)

    def set_state(self, *states: tuple[float, float]) -> None:
        """Coordinate and rate of each link."""
        for index, (coordinate, rate) in enumerate(states):
            self.world.call("resetJointState", self.number, index, coordinate, rate)

    def motion(self, index: int) -> Motion:
        """The motion of a link from the joint coordinates: the engine itself tells velocities of links in single precision."""
        link = self.links[index]
        coordinate, rate, *_ = self.world.joint_state(self.number, index)
        if link.before < 0:
            joint, attitude, velocity, spin = self.place, self.attitude, ORIGIN, ORIGIN
            arm = ORIGIN
        else:
            centre, attitude, velocity, spin = self.motion(link.before)
            arm = rotate(attitude, self.links[link.before].arm)
            joint = along(centre, arm, -1.0)
        axis, step = rotate(attitude, link.axis), rotate(attitude, link.place)
        if link.slides:
            step = along(step, axis, coordinate)
        velocity = along(velocity, cross(spin, along(step, arm, -1.0)), 1.0)
        if link.slides:
            velocity = along(velocity, axis, rate)
        else:
            attitude = times(attitude, turn_arm(link.axis, ORIGIN, coordinate)[0])
            spin = along(spin, axis, rate)
        lever = rotate(attitude, link.arm)
        position = along(along(joint, step, 1.0), lever, 1.0)
        return position, attitude, along(velocity, cross(spin, lever), 1.0), spin

    def gear(self, index: int, other: "Multibody", other_index: int, ratio: float) -> None:
        """A constraint at each step: rate of one link + `ratio` times the rate of another is zero."""
        call = self.world.call
        constraint = call(
            "createConstraint", self.number, index, other.number, other_index, self.world.api.JOINT_GEAR,
            (0, 0, 1), ORIGIN, ORIGIN,
        )  # fmt: skip
        call("changeConstraint", constraint, gearRatio=ratio, maxForce=FIRM)
        self.world.record({"gearForce": FIRM})

    def driven(self, index: int, position: Callable[[float], float] | None = None) -> Callable[[float], None]:
        """A motor that holds a coordinate, and a function that gives it at the end of a step the rate of `position(t)`."""
        world = self.world
        motor = world.bound("setJointMotorControl2", self.number, index, world.api.VELOCITY_CONTROL, force=FIRM)
        world.record({"motorForce": FIRM})
        motor(targetVelocity=0.0)

        def lead(t: float) -> None:
            if position is not None:
                motor(targetVelocity=(position(t + 2 * world.dt) - position(t)) / (2 * world.dt))

        return lead
