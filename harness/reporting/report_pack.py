"""The data that the page contains for its script, as columns and compressed, so that a hundred cases fit.

The page's script decompresses them: LZMA takes a fifth less than gzip, which browsers have. Nothing is fetched.
"""

import base64
import itertools
import json
import lzma
import re
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from typing import Any

from gnomon.harness.reporting.kept_parts import keep_result

BREAK = re.compile(r"(?=<t[rdh][ >])")
"""Where HTML is cut into pieces that are alike: a row or a cell of a table."""
TAG = re.compile(r"(<[^>]*>)")
HOLE = "\ue000"
"""Stands for a number in a text; of private use, and a text that has it counts it as a number."""
NUMBER = re.compile(rf"-?\d+(?:\.\d+)?(?:e-?\d+)?|{HOLE}")
IN_HTML = str.maketrans("<>&", ",.:")
"""Characters of base85 that a script element of a page should not have, and those that stand for them."""


LZMA = ({"id": lzma.FILTER_LZMA1, "preset": 9 | lzma.PRESET_EXTREME, "lc": 3, "lp": 0, "pb": 0},)
"""The parameters that the page's script has."""


def pack(text: str) -> str:
    """The number of bytes of a text, 4 bytes, and its LZMA, as base85: 4 bytes in 5 characters."""
    content = text.encode("utf-8")
    packed = len(content).to_bytes(4, "big") + lzma.compress(content, lzma.FORMAT_ALONE, filters=LZMA)
    return base64.b85encode(packed).decode("ascii").translate(IN_HTML)


def pack_vega() -> str:
    """The script that draws charts, packed and kept on disk: making it takes 5 s."""
    return str(keep_result((__name__,), version("vl-convert-python"), _vega))


def _vega() -> str:
    import vl_convert  # slow to load

    return pack(vl_convert.javascript_bundle("window.vegaEmbed = vegaEmbed;"))


def pack_json(value: Any) -> str:
    """JSON, packed. Raises ValueError for nan and infinity: JSON lacks them, and a browser would reject all of it."""
    return pack(json.dumps(value, separators=(",", ":"), ensure_ascii=False, allow_nan=False))


def pack_html(fragments: Mapping[str, str]) -> dict[str, Any]:
    """Pieces of HTML by name, with what is alike in their rows and cells stored once: a third less than compressed alone.

    A piece is the markup around its texts; the texts at one place of a piece are a column, and their numbers apart.
    """
    places: dict[tuple[str, ...], int] = {}
    texts: list[list[list[str]]] = []
    order, counts = [], []
    for html in fragments.values():
        pieces = [piece for piece in BREAK.split(html) if piece]
        counts.append(len(pieces))
        for piece in pieces:
            markup, words = _take_apart(piece)
            place = places.setdefault(markup, len(places))
            if place == len(texts):
                texts.append([[] for _ in words])
            for column, text in zip(texts[place], words, strict=True):
                column.append(text)
            order.append(place)
    packed = [[_pack_texts(column) for column in of] for of in texts]
    return {"names": list(fragments), "counts": counts, "order": order, "markup": list(places), "texts": packed}


def _take_apart(html: str) -> tuple[tuple[str, ...], list[str]]:
    """The markup between the texts, one more than texts, and the texts."""
    markup, texts = [""], []
    for k, part in enumerate(TAG.split(html)):
        if k % 2:
            markup[-1] += part
        elif part:
            texts.append(part)
            markup.append("")
    return tuple(markup), texts


def _pack_texts(texts: Sequence[str]) -> dict[str, Any]:
    forms: dict[str, int] = {}
    codes = [forms.setdefault(NUMBER.sub(HOLE, text), len(forms)) for text in texts]
    return {"forms": list(forms), "codes": codes, "numbers": " ".join(itertools.chain(*map(NUMBER.findall, texts)))}


def differences(values: Sequence[int | None]) -> list[int | None]:
    """Each whole number less the one before, which takes fewer characters; None where there is none."""
    steps: list[int | None] = []
    last = 0
    for value in values:
        steps.append(None if value is None else value - last)
        last = last if value is None else value
    return steps


def columnar(spec: dict[str, Any]) -> dict[str, Any]:
    """A chart's specification with its data as columns."""
    data = {
        name: columns({key: [row[key] for row in rows] for key in (rows[0] if rows else ())})
        for name, rows in spec["datasets"].items()
    }
    return spec | {"datasets": data}


def columns(table: dict[str, list[Any]]) -> dict[str, Any]:
    """Columns in few characters: words as indices into a list, floats to four figures."""
    packed: dict[str, Any] = {}
    for name, values in table.items():
        if any(isinstance(value, str) for value in values):
            places: dict[str, int] = {}
            codes = [places.setdefault(value, len(places)) if isinstance(value, str) else -1 for value in values]
            packed[name] = {"words": list(places), "codes": codes}
        else:
            packed[name] = [_short(value) for value in values]
    return packed


def _short(value: Any) -> Any:
    if isinstance(value, bool):
        return int(value)
    return float(f"{value:.4g}") if isinstance(value, float) else value
