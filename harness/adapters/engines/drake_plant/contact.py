"""The contacts of a scene in a Drake plant: point contact, a spring with Hunt and Crossley's dissipation and friction."""

from collections.abc import Mapping
from math import sqrt
from typing import Any

import numpy as np
from gnomon.cases.core.scene import Body, Contact, Scene, Vector
from gnomon.harness.adapters.engines.vectors import ORIGIN, dot
from gnomon.harness.contract.integrator import Refused

STIFFNESS = 1e8
"""N/m, of discrete contact: 1e5 leaves an error of 2e-3 m at every step."""
SLIP = 1e-7
"""m/s, the tolerance of stiction of discrete contact: with the default of 1e-3 a block at rest creeps."""
STEPS_OF_A_BOUNCE = 10
"""Continuous contact is a spring that an explicit step must resolve: its period is 2 pi times this number of steps."""
SLIP_STEPS = 4
"""The tolerance of stiction of continuous contact, over the change of the velocity by friction in one step."""
DAMPED_STEPS = {True: 5.0, False: 0.2}
"""A contact with a restitution of 0 loses its speed, under the weight, in this number of steps: continuous, discrete."""


class Contacts:
    """The contacts of a plant whose bodies are these; `add` registers those of a scene and returns what it set."""

    def __init__(self, drake: Any, plant: Any, bodies: Mapping[str, Any], dt: float, continuous: bool) -> None:
        self.api, self.plant, self.bodies, self.dt, self.continuous = drake, plant, bodies, dt, continuous
        self.options: dict[str, Any] = {}

    def add(self, scene: Scene, configured: bool, bounces: bool) -> Mapping[str, Any]:
        """Register shapes and surfaces. Raises Refused for a coefficient of restitution that contact does not have."""
        elastic = {contact.restitution for contact in scene.contacts} == {1.0}
        if bounces and self.continuous and not elastic:
            raise Refused("contact has no coefficient of restitution: what it dissipates depends on the speed")
        if bounces and not self.continuous and any(contact.restitution for contact in scene.contacts):
            raise Refused("contact has no coefficient of restitution: discrete contact damps every impact")
        self.configured = configured
        if configured:
            self._set_plant(scene)
        bodies = {body.name: body for body in scene.bodies}
        for number, contact in enumerate(scene.contacts):
            if not contact.partner:
                pose = self.api.HalfSpace.MakePose(np.array(contact.normal), np.zeros(3))
                world, mass = self.plant.world_body(), bodies[contact.body].mass
                self._register(world, (pose, self.api.HalfSpace(), f"plane {number}"), contact, mass)
        for body in scene.bodies:
            mine = [contact for contact in scene.contacts if body.name in (contact.body, contact.partner)]
            for number, (place, shape) in enumerate(self._shapes(body) if mine else ()):
                pose = self.api.RigidTransform(np.array(place))
                self._register(self.bodies[body.name], (pose, shape, f"{body.name} {number}"), mine[0], body.mass)
        return self.options

    def _set_plant(self, scene: Scene) -> None:
        weight = sqrt(dot(scene.gravity, scene.gravity)) or 1.0
        self.dissipation = 1 / (DAMPED_STEPS[self.continuous] * weight * self.dt)
        slip = SLIP
        if self.continuous:
            slip = SLIP_STEPS * weight * self.dt * (max(contact.friction for contact in scene.contacts) or 1.0)
        self.plant.set_stiction_tolerance(slip)
        self.plant.set_contact_model(self.api.ContactModel.kPoint)
        self.options |= {"stiction_tolerance": slip, "contact_model": "kPoint"}

    def _shapes(self, body: Body) -> list[tuple[Vector, Any]]:
        """A sphere, or the corners of a box: a contact of box and plane is one point, on which the box would rock."""
        if body.half_extents is None:
            return [(ORIGIN, self.api.Sphere(body.radius))]
        x, y, z = body.half_extents
        if not self.configured and all(body.half_extents):
            return [(ORIGIN, self.api.Box(2 * x, 2 * y, 2 * z))]
        corners = {(a * x, b * y, c * z) for a in (-1, 1) for b in (-1, 1) for c in (-1, 1)}
        return [(corner, self.api.Sphere(0.0)) for corner in sorted(corners)]

    def _register(self, body: Any, shape: tuple[Any, Any, str], contact: Contact, mass: float) -> None:
        api, surface = self.api, self.api.ProximityProperties()
        friction = api.CoulombFriction(contact.friction, contact.friction)
        if not self.configured:
            api.AddContactMaterial(properties=surface, friction=friction)
        else:
            # Two surfaces in contact are springs in a row, so that each has twice the stiffness.
            stiffness = 2 * (mass / (STEPS_OF_A_BOUNCE * self.dt) ** 2 if self.continuous else STIFFNESS)
            dissipation = 0.0 if contact.restitution else self.dissipation
            api.AddContactMaterial(
                dissipation=dissipation, point_stiffness=stiffness, friction=friction, properties=surface
            )
            self.options |= {"point_contact_stiffness": stiffness, "hunt_crossley_dissipation": dissipation}
        self.plant.RegisterCollisionGeometry(body, *shape, surface)
