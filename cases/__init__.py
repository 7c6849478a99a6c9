"""The cases: each one initial value problem whose exact motion is known, and checks without motion."""

import gnomon.cases.checks  # noqa: F401  loaded first: later it would replace the function `checks`
from gnomon.cases.core.case import Case
from gnomon.cases.core.check import Check
from gnomon.cases.core.registry import case_class, check_class, checks, get, get_check, names

__all__ = ["Case", "Check", "case_class", "check_class", "checks", "get", "get_check", "names"]
