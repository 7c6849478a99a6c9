"""The parts of an accuracy report's chapters, as the template of the document reads them from JSON."""

from collections.abc import Sequence
from typing import Any

Part = dict[str, Any]


def words(*texts: str, title: str = "") -> Part:
    """Paragraphs."""
    return {"shows": "words", "title": title, "texts": [text for text in texts if text]}


def answer(*texts: str) -> Part:
    """Paragraphs that stand out."""
    return words(*texts) | {"shows": "answer"}


def points(*texts: str) -> Part:
    """A list."""
    return words(*texts) | {"shows": "points"}


def code(*lines: str, title: str = "") -> Part:
    """Lines of a shell."""
    return words(*lines, title=title) | {"shows": "code"}


def terms(rows: Sequence[Sequence[str]], title: str = "") -> Part:
    """Pairs of a term and its text."""
    return {"shows": "terms", "title": title, "rows": rows}


def table(
    heads: Sequence[str], rows: Sequence[Sequence[str]], note: str = "", title: str = "", size: float = 9
) -> Part:
    """A table. A head with a leading ">" stands over a column of numbers, one with "<>" over the widest column."""
    columns = [
        {"head": head.lstrip("<>"), "right": head.startswith(">"), "wide": head.startswith("<>")} for head in heads
    ]
    return {"shows": "table", "title": title, "columns": columns, "rows": rows, "note": note, "size": size}


def figures(
    drawings: Sequence[str],
    caption: str,
    across: int = 1,
    width: float = 1.0,
    title: str = "",
    heads: Sequence[Sequence[str]] = (),
) -> Part:
    """Drawings in SVG, so many across the page, with one caption; `width` is their share of a column.

    `heads`: a title and a subtitle over each drawing.
    """
    return {
        "shows": "figures", "title": title, "drawings": drawings, "caption": caption, "across": across, "width": width, "heads": heads
    }  # fmt: skip


def chapter(title: str, *parts: Part, begins: str = "", whole: bool = False) -> dict[str, Any]:
    """A chapter; parts without texts, rows or drawings are left out.

    `begins`: a "page", or the "second page" unless an earlier chapter reaches it. `whole`: no page ends within it.
    """
    filled = [part for part in parts if part.get("texts") or part.get("rows") or part.get("drawings")]
    return {"title": title, "parts": filled, "begins": begins, "whole": whole}
