"""Newton on Warp: four of its solvers of rigid bodies, which step a model in float32, on a processor or a graphics card.

How it is driven: `ModelBuilder` makes a model of links, joints and shapes; `CollisionPipeline` finds contacts at the start of
each step, and `solver.step` moves one `State` into another; both are recorded once and replayed (`ScopedCapture`). The
forces of a scene, compiled as one function, are written to `State.body_f` once a step. Warp compiles each module of
kernels at its first use (minutes in all) and keeps it.

Traps: SolverSemiImplicit damps rotation by default (SolverFeatherstone has the same argument and ignores it); the engine
corrects the inertia of a body unless it is told not to; friction has torsional and rolling parts by default. All results are
float32, so an error stops falling at some 1e-5 to 1e-3 of the motion. XPBD sets speeds below 1e-4 (m/s, rad/s) to zero in
each iteration ("this improves gradient stability", `apply_body_deltas`): `millikan_oil_drop` never leaves rest, nor does
`gyrocompass_damped` at fine steps, because a step adds less than that. On a hinge it brakes fast rotation, w' = -w^3 dt/2:
`flywheel`, at 30 rad/s, still errs by 0.3 at steps of 8e-5 s. VBD brakes all rotation, a free body by w' = -w^3 dt/12.

VBD takes velocities from poses, which are float32: its errors stop falling at longer steps than those of the other solvers.

SolverMuJoCo and SolverKamino were tried and do not take part: docs/libraries.md says what was seen. `newton` installs
without `mujoco` and `mujoco-warp`, and without them SolverMuJoCo raises ImportError. SolverSteel is not driven; the solvers of
cloth and particles hold no rigid bodies.
"""

from collections.abc import Mapping
from typing import Any, ClassVar

from gnomon.cases.core.forms import Form
from gnomon.cases.core.scene import SceneForm
from gnomon.harness.adapters.engines.newton_world import World
from gnomon.harness.adapters.engines.scene_run import COARSE, TIGHTER, SceneIntegrator, idle
from gnomon.harness.contract.integrator import Steps

NO_SOLVER_HAS = {
    "driven_frame": "frames that rotate",
    "joint_friction": "dry friction of joints: `Model.joint_friction` is for other solvers",
    "pulley": "pulleys without a radius, as the scene has: the rollers of its tendons need one",
    "unwinding_string": "tendons that end wound on a body",
    "belt": "belts",
    "linkage": "bodies that stand for the links of a linkage",
    "adhesion": "bodies that stick at an impact",
    "adhesive_contact": "planes that hold a body at no distance",
    "static_friction": "a second coefficient of friction",
    "drill_friction": "contact patches: torsional friction has a length that the scene does not state",
    "disc_contact": "discs without thickness",
    "rolling_without_slip": "constraints on velocities",
    "curved_guide": "guides along curves: meshes have facets",
    "curved_surface": "constraints to smooth surfaces: meshes have facets",
    "loss_of_contact": "guides that hold on one side",
    "knife_edge": "constraints on velocities",
}
"""What neither the joints and shapes of `ModelBuilder` nor the limitations in the docstrings of the solvers offer.

Of joint friction they say: "`Model.joint_armature`, `Model.joint_friction`, `Model.joint_effort_limit`,
`Model.joint_velocity_limit`, and `Model.joint_target_mode` are not supported" (SolverXPBD; the others alike).
"""
PENALTY_HAS_NOT = {
    "rigid_impact": "coefficients of restitution: contacts are springs and dampers",
    "body_contact": "impacts of bodies: contacts are springs and dampers",
    "thin_rod_contact": "impacts without rebound: contacts are springs and dampers",
    "rope": "tendons in this solver",
    "driven_axis": "joints or tendons whose coordinate is prescribed",
}
DESCENT_HAS_NOT = {
    "rope": "ropes: with its tendons a mass on a rope through a hole errs more as the step shortens",
    "moving_surface": "surfaces that move in place: the velocity of a body without mass is the difference of its poses",
}
CONSTRAINED = frozenset({"hinge", "slider", "ball_joint", "rod", "rope", "rigid_impact", "coulomb_isotropic"}) | {
    "thin_rod_contact"
}
"""Scenes with one of these tokens have joints, tendons or contacts, on which XPBD iterates."""
SOLVER = "solver = newton.solvers.{name}(model, {option}={{}})"
LINES = {
    "lock_inertia": "body = builder.add_link(mass=mass, inertia=inertia, lock_inertia={})  # shapes have a mass by default",
    "skip_validation_inertia": "model = builder.finalize(skip_validation_inertia={})  # by default it changes inertia",
    "mu_torsional": "config = newton.ModelBuilder.ShapeConfig(mu_torsional={})",
    "mu_rolling": "config = newton.ModelBuilder.ShapeConfig(mu_rolling={})",
}
PENALTY_LINES = {
    "ke": "config = newton.ModelBuilder.ShapeConfig(ke={})  # stiffness of contacts",
    "kd": "config = newton.ModelBuilder.ShapeConfig(kd={})  # damping of contacts",
    "kf": "config = newton.ModelBuilder.ShapeConfig(kf={})  # damping of slip",
}


def lines(name: str, *options: str, **more: str) -> Mapping[str, str]:
    """The lines of the options of this solver, and those that all solvers have."""
    return LINES | {option: SOLVER.format(name=name, option=option) for option in options} | more


class Newton(SceneIntegrator):
    """What the solvers have in common: order 1, symplectic Euler; forces once a step.

    `reduced`: the solver moves the coordinates of joints; `springs`: the coefficients of contacts that it uses.
    """

    library = "newton"
    order: ClassVar[int | None] = 1
    lacks: ClassVar[Mapping[str, str]] = NO_SOLVER_HAS | PENALTY_HAS_NOT
    configured: ClassVar[bool] = True
    reduced: ClassVar[bool] = False
    springs: ClassVar[tuple[str, ...]] = ("ke", "kd", "kf")
    bits = 24
    sweep = Steps(coarsest=0.5, halvings=3)  # finer steps show the rounding of binary32

    def world(self, form: SceneForm, dt: float) -> World:
        return World(form, dt, self.solver, reduced=self.reduced, springs=self.springs, configured=self.configured)

    def solver(self, world: World) -> Any:
        """The engine's solver for a world with a model."""
        raise NotImplementedError


class Featherstone(Newton):
    """Featherstone's composite rigid bodies in coordinates of joints. Order 1. Springs and dampers at contacts.

    Newton Developers, `newton.solvers.SolverFeatherstone`; Featherstone 2014.
    """

    name, reduced = "SolverFeatherstone", True
    lines = lines(name, "angular_damping", **PENALTY_LINES)

    def solver(self, world: World) -> Any:
        return world.newton.solvers.SolverFeatherstone(world.model, **world.chosen(angular_damping=0.0))


class SemiImplicit(Newton):
    """Symplectic Euler for each body; joints and contacts are springs and dampers. Order 1.

    The springs stiffen as the step shortens: their fastest period stays 2 pi steps, and what they yield vanishes with the
    square of the step.
    """

    name = "SolverSemiImplicit"
    lines = lines(name, "angular_damping", "joint_attach_ke", "joint_attach_kd", **PENALTY_LINES)

    def solver(self, world: World) -> Any:
        settings = world.chosen(angular_damping=0.0)
        held = world.assembly.light
        if held < float("inf"):
            settings |= world.chosen(joint_attach_ke=held / world.dt**2, joint_attach_kd=held / world.dt)
        return world.newton.solvers.SolverSemiImplicit(world.model, **settings)


class XPBD(Newton):
    """Extended position-based dynamics: positions are corrected after a free step. Order 1; restitution at impacts.

    Mueller, Macklin, Chentanez, Jeschke and Kim 2020.
    """

    name, springs = "SolverXPBD", ()
    lacks = NO_SOLVER_HAS
    iterations: ClassVar[Mapping[str, int]] = {"iterations": 10}
    lines = lines(
        name,
        *("iterations", "joint_linear_relaxation", "joint_angular_relaxation", "enable_restitution"),
        "rigid_contact_restitution_iterations",
        compliance="guide = newton.TendonGuide(body=body, guide_type=newton.TendonGuideType.PINHOLE, compliance={})",
    )

    def solver(self, world: World) -> Any:
        settings = world.chosen(joint_linear_relaxation=1.0, joint_angular_relaxation=1.0, **self.iterations)
        if "rigid_impact" in world.needs:
            settings["enable_restitution"] = world.settings["enable_restitution"] = True
        return world.newton.solvers.SolverXPBD(world.model, **settings)


class VBD(Newton):
    """Augmented vertex block descent: implicit Euler, solved body by body. Order 1. Joints and contacts are stiff springs.

    Giles, Diaz and Yuksel 2025. The springs of joints stiffen as the step shortens, as in SolverSemiImplicit.
    """

    name, springs = "SolverVBD", ("ke", "kd")
    lacks = NO_SOLVER_HAS | PENALTY_HAS_NOT | DESCENT_HAS_NOT
    lines = lines(
        name,
        *("friction_epsilon", "rigid_joint_linear_ke", "rigid_joint_angular_ke"),
        ke=PENALTY_LINES["ke"],
        kd=PENALTY_LINES["kd"],
        skip_validation_inertia="builder.color(); model = builder.finalize(skip_validation_inertia={})  # it needs colours",
    )

    def solver(self, world: World) -> Any:
        settings = world.chosen(friction_epsilon=1e-5)
        held = world.assembly.light
        if held < float("inf"):
            stiff = 10 * held / world.dt**2
            settings |= world.chosen(rigid_joint_linear_ke=stiff, rigid_joint_angular_ke=stiff)
        return world.newton.solvers.SolverVBD(world.model, **settings)


class FeatherstoneAsShipped(Featherstone):
    """The same solver with its defaults: contacts of a fixed stiffness, and the engine may correct inertia."""

    policy, configured, order = "as shipped", False, None


class SemiImplicitAsShipped(SemiImplicit):
    """The same solver with its defaults: damping of rotation, and joints and contacts of a fixed stiffness."""

    policy, configured, order = "as shipped", False, None


class XPBDAsShipped(XPBD):
    """The same solver with its defaults: two iterations, and torsional and rolling friction."""

    policy, configured, order = "as shipped", False, None


class VBDAsShipped(VBD):
    """The same solver with its defaults: joints and contacts of a fixed stiffness, and friction that fades below 0.01 m/s."""

    policy, configured, order = "as shipped", False, None


class XPBDTight(XPBD):
    """XPBD as configured, with ten times the iterations, also of restitution."""

    policy, tight, primary = TIGHTER, True, False
    sweep = COARSE
    iterations: ClassVar[Mapping[str, int]] = {"iterations": 100, "rigid_contact_restitution_iterations": 20}

    def unsupported(self, form: Form | SceneForm) -> str | None:
        return super().unsupported(form) or idle(form, CONSTRAINED)


INTEGRATORS = (
    *(Featherstone, SemiImplicit, XPBD, VBD),
    *(FeatherstoneAsShipped, SemiImplicitAsShipped, XPBDAsShipped, VBDAsShipped, XPBDTight),
)
