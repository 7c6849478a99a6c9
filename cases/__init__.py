"""Cases: initial value problems whose exact motion is known; and checks, which have no motion."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from gnomon.cases.core.registry import case_class, check_class, check_names, get, get_check, names

if TYPE_CHECKING:
    from gnomon.cases.core.case import Case
    from gnomon.cases.core.check import Check

__all__ = ["Case", "Check", "case_class", "check_class", "check_names", "get", "get_check", "names"]


def __getattr__(name: str) -> Any:
    """Load `Case`, `Check` and the words of `declare` on first use: they need numpy, and listing names goes without."""
    if name in ("Case", "Check"):
        return getattr(import_module(f"gnomon.cases.core.{name.lower()}"), name)
    if not name.startswith("__"):
        declare = import_module("gnomon.cases.declare")
        if name in declare.__all__:
            return getattr(declare, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
