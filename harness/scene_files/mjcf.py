"""A tree of links in MJCF, the format of MuJoCo: everything but restitution, with the start as the keyframe `start`."""

from xml.etree.ElementTree import Element, SubElement

from gnomon.cases.core.scene import Vector
from gnomon.cases.scenes.attitude import in_body, matrix
from gnomon.harness.scene_files.tree import Link, Tree
from gnomon.harness.scene_files.xml import document, number, numbers

SUFFIX = ".xml"
LACKS: frozenset[str] = frozenset()
APART = {"contype": "0", "conaffinity": "0"}
"""A geom that touches nothing but the partners that `contact` names."""
JOINTS = {"hinge": "hinge", "slider": "slide", "ball": "ball"}
USE = (
    'MuJoCo: model = mujoco.MjModel.from_xml_path("{file}"); data = mujoco.MjData(model); '
    "mujoco.mj_resetDataKeyframe(model, data, 0) sets the start"
)


def missing(tree: Tree) -> list[str]:
    """What the file cannot say, and where it is."""
    if any(touch.restitution for touch in tree.touches):
        return ["restitution: in `contacts` of the manifest; MuJoCo's contacts are springs and dampers (solref)"]
    return []


def text(tree: Tree) -> str:
    root = Element("mujoco", model=tree.name)
    # Without these MuJoCo reads degrees, and takes inertia from geoms where a body has none.
    SubElement(root, "compiler", angle="radian", inertiafromgeom="false", balanceinertia="false")
    option = SubElement(root, "option", gravity=numbers(tree.gravity))
    if any(touch.friction for touch in tree.touches):
        option.set("cone", "elliptic")  # by default friction is a pyramid, which differs between directions
    world = SubElement(root, "worldbody")
    for index, normal in enumerate(tree.planes):
        plane = {"name": f"plane_{index}", "type": "plane", "size": "0 0 1", "zaxis": numbers(normal)}
        SubElement(world, "geom", plane | APART)
    start: list[float] = []
    rates: list[float] = []
    for link in tree.carried_by(""):
        _add(world, link, tree, start, rates)
    if tree.touches:
        _add_contacts(root, tree)
    keys = SubElement(root, "keyframe")
    SubElement(keys, "key", name="start", qpos=numbers(start), qvel=numbers(rates))
    return document(root)


def _add(parent: Element, link: Link, tree: Tree, start: list[float], rates: list[float]) -> None:
    """Add the link and those that it carries, and their coordinates and rates in MuJoCo's sequence."""
    x, y, z, w = link.attitude
    body = SubElement(parent, "body", name=link.name, pos=numbers(link.place), quat=numbers((w, x, y, z)))
    SubElement(body, "inertial", pos=numbers(link.centre), mass=number(link.mass), diaginertia=numbers(link.inertia))
    turning = in_body(matrix(link.attitude), link.spin)
    if link.joint == "free":
        SubElement(body, "freejoint", name=link.joint_name)
        start += (*link.place, w, x, y, z)
        rates += (*link.velocity, *turning)
    elif link.joint == "ball":
        SubElement(body, "joint", name=link.joint_name, type="ball")
        start += (1.0, 0.0, 0.0, 0.0)  # relative to the attitude of the body above
        rates += turning
    else:
        SubElement(body, "joint", name=link.joint_name, type=JOINTS[link.joint], axis=numbers(link.axis))
        start.append(link.coordinate)
        rates.append(link.rate)
    size: Vector | tuple[float] | None = link.half_extents if link.radius is None else (link.radius,)
    if size is not None:
        kind = "sphere" if link.radius is not None else "box"
        SubElement(body, "geom", {"name": link.name, "type": kind, "size": numbers(size)} | APART)
    for carried in tree.carried_by(link.name):
        _add(body, carried, tree, start, rates)


def _add_contacts(root: Element, tree: Tree) -> None:
    contact = SubElement(root, "contact")
    for touch in tree.touches:
        other = touch.other or f"plane_{tree.planes.index(touch.normal)}"
        pair = SubElement(contact, "pair", geom1=touch.link, geom2=other, condim="3" if touch.friction else "1")
        if touch.friction:
            pair.set("friction", numbers((touch.friction, touch.friction, 0, 0, 0)))
