"""DART: with the default solver the friction of a sliding block depends on the direction in which it slides.

A block of four points slides on a plane with 3 m/s and a coefficient of 0.3. Along the x axis it stops after v^2 / (2 mu g),
but not at 45 degrees. With `NsgsFrictionSolver` it stops there in both directions.
"""

import math

import dartpy

MU, SPEED, GRAVITY, DT = 0.3, 3.0, 9.81, 1e-3


def shape(node, form):
    made = node.createShapeNode(form)
    made.createCollisionAspect()
    made.createDynamicsAspect()
    made.getDynamicsAspect().setFrictionCoeff(MU)
    return made


def distance(degrees, cone):
    """The way (m) that the block slides."""
    world = dartpy.simulation.World()
    world.setTimeStep(DT)
    world.setGravity([0, 0, -GRAVITY])
    world.getConstraintSolver().setCollisionDetector(dartpy.collision.DARTCollisionDetector())
    if cone:
        world.getConstraintSolver().setBoxedLcpSolver(dartpy.constraint.NsgsFrictionSolver())
    ground, block = dartpy.dynamics.Skeleton("ground"), dartpy.dynamics.Skeleton("block")
    shape(ground.createWeldJointAndBodyNodePair()[1], dartpy.dynamics.PlaneShape([0, 0, 1], 0.0))
    joint, body = block.createFreeJointAndBodyNodePair()
    body.setInertia(dartpy.dynamics.Inertia(1.0, [0, 0, 0], [[0.1, 0, 0], [0, 0.1, 0], [0, 0, 0.1]]))
    for x, y in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
        shape(body, dartpy.dynamics.SphereShape(1e-9)).setRelativeTranslation([0.5 * x, 0.5 * y, -0.05])
    world.addSkeleton(ground)
    world.addSkeleton(block)
    angle = math.radians(degrees)
    joint.setPositions([0, 0, 0, 0, 0, 0.05])
    joint.setVelocities([0, 0, 0, SPEED * math.cos(angle), SPEED * math.sin(angle), 0])
    for _ in range(round(2 / DT)):
        world.step()
    x, y, _ = body.getWorldTransform().translation()
    return math.hypot(x, y)


exact = SPEED**2 / (2 * MU * GRAVITY)
found = {(cone, degrees): distance(degrees, cone) for cone in (False, True) for degrees in (0, 45)}
for (cone, degrees), way in found.items():
    print(f"{'NsgsFrictionSolver' if cone else 'default'}, {degrees} degrees: slides {way:.3f} m; exact {exact:.3f} m")
assert all(abs(found[key] - exact) < 0.01 for key in ((False, 0), (True, 0), (True, 45)))
assert abs(found[False, 45] - exact / math.sqrt(2)) < 0.01, "the direction no longer matters as it did"
