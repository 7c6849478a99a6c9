"""A page as it is once all its parts are drawn, by code that shares nothing with the page's script."""

import base64
import json
import lzma
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any


def carried(page: Path) -> Any:
    """The data that a page contains for its script, with the pieces of HTML by their names, and positions in diagrams."""
    text = page.read_text(encoding="utf-8")
    (packed,) = re.findall(r'<script type="text/plain" id="data">(.*?)</script>', text, re.DOTALL)
    found = json.loads(unpack(packed), parse_constant=_reject)
    for problem in (problem for of in found["work"]["cases"].values() for problem in of.values()):
        for name in ("time", "calls", "error"):
            problem["points"][name] = positions(problem["points"][name])
    return found | {name: unfold(found[name]) for name in ("times", "families", "stability", "parts")}


def unpack(text: str) -> bytes:
    found = base64.b85decode(text.translate(str.maketrans(",.:", "<>&")))
    return lzma.decompress(found[4:], lzma.FORMAT_ALONE)


def _reject(word: str) -> None:
    raise AssertionError(f"{word}: no browser reads that")


def unfold(packed: dict[str, Any]) -> dict[str, str]:
    """The pieces of HTML that `pack_html` packed."""
    columns = [[_texts(column) for column in of] for of in packed["texts"]]
    order = iter(packed["order"])
    found = {}
    for name, count in zip(packed["names"], packed["counts"], strict=True):
        parts: list[str] = []
        for _ in range(count):
            place = next(order)
            first, *others = packed["markup"][place]
            parts.append(first)
            for column, markup in zip(columns[place], others, strict=True):
                parts += (next(column), markup)
        found[name] = "".join(parts)
    return found


def _texts(column: dict[str, Any]) -> Iterator[str]:
    numbers = iter(column["numbers"].split(" "))
    for code in column["codes"]:
        first, *others = column["forms"][code].split("\ue000")
        yield first + "".join(next(numbers) + other for other in others)


def read_page(page: Path) -> str:
    """The HTML with all parts that the page draws later in their places."""
    parts = carried(page)["parts"]
    return re.sub(
        r'(<(\w+)[^>]*) data-part="(\d+)"></\2>',
        lambda found: f"{found[1]}>{parts[found[3]]}</{found[2]}>",
        page.read_text(encoding="utf-8"),
    )


def positions(differences: list[int | None]) -> list[int | None]:
    """The whole numbers of which a page stores the differences."""
    total, found = 0, []
    for value in differences:
        total += value or 0
        found.append(None if value is None else total)
    return found
