"""DART."""
from typing import ClassVar
from gnomon.cases.core.scene import SceneForm
from gnomon.harness.adapters.engines.dart_world import World
from gnomon.harness.adapters.engines.scene_run import SceneIntegrator


class Dart(SceneIntegrator):
    name, library = "World.step", "dartpy"
    order: ClassVar[int | None] = 1
    configured: ClassVar[bool] = True
    lacks = {
        "driven_frame": "x", "unwinding_string": "x", "belt": "x", "linkage": "x", "adhesion": "x", "adhesive_contact": "x",
        "static_friction": "x", "drill_friction": "x", "disc_contact": "x", "rolling_without_slip": "x", "curved_guide": "x",
        "curved_surface": "x", "loss_of_contact": "x", "knife_edge": "x",
    }

    def world(self, form: SceneForm, dt: float) -> World:
        import dartpy
        return World(dartpy, form, dt, self.configured)


class DartAsShipped(Dart):
    policy, configured, order = "as shipped", False, None


INTEGRATORS = (Dart, DartAsShipped)
