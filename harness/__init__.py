"""Runs cases through integrators, times, judges, stores and reports."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gnomon.harness.ensembles.parquet import load_ensemble
    from gnomon.harness.results.store import load
    from gnomon.harness.running.planned_run import compare
    from gnomon.harness.running.solve import solve

__all__ = ["compare", "load", "load_ensemble", "solve"]
_MODULES = {
    "compare": "running.planned_run",
    "load": "results.store",
    "load_ensemble": "ensembles.parquet",
    "solve": "running.solve",
}


def __getattr__(name: str) -> Any:
    """The names of `__all__`, imported on first use: whoever imports a module of the harness starts faster without them."""
    if name in _MODULES:
        return getattr(import_module(f"gnomon.harness.{_MODULES[name]}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
