"""PyBullet: `changeDynamics` with mass, inertia and damping in one call sets the inertia of a link to 0."""

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


alone, damped = inertia(), inertia(linearDamping=0)
print(f"inertia set to (1, 2, 3) kg m^2: {alone} with the mass alone, {damped} with linearDamping=0 in the same call")
assert alone == (1, 2, 3) and damped == (0, 0, 0), "the inertia is no longer lost"
