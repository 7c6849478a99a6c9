"""pymunk: the planar rigid bodies of Chipmunk, built from scenes. A step is a drift, then a kick.

Chipmunk moves bodies with their present velocities, finds contacts, adds forces to the velocities and solves joints and
contacts as impulses (cpSpaceStep.c). A force that is set before a step therefore belongs to the position before the drift
(explicit Euler); it is set in `velocity_func`, which is called after the drift. Order 1.
"""

from collections.abc import Mapping
from typing import ClassVar

from gnomon.cases.core.forms import Form
from gnomon.cases.core.scene import TOKENS, SceneForm
from gnomon.harness.adapters.engines.pymunk_world import World
from gnomon.harness.adapters.engines.scene_run import COARSE, TIGHTER, SceneIntegrator, idle

PLANAR = "planar engine: a body turns about one axis"


class Pymunk(SceneIntegrator):
    """pymunk with every option chosen so that it models the scene and nothing else. Order 1.

    Blomqvist, pymunk.org; Lembcke, chipmunk-physics.net.

    Scenes that move in a coordinate plane, or in a line, run in that plane.
    """

    name, library = "Space.step", "pymunk"
    order: ClassVar[int | None] = 1
    configured: ClassVar[bool] = True
    lacks: ClassVar[Mapping[str, str]] = {
        "gyroscopic": PLANAR,
        "ball_joint": PLANAR,
        "driven_frame": PLANAR,
        "drill_friction": PLANAR,
        "disc_contact": PLANAR,
        "curved_surface": "planar engine: bodies have two coordinates",
        "pulley": "no joint for a rope over a pulley",
        "unwinding_string": "no joint for a string that unwinds",
        "belt": "no belt between wheels",
        "linkage": "planar engine: the arms of a governor turn with its spindle",
        "adhesion": "points without a radius do not touch",
        "static_friction": "one coefficient of friction for sticking and sliding",
        "rolling_without_slip": "no constraint of rolling",
        "curved_guide": "no joint along a curve",
        "loss_of_contact": "no joint along a curve",
        "knife_edge": "no joint that blocks a direction of velocity",
    }

    lines: ClassVar[Mapping[str, str]] = {
        "error_bias": "constraint.error_bias = {}  # default 0.9**60: a tenth of a joint's error is corrected in 1/60 s",
        "collision_bias": "space.collision_bias = {}  # default 0.9**60: the correction of depth adds speed",
        "iterations": "space.iterations = {}  # default 10: a block that touches two planes errs at every step",
    }

    def world(self, form: SceneForm, dt: float) -> World:
        import pymunk  # without the library the status is `not_installed`

        return World(pymunk, form, dt, self.configured, self.tight)


class PymunkAsShipped(Pymunk):
    """pymunk with its defaults: only the properties that the scene declares are set.

    It corrects a tenth of the error of a joint in each 1/60 s. The error of a pendulum therefore falls below a radian only
    at steps below 1e-4 s, and a driven joint lags behind its drive at every step, so there is no order.
    """

    policy, configured, order = "as shipped", False, None


FREE = frozenset(token for token in TOKENS if token.endswith(("force", "torque")) or token == "impulse")


class PymunkTight(Pymunk):
    """pymunk as configured, with ten times the iterations of its solver of joints and contacts."""

    policy, tight, primary = TIGHTER, True, False
    sweep = COARSE

    def unsupported(self, form: Form | SceneForm) -> str | None:
        return super().unsupported(form) or idle(form, frozenset(TOKENS) - FREE)


INTEGRATORS = (Pymunk, PymunkAsShipped, PymunkTight)
