"""Drake: MultibodyPlant, built from scenes, continuous with fixed-step integrators, or discrete.

How it is driven, and why: a continuous plant is a system of equations that any of Drake's integrators takes, at fixed steps
or under error control, which is the default. The target accuracy is no relative tolerance: a motion smaller than it is
stepped at the longest step. Forces are a system of symbolic expressions in the diagram, so that each stage evaluates them
without Python (`drake_plant/forces.py`). A discrete plant is stepped with its contact solver, forces constant over a step. Traps:
the only ball joint is singular at a pitch of 90 degrees; continuous contact is a spring that a fixed step must resolve;
the plant's defaults leave contact as soft as 1 mm.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from logging import ERROR, getLogger
from typing import Any, ClassVar

from gnomon.cases.core.scene import SceneForm
from gnomon.harness.adapters.engines.drake_plant.world import Control, World
from gnomon.harness.adapters.engines.scene_run import SceneIntegrator, SceneRun
from gnomon.harness.contract.integrator import Floats, Problem, Solution, Solver, Steps, Tolerance
from gnomon.harness.contract.validation import require_positive

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

CONTACTS = ("rigid_impact", "coulomb_isotropic", "thin_rod_contact", "body_contact")

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
CONTROL_LINES = {
    "integration_scheme": LINES["integration_scheme"],
    "target_accuracy": "integrator.set_target_accuracy({})  # default 1e-4; significant digits, of numbers near 1",
    "maximum_step_size": "integrator.set_maximum_step_size({})  # a time in which the motion changes by its size",
    "requested_minimum_step_size": "integrator.set_requested_minimum_step_size({})  # it ends where it finds no step",
}


def drake() -> Any:
    """The library, loaded at its first use."""
    import pydrake.all  # without the library the status is `not_installed`

    # Half spaces bring a warning about deformable bodies, of which no scene has any.
    getLogger("drake").setLevel(ERROR)
    return pydrake.all


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
    sweep: ClassVar[Tolerance | Steps] = Steps(coarsest=0.5, halvings=4)  # finer steps show round-off
    scheme: ClassVar[str] = "runge_kutta3"
    configured: ClassVar[bool] = True

    def world(self, form: SceneForm, dt: float) -> World:
        return World(drake(), form, dt, self.scheme, self.configured)


class DrakeRungeKutta5(DrakeRungeKutta3):
    """A continuous plant with Drake's Runge-Kutta method of order 5 at fixed steps."""

    name, order, scheme = "runge_kutta5", 5, "runge_kutta5"


class DrakeControlled(DrakeRungeKutta3):
    """A continuous plant with Drake's default integrator as it is shipped: error control chooses the steps. Order 3."""

    policy, sampling = "error control", "stops at samples"
    sweep = Tolerance(loosest=1e-2, tightest=1e-10)
    lines: ClassVar[Mapping[str, str]] = CONTROL_LINES
    lacks: ClassVar[Mapping[str, str]] = LACKS | dict.fromkeys(
        CONTACTS, "a spring, which is as stiff as a fixed step admits"
    )

    def prepare(self, problem: Problem, setting: float) -> Solver:
        require_positive(setting, "accuracy")
        # No step is longer than a time in which the motion changes by its size: the accuracy is for numbers near 1.
        control = Control(setting, problem.time_scale, problem.elapsed)
        make = partial(World, drake(), dt=0.0, scheme=self.scheme, configured=self.configured, control=control)
        return ControlledRun(make, problem, 0.0)


class ControlledRun(SceneRun):
    """A solver whose world goes from sample to sample, and counts the steps."""

    def count(self, times: Floats, dt: float) -> list[int]:
        return list(range(1, len(times) + 1))

    def _solve(self, initial_states: Floats) -> Solution:
        world: Any = self.world
        before = world.steps_taken
        return replace(super()._solve(initial_states), steps=world.steps_taken - before)


class DrakeBogackiShampine3(DrakeControlled):
    """A continuous plant with the pair of Bogacki and Shampine (1989), under error control. Order 3."""

    name, scheme = "bogacki_shampine3", "bogacki_shampine3"


class DrakeControlled5(DrakeControlled):
    """A continuous plant with the pair of Dormand and Prince (1980), under error control. Order 5."""

    name, order, scheme = "runge_kutta5", 5, "runge_kutta5"


class DrakeRadau1(DrakeControlled):
    """A continuous plant with Radau's implicit method of one stage, under error control. Order 1."""

    name, order, scheme, primary = "radau1", 1, "radau1", False
    sweep = Tolerance(loosest=1e-2, tightest=1e-4)


class DrakeRadau3(DrakeControlled):
    """A continuous plant with Radau's implicit method of two stages, under error control. Order 3."""

    name, scheme, primary = "radau3", "radau3", False
    sweep = Tolerance(loosest=1e-2, tightest=1e-8)


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


INTEGRATORS = (
    DrakeRungeKutta3,
    DrakeRungeKutta5,
    DrakeControlled,
    DrakeControlled5,
    DrakeBogackiShampine3,
    DrakeRadau1,
    DrakeRadau3,
    DrakeSap,
    DrakeTamsi,
    DrakeAsShipped,
)
