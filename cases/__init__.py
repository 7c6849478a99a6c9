"""The scenes: each one initial value problem whose exact motion is known, and checks without motion."""

from gnomon.cases.core.case import Case
from gnomon.cases.core.check import Check
from gnomon.cases.core.registry import case_class, check_class, check_names, get, get_check, names

__all__ = ["Case", "Check", "case_class", "check_class", "check_names", "get", "get_check", "names"]
