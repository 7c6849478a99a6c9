"""Accelerations of the joints of a scene from PyBullet's mass matrix and inverse dynamics, without a step.

The engine knows gravity and the terms of the rates; forces and torques of the scene enter by their power. What acts in the
step alone is missing: gears, drives, friction of joints, contacts.
"""

from itertools import groupby

import numpy as np
from gnomon.cases.core.scene import Scene, SceneForm, Vector
from gnomon.harness.adapters.engines.bullet.pybullet_world import World
from gnomon.harness.adapters.engines.scene_run import forces_at, torques_at
from gnomon.harness.contract.integrator import Floats

MODELLED = frozenset(
    {
        "hinge",
        "slider",
        "linked_joint",
        "chained_hinges",
        "position_force",
        "velocity_force",
        "time_force",
        "torque",
        "drag_torque",
    }
)


def joint_accelerations(form: SceneForm, scene: Scene) -> dict[str, float]:
    """The acceleration of each joint at t = 0, by name: m/s^2 or rad/s^2.

    Parameters
    ----------
    form : SceneForm
        With no needs beyond `MODELLED`.
    scene : Scene
        A scene of this form, in any state.

    Returns
    -------
    dict
        Name of the joint -> second derivative of its coordinate.

    Raises
    ------
    ValueError
        If the form needs more than joints, forces and torques.
    """
    import pybullet  # without the library the caller is told by ImportError

    if beyond := form.needs - MODELLED:
        raise ValueError(f"{', '.join(sorted(beyond))}: only in steps; accelerations are those of joints under forces")
    world = World(pybullet, form, 1.0, configured=True, maximal=False)
    try:
        world.build(scene)
        world.place(scene)
        return _solve(world, scene)
    finally:
        world.close()


def _solve(world: World, scene: Scene) -> dict[str, float]:
    motions = {body: motion() for body, motion in world.carriers.items()}
    pushes = [(body, force) for body, force, _ in forces_at(scene, 0.0, lambda body: motions[body][::2])]  # type: ignore[arg-type,return-value]
    turns = list(torques_at(scene, 0.0, lambda body: motions[body][1::2]))  # type: ignore[arg-type,return-value]
    accelerations: dict[str, float] = {}
    for number, group in groupby(world.jointed.items(), key=lambda entry: entry[1][0]):
        names = [name for name, _ in group]
        states = [world.joint_state(number, index)[:2] for index in range(len(names))]
        places, rates = [list(values) for values in zip(*states, strict=True)]
        load = np.zeros(len(names))
        for index in range(len(names)):
            load[index] = _power(world, number, places, index, pushes, turns)
        for index, (place, rate) in enumerate(zip(places, rates, strict=True)):
            world.call("resetJointState", number, index, place, rate)
        load -= world.call("calculateInverseDynamics", number, places, rates, [0.0] * len(names))
        matrix: Floats = np.array(world.call("calculateMassMatrix", number, places))
        accelerations |= dict(zip(names, np.linalg.solve(matrix, load).tolist(), strict=True))
    return accelerations


def _power(
    world: World,
    number: int,
    places: list[float],
    joint: int,
    pushes: list[tuple[str, Vector]],
    turns: list[tuple[str, Vector]],
) -> float:
    """The power of forces and torques on a multibody when one joint has rate 1 and the others rest."""
    for index, place in enumerate(places):
        world.call("resetJointState", number, index, place, float(index == joint))
    moved = {body: motion() for body, motion in world.carriers.items() if world.handles[body][0] == number}
    power = sum(np.dot(moved[body][2], force) for body, force in pushes if body in moved)
    return float(power + sum(np.dot(moved[body][3], torque) for body, torque in turns if body in moved))
