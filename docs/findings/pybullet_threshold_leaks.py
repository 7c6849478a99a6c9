"""PyBullet: `contactBreakingThreshold` of one world holds in the worlds that the process opens later.

A ball of radius 0.1 m rests 1.5 mm above a plane without gravity. A new world with default settings finds a contact, or none, according to
what a world that was closed before it had set.
"""

import pybullet as p


def contacts():
    """The number of contacts that a new world with default settings finds."""
    world = p.connect(p.DIRECT)
    p.createMultiBody(0, p.createCollisionShape(p.GEOM_PLANE))
    p.createMultiBody(1, p.createCollisionShape(p.GEOM_SPHERE, radius=0.1), basePosition=[0, 0, 0.1015])
    p.stepSimulation()
    found = len(p.getContactPoints())
    p.disconnect(world)
    return found


first = contacts()
world = p.connect(p.DIRECT)
p.setPhysicsEngineParameter(contactBreakingThreshold=0.001)
p.disconnect(world)
later = contacts()
print(
    f"contacts at a distance of 1.5 mm: {first} in a first world, {later} after another world set the threshold to 1 mm"
)
assert (first, later) == (1, 0), "the threshold no longer leaks"
