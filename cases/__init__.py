"""Cases: initial value problems whose exact motion is known; and checks, which have no motion."""

from typing import TYPE_CHECKING, Any

from gnomon.cases.core.registry import case_class, check_class, check_names, get, get_check, names

if TYPE_CHECKING:
    from gnomon.cases.core.case import Case
    from gnomon.cases.core.check import Check

__all__ = ["Case", "Check", "case_class", "check_class", "check_names", "get", "get_check", "names"]


def __getattr__(name: str) -> Any:
    """`Case` and `Check` load numpy: on first use, so that listing names goes without."""
    if name == "Case":
        from gnomon.cases.core.case import Case

        return Case
    if name == "Check":
        from gnomon.cases.core.check import Check

        return Check
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
