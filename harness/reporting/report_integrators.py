"""Kinds of systems, by the most structured form that a case offers."""

from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet

from gnomon.harness.contract.declared import declared

KINDS: dict[str, list[str]] = declared("reporting", "templates/page.toml")["kinds"]
"""Kinds of systems by the most structured form that a case offers; the first match counts."""


def kinds(forms: Mapping[str, AbstractSet[str]], names: Sequence[str]) -> dict[str, list[str]]:
    """The cases of each kind, in the order of KINDS, without empty kinds. `forms`: the forms that each case offers."""
    found: dict[str, list[str]] = {}
    for words, marks in KINDS.items():
        known = {name for members in found.values() for name in members}
        members = [name for name in names if name not in known and not forms[name].isdisjoint(marks)]
        if members:
            found[words] = members
    return found
