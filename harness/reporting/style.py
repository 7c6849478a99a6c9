"""The common style of all figures: colours, shapes and fonts.

Colour shows the library, lightness the order within a family, shape and stroke the family, so that families differ
without colour vision too.
"""

import colorsys
import itertools
from collections.abc import Iterable
from typing import Any

import pandas as pd
from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.contract.declared import declared

STYLE = declared("reporting", "templates/figures.toml")
INK, QUIET, PALE, GRID = (STYLE["inks"][name] for name in ("ink", "quiet", "pale", "grid"))
HUES: dict[str, str] = STYLE["hues"] | {name: one.colour for name, one in LIBRARIES.items() if one.colour}
_OTHER_HUES = ("#8a6d00", "#56B4E9", "#4b4b4b", "#E69F00")
FAMILIES: dict[str, dict[str, Any]] = STYLE["families"]
STATUSES: dict[str, dict[str, str]] = declared("reporting", "templates/statuses.toml")
STATUS_COLOURS = {name: each["colour"] for name, each in STATUSES.items()}
LETTERS = {name: each["letter"] for name, each in STATUSES.items() if "letter" in each}
MEANINGS = {name: each["meaning"] for name, each in STATUSES.items() if "meaning" in each}


def hues(libraries: Iterable[str]) -> dict[str, str]:
    """The colour of each library: its own, or in turn one of the others."""
    others = itertools.cycle(_OTHER_HUES)
    return {name: HUES.get(name) or next(others) for name in libraries}


def family(row: pd.Series) -> str:
    """The kind of method of a series, from the declarations of its integrator."""
    if row["engine"]:
        return "physics engine"
    if row["setting_kind"] == "tolerance":
        return "adaptive step"
    geometric = any(word in str(row["conserves"]) for word in ("symplectic", "volume", "attitude"))
    return "fixed step, geometric" if geometric else "fixed step"


def styles(frame: pd.DataFrame) -> pd.DataFrame:
    """Label, colour, shape and dash of each integrator, sorted by library, family and order."""
    one = frame.drop_duplicates("integrator_id").copy()
    one["engine"] = one["integrator_id"].isin(frame.loc[frame["form"] == "SceneForm", "integrator_id"])
    one["family"] = one.apply(family, axis=1)
    libraries = [name for name in HUES if name in set(one["library"])]
    libraries += sorted(set(one["library"]) - set(HUES))
    place = {name: i for i, name in enumerate(libraries)}
    kind = {name: i for i, name in enumerate(FAMILIES)}
    one = one.assign(lane=one["library"].map(place), kind=one["family"].map(kind))
    one = one.sort_values(["lane", "kind", "order_declared", "integrator_id"], na_position="last")
    hue = hues(libraries)
    shades = {}
    for (library, _), members in one.groupby(["library", "family"], sort=False):
        for i, name in enumerate(members["integrator_id"]):
            share = i / max(len(members) - 1, 1) if len(members) > 1 else 0.6
            shades[name] = _shade(hue[library], share)
    return pd.DataFrame(
        {
            "series": one["integrator_id"],
            "library": one["library"],
            "family": one["family"],
            "colour": [shades[name] for name in one["integrator_id"]],
            "shape": [FAMILIES[name]["shape"] for name in one["family"]],
            "dash": [FAMILIES[name]["dash"] for name in one["family"]],
            "lane": one["lane"],
        }
    ).reset_index(drop=True)


def _shade(colour: str, share: float) -> str:
    """The colour lighter (share 0) to darker (share 1)."""
    red, green, blue = (int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5))
    hue, light, saturation = colorsys.rgb_to_hls(red, green, blue)
    light = 0.60 + (0.22 - 0.60) * share
    return "#" + "".join(f"{round(255 * x):02x}" for x in colorsys.hls_to_rgb(hue, light, min(saturation, 0.85)))


def records(table: pd.DataFrame) -> list[dict[str, Any]]:
    """Rows as Vega reads them, with null for a missing number."""
    return list(table.astype(object).where(table.notna(), None).to_dict("records"))


def dressed(chart: Any, datasets: dict[str, Any] | None = None) -> Any:
    """The chart in the common style: grey axes, no frame, one font; with its data by name."""
    found = chart.configure(**STYLE["config"]).configure_view(stroke=None)
    if datasets is not None:
        found.datasets = datasets  # last: every call before copies all rows
    return found
