"""The scenes: each one initial value problem whose exact motion is known."""

from gnomon.cases.case import Case
from gnomon.cases.registry import case_class, get, names

__all__ = ["Case", "case_class", "get", "names"]
