"""Newton."""

from typing import Any, ClassVar

from gnomon.cases.core.scene import SceneForm
from gnomon.harness.adapters.engines.newton_world import World
from gnomon.harness.adapters.engines.scene_run import SceneIntegrator


class Newton(SceneIntegrator):
    library = "newton"
    order: ClassVar[int | None] = 1
    configured: ClassVar[bool] = True
    reduced: ClassVar[bool] = False
    penalty: ClassVar[bool] = True

    def world(self, form: SceneForm, dt: float) -> World:
        return World(
            form, dt, self.solver, reduced=self.reduced, penalty=self.penalty, configured=self.configured
        )

    def solver(self, world: World) -> Any:
        raise NotImplementedError


class Featherstone(Newton):
    name = "SolverFeatherstone"
    reduced = True

    def solver(self, world: World) -> Any:
        return world.newton.solvers.SolverFeatherstone(world.model, **world.chosen(angular_damping=0.0))


class SemiImplicit(Newton):
    name = "SolverSemiImplicit"
    k = 0.5
    z = 1.0

    def solver(self, world: World) -> Any:
        settings = {"angular_damping": 0.0}
        if world.assembly.light < float("inf"):
            rate = self.k / world.dt
            settings |= {
                "joint_attach_ke": world.assembly.light * rate**2,
                "joint_attach_kd": self.z * world.assembly.light * rate,
            }
        return world.newton.solvers.SolverSemiImplicit(world.model, **world.chosen(**settings))


class XPBD(Newton):
    name = "SolverXPBD"
    penalty = False
    iterations = 20
    relax = 1.0

    def solver(self, world: World) -> Any:
        settings = dict(
            iterations=self.iterations, joint_linear_relaxation=self.relax, joint_angular_relaxation=self.relax,
        )
        return world.newton.solvers.SolverXPBD(world.model, enable_restitution=True, **world.chosen(**settings))


INTEGRATORS = (Featherstone, SemiImplicit, XPBD)
