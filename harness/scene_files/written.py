"""A scene as three files: the scene itself, its exact motion as CSV, and a manifest with their hashes and what they lack."""

import hashlib
import json
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

from gnomon.cases.core.case import Case
from gnomon.cases.core.scene import TOKENS
from gnomon.harness.scene_files import mjcf, sdf, urdf
from gnomon.harness.scene_files.motion import motion_of
from gnomon.harness.scene_files.tree import STATED, Link, Tree, tree_of
from gnomon.reference.storage import diskcache
from gnomon.reference.storage.version import VERSION

SCHEMA_VERSION = 1
FORMATS: dict[str, ModuleType] = {"mjcf": mjcf, "sdf": sdf, "urdf": urdf}


@dataclass(frozen=True)
class Written:
    """Three files, with what the scene lacks and how to load it."""

    scene: Path
    motion: Path
    manifest: Path
    missing: tuple[str, ...]
    replaced: tuple[str, ...]
    use: str


def list_unstated(needs: Iterable[str], form: str) -> list[str]:
    """The tokens of a scene that a file of this format cannot state."""
    return sorted(set(needs) - (STATED - FORMATS[form].LACKS))


def write(case: Case, form: str, folder: Path) -> Written:
    """Write the scene of a case to a folder, in numbers that are rounded to binary64.

    Raises ValueError if the case has no scene, or one that the format cannot state.
    """
    case, language = case.rounded(), FORMATS[form]
    if case.scene is None:
        raise ValueError(
            f"{case.id} has no scene; gnomon scene --list --format {form} lists those that {form} can state"
        )
    if lacking := list_unstated(case.scene.needs, form):
        named = ", ".join(f"{token} ({TOKENS[token]})" for token in lacking)
        raise ValueError(
            f"{case.id}: no {form} file can state {named}; gnomon scene --list --format {form} lists the scenes that it can"
        )
    tree = tree_of(case)
    units, table_text = motion_of(case)
    name = f"{tree.name}_{form}"
    files = {f"{name}{language.SUFFIX}": language.text(tree), f"{name}.csv": table_text}
    manifest = json.dumps(_manifest(case, tree, form, files) | {"columns": units}, indent=1, ensure_ascii=False) + "\n"
    scene, table, described = (folder / each for each in (*files, f"{name}.json"))
    for path, text in ((scene, files[scene.name]), (table, files[table.name]), (described, manifest)):
        diskcache.replace(path, text.encode())
    use = language.USE.format(file=scene.name)
    return Written(scene, table, described, (*language.missing(tree),), describe_replaced(tree), use)


def describe_replaced(tree: Tree) -> tuple[str, ...]:
    """How bodies of the file differ from the point masses of the scene."""
    return tuple(link.replaced for link in tree.links if link.replaced)


def _manifest(case: Case, tree: Tree, form: str, files: dict[str, str]) -> dict[str, Any]:
    numbers = {
        name: {"decimal": repr(float(value)), "hexadecimal": float(value).hex()} for name, value in case.numbers.items()
    }
    return {
        "schema_version": SCHEMA_VERSION,
        "gnomon": VERSION,
        "case": case.id,
        "format": form,
        "sha256": {name: hashlib.sha256(text.encode()).hexdigest() for name, text in files.items()},
        "parameters": {each.name: {**numbers[each.name], "unit": each.unit} for each in case.parameter_list},
        "initial_state": {each.name: {**numbers[each.name], "unit": each.unit} for each in case.state},
        "gravity": tree.gravity,
        "start": {
            "joints": {
                link.joint_name: {"position": link.coordinate, "rate": link.rate}
                for link in tree.links
                if link.joint in ("hinge", "slider")
            },
            "bodies": {link.name: _start(link) for link in tree.links if link.joint in ("ball", "free")},
        },
        "contacts": [
            {
                "body": touch.link,
                **({"other": touch.other} if touch.other else {"plane": touch.normal}),
                "restitution": touch.restitution,
                "friction": touch.friction,
            }
            for touch in tree.touches
        ],
        "missing": FORMATS[form].missing(tree),
        "replaced": describe_replaced(tree),
        "accuracy": "each value of `state` is within 0.51 ulp of the exact motion; readings follow from it in binary64",
    }


def _start(link: Link) -> dict[str, Any]:
    """Of the body's `point` in the link's frame, as the columns of the motion."""
    parts: dict[str, Any] = {"joint": link.joint, "frame": link.place, "quaternion": link.attitude, "point": link.point}
    return parts | {"velocity": link.velocity, "angular_velocity": link.spin}
