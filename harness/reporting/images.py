"""Writes specifications of Vega-Lite as files: a drawing, or the printed figures as small SVG and PNG on all cores."""

import io
import itertools
import os
import re
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from gnomon.harness.system.supervisor import calls, require
from gnomon.reference.storage import diskcache

PNG_SCALE = 1.0
COLOURS = 64
"""Of a PNG file: a drawing has few colours."""
SVG = "{http://www.w3.org/2000/svg}"
INHERITED = (
    *("fill", "stroke", "stroke-width", "stroke-dasharray", "stroke-miterlimit"),
    *("font-family", "font-size", "font-weight", "text-anchor"),
)
"""Attributes that the children of a group inherit from it."""


def write_images(specifications: Mapping[str, dict[str, Any]], folder: Path) -> None:
    """Write each specification as `folder`/name.svg and name.png."""
    folder.mkdir(parents=True, exist_ok=True)
    names = sorted(specifications)
    workers = min(os.cpu_count() or 1, len(names) or 1)
    for _, written in calls(_write, [(specifications[name], folder / name) for name in names], workers, "spawn", False):
        require(written)


def _write(drawing: tuple[dict[str, Any], Path]) -> None:
    import vl_convert  # many megabytes, which a page alone does not need

    specification, path = drawing
    svg = vl_convert.vegalite_to_svg(specification)
    diskcache.replace(path.with_suffix(".svg"), leaner(svg).encode())
    diskcache.replace(path.with_suffix(".png"), smaller(vl_convert.svg_to_png(svg, scale=PNG_SCALE)))


def save(specification: dict[str, Any], path: Path) -> None:
    """Write a drawing, a specification of Vega-Lite with its data, to a file .html, .svg or .png.

    Altair's own way to a file takes seconds to copy and to validate the data.
    """
    import vl_convert  # as above

    if path.suffix == ".html":
        written = vl_convert.vegalite_to_html(specification, bundle=True).encode()
    else:
        svg = vl_convert.vegalite_to_svg(specification)
        written = svg.encode() if path.suffix == ".svg" else vl_convert.svg_to_png(svg, scale=2)
    path.parent.mkdir(parents=True, exist_ok=True)
    diskcache.replace(path, written)


def smaller(png: bytes) -> bytes:
    """The picture with a palette, in fewer bytes; `png` itself unless it is opaque and without one."""
    from PIL import Image  # only printed figures need it

    with Image.open(io.BytesIO(png)) as picture:
        if picture.mode != "RGBA" or picture.getchannel("A").getextrema() != (255, 255):
            return png
        # Maximum coverage finds colours as different as possible, so that a thin line keeps its own beside a large area.
        method = Image.Quantize.MAXCOVERAGE
        palette = picture.convert("RGB").quantize(COLOURS, method, dither=Image.Dither.NONE)
        buffer = io.BytesIO()
        palette.save(buffer, "PNG", optimize=True)
    return buffer.getvalue()


def leaner(svg: str) -> str:
    """The drawing in a third of the characters.

    Coordinates are rounded to a tenth of a pixel; points on straight lines and invisible elements are removed; attributes that all children share
    move to their group; a mark that is drawn several times is defined once.
    """
    ET.register_namespace("", SVG[1:-1])
    root = ET.fromstring(re.sub(r"\d+\.\d{2,}", lambda number: f"{float(number[0]):.1f}", svg))
    _strip(root)
    marks: dict[str, list[ET.Element]] = {}
    for element in root.iter(f"{SVG}path"):
        if "transform" in element.attrib and len(element.attrib["d"]) > 12:
            marks.setdefault(element.attrib["d"], []).append(element)
    repeated = [(shape, uses) for shape, uses in marks.items() if len(uses) > 2]
    definitions = ET.Element(f"{SVG}defs")
    for number, (shape, uses) in enumerate(repeated):
        ET.SubElement(definitions, f"{SVG}path", {"id": f"m{number}", "d": shape})
        for element in uses:
            place = re.fullmatch(r"translate\(([-\d.]+),([-\d.]+)\)", element.attrib["transform"])
            if place is None:
                continue
            del element.attrib["d"], element.attrib["transform"]
            element.tag = f"{SVG}use"
            element.attrib |= {"href": f"#m{number}", "x": place[1], "y": place[2]}
    _hoist(root)
    root.insert(0, definitions)
    return ET.tostring(root, encoding="unicode")


STEPS = re.compile(r"M[-\d.]+,[-\d.]+(?:L[-\d.]+,[-\d.]+){2,}Z?")


def straighten(path: str) -> str:
    """The path without the points between two others on a horizontal or vertical line, and such lines by one number."""
    if not STEPS.fullmatch(path):
        return path
    closed = path.endswith("Z")
    points = [tuple(point.split(",")) for point in re.split("[ML]", path.rstrip("Z"))[1:]]
    corners = points[:1]
    for here, after in itertools.zip_longest(points[1:], points[2:]):
        if here == corners[-1]:
            continue
        if after is None or not any(corners[-1][k] == here[k] == after[k] for k in (0, 1)):
            corners.append(here)
    drawn = [f"M{corners[0][0]},{corners[0][1]}"]
    for (x, y), (u, v) in itertools.pairwise(corners):
        drawn.append(f"H{u}" if v == y else f"V{v}" if u == x else f"L{u},{v}")
    return "".join(drawn) + ("Z" if closed else "")


def _strip(element: ET.Element) -> None:
    """Remove invisible parts: roles, classes, default opacity, empty groups and paths."""
    for name in ("class", "role", "aria-hidden", "aria-label", "aria-roledescription", "pointer-events"):
        element.attrib.pop(name, None)
    if element.attrib.get("opacity") == "1":
        del element.attrib["opacity"]
    if element.attrib.get("transform") == "translate(0,0)":
        del element.attrib["transform"]
    if "d" in element.attrib:
        element.attrib["d"] = straighten(element.attrib["d"])
    for child in list(element):
        _strip(child)
        nothing = child.tag == f"{SVG}path" and not ({"fill", "stroke"} & set(child.attrib))
        if child.attrib.get("display") == "none" or nothing or (child.tag == f"{SVG}g" and not len(child)):
            element.remove(child)


def _hoist(element: ET.Element) -> None:
    """Move attributes of all children to their group; consecutive children with equal attributes become a group."""
    for child in element:
        _hoist(child)
    if element.tag != f"{SVG}g" or len(element) < 2:
        return
    runs = [list(run) for _, run in itertools.groupby(element, lambda child: [child.attrib.get(n) for n in INHERITED])]
    if 1 < len(runs) < len(element) / 2:
        element[:] = [_group_alike(run) for run in runs]
    for name in INHERITED:
        values = {child.attrib.get(name) for child in element}
        value = values.pop()
        if not values and value is not None:
            element.attrib[name] = value
            for child in element:
                del child.attrib[name]


def _group_alike(alike: list[ET.Element]) -> ET.Element:
    if len(alike) == 1:
        return alike[0]
    group = ET.Element(f"{SVG}g")
    group[:] = alike
    _hoist(group)
    return group
