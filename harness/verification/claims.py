"""Claims about an integrator: statement, reason, bound and verification of each; the depths of a verification."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

from gnomon.harness.contract.declared import read_declared
from gnomon.harness.contract.integrator import Unsupported
from gnomon.harness.measuring.trials import Extent, Trials
from gnomon.harness.studies import preflight


class Outcome(StrEnum):
    """The result of a claim on one case."""

    PASSED = "passed"
    FAILED = "failed"
    NOT_APPLICABLE = "not applicable"
    """The integrator cannot have the property, or the case does not show it."""
    NOT_CHECKED = "not checked"
    """The claim is made, but the time did not allow an answer, or the integrator had no solution to check."""


@dataclass(frozen=True)
class Finding:
    """The outcome of a claim on one case, with details.

    A failure has the setting, the expected and the actual result, and in `why` the reason for the claim. If a claim does
    not apply, or was not checked, `why` is the reason for that.
    """

    outcome: Outcome
    why: str = ""
    setting: str = ""
    expected: str = ""
    got: str = ""


def pass_claim(got: str = "") -> Finding:
    return Finding(Outcome.PASSED, got=got)


def not_applicable(why: str) -> Finding:
    return Finding(Outcome.NOT_APPLICABLE, why)


def not_checked(why: str) -> Finding:
    return Finding(Outcome.NOT_CHECKED, why)


def fail_claim(setting: str, expected: str, got: str, why: str = "") -> Finding:
    return Finding(Outcome.FAILED, why, setting, expected, got)


def within(allowed: float, got: float, setting: str, expected: str) -> Finding:
    """Whether a number is at most as large as allowed."""
    return pass_claim(f"{got:.2g}") if got <= allowed else fail_claim(setting, expected, f"{got:.2g}")


@dataclass(frozen=True)
class Depth(Extent):
    """How thoroughly an integrator is verified: the extent of its trials, and the number of cases and of hard variants."""

    name: str
    cases: int
    variants: int


DEPTHS = {
    "low": Depth(64 * 64, 1.0, "low", 3, 2),
    "normal": Depth(64 * 1024, 5.0, "normal", 6, 6),
    "high": Depth(64 * 16384, 60.0, "high", 100, 1000),
}

TEXTS: dict[str, dict[str, Any]] = read_declared("verification", "claims.toml") | preflight.TEXTS
"""The statement, reason and bound of each claim by id, the most informative claims first, then of each pre-flight."""
TIME = "time"
"""The claim about two versions; only `gnomon verify --against` makes it."""


@dataclass(frozen=True)
class Claim:
    """A claim. `applies` returns why the claim is not made of an integrator on a case, or None if it is made.

    `verify` is called only if the claim is made. `states`, `reason` and `bound` (with its derivation) are sentences for
    users.
    """

    id: str
    states: str
    reason: str
    bound: str
    applies: Callable[[Trials], str | None]
    verify: Callable[[Trials], Finding]
    hard: bool = False
    """Whether the claim is verified on hard variants instead of default variants."""
    once: bool = False
    """Whether the claim is verified on the first case only, because other cases would give the same result."""
    no_answer: bool = False
    """Whether a missing solution passes, because the claim is about finite states only."""

    def check(self, trials: Trials) -> Finding:
        """The finding on a case. An exception of the integrator is a failure whose text contains it."""
        why = self.applies(trials)
        if why is not None:
            return not_applicable(why)
        try:
            finding = self.verify(trials)
        except Unsupported as error:
            return not_applicable(f"unsupported: {error}")
        except Exception as error:  # the user's code may raise anything; the next claims are still verified
            return fail_claim("", "an answer", f"{type(error).__name__}: {error}", self.reason)
        return finding if finding.why or finding.outcome != Outcome.FAILED else replace(finding, why=self.reason)


def claim(
    name: str,
    applies: Callable[[Trials], str | None] = lambda trials: None,
    once: bool = False,
    no_answer: bool = False,
) -> Callable[[Callable[[Trials], Finding]], Claim]:
    """A decorator: the function verifies the claim `name`."""
    return lambda verify: Claim(name, **TEXTS[name], applies=applies, verify=verify, once=once, no_answer=no_answer)
