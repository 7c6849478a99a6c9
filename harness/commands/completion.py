"""Completion of the shell: the names of cases, checks and integrators."""

from __future__ import annotations

import io
import os
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, redirect_stdout

SIGN = "_GNOMON_COMPLETE"
"""The environment variable with which a shell asks for completions."""


def complete_case(incomplete: str) -> list[str]:
    """The cases whose names begin so; after a slash, the variants of a case."""
    from gnomon.cases.core import registry

    return _complete_name(incomplete, registry.names())


def complete_subject(incomplete: str) -> list[str]:
    """As `complete_case`, and checks."""
    from gnomon.cases.core import registry

    return _complete_name(incomplete, (*registry.names(), *registry.check_names()))


def complete_integrator(incomplete: str) -> list[str]:
    """The integrators whose ids begin so."""
    from gnomon.harness.registry.ids import list_ids

    return [name for name in list_ids() if name.startswith(incomplete)]


def _complete_name(incomplete: str, names: Iterable[str]) -> list[str]:
    from gnomon.cases.core import registry

    base, slash, _ = incomplete.partition("/")
    if slash:
        names = [
            f"{base}/{one}" for name in names if name == base for one in ("default", *registry.entry(base).variants)
        ]
    return [name for name in names if name.startswith(incomplete)]


@contextmanager
def whole_words() -> Iterator[None]:
    """Ask for the completion of a whole word, and print what readline is to insert, if bash asks.

    Bash divides a word at its colons, as an id has one, and replaces the text after the last colon. It reads a space or a
    bracket of an id as its own, unless a backslash is before it or the word is in quotes.
    """
    if os.environ.get(SIGN) != "complete_bash":
        yield
        return
    words, place = os.environ["COMP_WORDS"].split("\n"), int(os.environ["COMP_CWORD"])
    whole: list[str] = []
    for number, word in enumerate(words[: place + 1]):
        joins = number > 1 and (word.startswith(":") or words[number - 1].endswith(":"))
        whole[-1:] = [whole[-1] + word] if joins else [*whole[-1:], word]
    os.environ |= {"COMP_WORDS": "\n".join(whole), "COMP_CWORD": str(len(whole) - 1)}
    fixed, quoted = whole[-1].rfind(":") + 1, whole[-1][:1] in ("'", '"')
    answer = io.StringIO()
    try:
        with redirect_stdout(answer):
            yield
    finally:
        for word in answer.getvalue().splitlines():
            print(word if quoted else re.sub(r"([^\w.:/%+=@,-])", r"\\\1", word[fixed:]))
