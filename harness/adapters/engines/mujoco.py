"""MuJoCo: generalized coordinates and soft constraints, built from scenes as MJCF.

Forces come from the callback `mjcb_passive`, which every stage of RK4 calls with its time and state: forces that are set once a
step (`qfrc_applied`) drop RK4 to order 1. The callback is a C function (`mujoco_forces`), as the manual advises, and the engine
takes all steps between two samples in one call, unless a blow falls into them or a joint is prescribed. Blows are forces over
a step. Ropes between two bodies, impacts, contacts and dry friction
are constraints, which the engine makes soft; configured, they harden as the step decreases, so RK4 has order 2 with ropes and
dry friction, and all have an irregular order 1 with contacts. A body that slides with friction hops: see `SLIDING`.

A callback is global to the process: a world sets it while it steps. Large accelerations reset the state by default.
"""

from collections.abc import Mapping
from typing import ClassVar

from gnomon.cases.core.forms import Form
from gnomon.cases.core.scene import SceneForm
from gnomon.harness.adapters.engines.mujoco_world import World
from gnomon.harness.adapters.engines.scene_run import COARSE, TIGHTER, SceneIntegrator, idle
from gnomon.harness.contract.integrator import Steps

# "The solver can actually work with non-holonomic constraints as well, but we do not yet have such constraint types defined."
# (Computation: Equality.)
# Of a tendon's friction: "Such friction will be load-independent though." (Friction loss.) Of its way: "a minimal-length string
# wrapping around spatial obstacles". (Equality.)
NO_RATES = "constraints act on positions: it has no type of non-holonomic constraint"
WELDS = "a weld is switched on by a program, not by a touch"
LACKS: Mapping[str, str] = {
    "driven_frame": "gravity and forces are in one inertial frame",
    "unwinding_string": "a tendon takes the shortest way around a body: it is not wound on it",
    "belt": "the friction of a tendon on the bodies that it wraps does not depend on the load",
    "adhesion": WELDS,
    "adhesive_contact": WELDS,
    "static_friction": "a contact has one coefficient for sticking and sliding",
    "drill_friction": "force and drilling torque share an elliptic cone, which is not the law of a patch of contact",
    "disc_contact": "geoms are solids: a disc has a thickness and two edges",
    "rolling_without_slip": NO_RATES,
    "curved_guide": "joints turn or slide; a curve is a polynomial of at most degree 4 between two joints",
    "curved_surface": "no joint moves on a curved surface",
    "loss_of_contact": "limits stop joints and tendons; no curve holds on one side",
    "knife_edge": NO_RATES,
}


SOFT = "by default it yields by a tenth of the force"
LINES: Mapping[str, str] = {
    "integrator": "model.opt.integrator = mujoco.mjtIntegrator.mjINT_{upper}",
    "autoreset": "model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_AUTORESET  # by default large accelerations reset",
    "cone": "model.opt.cone = mujoco.mjtCone.mjCONE_{upper}  # by default a pyramid: friction depends on direction",
    "impratio": "model.opt.impratio = {}  # default 1: a body at rest slips",
    "iterations": "model.opt.iterations = {}  # default 100",
    "tolerance": "model.opt.tolerance = {}  # default 1e-8",
    "impact.solref": "model.pair_solref[pair, :] = {}  # -stiffness, -damping",
    "contact.solref": "model.pair_solref[pair, :] = {}  # the default time constant is 0.02 s at every step",
    "sliding.solref": "model.pair_solref[pair, :] = {}  # with friction; a shorter one lifts a body that slides",
    "contact.solimp": "model.pair_solimp[pair, :3] = {}  # " + SOFT,
    "equality.solref": "model.eq_solref[equality, :] = {}  # the default time constant is 0.02 s at every step",
    "equality.solimp": "model.eq_solimp[equality, :3] = {}  # " + SOFT,
    "friction.solref": "model.dof_solref[dof, :] = {}  # dry friction of a joint",
    "friction.solimp": "model.dof_solimp[dof, :3] = {}  # dry friction of a joint: " + SOFT,
    "armature": "model.dof_armature[dof] = {}  # a joint whose motion is prescribed, so that no force changes it",
}
ITERATES = frozenset({"rigid_impact", "coulomb_isotropic", "thin_rod_contact", "rope", "linkage", "joint_friction"})
"""Scenes with one of these tokens have constraints here; joints are in reduced coordinates."""


class Euler(SceneIntegrator):
    """Semi-implicit Euler, the engine's default integrator. Order 1.

    Todorov, Erez and Tassa, IROS 2012; mujoco.readthedocs.io, Computation.
    """

    name, library = "mj_step Euler", "mujoco"
    primary = False  # RK4 and implicitfast are those that the manual recommends; the suite `engines` compares them all
    order: ClassVar[int | None] = 1
    integrator: ClassVar[str] = "Euler"
    configured: ClassVar[bool] = True
    lacks, lines = LACKS, LINES

    def unsupported(self, form: Form | SceneForm) -> str | None:
        return super().unsupported(form) or (idle(form, ITERATES) if self.tight else None)

    def world(self, form: SceneForm, dt: float) -> World:
        import mujoco  # without the library the status is `not_installed`

        return World(mujoco, form, dt, self.integrator, self.configured, self.tight)


class ImplicitFast(Euler):
    """Implicit in the velocities for damping and for the gyroscopic torque of free bodies, which the manual recommends. Order 1.

    Forces of a callback are explicit, so on most scenes it moves as Euler does.
    """

    name, integrator, primary = "mj_step implicitfast", "implicitfast", True


class RungeKutta(Euler):
    """The classical method of Runge and Kutta. Order 4; with ropes between two bodies, linkages and dry friction of hinges 2."""

    name, integrator, order, primary = "mj_step RK4", "RK4", 4, True
    sweep = Steps(coarsest=0.5, halvings=4)  # finer steps show round-off


class EulerAsShipped(Euler):
    """Euler with the engine's defaults: contacts have a time constant of 0.02 s and a pyramid of friction. Order 1.

    On scenes without contacts, ropes and dry friction it moves as configured, unless an acceleration above 1e10 resets it.
    """

    policy, configured = "as shipped", False


class EulerTight(Euler):
    """Euler as configured, with ten times the iterations of its solver and a hundredth of its tolerance."""

    policy, tight, primary = TIGHTER, True, False
    sweep = COARSE


class ImplicitFastTight(ImplicitFast):
    """implicitfast as configured, with the solver of `EulerTight`."""

    policy, tight, primary = TIGHTER, True, False
    sweep = COARSE


class RungeKuttaTight(RungeKutta):
    """RK4 as configured, with the solver of `EulerTight`."""

    policy, tight, primary = TIGHTER, True, False
    sweep = COARSE


INTEGRATORS = (Euler, ImplicitFast, RungeKutta, EulerAsShipped, EulerTight, ImplicitFastTight, RungeKuttaTight)
