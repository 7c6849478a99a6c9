"""Text that others wrote, as a terminal, a page and a figure may show it: what steers them is spelled out."""

from __future__ import annotations

import re

_LINES = "\t\n"
_UNSEEN = re.compile("[\x00-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff\ufffe\uffff]")
"""Control characters, among them the escape that starts a terminal's commands, marks that turn the direction of text,
halves of surrogate pairs, and what no XML may hold."""

_MARKS = re.compile(r"[\\`*~|$]|](?=[(\[:])|(?<![^\W_])_|_(?![^\W_])|(?<=:)/(?=/)|(?<=www)\.", re.IGNORECASE)
"""What Markdown takes for more than a character: single brackets and underscores within words are none of it."""


def visible(text: str, lines: bool = False) -> str:
    """The text with every character that does not show spelled out, as \\x1b; tabs and new lines stay where `lines`."""
    return _UNSEEN.sub(lambda found: found[0] if lines and found[0] in _LINES else _spelled(found[0]), text)


def _spelled(character: str) -> str:
    return character.encode("unicode_escape").decode("ascii")


def markdown(value: object) -> str:
    """A value as a Markdown file shows it: nothing in it is a tag, a link, a table's border or emphasis."""
    if isinstance(value, Verbatim):
        return value
    text = _MARKS.sub(lambda found: f"\\{found[0]}", re.sub(r"[\t\r\n]+", " ", str(value)))
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


class Verbatim(str):
    """A text that is Markdown already."""


def code(value: object) -> Verbatim:
    """A plain word between backticks; any other text as `markdown` gives it."""
    plain = re.fullmatch(r"[\w.,:/+ -]+", str(value)) is not None
    return Verbatim(f"`{value}`" if plain else markdown(value))
