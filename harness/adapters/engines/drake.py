"""Drake: MultibodyPlant, built from scenes, continuous with fixed-step integrators, or discrete.

How it is driven, and why: a continuous plant is a system of equations that any of Drake's integrators takes; its steps
are fixed, because the target accuracy of error control does not bound the error. Forces are a system of the diagram, so
that each stage evaluates them. A discrete plant is stepped with its contact solver, forces constant over a step. Traps:
the only ball joint is singular at a pitch of 90 degrees; continuous contact is a spring that a fixed step must resolve;
the plant's defaults leave contact as soft as 1 mm.
"""

from collections.abc import Mapping
from logging import ERROR, getLogger
from typing import ClassVar

from gnomon.cases.core.scene import SceneForm
from gnomon.harness.adapters.engines.drake_world import World
from gnomon.harness.adapters.engines.scene_run import SceneIntegrator
from gnomon.harness.contract.integrator import Steps

LACKS = {
    "driven_axis": "no joint whose motion is prescribed; a joint can only be locked",
    "driven_frame": "no frame whose motion is prescribed",
    "joint_friction": "joints have viscous damping, no dry friction",
    "rope": "no ropes; a distance constraint keeps two points apart",
    "pulley": "no ropes, so no pulleys",
    "unwinding_string": "no strings",
    "belt": "no belts",
    "linkage": "a loop of joints closes by a soft constraint, in discrete plants only",
    "adhesion": "contact only pushes; bodies cannot be joined at a touch",
    "adhesive_contact": "contact only pushes",
    "static_friction": "the static coefficient is ignored",
    "drill_friction": "point contact has no torsional friction",
    "moving_surface": "a surface moves with its body only",
    "disc_contact": "a disc is a cylinder, whose length must be positive",
    "rolling_without_slip": "no such constraint: bodies roll by friction",
    "curved_guide": "no joint along a curve",
    "curved_surface": "no joint on a surface",
    "loss_of_contact": "no joint along a curve",
    "knife_edge": "no constraints of velocities",
}

LINES = {
    "integration_scheme": 'integrator = ResetIntegratorFromFlags(simulator, "{}", dt)',
    "fixed_step_mode": "integrator.set_fixed_step_mode({})  # the default accuracy does not bound the error",
    "discrete_contact_approximation": "plant.set_discrete_contact_approximation(DiscreteContactApproximation.{})",
    "contact_model": "plant.set_contact_model(ContactModel.{})",
    "stiction_tolerance": "plant.set_stiction_tolerance({})  # default 1e-3 m/s: bodies at rest creep",
    "point_contact_stiffness": "AddContactMaterial(properties=properties, point_stiffness={})  # of each body",
    "hunt_crossley_dissipation": "AddContactMaterial(properties=properties, dissipation={})  # of each body",
}
"""The names are those of `pydrake.all`."""


class DrakeRungeKutta3(SceneIntegrator):
    """A continuous plant with Drake's default integrator, Bogacki and Shampine's (1989), at fixed steps. Order 3.

    Tedrake and the Drake Development Team, drake.mit.edu.
    """

    name, library = "runge_kutta3", "pydrake"
    order: ClassVar[int | None] = 3
    lacks: ClassVar[Mapping[str, str]] = LACKS | {
        "static_friction": "friction at rest is a function of the slip speed, so that a body creeps",
        "thin_rod_contact": "no restitution of 0: the dissipation that stops a body is too stiff for fixed explicit steps",
    }
    lines: ClassVar[Mapping[str, str]] = LINES
    sweep = Steps(coarsest=0.5, halvings=4)  # finer steps show round-off
    scheme: ClassVar[str] = "runge_kutta3"
    configured: ClassVar[bool] = True

    def world(self, form: SceneForm, dt: float) -> World:
        import pydrake.all  # without the library the status is `not_installed`

        # Half spaces bring a warning about deformable bodies, of which no scene has any.
        getLogger("drake").setLevel(ERROR)
        return World(pydrake.all, form, dt, self.scheme, self.configured)


class DrakeRungeKutta5(DrakeRungeKutta3):
    """A continuous plant with Drake's Runge-Kutta method of order 5 at fixed steps."""

    name, order, scheme = "runge_kutta5", 5, "runge_kutta5"


class DrakeSap(DrakeRungeKutta3):
    """A discrete plant with the convex contact solver SAP (Castro, Permenter, Han 2022). Order 1: symplectic Euler.

    The contact law is `kLagged`. With `kSap` a sliding body hops: the law has it hover, at a height of mu v dt. There is no
    tighter solver: Python has no tolerance or iteration of SAP, and its near-rigid threshold changes nothing of this law.
    """

    name, order, scheme, lacks = "SAP", 1, "kLagged", LACKS
    sweep = SceneIntegrator.sweep


class DrakeTamsi(DrakeRungeKutta3):
    """A discrete plant with the contact solver TAMSI (Castro and others 2020). Order 1: symplectic Euler."""

    name, order, scheme, lacks = "TAMSI", 1, "kTamsi", LACKS
    sweep = SceneIntegrator.sweep


class DrakeAsShipped(DrakeRungeKutta3):
    """A discrete plant with all defaults, on which the tutorials start: only what the scene declares is set. Order 1."""

    name, order, scheme, policy = "discrete", 1, "", "as shipped"
    sweep = SceneIntegrator.sweep
    configured, lacks = False, LACKS


INTEGRATORS = (DrakeRungeKutta3, DrakeRungeKutta5, DrakeSap, DrakeTamsi, DrakeAsShipped)
