"""Runs cases through integrators, times, judges, stores and reports."""

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from gnomon.harness.results.store import load
    from gnomon.harness.running.run import compare

__all__ = ["compare", "load"]


def __getattr__(name: str) -> Any:
    """`compare` and `load`, imported on first use: everything else here starts faster without them."""
    if name == "compare":
        # slow to load: whoever imports a module of the harness goes without
        from gnomon.harness.running.run import compare

        return compare
    if name == "load":
        from gnomon.harness.results.store import load

        return load
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
