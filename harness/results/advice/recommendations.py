"""Reads the table of recommendations, `recommendations.jsonl`, which publication writes into the package. Without pandas.

Its first line has the origin of the measurements: revision, machine, date. The next lines hold the forms of equations that
each method accepts. Each further line is an answer of `needs` for a subject, an error and a library.
"""

import json
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from functools import cache
from importlib.resources import files
from typing import Any

from gnomon.cases.core.numbers import nearest
from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.contract.declared import read_declared

NAME = "recommendations.jsonl"
MOST_BYTES = 600_000
"""The largest size of the table."""
SCHEMA = 2
"""The form of the table, in its head: a table of another form has other fields, or fields of another meaning."""
OURS = "gnomon"
WORDS = {"jax": "diffrax", "cvode": "sksundae"}
"""Further words for libraries."""
CLOSE = 0.7
"""The least likeness of a name that is suggested in place of an unknown one, as `difflib` computes it."""
ENGINES = ("engine", "engines")
"""Words for all physics engines."""


@dataclass(frozen=True)
class Table:
    """The table: its head, the forms that each method accepts, and its answers."""

    head: Mapping[str, Any]
    forms: Mapping[str, Sequence[str]]
    """By id; none for an engine."""
    rows: Sequence[Mapping[str, Any]]


@dataclass(frozen=True)
class Found:
    """The answers to a question: of the error in the table that is at most the one that was asked for."""

    subject: str
    title: str
    about: str
    error: float
    rows: Sequence[Mapping[str, Any]]
    further: Mapping[str, str]
    """Words of the question that lead to other subjects, with these subjects."""


@cache
def read() -> Table:
    """The table that comes with gnomon."""
    text = (files("gnomon.harness.results.advice") / NAME).read_text("utf-8")
    head, *parts = [json.loads(line) for line in text.splitlines()]
    require_schema(head)
    forms = {row["method"]: row["forms"] for row in parts if "method" in row}
    return Table(head, forms, [row for row in parts if "subject" in row])


def require_schema(head: Mapping[str, Any]) -> None:
    """Raise ValueError for the head of a table of another form, whose fields would be misread."""
    if head.get("schema") != SCHEMA:
        raise ValueError(
            f"{NAME}: schema {head.get('schema', 'not given')}, and this gnomon reads schema {SCHEMA}:"
            " install gnomon again, or write the table anew from a results file by `make publication`"
        )


def outside_text(outside: Mapping[str, Any] | None, subject: str = "") -> str:
    """The results of a trial on systems outside of the catalogue, of all and of a subject, in words; or that there is none."""
    if outside is None:
        return "Outside of the catalogue these settings were not tried."
    reached, order = (percent_text(outside[name]) for name in ("share", "order"))
    text = (
        "On systems outside of the catalogue, drawn at random, the recommended settings of all libraries reached their error in"
        f" {reached}; of two libraries the one that is faster here was faster there in {order}."
    )
    if not subject:
        return text
    of = next((row for row in outside.get("by_need", ()) if row["need"] == subject), None)
    return f"{text} For this need alone they reached it in {percent_text(of)}."


def outside_share(outside: Mapping[str, Any] | None, subject: str, library: str) -> Mapping[str, Any] | None:
    """The share of trials outside of the catalogue in which a library's settings for a subject reached the error."""
    rows = (outside or {}).get("by_need_and_library", ())
    return next((row for row in rows if (row["need"], row["library"]) == (subject, library)), None)


def percent_text(share: Mapping[str, Any] | None) -> str:
    """A share with its 95 % interval, and the number of systems that it rests on."""
    if share is None or None in (share["share"], share["low"], share["high"]):
        return "no trial"
    part, low, high = (f"{100 * share[name]:.0f}" for name in ("share", "low", "high"))
    return f"{part} % of the trials ({low} to {high} %, on {share['systems']} systems)"


def subjects() -> dict[str, tuple[str, str]]:
    """The title and the description of each subject, by its key."""
    return {key: (row["title"], row["about"]) for key, row in read_declared("results", "advice/needs.toml").items()}


def subject(phrase: str) -> str:
    """The key of the subject that a phrase names by key, title, kind of system, or one of its words.

    In a longer phrase the name with the most words counts, as "double pendulum" in "a driven double pendulum". Raises
    ValueError, with all subjects, for a phrase without such a name, and for names of several subjects.
    """
    known = _names()
    held = _names_in(phrase, known)
    longest = max((len(_plain(name).split()) for name in held), default=0)
    by_key = {known[name]: name for name in held if len(_plain(name).split()) == longest}
    if len(by_key) == 1:
        return next(iter(by_key))
    if by_key:
        leads = " and ".join(f"{name!r} to {key}" for key, name in by_key.items())
        raise ValueError(f"{phrase!r} leads to several subjects, {leads}; name one")
    close = get_close_matches(phrase.lower(), known, cutoff=CLOSE)
    hint = f" (did you mean {' or '.join(close)}?)" if close else ""
    raise ValueError(f"no subject is called {phrase!r}{hint}; the subjects are {', '.join(subjects())}")


def further_subjects(phrase: str) -> dict[str, str]:
    """The names of a phrase that lead to other subjects than `subject` finds, with these subjects.

    >>> further_subjects("double pendulum with friction")
    {'friction': 'events'}
    """
    known, key = _names(), subject(phrase)
    held = _names_in(phrase, known)
    return {
        name: known[name]
        for name in held
        if known[name] != key and not any(name != other and _is_within(name, other) for other in held)
    }


def _names() -> dict[str, str]:
    """The subject of each of its names."""
    known: dict[str, str] = {}
    for key, row in read_declared("results", "advice/needs.toml").items():
        kinds = [name for name in row.get("kinds", ()) if name not in ("smooth", "events")]
        known |= dict.fromkeys([*kinds, *row.get("words", ()), row["title"], key], key)
    return known


def _names_in(phrase: str, known: Iterable[str]) -> list[str]:
    return [name for name in known if _is_within(name, phrase)]


def _is_within(name: str, phrase: str) -> bool:
    """Whether the words of a name stand together in a phrase."""
    return f" {_plain(name)} " in f" {_plain(phrase)} "


def _plain(phrase: str) -> str:
    """A phrase in small letters, its words in the singular with a blank between them."""
    return " ".join(word.removesuffix("s") for word in re.split(r"[^a-z0-9]+", phrase.lower()) if word)


def library(word: str) -> str:
    """The name of a library by its name, its title, its distribution, or a word of WORDS; ValueError for others."""
    known: dict[str, str] = {OURS: OURS} | WORDS
    for name, declared in LIBRARIES.items():
        known |= {text.lower(): name for text in (name, declared.title, declared.package)}
    if word.lower() not in known:
        raise ValueError(f"no library is called {word!r}; {nearest(word.lower(), known)}")
    return known[word.lower()]


def libraries_of(word: str) -> list[str]:
    """The library that a word names, or all physics engines; ValueError for others."""
    if word.lower() in ENGINES:
        return [name for name, declared in LIBRARIES.items() if "engine" in declared.calls.values()]
    return [library(word)]


def find(word: str, error: float | None = None, libraries: Sequence[str] = ()) -> Found:
    """The answers for a need or a kind of system, at an error, of these libraries or of all.

    Raises ValueError for an unknown subject or library, and for an error below all measured ones.
    """
    key, chosen = subject(word), {name for word in libraries for name in libraries_of(word)}
    row, table = read_declared("results", "advice/needs.toml")[key], read()
    known = sorted({answer["error"] for answer in table.rows}, reverse=True)
    wanted = row["error"] if error is None else error
    if not wanted > 0:
        raise ValueError(f"--error {wanted:g}: give a positive number, as 1e-6")
    levels = [level for level in known if level <= wanted * (1 + 1e-9)]
    if not levels:
        raise ValueError(f"--error {wanted:g}: errors were measured down to {known[-1]:g}; ask for no less")
    rows = [
        answer
        for answer in table.rows
        if answer["subject"] == key and answer["error"] == levels[0] and (not chosen or answer["library"] in chosen)
    ]
    return Found(key, row["title"], row["about"], levels[0], rows, further_subjects(word))
