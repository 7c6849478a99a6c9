"""Drake: a diagram with a system written in Python is never freed, nor is the system.

The garbage collector frees the same diagram without it.
"""

import gc
import weakref

import pydrake.systems.framework as framework
from pydrake.systems.primitives import ConstantVectorSource


class Still(framework.LeafSystem):
    """A system written in Python that does nothing."""


def alive(make):
    """How many of ten diagrams and of their systems are left once they are dropped and collected."""
    systems, diagrams = [], []
    for _ in range(10):
        builder = framework.DiagramBuilder()
        system = builder.AddSystem(make())
        diagram = builder.Build()
        systems.append(weakref.ref(system))
        diagrams.append(weakref.ref(diagram))
        del builder, system, diagram
    for _ in range(3):
        gc.collect()
    return [sum(one() is not None for one in each) for each in (systems, diagrams)]


python, engine = alive(Still), alive(lambda: ConstantVectorSource([0.0]))
print(f"of 10 systems and diagrams are left: {python} with a system in Python, {engine} with one of the engine")
assert engine == [0, 0]
assert python == [10, 10], "they are freed now"
