"""The JSON files beside a page: read, and validated against `templates/sidecars.schema.json`, by the name of the file.

Keys that the schema does not name are accepted. All texts are made `visible`: control characters are escaped.
"""

import json
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Any

from gnomon.harness.reporting.kept_parts import keep_result
from gnomon.harness.results.visible import visible
from gnomon.reference.numerics.precision import shortened
from jsonschema import Draft202012Validator

MOST_BYTES = 1 << 26
_SCHEMA = json.loads((files("gnomon.harness.reporting") / "templates" / "sidecars.schema.json").read_text("utf-8"))

LEAGUE = "engines.json"
FORMERLY_LISTS = ("certificates.json", "checks.json")
"""Files of earlier revisions had the rows of these alone, without an environment."""
NAMES: tuple[str, ...] = tuple(name for name in _SCHEMA["$defs"] if name.endswith(".json"))
"""The files that may lie beside a page."""


def first(name: str, *folders: Path) -> Any:
    """The contents of the file of this name in the first folder that has it; None without a file."""
    return next((read(folder / name) for folder in folders if (folder / name).is_file()), None)


def read(path: Path) -> Any:
    """The contents of a file. Raises ValueError, which names the file and the place, if it has another shape."""
    if path.stat().st_size > MOST_BYTES:
        raise ValueError(f"{path}: {path.stat().st_size} bytes; a file of gnomon's has at most {MOST_BYTES}")
    content = path.read_bytes()
    inputs = f"{path.name}\n{json.dumps(_SCHEMA)}\n".encode() + content
    return keep_result(
        (__name__, visible.__module__), inputs, lambda: _validate(path, content)
    )  # validation takes seconds


def _validate(path: Path, content: bytes) -> Any:
    try:
        # NaN and Infinity are not JSON: they become texts, which no number may be.
        contents = _visible(json.loads(content.decode(), parse_constant=str))
    except (ValueError, RecursionError) as error:
        reason = "nested too deep" if isinstance(error, RecursionError) else str(error)
        raise ValueError(f"{path}: no JSON of gnomon's ({reason}); make it again, or remove it") from None
    if path.name in FORMERLY_LISTS and isinstance(contents, list):
        contents = {"environment": {}, "rows": contents}
    validator = Draft202012Validator(_SCHEMA | {"$ref": f"#/$defs/{path.name}"})
    wrong = next(validator.iter_errors(contents), None)
    if wrong is not None:
        place = wrong.json_path.removeprefix("$").lstrip(".")[:100] or "the whole"
        fault = f" = {visible(shortened(wrong.instance))}, where {wrong.schema.get('description')} belongs"
        if wrong.validator == "required":
            fault = f": {wrong.message}"
        raise ValueError(f"{path}: {place}{fault}; make it again, or remove it")
    if path.name == LEAGUE:
        _refuse_unnamed(path, contents)
    return contents


def _refuse_unnamed(path: Path, contents: Mapping[str, Any]) -> None:
    """Raise ValueError for a row of the league whose integrator or scene is not among those of the file."""
    named = {
        "integrator": {engine["id"] for engine in contents["engines"]},
        "scene": {scene["scene"] for scene in contents["scenes"]},
    }
    for place, row in enumerate(contents["rows"]):
        for key, members in named.items():
            if row[key] not in members:
                value = visible(shortened(row[key]))
                raise ValueError(
                    f"{path}: rows[{place}].{key} = {value}, which the file does not describe; make it again, or remove it"
                )


def _visible(value: Any) -> Any:
    """The value with all texts, keys too, made visible."""
    if isinstance(value, dict):
        return {visible(key): _visible(member) for key, member in value.items()}
    if isinstance(value, list):
        return [_visible(member) for member in value]
    return visible(value) if isinstance(value, str) else value
