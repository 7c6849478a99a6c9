"""PyBullet: Bullet's rigid bodies, built from scenes. A step is a kick, then a drift: symplectic Euler.

Positions and rates are read through the functions that return doubles (`getLinkState` gives float32 velocities).

How it is driven: joints are trees of links in reduced coordinates, in which the engine's joints have no error of their own
(pybullet_trees). Ball joints are three revolutes, rods and ropes are rails that a motor or a gear holds (pybullet_swivels).
Driven coordinates are motors. Forces, torques and blows act over a step (pybullet_forces). Moving planes are heavy boxes,
as the engine's static bodies are at rest in contacts (pybullet_planes).

Traps: a call of `changeDynamics` that sets the mass and inertia of a link must set nothing else, or the inertia becomes
zero. A force on a link is given at the position that the engine keeps of it, which is one step old.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import ClassVar

from gnomon.cases.core.forms import Form
from gnomon.cases.core.scene import Body, Hinge, Readings, Scene, SceneForm, Slider, Vector
from gnomon.harness.adapters.engines.bullet.pybullet_world import World
from gnomon.harness.adapters.engines.scene_run import COARSE, TIGHTER, SceneIntegrator, SceneRun, idle
from gnomon.harness.contract.integrator import Floats, Problem, Solver, Steps
from gnomon.harness.contract.validation import require_positive


class PyBullet(SceneIntegrator):
    """PyBullet with every option chosen so that it models the scene and nothing else. Order 1, for charges 2.

    Coumans, pybullet.org.

    Bodies are multibodies in reduced coordinates (Featherstone). Scenes with bouncing bodies are in maximal
    coordinates, as a multibody gains energy at impacts. `lacks` says what it is not given; all other scenes run.
    """

    name, library = "stepSimulation", "pybullet"
    order: ClassVar[int | None] = 1
    lacks: ClassVar[Mapping[str, str]] = {
        "driven_frame": "its frame of reference is inertial: gravity is its only field",
        "unwinding_string": "it has no string: a gear in its place needs a radius, which the scene does not give",
        "belt": "it has no belt: a gear in its place needs radii and a force, which the scene does not give",
        "adhesion": "its contacts do not stick, and fast small bodies pass through one another between two steps",
        "static_friction": "it has one coefficient of friction, for rest and sliding",
        "drill_friction": "its friction against rotation about the normal does not depend on the slip, nor the slip's on it",
        "disc_contact": "its discs are cylinders with a thickness, and thin ones do not roll straight",
        "rolling_without_slip": "it has friction, no constraint of rolling",
        "curved_guide": "it has no constraint of a point to a curve",
        "curved_surface": "its surfaces are planes, spheres, boxes, cylinders and flat triangles",
        "knife_edge": "its constraints restrict positions, and none restricts the velocity in one direction of the body",
    }
    configured: ClassVar[bool] = True
    staggered: ClassVar[bool] = False
    # Each option alone: a call that also sets mass and inertia makes the inertia zero. Link -1 is the base.
    lines: ClassVar[Mapping[str, str]] = {
        "linearDamping": "p.changeDynamics(body, link, linearDamping={})  # default 0.04; link: each, -1 is the base",
        "angularDamping": "p.changeDynamics(body, link, angularDamping={})  # default 0.04",
        "maxJointVelocity": "p.changeDynamics(body, link, maxJointVelocity={})  # default 100, also for free bodies",
        "velocityMotorForce": "p.setJointMotorControl2(body, joint, p.VELOCITY_CONTROL, force={})  # the default motor brakes",
        "motorForce": "p.setJointMotorControl2(body, joint, p.VELOCITY_CONTROL, targetVelocity=rate, force={})"
        "  # a joint that is held or driven",
        "gearForce": "p.changeConstraint(gear, maxForce={})  # a gear that holds, as a rope over a pulley",
        "movingPlaneMass": "plane = p.createMultiBody({}, shape)  # a plane that moves: fixed ones are at rest in contacts",
        "useMaximalCoordinates": "body = p.createMultiBody(mass, shape, useMaximalCoordinates={})"
        "  # a multibody gains energy at impacts",
        "restitutionVelocityThreshold": "p.setPhysicsEngineParameter(restitutionVelocityThreshold={})"
        "  # default 0.2: slower bodies do not bounce",
        "contactERP": "p.setPhysicsEngineParameter(contactERP={})"
        "  # by default restitution vanishes as the step decreases",
        "contactSlop": "p.setPhysicsEngineParameter(contactSlop={})  # by default bodies sink in a little",
        "contactProcessingThreshold": "p.changeDynamics(body, -1, contactProcessingThreshold={})"
        "  # by default contacts act before they close; also for the plane",
        "solverResidualThreshold": "p.setPhysicsEngineParameter(solverResidualThreshold={})"
        "  # by default it stops early at small steps",
        "numSolverIterations": "p.setPhysicsEngineParameter(numSolverIterations={})  # default 50: a block at rest creeps",
        "charges": "# charges in a magnetic field: {}",
    }
    maximal: ClassVar[frozenset[str]] = frozenset({"rigid_impact"})
    """Scenes with one of these tokens are in maximal coordinates."""

    def unsupported(self, form: Form | SceneForm) -> str | None:
        lacking = super().unsupported(form)
        if lacking is None and self.staggered and isinstance(form, SceneForm) and not form.conservative:
            return "a staggered start needs accelerations that depend on position alone"
        return lacking

    def world(self, form: SceneForm, dt: float) -> World:
        import pybullet  # without the library the status is `not_installed`

        return World(pybullet, form, dt, self.configured, bool(form.needs & self.maximal), self.tight)

    def prepare(self, problem: Problem, setting: float) -> Solver:
        require_positive(setting, "step size")
        run = StaggeredRun if self.staggered else SceneRun
        return run(lambda form: self.world(form, setting), problem, setting)


class PyBulletStaggered(PyBullet):
    """PyBullet as a leapfrog: its velocities belong to a time half a step before its positions. Order 2.

    It starts from v0 - dt/2 a(q0) and reads v + dt/2 a(q), both from the change of the velocity over one step.
    """

    order, policy, staggered = 2, "staggered", True
    primary = False  # the suite `engines` compares the ways to drive an engine


ON_JOINTS = frozenset({"slider", "linked_joint", "chained_hinges", "ball_joint", "rod", "rope", "linkage"})
"""Scenes with one of these tokens have bodies that only joint coordinates model here."""


class PyBulletMaximal(PyBullet):
    """PyBullet in maximal coordinates for scenes that both kinds of coordinates can model. Order 1.

    Gyroscopic torque is then implicit, and a hinge is a point-to-point constraint.
    """

    policy = "configured, maximal coordinates"
    primary = False
    maximal = frozenset({"gyroscopic", "hinge"})

    def unsupported(self, form: Form | SceneForm) -> str | None:
        if isinstance(form, SceneForm) and (not form.needs & self.maximal or form.needs & ON_JOINTS):
            return "runs hinges and gyroscopic motion only; the rest is as configured"
        if isinstance(form, SceneForm) and "hinge" in form.needs and form.needs != {"hinge"}:
            return "what acts on a hinged body is applied to its joint, which maximal coordinates lack"
        return super().unsupported(form)


ITERATES = frozenset(
    {
        "rigid_impact",
        "coulomb_isotropic",
        "thin_rod_contact",
        "adhesive_contact",
        "driven_axis",
        "rope",
        "rod",
        "pulley",
    }
    | {"linkage", "joint_friction"}
)
"""Scenes with one of these tokens have contacts, motors or gears here; other joints are in reduced coordinates."""


class PyBulletAsShipped(PyBullet):
    """PyBullet with its defaults: only the properties that the scene declares are set.

    It converges to a motion with its damping and its joints' motors, so it has no order against the exact motion.
    """

    policy, configured, order = "as shipped", False, None
    primary = False
    sweep = Steps(coarsest=0.5, halvings=7)  # its errors come from damping and motors: finer steps do not help
    maximal = frozenset()


class PyBulletTight(PyBullet):
    """PyBullet as configured, with ten times the iterations of its solver of contacts, motors and gears."""

    policy, tight, primary = TIGHTER, True, False
    sweep = COARSE

    def unsupported(self, form: Form | SceneForm) -> str | None:
        return super().unsupported(form) or idle(form, ITERATES)


INTEGRATORS = (PyBullet, PyBulletStaggered, PyBulletMaximal, PyBulletAsShipped, PyBulletTight)


class StaggeredRun(SceneRun):
    """A run that starts half a step early in its rates and reads them as the mean over a step.

    A start first takes a step for the accelerations, in a separate world, because steps leave state behind.
    """

    def __init__(self, make: Callable[[SceneForm], World], problem: Problem, dt: float) -> None:
        self.trial: World | None = None
        super().__init__(make, problem, dt)
        self.trial = make(self.form)
        self.trial.build(self.at_zero)
        self.close = self._close_both

    def _close_both(self) -> None:
        self.world.close()
        if self.trial is not None:
            self.trial.close()

    def _rebuild(self) -> None:
        super()._rebuild()
        if self.trial is not None:
            self.trial.build(self.at_zero)

    def _follow(self, scene: Scene, rows: Floats) -> None:
        assert self.trial is not None
        self.trial.place(scene)
        start = self.trial.read()
        self.trial.advance(1)
        self.world.place(back_up(scene, start, self.trial.read()))
        reached = 0
        for row, count in zip(rows, self.counts, strict=True):
            self.world.advance(count - reached)
            readings = self.world.read()
            self.world.advance(1)
            reached = count + 1
            row[:] = self.form.observe(with_mean_rates(readings, self.world.read()), self.parameters)


def back_up(scene: Scene, start: Readings, after: Readings) -> Scene:
    """The scene with its rates half a step earlier: v0 - (v1 - v0)/2, where v1 - v0 = dt a(q0)."""

    def rate(joint: Hinge | Slider) -> float:
        return joint.rate - (after.joints[joint.name][1] - start.joints[joint.name][1]) / 2

    def earlier(body: Body) -> Body:
        if body.name not in start.bodies:
            return body
        v0, v1 = start.bodies[body.name][2], after.bodies[body.name][2]
        x, y, z = (v - (b - a) / 2 for v, a, b in zip(body.velocity, v0, v1, strict=True))
        return replace(body, velocity=(x, y, z))

    return replace(
        scene,
        bodies=tuple(earlier(body) for body in scene.bodies),
        hinges=tuple(replace(hinge, rate=rate(hinge)) for hinge in scene.hinges),
        sliders=tuple(replace(slider, rate=rate(slider)) for slider in scene.sliders),
    )


def with_mean_rates(now: Readings, after: Readings) -> Readings:
    """The positions of `now` with the rates at this time: the mean of the rates half a step before and after it."""
    joints = {name: (q, (rate + after.joints[name][1]) / 2) for name, (q, rate) in now.joints.items()}
    bodies = {
        name: (position, attitude, _mean(v, after.bodies[name][2]), _mean(w, after.bodies[name][3]))
        for name, (position, attitude, v, w) in now.bodies.items()
    }
    return Readings(joints, bodies)


def _mean(a: Vector, b: Vector) -> Vector:
    return (a[0] + b[0]) / 2, (a[1] + b[1]) / 2, (a[2] + b[2]) / 2
