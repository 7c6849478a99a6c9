"""The joints of a scene as trees: each joint after the joint that carries it, from the world outwards."""

from collections.abc import Iterator
from dataclasses import dataclass

from gnomon.cases.core.scene import Hinge, Scene, Slider, Vector
from gnomon.harness.adapters.engines.vectors import ORIGIN, along


@dataclass(frozen=True)
class Branch:
    """A joint, the name of the joint that carries it ("": the world), and where it is.

    `place`: its anchor relative to the anchor of the joint that carries it. `arm`: from its anchor to the centre of mass of
    its body. Both at coordinate zero of all joints, when the axes of all bodies are those of space.
    """

    joint: Hinge | Slider
    before: str
    place: Vector
    arm: Vector


def branches(scene: Scene) -> Iterator[Branch]:
    """The joints of a scene in the order of its trees. Raises ValueError if joints carry one another in a circle."""
    carrier = {joint.body: joint for joint in scene.joints}
    arms = {joint.name: joint.arm if isinstance(joint, Hinge) else ORIGIN for joint in scene.joints}
    waiting, joined = list(scene.joints), set[str]()
    while waiting:
        joint = next((each for each in waiting if not each.parent or carrier[each.parent].name in joined), None)
        if joint is None:
            raise ValueError(f"the joints {', '.join(each.name for each in waiting)} carry one another in a circle")
        waiting.remove(joint)
        joined.add(joint.name)
        before = carrier[joint.parent].name if joint.parent else ""
        place = along(arms[before], joint.anchor, 1.0) if before else joint.anchor
        yield Branch(joint, before, place, arms[joint.name])
