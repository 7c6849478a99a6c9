"""Claims about an integrator: what each states, why, its bound, and how it is verified."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any

from gnomon.harness.contract.declared import declared
from gnomon.harness.contract.integrator import Unsupported
from gnomon.harness.verification.trials import Trials


class Outcome(StrEnum):
    """What became of a claim on one case."""

    PASSED = "passed"
    FAILED = "failed"
    NOT_APPLICABLE = "not applicable"


@dataclass(frozen=True)
class Finding:
    """What a claim found on one case: for a failure the setting, what was expected and got, and why it counts.

    `why` is the reason for a claim that does not apply.
    """

    outcome: Outcome
    why: str = ""
    setting: str = ""
    expected: str = ""
    got: str = ""


def passed(got: str = "") -> Finding:
    return Finding(Outcome.PASSED, got=got)


def not_applicable(why: str) -> Finding:
    return Finding(Outcome.NOT_APPLICABLE, why)


def failed(setting: str, expected: str, got: str, why: str = "") -> Finding:
    return Finding(Outcome.FAILED, why, setting, expected, got)


TEXTS: dict[str, dict[str, Any]] = declared("verification", "claims.toml")
"""What each claim states, its reason and its bound, by id, from the most telling."""
TIME = "time"
"""The claim that needs two versions: only `gnomon verify --against` makes it."""


@dataclass(frozen=True)
class Claim:
    """`applies` gives the reason why a claim is not made of an integrator on a case, None where it is made.

    `verify` is called only where it applies. `states`, `reason` and `bound` (with what it follows from) are sentences for users.
    """

    id: str
    states: str
    reason: str
    bound: str
    applies: Callable[[Trials], str | None]
    verify: Callable[[Trials], Finding]
    hard: bool = False
    """Whether it is verified on hard variants; the others on default variants."""
    once: bool = False
    """Whether it is verified on the first case only, as another would show the same."""
    no_answer: bool = False
    """Whether no answer is no failure: what it states is of finite states only."""

    def check(self, trials: Trials) -> Finding:
        """Passed, failed or not applicable. An exception of the integrator is a failure that names it."""
        why = self.applies(trials)
        if why is not None:
            return not_applicable(why)
        try:
            found = self.verify(trials)
        except Unsupported as error:
            return not_applicable(f"unsupported: {error}")
        except Exception as error:  # the user's code may raise anything, and the next claim is verified all the same
            return failed("", "an answer", f"{type(error).__name__}: {error}", self.reason)
        return found if found.why or found.outcome != Outcome.FAILED else replace(found, why=self.reason)


def claim(
    name: str,
    applies: Callable[[Trials], str | None] = lambda trials: None,
    once: bool = False,
    no_answer: bool = False,
) -> Callable[[Callable[[Trials], Finding]], Claim]:
    """A decorator: the function verifies the claim of this name."""
    return lambda verify: Claim(name, **TEXTS[name], applies=applies, verify=verify, once=once, no_answer=no_answer)
