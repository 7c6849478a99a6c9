"""A tree of links in URDF, the format of ROS: one tree, without gravity, planes, coefficients of contact or a start."""

from xml.etree.ElementTree import Element, SubElement

from gnomon.harness.adapters.engines.vectors import ORIGIN
from gnomon.harness.scene_files.tree import Link, Tree
from gnomon.harness.scene_files.xml import document, number, numbers

SUFFIX = ".urdf"
LACKS = frozenset({"ball_joint", "rod", "body_contact"})
"""Its joints have one axis or are free; one file holds one tree, so no second free body."""
JOINTS = {"hinge": "continuous", "slider": "prismatic"}
FAR = 1e9
"""A rail needs limits (m, N, m/s)."""
USE = (
    'PyBullet: loadURDF("{file}", flags=URDF_USE_INERTIA_FROM_FILE, useFixedBase=...), True if the file has a link `world`;'
    " gravity and the start are in the manifest"
)


def missing(tree: Tree) -> list[str]:
    """What the file cannot say, and where it is."""
    lines = [
        "gravity: in `gravity` of the manifest",
        "the start: in `start` of the manifest; the file has coordinate zero",
    ]
    if tree.touches:
        lines.append("planes, friction and restitution: in `contacts` of the manifest")
    return lines


def text(tree: Tree) -> str:
    root = Element("robot", name=tree.name)
    if any(link.joint != "free" for link in tree.links):
        SubElement(root, "link", name="world")
    for link in tree.links:
        _add(root, link)
    return document(root)


def _add(root: Element, link: Link) -> None:
    element = SubElement(root, "link", name=link.name)
    inertial = SubElement(element, "inertial")
    SubElement(inertial, "origin", xyz=numbers(link.centre), rpy="0 0 0")
    SubElement(inertial, "mass", value=number(link.mass))
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    SubElement(inertial, "inertia", dict(zip(names, map(number, (*link.inertia, *ORIGIN)), strict=True)))
    if link.radius is not None or link.half_extents is not None:
        geometry = SubElement(SubElement(element, "collision"), "geometry")
        if link.radius is not None:
            SubElement(geometry, "sphere", radius=number(link.radius))
        elif link.half_extents is not None:
            SubElement(geometry, "box", size=numbers(2 * x for x in link.half_extents))
    if link.joint != "free":
        joint = SubElement(root, "joint", name=link.joint_name, type=JOINTS[link.joint])
        SubElement(joint, "parent", link=link.parent or "world")
        SubElement(joint, "child", link=link.name)
        SubElement(joint, "origin", xyz=numbers(link.place), rpy="0 0 0")
        SubElement(joint, "axis", xyz=numbers(link.axis))
        if link.joint == "slider":
            far = number(FAR)
            SubElement(joint, "limit", lower=number(-FAR), upper=far, effort=far, velocity=far)
        SubElement(joint, "dynamics", damping="0.0", friction="0.0")
