"""Families of methods, such as explicit Runge-Kutta methods or Taylor series, by the ids of integrators."""

from fnmatch import fnmatchcase
from functools import cache

from gnomon.harness.contract.declared import declared

FAMILIES: dict[str, list[str]] = declared("registry", "families.toml")["families"]
"""Patterns of ids by family; the first match counts."""
OTHER = "Other"
"""The family of integrators that a user gave."""


@cache
def family_of(integrator: str) -> str:
    """The family of an integrator by its id; OTHER if no pattern fits.

    Examples
    --------
    >>> family_of("scipy:DOP853"), family_of("scipy:DOP853 [events]")
    ('Explicit Runge-Kutta', 'Event location')
    """
    return next((name for name, patterns in FAMILIES.items() if any(fits(integrator, one) for one in patterns)), OTHER)


def fits(integrator: str, pattern: str) -> bool:
    """Whether an id matches, with brackets as themselves: fnmatch would take them for sets of letters."""
    return fnmatchcase(integrator, pattern.replace("[", "[[]"))
