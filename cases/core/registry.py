"""The registry of cases and checks by name. Their files are found by their text: listing names imports none of them."""

from __future__ import annotations

import importlib
import re
from collections.abc import Sequence
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from gnomon.cases.core.numbers import nearest
from gnomon.reference.numerics.precision import Number
from gnomon.reference.storage.importing import confined

if TYPE_CHECKING:
    from gnomon.cases.core.case import Case
    from gnomon.cases.core.check import Check

FOLDER = Path(__file__).parents[1]
SEQUENCE = Path(__file__).with_name("sequence.txt")
"""The sequence of cases and checks in lists, reports and random draws; a name that it does not have follows, by file."""
_CLASS = re.compile(r"^class (\w+)\(.*\):\n((?:(?!\S).*\n)+)", re.M)
_STATED = re.compile(r'^    (name|title) = "(.*)"$', re.M)
_VARIANT = re.compile(r'\bVariant\(\s*"(\w[^"]*)"')


class Entry(NamedTuple):
    """A case or check as the text of its file states it; `path` is package.module:Class."""

    name: str
    path: str
    title: str
    variants: tuple[str, ...]


@cache
def _entries(checks: bool) -> dict[str, Entry]:
    """The cases, or the checks, of gnomon by name."""
    entries = {}
    for file in sorted(FOLDER.glob("*/*.py")):
        folder = file.parent.name
        if folder == "core" or (folder == "checks") != checks:
            continue
        for kind, body in _CLASS.findall(file.read_text(encoding="utf-8")):
            stated = dict(_STATED.findall(body))
            if "name" in stated:
                path = f"gnomon.cases.{folder}.{file.stem}:{kind}"
                entries[stated["name"]] = Entry(stated["name"], path, stated["title"], tuple(_VARIANT.findall(body)))
    known = [name for name in SEQUENCE.read_text(encoding="utf-8").split() if name in entries]
    return {name: entries[name] for name in (*known, *entries)}


def entry(name: str) -> Entry:
    """The entry of a case or a check. A case of another package is imported for it."""
    known = _entries(False) | _entries(True)
    if name in known:
        return known[name]
    kind = case_class(name)
    return Entry(name, f"{kind.__module__}:{kind.__qualname__}", kind.title, tuple(v.name for v in kind.variants))


def names() -> tuple[str, ...]:
    """The names of all cases (checks excluded), entry points of the group `gnomon.cases` included.

    Returns
    -------
    tuple of str
        The names in the order of lists and reports.

    Examples
    --------
    >>> "kepler_orbit" in names()
    True
    """
    return (*_entries(False), *(point.name for point in entry_points(group="gnomon.cases")))


def case_class(name: str) -> type[Case]:
    """The class of a case.

    Parameters
    ----------
    name : str
        The name of the case, or ``package.module:Class``.

    Returns
    -------
    type
        A subclass of `Case`.

    Raises
    ------
    ValueError
        For an unknown name; the message has the nearest valid names.

    Examples
    --------
    >>> case_class("kepler_orbit").title
    'Kepler orbit'
    """
    if name in _entries(False):
        return load(_entries(False)[name].path)
    for point in entry_points(group="gnomon.cases"):
        if point.name == name:
            return load(point.value)
    if ":" in name:
        return load(name)
    raise ValueError(f"no case is named {name!r}; {nearest(name, names())}")


def installed_names() -> frozenset[str]:
    """The names of gnomon's cases and of the cases that installed packages declare as entry points `gnomon.cases`."""
    return frozenset(names())


def load(path: str) -> type[Case]:
    """A case class from `package.module:Class`."""
    module, _, attribute = path.partition(":")
    try:
        with confined():
            return _checked(getattr(importlib.import_module(module), attribute), path)
    except BaseException as error:  # a user's module may raise anything while it is imported
        raise ValueError(
            f"{path}: {type(error).__name__}: {error}; give package.module:Class of a subclass of gnomon.cases.Case"
        ) from None


def _checked(kind: object, path: str) -> type[Case]:
    from gnomon.cases.core.case import Case  # loads numpy: listing names goes without

    if not (isinstance(kind, type) and issubclass(kind, Case)):
        raise ValueError(f"{path} is not a subclass of gnomon.cases.Case")
    return kind


def get(
    name: str,
    variant: str | None = None,
    initial_state: Sequence[Number] | None = None,
    span: Number | None = None,
    **parameters: Number,
) -> Case:
    """A case with exact numbers.

    Parameters
    ----------
    name : str
        The name of the case, or ``package.module:Class``.
    variant : str, optional
        The name of a variant, whose numbers replace the defaults.
    initial_state : sequence of number, optional
        The initial state in the order of the case's coordinates, in their units; it replaces the variant's.
    span : number, optional
        The duration (s); it replaces the variant's.
    **parameters : number
        Parameters, and starts of coordinates, by name, in their units; they replace the variant's. A number is an int, a float, a Fraction, or a
        decimal text, which is exact: ``g="9.81"``.

    Returns
    -------
    Case
        The initial value problem with its exact motion.

    Raises
    ------
    ValueError
        For an unknown name or variant, and for numbers outside the domain.

    Examples
    --------
    >>> swing = get("pendulum_simple", g="9.81", L=2)
    >>> float(swing.exact(0)[0])
    2.0
    >>> swing.times.shape
    (64,)
    """
    return case_class(name)(variant, initial_state, span, **parameters)


def check_names() -> tuple[str, ...]:
    """The names of all checks, which are rows of the catalogue without motion.

    Returns
    -------
    tuple of str
        The names in the order of lists and reports.

    Examples
    --------
    >>> len(check_names()) > 20
    True
    """
    return tuple(_entries(True))


def check_class(name: str) -> type[Check]:
    """The class of a check.

    Parameters
    ----------
    name : str
        The name of the check.

    Returns
    -------
    type
        A subclass of `Check`.

    Raises
    ------
    ValueError
        For an unknown name; the message has the nearest valid names.

    Examples
    --------
    >>> check_class(check_names()[0]).name == check_names()[0]
    True
    """
    if name not in _entries(True):
        raise ValueError(f"no check is named {name!r}; {nearest(name, check_names())}")
    module, _, attribute = _entries(True)[name].path.partition(":")
    kind: type[Check] = getattr(importlib.import_module(module), attribute)
    return kind


def get_check(name: str, variant: str | None = None, **parameters: Number) -> Check:
    """A check with exact numbers.

    Parameters
    ----------
    name : str
        The name of the check.
    variant : str, optional
        The name of a variant, whose numbers replace the defaults.
    **parameters : number
        Parameters by name, in their units; they replace the variant's.

    Returns
    -------
    Check
        The closed forms and their independent computation.

    Raises
    ------
    ValueError
        For an unknown name, variant or parameter, and for numbers outside the domain.

    Examples
    --------
    >>> check = get_check(check_names()[0])
    >>> check.exact(20).keys() == check.independent(20).keys()
    True
    """
    return check_class(name)(variant, **parameters)
