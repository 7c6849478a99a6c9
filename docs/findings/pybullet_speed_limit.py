"""PyBullet: a free body in default (reduced) coordinates never moves faster than 100 m/s.

The limit is `maxJointVelocity`, whose default is 100. It acts on the base of a multibody too, which has no joint.
"""

import pybullet as p

p.connect(p.DIRECT)
p.setPhysicsEngineParameter(fixedTimeStep=1e-3, numSubSteps=0)
body = p.createMultiBody(1)
p.changeDynamics(body, -1, localInertiaDiagonal=[1, 1, 1], linearDamping=0, angularDamping=0)
p.resetBaseVelocity(body, [250, 0, 0])
p.stepSimulation()
limited = p.getBaseVelocity(body)[0][0]
p.changeDynamics(body, -1, maxJointVelocity=1e9)
p.resetBaseVelocity(body, [250, 0, 0])
p.stepSimulation()
free = p.getBaseVelocity(body)[0][0]
print(f"set 250 m/s without forces; after one step: {limited:g} m/s; with maxJointVelocity=1e9: {free:g} m/s")
assert limited < free == 250, "the speed is no longer limited"
