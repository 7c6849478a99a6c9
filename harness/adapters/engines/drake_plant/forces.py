"""The forces of a scene as symbolic expressions, which Drake evaluates without Python.

A `LeafSystem` of Python is called at each stage of an integrator. The laws of most scenes are expressions of the state of
the plant, and `SymbolicVectorSystem` is a system of C++ that evaluates such expressions.
"""

from collections.abc import Callable, Mapping
from types import FunctionType
from typing import Any

import numpy as np
from gnomon.cases.core.arithmetic import FUNCTIONS, rebind
from gnomon.cases.core.scene import Hinge, Scene
from gnomon.harness.adapters.engines.scene_run import LOAD, MOTION, loads_of
from gnomon.harness.adapters.engines.vectors import along, cross, dot
from gnomon.harness.kernels.straight_line import compute
from gnomon.harness.kernels.traced import Trace


def symbolic_loads(world: Any) -> Any:
    """The system of the generalised forces of a world's scene; None for scenes whose forces only Python computes.

    These are laws that branch, and forces on a body that hangs on a ball joint or on a body that moves.
    """
    try:
        t, state, loads = _expressions(world)
    except Exception:  # code of a law may raise anything at a symbol; Python calls the law itself, and shows its errors
        return None
    # Drake takes no system of expressions without a state into a continuous diagram: this state rests.
    rest = {"state": [world.api.Variable("rest")], "dynamics": [world.api.Expression(0.0)]} if world.continuous else {}
    return world.api.SymbolicVectorSystem(time=t, input=state, output=loads, **rest)


def _expressions(world: Any) -> tuple[Any, Any, Any]:
    api, plant, scene = world.api, world.plant, world.scene
    t, size = api.Variable("t"), plant.num_multibody_states()
    state = np.array([api.Variable(f"x{i}") for i in range(size)])
    names = [name for force in scene.forces for name in (force.body, force.partner) if name]
    bodies = tuple(dict.fromkeys([*names, *(torque.body for torque in scene.torques)]))
    trace = Trace(MOTION * len(bodies), 0)

    def in_trace(law: Callable[..., Any]) -> Callable[..., Any]:
        return rebind(law, trace.functions) if isinstance(law, FunctionType) else law

    values = loads_of(scene, bodies, trace.t, trace.state, in_trace)
    parts = [_part(world, scene, name, state) for name in bodies]
    functions = {name: getattr(api, name) for name in FUNCTIONS if hasattr(api, name)}
    functions["hypot"] = lambda x, y: api.sqrt(x * x + y * y)
    loads = compute(values, trace, t, [number for motion, _ in parts for number in motion], (), functions)
    total = [api.Expression(0.0)] * plant.num_velocities()
    for k, (_, rows) in enumerate(parts):
        for row, push in rows.items():
            # Not +=, which would change the expression that all rows begin with.
            total[row] = total[row] + push(loads[LOAD * k : LOAD * (k + 1)])
    return t, state, np.array(total)


def _part(world: Any, scene: Scene, name: str, state: Any) -> tuple[list[Any], Mapping[int, Callable[[Any], Any]]]:
    """The motion of a body by the plant's state, and the generalised forces of a load, by their rows."""
    velocities = world.plant.num_positions()
    if name in world.free:
        q, v = world.free[name][0], world.free[name][1]
        spin, velocity = (state[velocities + v + i : velocities + v + i + 3] for i in (0, 3))
        forces = {v + i: lambda load, i=i: load[(i + 3) % 6] for i in range(6)}
        return [*spin, *velocity, *state[q + 4 : q + 7], *state[q : q + 4]], forces
    joint = next(each for each in scene.joints if each.body == name)
    if joint.parent:
        raise ValueError(f"{joint.parent} moves and carries {name}")
    hinge, axis = world.joints[joint.name], joint.axis
    q, rate = state[hinge.position_start()], state[velocities + hinge.velocity_start()]
    if not isinstance(joint, Hinge):
        place, velocity = along(joint.anchor, axis, q), [rate * x for x in axis]
        return [0.0] * 3 + [*velocity, *place, 1.0, 0.0, 0.0, 0.0], {
            hinge.velocity_start(): lambda load: dot(axis, load[:3])
        }
    cos, sin = world.api.cos, world.api.sin
    rest = along((0.0, 0.0, 0.0), axis, dot(axis, joint.arm))
    level, side = along(joint.arm, rest, -1.0), cross(axis, joint.arm)
    arm: Any = tuple(rest[i] + level[i] * cos(q) + side[i] * sin(q) for i in range(3))
    turn: Any = tuple(rate * x for x in axis)
    attitude = [cos(q / 2), *(x * sin(q / 2) for x in axis)]
    place = along(joint.anchor, arm, 1.0)
    return [*turn, *cross(turn, arm), *place, *attitude], {
        hinge.velocity_start(): lambda load: dot(axis, cross(arm, load[:3])) + dot(axis, load[3:])
    }
