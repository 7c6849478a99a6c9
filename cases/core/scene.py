"""What a physics engine is given: bodies, joints, forces and contacts, and nothing that the scene does not need."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
IDENTITY: Quaternion = (0.0, 0.0, 0.0, 1.0)


@dataclass(frozen=True)
class Body:
    """A rigid body. `inertia`: principal moments about its centre of mass, its axes the body axes; zeros: a point mass.

    `radius` (sphere) or `half_extents` (box) is given only where the body touches something. `quaternion` is
    (x, y, z, w), body -> space; velocities are in space.
    """

    name: str
    mass: float
    inertia: Vector
    position: Vector = (0.0, 0.0, 0.0)
    quaternion: Quaternion = IDENTITY
    velocity: Vector = (0.0, 0.0, 0.0)
    angular_velocity: Vector = (0.0, 0.0, 0.0)
    radius: float | None = None
    half_extents: Vector | None = None


@dataclass(frozen=True)
class Hinge:
    """A revolute joint between the world and `body`, through `anchor` along `axis`, both in space at angle zero.

    The body's centre of mass stands at `arm` from the anchor at angle zero; `angle` and `rate` are its start. With a
    `parent` (token `linked_joint`) the anchor is a point of that body, seen from its centre of mass.
    """

    name: str
    body: str
    anchor: Vector
    axis: Vector
    arm: Vector
    angle: float
    rate: float
    parent: str = field(default="", kw_only=True)


@dataclass(frozen=True)
class Slider:
    """A prismatic joint between the world and `body`, whose centre of mass stands at `anchor` + `position` * `axis`.

    With a `parent` (token `linked_joint`) the anchor is a point of that body, seen from its centre of mass. `drive(t)`
    prescribes the position (token `driven_axis`).
    """

    name: str
    body: str
    anchor: Vector
    axis: Vector
    position: float
    rate: float
    parent: str = field(default="", kw_only=True)
    drive: Callable[[float], float] | None = field(default=None, kw_only=True)


@dataclass(frozen=True)
class Guide:
    """A smooth fixed curve that `body` follows: its centre of mass stands at `curve(coordinate)`."""

    name: str
    body: str
    curve: Callable[[float], Vector]
    coordinate: float
    rate: float


@dataclass(frozen=True)
class Contact:
    """Body against a plane through the origin with unit `normal`: coefficient of restitution and of friction.

    `velocity` is that of the plane's surface, as of a belt (token `moving_surface`). What touches an `adhesive` one stays
    (token `adhesive_contact`). With a `partner` (token
    `body_contact`) body and partner, both spheres, touch each other instead of a plane.
    """

    body: str
    normal: Vector
    restitution: float = 0.0
    friction: float = 0.0
    velocity: Vector = (0.0, 0.0, 0.0)
    adhesive: bool = False
    partner: str = ""


@dataclass(frozen=True)
class Force:
    """A force on the centre of mass of `body`: `law(t, position, velocity)` -> force (N), in space, and its token.

    With a `partner` (token `mutual_force`) place and velocity are those of the body as seen from the partner, on which
    the opposite force acts. `fields(t, position)` -> (a, w), of a charge: `law` is mass (a + velocity x w).
    """

    body: str
    token: str
    law: Callable[[float, Vector, Vector], Vector]
    partner: str = ""
    fields: Callable[[float, Vector], tuple[Vector, Vector]] | None = None


@dataclass(frozen=True)
class Rope:
    """A light rope from `body` through a hole or over a pulley without friction at `hole`, and on to `other` (token `rope`).

    `other` moves along `axis` from the hole; `length(t)` is that of the whole rope, and with no `other` of what is left
    of it; `inertia` is that of the pulley over the square of its radius, for a rope that does not slip (token `pulley`).
    """

    body: str
    hole: Vector
    length: Callable[[float], float]
    other: str = ""
    axis: Vector = (0.0, 0.0, -1.0)
    inertia: float = 0.0


@dataclass(frozen=True)
class Scene:
    """Everything the scene needs, and where it starts."""

    gravity: Vector
    bodies: tuple[Body, ...]
    hinges: tuple[Hinge, ...] = ()
    sliders: tuple[Slider, ...] = ()
    guides: tuple[Guide, ...] = ()
    contacts: tuple[Contact, ...] = ()
    forces: tuple[Force, ...] = ()
    ropes: tuple[Rope, ...] = ()

    @property
    def joints(self) -> tuple[Hinge | Slider, ...]:
        return (*self.hinges, *self.sliders)


@dataclass(frozen=True)
class Readings:
    """What an engine reports at one sample, by name.

    `joints`: (coordinate, rate) of each hinge, slider and guide. `bodies`, those that no joint holds: (position,
    quaternion, velocity, angular velocity), as in Body.
    """

    joints: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    bodies: Mapping[str, tuple[Vector, Quaternion, Vector, Vector]] = field(default_factory=dict)


@dataclass(frozen=True)
class SceneForm:
    """`build(state, parameters)` -> the Scene that starts in that state; `observe(readings, parameters)` -> the state.

    Only where the scene starts may depend on the state: what it consists of is read from build(zeros, parameters).
    `needs` are the tokens that an engine must support, known before anything is built. `conservative` scenes admit the
    staggered start: their accelerations depend on position alone and nothing jumps.
    """

    build: Callable[[tuple[float, ...], tuple[float, ...]], Scene]
    observe: Callable[[Readings, tuple[float, ...]], tuple[float, ...]]
    needs: frozenset[str]
    conservative: bool = True
