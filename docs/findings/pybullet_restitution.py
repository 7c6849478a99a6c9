"""PyBullet: with default settings a ball bounces the less, the smaller the step is.

The ball has restitution 1, on a plane of restitution 1, and falls from rest with 1 m below it. Newton's law, which the
parameter is named after, gives the same speed after the impact as before it, at every step size.
"""

import pybullet as p

RADIUS, HEIGHT, GRAVITY = 0.1, 1.0, 9.81


def bounce(dt):
    """The height of the first bounce (m)."""
    world = p.connect(p.DIRECT)
    p.setGravity(0, 0, -GRAVITY)
    p.setPhysicsEngineParameter(fixedTimeStep=dt, numSubSteps=0)
    plane = p.createMultiBody(0, p.createCollisionShape(p.GEOM_PLANE))
    ball = p.createMultiBody(
        1,
        p.createCollisionShape(p.GEOM_SPHERE, radius=RADIUS),
        basePosition=[0, 0, RADIUS + HEIGHT],
        useMaximalCoordinates=1,
    )
    p.changeDynamics(plane, -1, restitution=1)
    p.changeDynamics(ball, -1, restitution=1, linearDamping=0, angularDamping=0)
    top = 0.0
    for step in range(int(1.3 / dt)):
        p.stepSimulation()
        if step * dt > 0.5:  # after the first impact, at 0.45 s
            top = max(top, p.getBasePositionAndOrientation(ball)[0][2] - RADIUS)
    p.disconnect(world)
    return top


STEPS = (1e-2, 1e-3, 1e-4)
found = [bounce(dt) for dt in STEPS]
for dt, height in zip(STEPS, found, strict=True):
    print(f"step {dt:g} s: bounces to {height:.3f} m; exact {HEIGHT:g} m")
assert found[-1] < 0.5 * HEIGHT, "the smallest step no longer gives the smallest bounce"
