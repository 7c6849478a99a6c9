"""What a worker of a cluster must have in common with the client: versions and sources."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache

from gnomon.cases import Case
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.registry import environment
from gnomon.harness.registry.references import MAIN, pickled
from gnomon.reference.storage.import_closure import closure


def identity(cases: Iterable[Case], integrators: Iterable[Integrator]) -> dict[str, str]:
    """Names and values of the versions that results depend on, and of the sources of cases and integrators from elsewhere.

    Raises ValueError for one that has no module which a worker could import.
    """
    modules = {type(case).__module__ for case in cases}
    for one in integrators:
        modules |= {*pickled(one)[1]}
    found = environment.versions() | {
        name: environment.versions().get(name, "none") for name in environment.DISTRIBUTIONS
    }
    for module in sorted(name for name in modules if not name.startswith("gnomon.")):
        if _source(module) == "none":
            raise ValueError(f"--dask: workers cannot import {module}; put the integrator or the case into a module")
        found[f"module {module}"] = _source(module)
    return found


def difference(client: Mapping[str, str]) -> str | None:
    """What this process has that the client has not, in words; None if they agree. A worker calls this."""
    own = environment.versions()
    for name, value in client.items():
        here = _source(name.removeprefix("module ")) if name.startswith("module ") else own.get(name, "none")
        if here != value:
            return f"has {name} {here}, the client {name} {value}"
    return None


@cache
def _source(module: str) -> str:
    """A hash of a module and of all that it imports, as it was when this process first asked."""
    return "none" if module == MAIN else closure(module) or "none"
