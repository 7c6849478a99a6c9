"""The known integrators that do not take part: `absent.toml`, which changes no key of a result."""

from dataclasses import dataclass

from gnomon.harness.contract.declared import read_declared


@dataclass(frozen=True)
class Absent:
    """A table of `absent.toml`: a library, or several that share the reason."""

    title: str
    reason: str
    readme: str | None = None
    """The name by which README.md mentions it, if it does."""


ABSENT = tuple(Absent(**row) for row in read_declared("adapters", "absent.toml")["absent"])
