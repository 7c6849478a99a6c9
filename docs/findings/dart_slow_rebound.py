"""DART: a ball of restitution 1 does not rebound when it arrives with 0.1 m/s or less.

There is no gravity, so the speed after the impact is that before it. Python has no setting for this threshold.
"""

import dartpy

DT = 1e-3


def rebound(speed):
    """The speed (m/s) after an impact with a plane."""
    world = dartpy.simulation.World()
    world.setTimeStep(DT)
    world.setGravity([0, 0, 0])
    ground, ball = dartpy.dynamics.Skeleton("ground"), dartpy.dynamics.Skeleton("ball")
    plane = ground.createWeldJointAndBodyNodePair()[1].createShapeNode(dartpy.dynamics.PlaneShape([0, 0, 1], 0.0))
    joint, body = ball.createFreeJointAndBodyNodePair()
    for node in (plane, body.createShapeNode(dartpy.dynamics.SphereShape(0.1))):
        node.createCollisionAspect()
        node.createDynamicsAspect()
        node.getDynamicsAspect().setRestitutionCoeff(1.0)
    world.addSkeleton(ground)
    world.addSkeleton(ball)
    joint.setPositions([0, 0, 0, 0, 0, 0.1 + 5.5 * speed * DT])
    joint.setVelocities([0, 0, 0, 0, 0, -speed])
    for _ in range(20):
        world.step()
    return body.getLinearVelocity()[2]


for speed in (1.0, 0.11, 0.09, 0.01):
    after = rebound(speed)
    print(f"arrives with {speed:g} m/s, leaves with {after:.4g} m/s")
    assert (after > 0.99 * speed) == (speed > 0.1), "the threshold has changed"
