"""A tree of links in SDFormat 1.9, which Gazebo and Drake read: the first version with quaternions."""

from xml.etree.ElementTree import Element, SubElement

from gnomon.cases.core.scene import IDENTITY, Quaternion, Vector
from gnomon.harness.adapters.engines.vectors import ORIGIN
from gnomon.harness.scene_files.tree import Link, Touch, Tree
from gnomon.harness.scene_files.xml import document, number, numbers

SUFFIX = ".sdf"
LACKS: frozenset[str] = frozenset()
JOINTS = {"hinge": "revolute", "slider": "prismatic", "ball": "ball"}
USE = (
    'Drake: Parser(plant).AddModels("{file}"), which warns that it ignores gravity: plant.mutable_gravity_field()'
    ".set_gravity_vector(...) sets it; the start is in the manifest"
)


def missing(tree: Tree) -> list[str]:
    """What the file cannot say, and where it is."""
    lines = [
        "rates at the start, and coordinates of hinges and sliders: in `start` of the manifest; poses are those at zero"
    ]
    if tree.touches:
        lines.append(
            "the rule by which an engine combines two surfaces: both have the coefficients of `contacts`, as for a minimum,"
            " a maximum or a mean"
        )
    return lines


def text(tree: Tree) -> str:
    root = Element("sdf", version="1.9")
    world = SubElement(root, "world", name=tree.name)
    SubElement(world, "gravity").text = numbers(tree.gravity)
    for index, normal in enumerate(tree.planes):
        _add_plane(world, index, normal, next(touch for touch in tree.touches if touch.normal == normal))
    for first in tree.carried_by(""):
        _add(SubElement(world, "model", name=f"{first.name}_model"), first, tree)
    return document(root)


def _pose(parent: Element, place: Vector, attitude: Quaternion, frame: str = "") -> None:
    pose = SubElement(parent, "pose")
    if frame:
        pose.set("relative_to", frame)
    if attitude == IDENTITY:
        pose.text = numbers((*place, *ORIGIN))
    else:
        pose.set("rotation_format", "quat_xyzw")
        pose.text = numbers((*place, *attitude))


def _add(model: Element, link: Link, tree: Tree) -> None:
    element = SubElement(model, "link", name=link.name)
    _pose(element, link.place, link.attitude, link.parent)
    inertial = SubElement(element, "inertial")
    _pose(inertial, link.centre, IDENTITY)
    SubElement(inertial, "mass").text = number(link.mass)
    inertia = SubElement(inertial, "inertia")
    for name, value in zip(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), (*link.inertia, *ORIGIN), strict=True):
        SubElement(inertia, name).text = number(value)
    if link.radius is not None or link.half_extents is not None:
        collision = SubElement(element, "collision", name=f"{link.name}_surface")
        geometry = SubElement(collision, "geometry")
        if link.radius is not None:
            SubElement(SubElement(geometry, "sphere"), "radius").text = number(link.radius)
        elif link.half_extents is not None:
            SubElement(SubElement(geometry, "box"), "size").text = numbers(2 * x for x in link.half_extents)
        _add_surface(collision, next(touch for touch in tree.touches if link.name in (touch.link, touch.other)))
    if link.joint != "free":
        joint = SubElement(model, "joint", name=link.joint_name, type=JOINTS[link.joint])
        SubElement(joint, "parent").text = link.parent or "world"
        SubElement(joint, "child").text = link.name
        if link.joint != "ball":
            SubElement(SubElement(joint, "axis"), "xyz").text = numbers(link.axis)
    for carried in tree.carried_by(link.name):
        _add(model, carried, tree)


def _add_plane(world: Element, index: int, normal: Vector, touch: Touch) -> None:
    model = SubElement(world, "model", name=f"plane_{index}")
    SubElement(model, "static").text = "true"
    collision = SubElement(SubElement(model, "link", name="ground"), "collision", name="surface")
    plane = SubElement(SubElement(collision, "geometry"), "plane")
    SubElement(plane, "normal").text = numbers(normal)
    SubElement(plane, "size").text = "1 1"
    _add_surface(collision, touch)


def _add_surface(collision: Element, touch: Touch) -> None:
    surface = SubElement(collision, "surface")
    bounce = SubElement(surface, "bounce")
    SubElement(bounce, "restitution_coefficient").text = number(touch.restitution)
    SubElement(bounce, "threshold").text = "0.0"  # by default so large that nothing bounces
    friction = SubElement(SubElement(surface, "friction"), "ode")
    for name in ("mu", "mu2"):
        SubElement(friction, name).text = number(touch.friction)
