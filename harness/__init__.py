"""Runs cases through integrators, times, judges, stores and reports."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gnomon.harness.ensembles.parquet import load_ensemble
    from gnomon.harness.results.store import load
    from gnomon.harness.running.run import compare
    from gnomon.harness.running.solve import solve

__all__ = ["compare", "load", "load_ensemble", "solve"]


def __getattr__(name: str) -> Any:
    """`compare`, `load`, `load_ensemble` and `solve`, imported on first use: everything else here starts faster without them."""
    if name == "compare":
        # slow to load: whoever imports a module of the harness goes without
        from gnomon.harness.running.run import compare

        return compare
    if name == "load":
        from gnomon.harness.results.store import load

        return load
    if name == "load_ensemble":
        from gnomon.harness.ensembles.parquet import load_ensemble

        return load_ensemble
    if name == "solve":
        from gnomon.harness.running.solve import solve

        return solve
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
