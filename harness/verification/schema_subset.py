"""Validates JSON against those words of JSON Schema that the description of a program needs: its library is five packages."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

KINDS: Mapping[str, type | tuple[type, ...]] = {
    "object": dict,
    "array": list,
    "string": str,
    "boolean": bool,
    "null": type(None),
    "number": (int, float),
}
Schema = Mapping[str, Any]


class Wrong(NamedTuple):
    """A part of a value that the schema does not admit."""

    place: str
    value: Any
    rule: str


def faults(schema: Schema, value: Any, place: str = "") -> Iterator[Wrong]:
    """What is wrong in a value, in the order of its schema. `$ref` and conditions are the caller's."""
    kinds = schema.get("type", ())
    kinds = [kinds] if isinstance(kinds, str) else kinds
    if (kinds and not any(_is(kind, value) for kind in kinds)) or not _admitted(schema, value):
        yield Wrong(place, value, f"it is {schema.get('description')}")
        return
    if isinstance(value, dict):
        for name, part in schema.get("properties", {}).items():
            if name in value:
                yield from faults(part, value[name], f"{place}.{name}".lstrip("."))
        for name in schema.get("required", ()):
            if name not in value:
                yield Wrong(place, value, f"{name!r} is a required property")
    if isinstance(value, list) and "items" in schema:
        for k, part in enumerate(value):
            yield from faults(schema["items"], part, f"{place}[{k}]")


def _is(kind: str, value: Any) -> bool:
    if kind == "integer":
        return _is("number", value) and bool(value % 1 == 0)
    return isinstance(value, KINDS[kind]) and (kind == "boolean" or not isinstance(value, bool))


def _admitted(schema: Schema, value: Any) -> bool:
    """Whether a value of the right type is one of those that the schema admits."""
    wanted: Sequence[Any] = [schema["const"]] if "const" in schema else schema.get("enum", [value])
    if not any(one == value and isinstance(one, bool) == isinstance(value, bool) for one in wanted):
        return False
    if isinstance(value, str):
        return len(value) >= int(schema.get("minLength", 0))
    if not _is("number", value):
        return True
    low, high = schema.get("minimum", value), schema.get("maximum", value)
    return bool(low <= value <= high and ("exclusiveMinimum" not in schema or value > schema["exclusiveMinimum"]))
