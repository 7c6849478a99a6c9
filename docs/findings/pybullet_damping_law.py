"""PyBullet: the damping of a body in default (reduced) coordinates is k (1 + |v|) v, and not proportional to the velocity.

`linearDamping`, 0.04 by default, brakes a body at 10 m/s eleven times as strongly per m/s as a slow one.
"""

import pybullet as p

DT = 1e-3


def rate(speed, **settings):
    """The deceleration over the speed (1/s) of a free body without gravity."""
    world = p.connect(p.DIRECT)
    p.setPhysicsEngineParameter(fixedTimeStep=DT, numSubSteps=0)
    body = p.createMultiBody(1)
    p.changeDynamics(body, -1, localInertiaDiagonal=[1, 1, 1])
    if settings:
        p.changeDynamics(body, -1, **settings)
    p.resetBaseVelocity(body, [speed, 0, 0])
    p.stepSimulation()
    after = p.getBaseVelocity(body)[0][0]
    p.disconnect(world)
    return (speed - after) / (speed * DT)


for speed in (0.01, 1.0, 10.0, 50.0):
    default, off = rate(speed), rate(speed, linearDamping=0)
    print(f"at {speed:g} m/s: decelerates by {default:.4f} of its speed per s by default; {off:g} with linearDamping=0")
    assert abs(default / (0.04 * (1 + speed)) - 1) < 1e-3, "the law has changed"
    assert off == 0
