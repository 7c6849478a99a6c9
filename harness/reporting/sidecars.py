"""The JSON files beside a page: read, and validated against the shape that each must have.

A shape is a dictionary of shapes by key, a list with the shape of its members, or a `Kind`. Keys that a shape does not
name are accepted. All texts are made `visible`: control characters are escaped.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from gnomon.harness.results.visible import visible
from gnomon.reference.numerics.precision import shortened

MOST_BYTES = 1 << 26
LARGEST = 1e300
"""Whole numbers above this do not fit a double."""


class Kind(NamedTuple):
    """What a value may be: a predicate, and its description for error messages."""

    holds: Callable[[Any], bool]
    words: str

    def or_null(self) -> Kind:
        return Kind(lambda value: value is None or self.holds(value), f"{self.words} or null")


class Optional(NamedTuple):
    """A key that may be missing."""

    shape: Any


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) < LARGEST


NUMBER = Kind(_number, "a finite number")
SIZE = Kind(lambda value: _number(value) and value >= 0, "a finite number, at least 0")
POSITIVE = Kind(lambda value: _number(value) and value > 0, "a finite number above 0")
WHOLE = Kind(lambda value: _number(value) and isinstance(value, int), "a whole number")
TEXT = Kind(lambda value: isinstance(value, str), "a text")
FLAG = Kind(lambda value: isinstance(value, bool), "true or false")
NUMERAL = Kind(
    lambda value: (
        isinstance(value, str) and re.fullmatch(r"[0-9]{1,9}(\.[0-9]+)?(e[+-]?[0-9]{1,3})?", value) is not None
    ),
    "a number as text",
)
TEXTS = Kind(
    lambda value: isinstance(value, dict) and all(text is None or isinstance(text, str) for text in value.values()),
    "an object of texts",
)
NUMBERS = Kind(lambda value: isinstance(value, dict) and all(map(_number, value.values())), "an object of numbers")


def one_of(words: Mapping[str, Any] | tuple[str, ...]) -> Kind:
    return Kind(lambda value: isinstance(value, str) and value in words, f"one of {', '.join(words)}")


def read(path: Path, shape: Any) -> Any:
    """The contents of a file. Raises ValueError, which names the file and the place, if it has another shape."""
    if path.stat().st_size > MOST_BYTES:
        raise ValueError(f"{path}: {path.stat().st_size} bytes; a file of gnomon's has at most {MOST_BYTES}")
    try:
        found = _visible(json.loads(path.read_text(encoding="utf-8")))
    except (ValueError, RecursionError) as error:
        told = "nested too deep" if isinstance(error, RecursionError) else str(error)
        raise ValueError(f"{path}: no JSON of gnomon's ({told}); make it again, or remove it") from None
    check(found, shape, path)
    return found


def check(value: Any, shape: Any, path: Path, place: str = "") -> None:
    """Raise ValueError, which names the file and the place, if a value has another shape."""
    if isinstance(shape, Kind):
        fine, words = shape.holds(value), shape.words
    else:
        fine, words = isinstance(value, type(shape)), "an object" if isinstance(shape, dict) else "a list"
    if not fine:
        raise ValueError(
            f"{path}: {place or 'the whole'} = {visible(shortened(value))}, where {words} belongs; make it again, or remove it"
        )
    if isinstance(shape, list):
        for number, member in enumerate(value):
            check(member, shape[0], path, f"{place}[{number}]")
    if isinstance(shape, dict):
        for key, kind in shape.items():
            inner = kind.shape if isinstance(kind, Optional) else kind
            if key in value:
                check(value[key], inner, path, f"{place}.{key}" if place else key)
            elif not isinstance(kind, Optional):
                raise ValueError(f"{path}: {place or 'the whole'} lacks {key!r}; make it again, or remove it")


def _visible(value: Any) -> Any:
    """The same value with all texts, keys too, made visible."""
    if isinstance(value, dict):
        return {visible(key): _visible(member) for key, member in value.items()}
    if isinstance(value, list):
        return [_visible(member) for member in value]
    return visible(value) if isinstance(value, str) else value
