"""Claims as tests of a user's own pytest: `parametrize` a test with them, or `assert_follows` one exact motion."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from gnomon.cases import Case
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.measuring.reference_solution import CaseSpec
from gnomon.harness.measuring.score import INACCURATE
from gnomon.harness.measuring.trials import Answer, Trials
from gnomon.harness.registry import selection
from gnomon.harness.results.visible import show
from gnomon.harness.system import extras
from gnomon.harness.verification.claims import DEPTHS, Depth, Finding, Outcome
from gnomon.harness.verification.convergence_claims import sum_allowed_errors
from gnomon.harness.verification.verification_report import command, failure, read_known
from gnomon.harness.verification.verify import ACCURACY, CLAIMS, FOLLOWS, Report, Row, plan_verification

if TYPE_CHECKING:
    import pytest


@dataclass(frozen=True)
class ClaimTest:
    """One claim about an integrator on one case.

    A call raises AssertionError if the claim fails or could not be checked, and skips the test if it does not apply.
    `FOLLOWS` fails too if no claim about accuracy is checked on its case: else a test run would be green on nothing.
    """

    integrator: Integrator
    case: Case
    claim: str
    depth: Depth
    how: str = ""
    """The words that name the integrator on the command line; empty if there are none."""

    @property
    def id(self) -> str:
        return f"{self.claim}[{self.case.id}]"

    @property
    def key(self) -> tuple[str, str]:
        """(claim, case), as in a file of known failures."""
        return self.claim, self.case.id

    def marks(self, known: Mapping[tuple[str, str], str]) -> list[pytest.MarkDecorator]:
        """The mark of an expected failure, if this failure is known. pytest reports a known failure that passes."""
        import pytest  # of the extra `test`, like the imports below: who only verifies needs none

        return [pytest.mark.xfail(reason=show(known[self.key]), strict=False)] if self.key in known else []

    def __call__(self) -> None:
        import pytest  # as above

        finding = self._finding(self.claim)
        if finding.outcome == Outcome.NOT_CHECKED:
            raise AssertionError(show(f"{self.claim} on {self.case.id} was not checked: {finding.why}"))
        if self.claim == FOLLOWS and finding.outcome == Outcome.PASSED:
            self._require_accuracy()
        if finding.outcome == Outcome.NOT_APPLICABLE:
            pytest.skip(show(finding.why))
        if finding.outcome == Outcome.FAILED:
            row, report = Row(self.claim, self.case.id, finding), Report(self.integrator.id, self.depth.name)
            alone = [f"  command:  {command(report, row, self.how)}"] if self.how else []
            raise AssertionError("\n".join(map(show, [*failure(row), *alone])))

    def _finding(self, claim: str) -> Finding:
        return _finding(self.integrator, CaseSpec.of(self.case), self.depth, claim)

    def _require_accuracy(self) -> None:
        """Raise AssertionError if no claim about accuracy passed or failed on the case."""
        rows = []
        for name in (FOLLOWS, *ACCURACY):
            rows.append(Row(name, self.case.id, self._finding(name)))
            gaps = Report(self.integrator.id, self.depth.name, rows, cases=(self.case.id,)).gaps()
            if not gaps:
                return
        raise AssertionError("\n".join(map(show, gaps)))


@lru_cache(maxsize=256)
def _finding(integrator: Integrator, spec: CaseSpec, depth: Depth, claim: str) -> Finding:
    return CLAIMS[claim].check(_trials(integrator, spec, depth))


@lru_cache(maxsize=16)
def _trials(integrator: Integrator, spec: CaseSpec, depth: Depth) -> Trials:
    """The solutions on one case, shared by its claims."""
    return Trials.of(integrator, spec, depth)


def claim_tests(
    integrator: Integrator, depth: str = "low", names: Sequence[selection.CaseLike] | None = None, how: str = ""
) -> list[ClaimTest]:
    """The tests of the claims about an integrator, case by case; arguments and errors as in `verify.verify`.

    For `how` see `ClaimTest`. Also raises ValueError if no case offers a form that the integrator accepts.
    """
    tests = [
        ClaimTest(integrator, case, claim, DEPTHS[depth], how)
        for case, claims in plan_verification(integrator, names, depth)
        for claim in claims
    ]
    if not tests:
        raise ValueError(f"no case has a form that {integrator.id} accepts, so there is nothing to verify")
    return tests


def parametrize(
    integrator: Integrator,
    depth: str = "low",
    cases: Sequence[selection.CaseLike] | None = None,
    known_failures: Path | str | None = None,
) -> pytest.MarkDecorator:
    """Parametrize a test over claims and cases: one test for each claim about an integrator on each case.

    Parameters
    ----------
    integrator : Integrator
        The integrator to verify.
    depth : {"low", "normal", "high"}
        The number of cases and the shortest steps.
    cases : sequence of str, Case or ExactCase, optional
        Names as ``case`` or ``case/variant``, or cases of `gnomon.case`; by default the cases of the depth.
    known_failures : path, optional
        A text file with a line ``CLAIM CASE REASON`` for each known failure. Their tests are expected failures.

    Returns
    -------
    pytest.MarkDecorator
        The decorator of a test that takes the argument `check` and calls it.

    Raises
    ------
    ValueError
        For an unknown name, a wrong declaration or an invalid file, if no case offers a form that the integrator
        accepts, or if pytest is not installed.

    Examples
    --------
    >>> from gnomon.verify import from_step, parametrize
    >>> euler = from_step(lambda f, t, y, h: y + h * f(t, y), name="Euler", order=1)
    >>> @parametrize(euler)
    ... def test_euler(check):
    ...     check()
    """
    extras.require("test", "parametrize")
    import pytest  # as above

    known: Mapping[tuple[str, str], str] = {} if known_failures is None else read_known(Path(known_failures))
    return pytest.mark.parametrize(
        "check",
        [pytest.param(test, id=test.id, marks=test.marks(known)) for test in claim_tests(integrator, depth, cases)],
    )


def assert_follows(
    integrator: Integrator, case: selection.CaseLike, setting: float, within: float | None = None
) -> None:
    """Assert that an integrator follows the exact motion of a case at one setting.

    Parameters
    ----------
    integrator : Integrator
        The integrator to test.
    case : str, Case or ExactCase
        A case, of `gnomon.case` too, or its name, as ``case`` or ``case/variant``.
    setting : float
        The step size (s), or the tolerance.
    within : float, optional
        The largest error in the case's metric. By default, for a tolerance only, the bound that the local errors of all
        steps may add up to.

    Raises
    ------
    AssertionError
        If the error is larger, or there is no solution. The message shows the exact and the computed state at the worst
        sample.
    ValueError
        For a bound that is not positive, and without a bound for a step size, or a tolerance that bounds no error.

    Examples
    --------
    >>> from gnomon.verify import assert_follows, from_step
    >>> euler = from_step(lambda f, t, y, h: y + h * f(t, y), name="Euler", order=1)
    >>> assert_follows(euler, "projectile_parabola", setting=0.01, within=0.1)
    """
    (chosen,) = selection.find_cases([case])
    if within is not None and not 0 < within < math.inf:
        raise ValueError(f"within={within}: give a positive error")
    trials = _trials(integrator, CaseSpec.of(chosen), DEPTHS["high"])
    if within is None and trials.steps:
        raise ValueError(f"{integrator.id} takes step sizes, which bound no error; give within=, the largest error")
    answer = trials.whole(setting)
    allowed = sum_allowed_errors(trials, setting, answer) if within is None else within
    if within is None and not allowed < INACCURATE and not answer.declined:
        raise ValueError(
            f"{integrator.id}: tolerance {setting:g} bounds the error by {allowed:.2g} of the size of the motion, which says"
            " nothing; give within=, the largest error, or a tighter tolerance"
        )
    if not answer.declined and answer.error <= allowed:
        return
    raise AssertionError("\n".join(map(show, _departure(trials, answer, allowed))))


def _departure(trials: Trials, answer: Answer, allowed: float) -> list[str]:
    """The message about a wrong motion: its error, and the worst sample component by component."""
    named = f"{trials.integrator.id} on {trials.case.id} at {trials.named(answer.setting)}"
    if answer.states is None or math.isnan(answer.error):
        return [f"{named} has no solution: {answer.why}"]
    exact, times = trials.reference.exact, trials.reference.times
    worst = int(np.argmax(answer.errors))
    lines = [
        f"{named}: error {answer.error:.3g}, allowed {allowed:.3g}, floor {trials.reference.floor[worst]:.2g}"
        + (f"; stopped: {answer.stopped}" if answer.stopped else ""),
        f"largest at sample {worst + 1} of {len(times)}, t = {times[worst]:.17g}:",
    ]
    for coordinate, right, got in zip(trials.case.state, exact[worst], answer.states[worst], strict=True):
        ulps = (got - right) / np.spacing(abs(right))
        lines.append(
            f"  {coordinate.name}: exact {right:.17g}, computed {got:.17g}, difference {got - right:.3g} {coordinate.unit},"
            f" {ulps:.3g} ulp"
        )
    return lines
