"""Makes text from outside safe to show on a terminal, a page or a figure: control characters are escaped."""

import os
import re

_LINES = "\t\n"
_UNSEEN = re.compile("[\x00-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u2069\ud800-\udfff\ufffe\uffff]")
"""Control characters, among them the escape that starts a terminal's commands, marks that change the direction of text,
halves of surrogate pairs, and characters that XML forbids."""
_COMMANDS = re.compile(r"(?<=:):|(?<=#)#(?=\\*\[)")
"""The beginning of a command of GitHub Actions in a log: ::name:: at the beginning of a line, or ##[name] anywhere
(actions/runner, src/Runner.Common/ActionCommand.cs). Rich escapes the bracket with a backslash."""

_MARKS = re.compile(r"[\\`*~|$]|](?=[(\[:])|(?<![^\W_])_|_(?![^\W_])|(?<=:)/(?=/)|(?<=www)\.", re.IGNORECASE)
"""Characters with a meaning in Markdown, without single brackets and underscores within words."""


def visible(text: str, lines: bool = False) -> str:
    """The text with every invisible character escaped, as \\x1b; tabs and new lines stay if `lines`."""
    return _UNSEEN.sub(lambda match: match[0] if lines and match[0] in _LINES else ascii(match[0])[1:-1], text)


def show(text: str, lines: bool = False) -> str:
    """The text from `visible`; under GitHub Actions it is also free of commands of a workflow."""
    text = visible(text, lines)
    commands = os.environ.get("GITHUB_ACTIONS") == "true"
    return _COMMANDS.sub(lambda match: f"\\x{ord(match[0]):x}", text) if commands else text


def shorten(text: str, most: int = 160) -> str:
    """A text of more than `most` characters shortened in its middle: the end of a path identifies it."""
    half = most // 2 - 2
    return text if len(text) <= most else f"{text[:half]}...{text[-half:]}"


def markdown(value: object) -> str:
    """A value as plain text for a Markdown file: escaped, so that it has no tag, link, table border or emphasis."""
    if isinstance(value, Verbatim):
        return value
    text = _MARKS.sub(lambda match: f"\\{match[0]}", re.sub(r"[\t\r\n]+", " ", str(value)))
    return text.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;")


class Verbatim(str):
    """Text that is Markdown already and needs no escaping."""


def code(value: object) -> Verbatim:
    """Text of plain characters between backticks; any other text as from `markdown`."""
    plain = re.fullmatch(r"[\w.,:/+ -]+", str(value)) is not None
    return Verbatim(f"`{value}`" if plain else markdown(value))
