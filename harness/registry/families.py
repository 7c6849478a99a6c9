"""Families of methods, such as explicit Runge-Kutta methods or Taylor series, and systems that a method solves exactly."""

from fnmatch import fnmatchcase
from functools import cache

from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.contract.declared import read_declared
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.registry import lookup

_TABLE = read_declared("registry", "families.toml")
FAMILIES: dict[str, dict[str, list[str]]] = _TABLE["families"]
"""The forms and the sources by which a method is of a family."""
OTHER = "Other"
"""The family of integrators that a user gave."""
_SOURCES = {source: name for name, row in FAMILIES.items() for source in row.get("sources", ())}
_FOLDER = "gnomon.harness.integrators."


@cache
def family_of(integrator: str) -> str:
    """The family of an integrator by its id; OTHER for one that does not come with gnomon.

    Examples
    --------
    >>> family_of("scipy:DOP853"), family_of("scipy:DOP853 [events]")
    ('Explicit Runge-Kutta', 'Event location')
    """
    known = lookup.own().get(integrator)
    return OTHER if known is None else find_family(known) or OTHER


def find_family(integrator: Integrator) -> str:
    """The family by the form that a method takes, else as its library declares it, else by its class; empty without one."""
    forms = {form.__name__ for form in integrator.accepts}
    by_form = next((name for name, row in FAMILIES.items() if forms & {*row.get("forms", ())}), "")
    if by_form:
        return by_form
    if integrator.library in LIBRARIES:
        return LIBRARIES[integrator.library].family(integrator.id.partition(":")[2])
    bases = [kind.__module__.removeprefix(_FOLDER) for kind in reversed(type(integrator).__mro__)]
    sources = (source for module in bases for source in (module, module.partition(".")[0]))
    return next((_SOURCES[source] for source in sources if source in _SOURCES), "")


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
            if case in row["cases"] and any(fits(integrator, method) for method in row["methods"])
        ),
        None,
    )


def fits(integrator: str, pattern: str) -> bool:
    """Whether an id matches, with brackets as themselves: fnmatch would take them for sets of letters."""
    return fnmatchcase(integrator, pattern.replace("[", "[[]"))
