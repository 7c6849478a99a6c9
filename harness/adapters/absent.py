"""The known integrators that do not take part, and the measurements of two of them that ran as programs.

`absent.toml` is written by hand; `make other-languages` writes `other_languages.toml`. Both are data that change no key
of a result.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from gnomon.harness.contract.declared import declared


@dataclass(frozen=True)
class Absent:
    """A table of `absent.toml`: a library, or several that share the reason."""

    title: str
    reason: str
    readme: str | None = None
    """The name by which README.md mentions it, if it does."""


ABSENT = tuple(Absent(**row) for row in declared("adapters", "absent.toml")["absent"])


@dataclass(frozen=True)
class Series:
    """The trials of one integrator on one case: those with the status ok, and the number of the others by status."""

    case: str
    integrator: str
    setting: Sequence[float]
    error: Sequence[float]
    rhs_calls: Sequence[int]
    others: Mapping[str, int]

    def calls_within(self, error: float) -> int | None:
        """The fewest right-hand sides of a trial with at most this error; None if there is no such trial."""
        pairs = zip(self.error, self.rhs_calls, strict=True)
        return min((calls for found, calls in pairs if found <= error), default=None)

    @property
    def least_error(self) -> float:
        return min(self.error, default=math.nan)


@dataclass(frozen=True)
class Measured:
    """The contents of `other_languages.toml`."""

    versions: Mapping[str, str]
    """The version of each library and of the compilers."""
    limit_seconds: float
    series: Sequence[Series]


def measured() -> Measured:
    """The measurements of the libraries that ran as programs, and of SciPy's methods in the same run."""
    found: dict[str, Any] = declared("adapters", "other_languages.toml")
    return Measured(found["versions"], found["limit_seconds"], tuple(Series(**row) for row in found["series"]))
