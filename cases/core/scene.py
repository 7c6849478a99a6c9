"""Scenes for physics engines: bodies, joints, forces and contacts."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

Vector = tuple[float, float, float]
Quaternion = tuple[float, float, float, float]
IDENTITY: Quaternion = (0.0, 0.0, 0.0, 1.0)

TOKENS: Mapping[str, str] = {
    "gyroscopic": "the attitude of a free body that turns about more than one axis",
    "hinge": "a body on a hinge that is fixed in space",
    "slider": "a body on a rail that is fixed in space",
    "linked_joint": "a joint on a body that moves along a rail",
    "chained_hinges": "a hinge on a body that turns on a hinge",
    "ball_joint": "a body whose fixed point is the origin",
    "rod": "a point mass at a constant distance from the origin",
    "position_force": "forces that depend on position",
    "velocity_force": "forces that depend on velocity",
    "time_force": "forces that depend on time",
    "mutual_force": "forces between two bodies",
    "torque": "torques that depend on time or attitude",
    "drag_torque": "torques that depend on the angular velocity",
    "impulse": "blows at given times",
    "driven_axis": "a rail, or the length of a rope, whose position is prescribed",
    "driven_frame": "a frame that rotates at a prescribed rate",
    "joint_friction": "dry friction of a hinge",
    "rope": "a massless rope through a hole or over a pulley",
    "pulley": "a pulley with inertia, on which the rope does not slip",
    "unwinding_string": "a string that unwinds from the body",
    "belt": "a belt that slips, then grips",
    "linkage": "a linkage of rods and a sleeve",
    "rigid_impact": "impacts by Newton's law of restitution",
    "body_contact": "contact of two moving bodies",
    "adhesion": "a body that sticks to another when it touches",
    "adhesive_contact": "a body that sticks to a plane when it touches",
    "coulomb_isotropic": "sliding and rolling with dry friction on a plane, equal in all directions",
    "static_friction": "a coefficient of static friction above the kinetic one",
    "drill_friction": "a contact patch whose friction resists rotation about its normal",
    "moving_surface": "a plane whose surface moves",
    "thin_rod_contact": "the ends of a thin rod that slide on floor and wall",
    "disc_contact": "the sharp edge of a disc on a plane",
    "rolling_without_slip": "rolling without slip as a constraint",
    "curved_guide": "a smooth curve that a body follows",
    "curved_surface": "a smooth surface on which a body moves",
    "loss_of_contact": "a guide that holds on one side only",
    "knife_edge": "a blade that moves only along its edge",
}
"""What a scene may need from an engine beyond free bodies under gravity."""


@dataclass(frozen=True)
class Body:
    """A rigid body, SI units. `inertia`: principal moments about the centre of mass, along the body axes; 0 for a point mass.

    `radius` (sphere) or `half_extents` (box) is given only if the body touches something. `quaternion` is
    (x, y, z, w), body -> space; position (of the centre of mass) and velocities are in space.

    Examples
    --------
    >>> Body("ball", mass=2.0, inertia=(0.0, 0.0, 0.0), position=(0.0, 0.0, 1.0)).velocity
    (0.0, 0.0, 0.0)
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

    At angle zero `arm` points from the anchor to the body's centre of mass; `angle` and `rate` are the initial values.
    With a `parent` (token `linked_joint` or `chained_hinges`) the anchor is a point of that body, relative to its centre of
    mass. `friction`: a torque of this size (N m) opposes the rate until the hinge stops (token `joint_friction`).

    Examples
    --------
    >>> swing = Hinge("pivot", "rod", (0, 0, 0), (0, 1, 0), arm=(0, 0, -1), angle=0.5, rate=0.0)
    >>> swing.axis
    (0, 1, 0)
    """

    name: str
    body: str
    anchor: Vector
    axis: Vector
    arm: Vector
    angle: float
    rate: float
    parent: str = field(default="", kw_only=True)
    friction: float = field(default=0.0, kw_only=True)


@dataclass(frozen=True)
class Slider:
    """A prismatic joint between the world and `body`, whose centre of mass is at `anchor` + `position` * `axis`.

    With a `parent` (token `linked_joint`) the anchor is a point of that body, relative to its centre of mass. `drive(t)`
    prescribes the position (token `driven_axis`).

    Examples
    --------
    >>> Slider("rail", "cart", (0, 0, 0), (1, 0, 0), position=0.25, rate=0.0).position
    0.25
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
    """A smooth fixed curve that `body` follows: its centre of mass is at `curve(coordinate)`.

    Examples
    --------
    >>> wire = Guide("wire", "bead", lambda s: (s, 0.0, s * s), coordinate=0.5, rate=0.0)
    >>> wire.curve(0.5)
    (0.5, 0.0, 0.25)
    """

    name: str
    body: str
    curve: Callable[[float], Vector]
    coordinate: float
    rate: float


@dataclass(frozen=True)
class Contact:
    """Contact of a body with a plane through the origin with unit `normal`; coefficients of restitution and friction.

    `velocity` is the velocity of the plane's surface, for example of a belt (token `moving_surface`). A body that touches an
    `adhesive` plane sticks to it (token `adhesive_contact`). With a `partner` (token `body_contact`) body and partner,
    both spheres, touch each other instead of a plane.

    Examples
    --------
    >>> Contact("ball", (0, 0, 1), restitution=0.9).friction
    0.0
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
    """A force on the centre of mass of `body`: `law(t, position, velocity)` -> force (N) in space; `token` is its kind.

    With a `partner` (token `mutual_force`) position and velocity are relative to the partner, on which the opposite force
    acts. For a charge `fields(t, position)` -> (a, w), and `law` is mass (a + velocity x w).

    Examples
    --------
    >>> drag = Force("ball", "velocity_force", lambda t, x, v: tuple(-0.5 * each for each in v))
    >>> drag.law(0, (0, 0, 0), (2, 0, 0))[0]
    -1.0
    """

    body: str
    token: str
    law: Callable[[float, Vector, Vector], Vector]
    partner: str = ""
    fields: Callable[[float, Vector], tuple[Vector, Vector]] | None = None


@dataclass(frozen=True)
class Torque:
    """A torque on `body`: `law(t, quaternion, angular_velocity)` -> torque (N m) in space.

    `token` is its kind: `drag_torque` if it depends on the angular velocity, else `torque`.

    Examples
    --------
    >>> brake = Torque("top", "drag_torque", lambda t, attitude, spin: tuple(-0.1 * each for each in spin))
    >>> brake.law(0, IDENTITY, (0, 0, 5))[2]
    -0.5
    """

    body: str
    token: str
    law: Callable[[float, Quaternion, Vector], Vector]


@dataclass(frozen=True)
class Impulse:
    """A blow on `body` at `time` (token `impulse`): `linear` (N s) at its centre of mass, and a couple `angular` (N m s), in space.

    Examples
    --------
    >>> Impulse("ball", 0.5, linear=(0, 0, 2)).angular
    (0.0, 0.0, 0.0)
    """

    body: str
    time: float
    linear: Vector = (0.0, 0.0, 0.0)
    angular: Vector = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Rope:
    """A massless rope from `body` to `other` (token `rope`), through a smooth hole or over a pulley at `hole`.

    `other` moves along `axis` from the hole. `length(t)` is the length of the rope; without `other` the part between body
    and hole. `inertia`: moment of the pulley over the square of its radius; the rope does not slip (token `pulley`).
    """

    body: str
    hole: Vector
    length: Callable[[float], float]
    other: str = ""
    axis: Vector = (0.0, 0.0, -1.0)
    inertia: float = 0.0


@dataclass(frozen=True)
class Scene:
    """Everything that a physics engine is given, with the initial state.

    Examples
    --------
    >>> Scene((0, 0, -9.81), (Body("ball", 1.0, (0, 0, 0)),)).joints
    ()
    """

    gravity: Vector
    bodies: tuple[Body, ...]
    hinges: tuple[Hinge, ...] = ()
    sliders: tuple[Slider, ...] = ()
    guides: tuple[Guide, ...] = ()
    contacts: tuple[Contact, ...] = ()
    forces: tuple[Force, ...] = ()
    ropes: tuple[Rope, ...] = ()
    torques: tuple[Torque, ...] = ()
    impulses: tuple[Impulse, ...] = ()

    @property
    def joints(self) -> tuple[Hinge | Slider, ...]:
        return (*self.hinges, *self.sliders)


@dataclass(frozen=True)
class Readings:
    """The state that an engine reads at one sample time, by name.

    Attributes
    ----------
    joints : mapping
        (coordinate, rate) of each hinge, slider and guide: m and m/s, or rad and rad/s.
    bodies : mapping
        (position, quaternion, velocity, angular velocity) of each body without a joint, as in `Body`.

    Examples
    --------
    >>> Readings(bodies={"ball": ((0, 0, 1), IDENTITY, (0, 0, -3), (0, 0, 0))}).bodies["ball"][0]
    (0, 0, 1)
    """

    joints: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    bodies: Mapping[str, tuple[Vector, Quaternion, Vector, Vector]] = field(default_factory=dict)


Observe = Callable[[Readings, Sequence[float]], tuple[float, ...]]


def joint(name: str) -> Observe:
    """Read the coordinate and the rate of a joint as the state.

    Parameters
    ----------
    name : str
        The name of the joint.

    Returns
    -------
    callable
        For the argument `observe` of a `SceneForm`.

    Examples
    --------
    >>> joint("pivot")(Readings(joints={"pivot": (0.1, 2.0)}), ())
    (0.1, 2.0)
    """
    return lambda readings, parameters: readings.joints[name]


def free_body(name: str, *axes: int) -> Observe:
    """Read position and velocity of a body without a joint as the state.

    Parameters
    ----------
    name : str
        The name of the body.
    *axes : int
        The axes of the engine (0, 1, 2) along which the state has coordinates.

    Returns
    -------
    callable
        For the argument `observe` of a `SceneForm`.

    Examples
    --------
    >>> free_body("ball", 0, 2)(Readings(bodies={"ball": ((0, 0, 1), IDENTITY, (4, 0, -3), (0, 0, 0))}), ())
    (0, 1, 4, -3)
    """
    return lambda readings, parameters: tuple(readings.bodies[name][part][axis] for part in (0, 2) for axis in axes)


@dataclass(frozen=True)
class SceneForm:
    """A case as a scene: `build(state, parameters)` -> Scene in that state, `observe(readings, parameters)` -> state.

    The state may determine only initial positions and velocities: bodies, joints and forces are read from
    build(zeros, parameters). `needs` are the tokens that an engine must support, known before a scene is built. A scene is
    `conservative` if accelerations depend on position alone and nothing jumps; it admits the staggered start.

    Examples
    --------
    >>> from gnomon.cases import get
    >>> sorted(get("pendulum_simple").scene.needs)
    ['hinge']
    """

    build: Callable[[tuple[float, ...], tuple[float, ...]], Scene]
    observe: Callable[[Readings, tuple[float, ...]], tuple[float, ...]]
    needs: frozenset[str]
    conservative: bool = True
