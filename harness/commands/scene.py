"""`gnomon scene`: a scene and its exact motion as files, for engines and their tests."""

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer
from gnomon.harness.commands import options
from gnomon.harness.commands.options import Shown, out
from rich.box import SIMPLE_HEAD
from rich.table import Column, Table

WIDTH = 100
"""Columns of the list of scenes, so that each has one line."""


class SceneFormat(StrEnum):
    """The formats that `gnomon scene` writes."""

    mjcf = "mjcf"
    urdf = "urdf"
    sdf = "sdf"


def scene(
    case: options.CaseArgument = None,
    named: options.CaseOption = None,
    variant: Annotated[str | None, typer.Option(help="A variant of the case; the same as case/variant.")] = None,
    form: Annotated[SceneFormat, typer.Option("--format", help="The format of the scene.")] = SceneFormat.mjcf,
    to: Annotated[Path | None, options.path_option("The folder to write to.", "--out")] = None,
    parameters: options.Parameters = None,
    listed: Annotated[bool, typer.Option("--list", help="List the scenes that the format can state.")] = False,
) -> None:
    """Write a scene as MJCF, URDF or SDF, its exact motion as CSV, and a manifest with hashes and what the file lacks."""
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.harness.scene_files import written

    from gnomon import cases

    if listed:
        if case or named or to:
            raise ValueError("--list lists all scenes: leave out the case and --out")
        Shown(width=options.columns(WIDTH), emoji=False).print(scenes_table(form.value))
        return
    name = options.one_case(case, named)
    if name.partition("/")[0] in cases.check_names():
        raise ValueError(f"{name} is a check, without motion: it has no scene")
    if variant is not None and "/" in name:
        raise ValueError(f"--variant {variant}: {name} names a variant already")
    if to is None:
        raise ValueError("name the folder to write to with --out")
    chosen = options.choose_one(name if variant is None else f"{name}/{variant}", parameters)
    options.ensure_folder(to, "--out")
    files = written.write(chosen, form.value, to)
    for path, what in ((files.scene, "scene"), (files.motion, "exact motion"), (files.manifest, "manifest")):
        out.print(f"wrote {path}: {what}", highlight=False, markup=False)
    for title, lines in (("not in the file", files.missing), ("replaced", files.replaced), ("load it", [files.use])):
        for line in lines:
            out.print(f"{title}: {line}", highlight=False, markup=False)


def scenes_table(form: str) -> Table:
    """The scenes that a format can state, then the tokens that keep out each of the others."""
    from gnomon.harness.scene_files.written import list_unstated

    from gnomon import cases

    scenes = {name: each.needs for name in cases.names() if (each := cases.get(name).scene) is not None}
    lacking = {name: list_unstated(needs, form) for name, needs in scenes.items()}
    able = sum(not each for each in lacking.values())
    title = f"{form} can state {able} of {len(scenes)} scenes"
    table = Table(
        Column("scene", no_wrap=True), "the format cannot state", title=title, box=SIMPLE_HEAD, padding=(0, 1)
    )
    for name in sorted(lacking, key=lambda name: bool(lacking[name])):
        table.add_row(name, ", ".join(lacking[name]))
    return table
