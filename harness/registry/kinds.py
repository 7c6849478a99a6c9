"""Kinds of systems, by the most structured form that a case offers."""

from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet

from gnomon.harness.contract.declared import read_declared

KINDS: dict[str, list[str]] = read_declared("reporting", "templates/page.toml")["kinds"]
"""Kinds of systems by the most structured form that a case offers; the first match counts."""


def kind_of(forms: AbstractSet[str]) -> str | None:
    """The kind of a system that offers these forms; None if they are in no kind."""
    return next((kind for kind, marks in KINDS.items() if not forms.isdisjoint(marks)), None)


def kinds(forms: Mapping[str, AbstractSet[str]], names: Sequence[str]) -> dict[str, list[str]]:
    """The cases of each kind, in the order of KINDS, without empty kinds. `forms`: the forms that each case offers."""
    of = {name: kind_of(forms[name]) for name in names}
    members = {kind: [name for name in names if of[name] == kind] for kind in KINDS}
    return {kind: members for kind, members in members.items() if members}
