"""PyBullet: a ball in default (reduced) coordinates gains energy at elastic impacts, in proportion to the step.

In maximal coordinates it does not. The restitution is 1 on both surfaces, damping is off, contacts act only once they are closed.
"""

import pybullet as p

RADIUS, HEIGHT, GRAVITY = 0.1, 1.0, 9.81


def highest(maximal, dt):
    """The height over the plane that the ball reaches in 10 s, after a fall from HEIGHT."""
    world = p.connect(p.DIRECT)
    p.setGravity(0, 0, -GRAVITY)
    p.setPhysicsEngineParameter(
        fixedTimeStep=dt, numSubSteps=0, restitutionVelocityThreshold=0, contactERP=0, contactSlop=0
    )
    plane = p.createMultiBody(0, p.createCollisionShape(p.GEOM_PLANE), useMaximalCoordinates=maximal)
    ball = p.createMultiBody(
        1,
        p.createCollisionShape(p.GEOM_SPHERE, radius=RADIUS),
        basePosition=[0, 0, RADIUS + HEIGHT],
        useMaximalCoordinates=maximal,
    )
    for body in (plane, ball):
        p.changeDynamics(body, -1, restitution=1, linearDamping=0, angularDamping=0, contactProcessingThreshold=0)
    p.changeDynamics(ball, -1, maxJointVelocity=1e9)
    top = 0.0
    for step in range(int(10 / dt)):
        p.stepSimulation()
        if step * dt > 0.5:  # after the first impact
            top = max(top, p.getBasePositionAndOrientation(ball)[0][2] - RADIUS)
    p.disconnect(world)
    return top


found = {dt: (highest(0, dt), highest(1, dt)) for dt in (1e-2, 1e-3, 1e-4)}
for dt, (reduced, maximal) in found.items():
    print(
        f"step {dt:g} s, fall from {HEIGHT:g} m, highest bounce in 10 s: {reduced:.4f} m in reduced, {maximal:.4f} m in maximal coordinates"
    )
assert found[1e-2][0] > 1.2 * HEIGHT > 1.1 * found[1e-2][1], "it no longer gains energy"
