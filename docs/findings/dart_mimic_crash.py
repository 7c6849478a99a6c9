"""DART: a coupled joint whose leader is set for its only degree of freedom crashes the process in the first step.

The properties of a joint, through which Python sets a leader, have entries for six degrees of freedom, and all of them need
one. Each try is a process.
"""

import subprocess
import sys

import dartpy

ENTRIES = 6


def step(entries):
    """One step of two sliders, of which one follows the other; this many of the entries get a leader."""
    world = dartpy.simulation.World()
    pair = dartpy.dynamics.Skeleton("pair")
    leader, _ = pair.createPrismaticJointAndBodyNodePair()
    follower, _ = pair.createPrismaticJointAndBodyNodePair()
    world.addSkeleton(pair)
    properties = dartpy.dynamics.PrismaticJointProperties()
    listed = properties.mMimicDofProps
    assert (len(listed), follower.getNumDofs()) == (ENTRIES, 1)
    for entry in listed[:entries]:
        entry.mReferenceJoint, entry.mMultiplier, entry.mOffset = leader, -1.0, 0.0
        entry.mConstraintType = dartpy.dynamics.MimicConstraintType.Coupler
    properties.mMimicDofProps = listed
    follower.setProperties(properties)
    follower.setActuatorType(dartpy.dynamics.MIMIC)
    follower.setUseCouplerConstraint(True)
    world.step()


if len(sys.argv) > 1:
    step(int(sys.argv[1]))
else:
    codes = {entries: subprocess.run([sys.executable, __file__, str(entries)]).returncode for entries in (1, ENTRIES)}
    for entries, code in codes.items():
        print(f"leader in {entries} of {ENTRIES} entries of a joint with 1 degree of freedom: exit status {code}")
    assert codes[ENTRIES] == 0
    assert codes[1] != 0, "it no longer crashes"
