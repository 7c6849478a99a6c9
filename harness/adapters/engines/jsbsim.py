"""JSBSim: a flight simulator's equations of motion of one free rigid body, with its own multistep integrators.

Its integrators of rates and positions, of rotation and translation, are four options by number (FGPropagate.h). Each
integrator here sets them alike, apart from the special methods for attitudes. Each multistep method starts with copies of
the first derivative as its history, so its order is at most 2: the error of the first step stays.
"""

from collections.abc import Mapping
from typing import ClassVar

from gnomon.cases.core.scene import TOKENS, SceneForm
from gnomon.harness.adapters.engines.jsbsim_world import SELECTORS, World
from gnomon.harness.adapters.engines.scene_run import SceneIntegrator

FREE = {"gyroscopic", "position_force", "velocity_force", "time_force", "torque", "drag_torque"}
JOINTS, CONTACTS = "no joints", "no rigid contact: its contacts are springs"
REASONS = {
    "mutual_force": "one body in a simulation",
    "body_contact": "one body in a simulation",
    "impulse": "no blows: forces only",
    "rigid_impact": CONTACTS,
    "adhesion": CONTACTS,
    "adhesive_contact": CONTACTS,
    "coulomb_isotropic": CONTACTS,
    "static_friction": CONTACTS,
    "drill_friction": CONTACTS,
    "moving_surface": CONTACTS,
    "thin_rod_contact": CONTACTS,
    "disc_contact": CONTACTS,
    "loss_of_contact": CONTACTS,
    "rolling_without_slip": CONTACTS,
}


class Jsbsim(SceneIntegrator):
    """JSBSim with its default integrators: Euler for rotations (order 1), Adams-Bashforth 2 and 3 for translations (order 2).

    Berndt, AIAA 2004-4923; jsbsim-team.github.io.
    """

    name, library, policy = "default", "jsbsim", "as shipped"
    order: ClassVar[int | None] = None
    lacks: ClassVar[Mapping[str, str]] = {token: REASONS.get(token, JOINTS) for token in TOKENS if token not in FREE}
    lines: ClassVar[Mapping[str, str]] = {name: f'fdm["{name}"] = {{}}' for name in SELECTORS}
    methods: ClassVar[tuple[int, int, int, int] | None] = None
    """The numbers of the integrators: rates of rotation and translation, then positions of both; None for the defaults."""

    def world(self, form: SceneForm, dt: float) -> World:
        import jsbsim  # without the library the status is `not_installed`

        return World(jsbsim, dt, self.methods)


class JsbsimEuler(Jsbsim):
    """JSBSim with rectangular Euler for all integrations. Order 1."""

    name, policy, order, methods = "Euler", "configured", 1, (1, 1, 1, 1)


class JsbsimTrapezoidal(Jsbsim):
    """JSBSim with its "trapezoidal" integrator: it averages the last two derivatives, so it is of order 1, with twice the
    error of Euler's method."""

    name, policy, order, methods = "trapezoidal", "configured", 1, (2, 2, 2, 2)


class JsbsimAB2(Jsbsim):
    """JSBSim with Adams-Bashforth 2 for all integrations. Order 2."""

    name, policy, order, methods = "Adams-Bashforth 2", "configured", 2, (3, 3, 3, 3)


class JsbsimAB3(Jsbsim):
    """JSBSim with Adams-Bashforth 3 for all integrations. Order 2, because of its start."""

    name, policy, order, methods = "Adams-Bashforth 3", "configured", 2, (4, 4, 4, 4)


class JsbsimAB4(Jsbsim):
    """JSBSim with Adams-Bashforth 4 for all integrations. Order 2, because of its start."""

    name, policy, order, methods = "Adams-Bashforth 4", "configured", 2, (5, 5, 5, 5)


class JsbsimAB5(Jsbsim):
    """JSBSim with Adams-Bashforth 5 for all integrations. Order 2, because of its start."""

    name, policy, order, methods = "Adams-Bashforth 5", "configured", 2, (9, 9, 9, 9)


class OfAttitudes(Jsbsim):
    """A special method for attitudes, with Adams-Bashforth 2 for the rest."""

    policy = "configured, Adams-Bashforth 2"

    def unsupported(self, form: object) -> str | None:
        if isinstance(form, SceneForm) and "gyroscopic" not in form.needs:
            return "a method for attitudes; the rest is as Adams-Bashforth 2"
        return super().unsupported(form)  # type: ignore[arg-type]


class JsbsimBuss1(OfAttitudes):
    """JSBSim with Buss' first method for attitudes (Buss, J. Comput. Phys. 164 (2000) 377). Order 1."""

    name, order, methods = "Buss 1", 1, (3, 3, 6, 3)


class JsbsimBuss2(OfAttitudes):
    """JSBSim with Buss' augmented second-order method for attitudes (Buss, J. Comput. Phys. 164 (2000) 377). Order 2."""

    name, order, methods = "Buss 2", 2, (3, 3, 7, 3)


class JsbsimLinearised(OfAttitudes):
    """JSBSim with local linearisation of the quaternion's equation (Barker, Bowles and Williams, NASA TN D-7347, 1973).
    Order 2."""

    name, order, methods = "local linearisation", 2, (3, 3, 8, 3)


INTEGRATORS = (
    Jsbsim,
    JsbsimEuler,
    JsbsimTrapezoidal,
    JsbsimAB2,
    JsbsimAB3,
    JsbsimAB4,
    JsbsimAB5,
    JsbsimBuss1,
    JsbsimBuss2,
    JsbsimLinearised,
)
