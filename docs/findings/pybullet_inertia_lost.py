"""PyBullet: `changeDynamics` with mass, inertia and a damping in one call sets the inertia of a link to 0.

Of the other arguments tried, `maxJointVelocity` does so too; `jointDamping`, `lateralFriction` and `restitution` do not.
"""

import pybullet as p


def inertia(**more):
    """The inertia (kg m^2) of a link after it was set to (1, 2, 3) in a call together with `more`."""
    world = p.connect(p.DIRECT)
    body = p.createMultiBody(
        baseMass=0,
        linkMasses=[1],
        linkCollisionShapeIndices=[-1],
        linkVisualShapeIndices=[-1],
        linkPositions=[[0, 0, 0]],
        linkOrientations=[[0, 0, 0, 1]],
        linkInertialFramePositions=[[0, 0, 0]],
        linkInertialFrameOrientations=[[0, 0, 0, 1]],
        linkParentIndices=[0],
        linkJointTypes=[p.JOINT_REVOLUTE],
        linkJointAxis=[[0, 1, 0]],
    )
    p.changeDynamics(body, 0, mass=1, localInertiaDiagonal=[1, 2, 3], **more)
    found = p.getDynamicsInfo(body, 0)[2]
    p.disconnect(world)
    return found


alone = inertia()
print(f"set to (1, 2, 3) kg m^2 with the mass alone: {alone}")
assert alone == (1, 2, 3)
for name in ("linearDamping", "angularDamping", "maxJointVelocity"):
    found = inertia(**{name: 1})
    print(f"with {name}=1 in the same call: {found}")
    assert found == (0, 0, 0), "the inertia is no longer lost"
for name in ("jointDamping", "lateralFriction", "restitution"):
    assert inertia(**{name: 1}) == alone
