"""Families of methods, such as explicit Runge-Kutta methods or Taylor series, and systems that a method solves exactly."""

from fnmatch import fnmatchcase
from functools import cache

from gnomon.harness.contract.declared import read_declared

_TABLE = read_declared("registry", "families.toml")
FAMILIES: dict[str, list[str]] = _TABLE["families"]
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


@cache
def exact_reason(integrator: str, case: str) -> str | None:
    """Why an integrator is exact by construction on a case, as `families.toml` declares; None if it is not.

    Examples
    --------
    >>> exact_reason("rebound:WHFast", "kepler_orbit")
    "it moves bodies on Kepler's orbits, and two bodies are subject to no other force"
    >>> exact_reason("rebound:IAS15", "kepler_orbit") is None
    True
    """
    return next(
        (
            row["reason"]
            for row in _TABLE["exact"]
            if case in row["cases"] and any(fits(integrator, one) for one in row["methods"])
        ),
        None,
    )


def fits(integrator: str, pattern: str) -> bool:
    """Whether an id matches, with brackets as themselves: fnmatch would take them for sets of letters."""
    return fnmatchcase(integrator, pattern.replace("[", "[[]"))
