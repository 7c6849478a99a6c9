"""The laws of a scene as one compiled function of the time and of the motions of bodies.

Engines that call Python for forces spend most of a step in it, and a user's own law could be compiled. A law that can be
neither traced nor emitted from its source stays a function of Python, which the adapter calls itself.
"""

import itertools
from collections.abc import Callable, Sequence
from math import isfinite
from types import FunctionType
from typing import Any, NamedTuple

import numpy as np
from gnomon.cases.core.arithmetic import rebind
from gnomon.cases.core.scene import Scene
from gnomon.harness.adapters.engines.scene_run import LOAD, MOTION, loads_of
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.kernels import emission, ir
from gnomon.harness.kernels.equations import Kernel, content, write
from gnomon.harness.kernels.straight_line import compute
from gnomon.harness.kernels.traced import RUN, Node, Trace, Value, sequence

Law = Callable[[Any], Any]
"""A function of time."""


class Laws(NamedTuple):
    """Compiled laws, the numbers in them, and the names of the bodies on which they act."""

    kernel: Kernel
    numbers: Floats
    bodies: tuple[str, ...]


class Numbers(Trace):
    """A trace in which the floats of laws are parameters: scenes that differ in numbers share the code.

    Exponents stay numbers: a power of a known exponent takes less time.
    """

    def __init__(self, dimension: int) -> None:
        super().__init__(dimension, 0)
        self.numbers: dict[str, Node] = {}

    def held(self, value: Value) -> Value:
        if not isinstance(value, float):
            return value
        if value.hex() not in self.numbers:
            self.numbers[value.hex()] = self._variable(f"p[{len(self.numbers)}]", RUN)
            self.parameters = tuple(self.numbers.values())
        return self.numbers[value.hex()]

    def node(self, operation: str, *arguments: Value) -> Node:
        first, *others = arguments
        others = others if operation == "**" else [self.held(x) for x in others]
        return super().node(operation, self.held(first), *others)


def compile_laws(scene: Scene, drives: Sequence[Law], driven: Callable[[Law, Any], Sequence[Any]]) -> Laws | None:
    """The laws of a scene as a kernel of the motions of its bodies; None for laws that only Python computes.

    After the loads on the bodies it computes the numbers `driven(law, t)` of each law of `drives`, a function of time. Laws
    that branch cannot be traced: they are compiled from their source, with the numbers in it.
    """
    names = [name for force in scene.forces for name in (force.body, force.partner) if name]
    bodies = tuple(dict.fromkeys([*names, *(torque.body for torque in scene.torques)]))
    try:
        return trace_laws(scene, bodies, drives, driven)
    except Exception:  # code of a law may raise anything at a symbol
        pass
    try:
        return None if drives else emit_laws(scene, bodies)
    except Exception:  # the engine calls the law itself, which shows its own errors
        return None


def trace_laws(
    scene: Scene, bodies: tuple[str, ...], drives: Sequence[Law], driven: Callable[[Law, Any], Sequence[Any]]
) -> Laws:
    trace = Numbers(MOTION * len(bodies))

    def in_trace(law: Callable[..., Any]) -> Callable[..., Any]:
        return rebind(law, trace.functions) if isinstance(law, FunctionType) else law

    loads = loads_of(scene, bodies, trace.t, trace.state, in_trace)
    found = itertools.chain(loads, *(driven(in_trace(law), trace.t) for law in drives))
    values = [trace.held(value) for value in found]

    def body(t: ir.Value, y: ir.Array, p: ir.Array, out: ir.Array) -> None:
        write(out, compute(values, trace, t, content(y), content(p), emission.MATH))

    def named(value: Value) -> str:
        return f"#{value.index}" if isinstance(value, Node) else repr(value)

    lines = [f"{named(node)} {node.operation} {[named(x) for x in node.arguments]}" for node in sequence(values)]
    key = "\n".join(["traced laws", *lines, *(named(value) for value in values)])
    numbers = np.array([*map(float.fromhex, trace.numbers), 0.0])
    return Laws(Kernel(key, body, (len(trace.state), len(trace.numbers), len(values))), numbers, bodies)


def emit_laws(scene: Scene, bodies: tuple[str, ...]) -> Laws:
    def body(t: ir.Value, y: ir.Array, p: ir.Array, out: ir.Array) -> None:
        write(out, loads_of(scene, bodies, t, content(y), emission.Translation().inline))

    pushes = [f"{x.body} {x.partner} {emission.fingerprint(x.law)}" for x in scene.forces]
    turns = [f"{x.body} {emission.fingerprint(x.law)}" for x in scene.torques]
    kernel = Kernel("\n".join(["emitted laws", *pushes, *turns]), body, (MOTION * len(bodies), 0, LOAD * len(bodies)))
    _ = kernel.address  # raises an error for a law that cannot be emitted
    return Laws(kernel, np.zeros(1), bodies)


class Loads:
    """The loads on the bodies of a scene, computed from their motions: the adapter fills `parts`, calls `update` and reads them.

    Attributes
    ----------
    parts : dict of str to tuple of memoryview
        For each body that is pushed its spin, velocity, place and attitude (scalar first), and the force and the torque on it.
        Python sets the numbers of a memoryview in a third of the time that it needs for an array.
    """

    def __init__(self, laws: Laws) -> None:
        count, (pointer, numbers) = len(laws.bodies), (laws.kernel.pointer, laws.numbers)
        motions, loads = np.zeros((count, MOTION)), np.zeros((count, LOAD))
        self.parts: dict[str, tuple[Any, ...]] = {}
        for name, motion, load in zip(laws.bodies, motions, loads, strict=True):
            y, out = motion.data, load.data
            self.parts[name] = y[:3], y[3:6], y[6:9], y[9:], out[:3], out[3:]
        inputs, outputs = motions.ravel(), loads.ravel()
        self._values = outputs.data
        self._compute: Callable[[float], None] = lambda t: pointer(t, inputs, numbers, outputs)

    def update(self, t: float) -> None:
        """Compute the loads at time t. Raises FloatingPointError at a singularity: an engine may ignore such a force."""
        self._compute(t)
        if not isfinite(sum(self._values)):
            raise FloatingPointError(f"the forces at t = {t:g} are not finite")


def loads_if_compiled(scene: Scene) -> Loads | None:
    """The loads of a scene with forces or torques; None without them, and for laws that only Python computes."""
    laws = compile_laws(scene, (), lambda law, t: ()) if scene.forces or scene.torques else None
    return None if laws is None else Loads(laws)
