"""The common style of all figures: colours, shapes and fonts.

Colour shows the library, shape and stroke the family of methods. gnomon's own methods are grey until a reader colours them.
"""

import re
from typing import Any

import pandas as pd
from gnomon.cases.core.numbers import nearest
from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.contract.declared import read_declared
from gnomon.harness.results.profiles import OURS

_DECLARED = read_declared("reporting", "templates/colours.toml")
_PAIRS = {name: pair for name, pair in _DECLARED["figures"].items() if isinstance(pair, list)}
COLOURS: dict[str, str] = _DECLARED["figures"] | {name: light for name, (light, _) in _PAIRS.items()}
"""The colours of figures by name."""
DARK: dict[str, str] = dict(_PAIRS.values())
"""By colour, its counterpart on a dark page."""
PAGE: dict[str, list[str]] = _DECLARED["page"]
"""The colours of the page by name, each on a light page and on a dark one."""
DOCUMENT: dict[str, str] = _DECLARED["document"]
LINES: list[str] = _DECLARED["sequences"]["lines"]
SHARE: list[str] = _DECLARED["sequences"]["share"]
INK, QUIET, PALE, GRID, EDGE, OWN_GREY = (COLOURS[name] for name in ("ink", "quiet", "pale", "grid", "edge", "own"))


def find_colour(name: str) -> str:
    """The colour of figures with this name; ValueError for an unknown one."""
    if name not in COLOURS:
        raise ValueError(f"no colour is called {name!r} in templates/colours.toml; {nearest(name, COLOURS)}")
    return COLOURS[name]


HUES = {name: find_colour(library.colour) for name, library in LIBRARIES.items() if library.colour} | {OURS: OWN_GREY}
STYLE = read_declared("reporting", "templates/figures.toml")
DRESS: dict[str, Any] = {
    part: {key: find_colour(value) if key.lower().endswith("color") else value for key, value in setting.items()}
    if isinstance(setting, dict)
    else setting
    for part, setting in STYLE["config"].items()
} | {"view": {"stroke": None}}
"""The common style as Vega-Lite's configuration: grey axes, no frame, one font."""
FAMILIES: dict[str, dict[str, Any]] = STYLE["families"]
STATUSES: dict[str, dict[str, str]] = read_declared("reporting", "templates/statuses.toml")
STATUS_COLOURS: dict[str, str] = _DECLARED["statuses"]
LETTERS = {name: each["letter"] for name, each in STATUSES.items() if "letter" in each}
MEANINGS = {name: each["meaning"] for name, each in STATUSES.items() if "meaning" in each}


def hue(library: str) -> str:
    """The colour of a library; of one that the run was given, the colour of text."""
    return str(HUES.get(library, INK))


def apply_theme(text: str) -> str:
    """A drawing, or its specification as JSON, with the colours of `DARK` as variables of the page's style sheet."""
    return re.sub(
        "#[0-9a-fA-F]{6}",
        lambda match: f"var(--x{match[0][1:].lower()})" if match[0].lower() in DARK else match[0],
        text,
    )


def apply_theme_to_values(value: Any) -> Any:
    """A copy of a specification, or of several, with its colours as in `apply_theme`."""
    if isinstance(value, str):
        return apply_theme(value) if value.startswith("#") else value
    if isinstance(value, dict):
        return {name: apply_theme_to_values(each) for name, each in value.items()}
    return [apply_theme_to_values(each) for each in value] if isinstance(value, list | tuple) else value


def family(row: pd.Series) -> str:
    """The kind of method of a series, from the declarations of its integrator."""
    if row["engine"]:
        return "physics engine"
    if row["setting_kind"] == "tolerance":
        return "adaptive step"
    geometric = any(word in str(row["conserves"]) for word in ("symplectic", "volume", "attitude"))
    return "fixed step, geometric" if geometric else "fixed step"


def styles(frame: pd.DataFrame) -> pd.DataFrame:
    """Label, colour, shape and dash of each integrator, third parties first, sorted by library, family and order."""
    rows = frame.drop_duplicates("integrator_id").copy()
    rows["engine"] = rows["integrator_id"].isin(frame.loc[frame["form"] == "SceneForm", "integrator_id"])
    rows["family"] = rows.apply(family, axis=1)
    libraries = [name for name in HUES if name in set(rows["library"])]
    libraries += sorted(set(rows["library"]) - set(HUES))
    place = {name: i for i, name in enumerate(libraries)}
    kind = {name: i for i, name in enumerate(FAMILIES)}
    rows = rows.assign(lane=rows["library"].map(place), kind=rows["family"].map(kind))
    rows = rows.sort_values(["lane", "kind", "order_declared", "integrator_id"], na_position="last")
    return pd.DataFrame(
        {
            "series": rows["integrator_id"],
            "library": rows["library"],
            "family": rows["family"],
            "colour": [hue(name) for name in rows["library"]],
            "shape": [FAMILIES[name]["shape"] for name in rows["family"]],
            "dash": [FAMILIES[name]["dash"] for name in rows["family"]],
            "lane": rows["lane"],
        }
    ).reset_index(drop=True)


def records(table: pd.DataFrame) -> list[dict[str, Any]]:
    """Rows as Vega reads them, with null for a missing number."""
    return list(table.astype(object).where(table.notna(), None).to_dict("records"))


def dress(chart: Any, datasets: dict[str, Any] | None = None) -> Any:
    """The chart in the common style: grey axes, no frame, one font; with its data by name."""
    dressed = chart.configure(**DRESS)
    if datasets is not None:
        dressed.datasets = datasets  # last: every call before copies all rows
    return dressed
