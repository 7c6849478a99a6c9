"""Compare the versions and sources of a cluster's workers with the client's."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cache

from gnomon.cases import Case
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.registry import environment
from gnomon.harness.registry.references import MAIN, pickle_integrator
from gnomon.reference.storage.import_closure import closure


def identity(cases: Iterable[Case], integrators: Iterable[Integrator]) -> dict[str, str]:
    """The versions on which results depend, and hashes of the modules of users' cases and integrators, by name.

    Raises ValueError for a case or an integrator without a module that a worker could import.
    """
    modules = {type(case).__module__ for case in cases}.union(*(pickle_integrator(method)[1] for method in integrators))
    versions = environment.versions() | {
        name: environment.versions().get(name, "none") for name in environment.DISTRIBUTIONS
    }
    for module in sorted(name for name in modules if not name.startswith("gnomon.")):
        if _source(module) == "none":
            raise ValueError(f"--dask: workers cannot import {module}; put the integrator or the case into a module")
        versions[f"module {module}"] = _source(module)
    return versions


def difference(client: Mapping[str, str]) -> str | None:
    """A sentence about the first version or source that differs from the client's; None if all agree.

    A worker calls this.
    """
    own = environment.versions()
    for name, value in client.items():
        here = _source(name.removeprefix("module ")) if name.startswith("module ") else own.get(name, "none")
        if here != value:
            return f"has {name} {here}, the client {name} {value}"
    return None


@cache
def _source(module: str) -> str:
    """A hash of a module and of all its imports, at the time of the first call in this process."""
    return "none" if module == MAIN else closure(module) or "none"
