"""MuJoCo: generalized coordinates and soft constraints, built from scenes as MJCF."""

from typing import ClassVar

from gnomon.cases.core.scene import SceneForm
from gnomon.harness.adapters.engines.mujoco_world import World
from gnomon.harness.adapters.engines.scene_run import SceneIntegrator


class Euler(SceneIntegrator):
    """Semi-implicit Euler, the engine's default integrator. Order 1."""

    name, library = "Euler", "mujoco"
    order: ClassVar[int | None] = 1
    integrator: ClassVar[str] = "Euler"
    configured: ClassVar[bool] = True
    lacks: ClassVar[dict[str, str]] = {
        "driven_frame": "frames of prescribed poses have no velocity",
        "unwinding_string": "a tendon has no spool",
        "belt": "tendons slide over the bodies that they wrap without friction",
        "linkage": "x",
        "adhesion": "a weld is switched by a program, not by a touch",
        "adhesive_contact": "a weld is switched by a program, not by a touch",
        "static_friction": "one coefficient of friction",
        "drill_friction": "x",
        "moving_surface": "a plane has no velocity of its surface",
        "disc_contact": "geoms have positive thickness",
        "rolling_without_slip": "constraints are on positions",
        "curved_guide": "no joint along a curve",
        "curved_surface": "no joint on a surface",
        "loss_of_contact": "no guide",
        "knife_edge": "constraints are on positions",
    }

    def world(self, form: SceneForm, dt: float) -> World:
        import mujoco  # without the library the status is `not_installed`

        return World(mujoco, form, dt, self.integrator, self.configured)


class ImplicitFast(Euler):
    name, integrator = "implicitfast", "implicitfast"


class RungeKutta(Euler):
    name, integrator, order = "RK4", "RK4", 4


class EulerAsShipped(Euler):
    policy, configured = "as shipped", False


INTEGRATORS = (Euler, ImplicitFast, RungeKutta, EulerAsShipped)
