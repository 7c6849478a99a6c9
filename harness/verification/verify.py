"""Verifies an integrator: plans the claims on each case, and runs each case in its own process, which can be killed."""

from __future__ import annotations

import json
import math
import re
import traceback
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import partial
from itertools import zip_longest
from multiprocessing.connection import Connection
from time import monotonic
from typing import Any

from gnomon.cases import Case
from gnomon.cases.core.forms import FirstOrder
from gnomon.cases.core.numbers import nearest
from gnomon.harness.contract.integrator import Integrator, Refused, Steps, TooManyCalls, Unsupported
from gnomon.harness.contract.problem import problem_of, takes
from gnomon.harness.contract.validation import Unusable
from gnomon.harness.contract.velocity_forces import VelocityForces, require_velocities
from gnomon.harness.measuring.reference_solution import CaseSpec
from gnomon.harness.measuring.trials import Trials
from gnomon.harness.registry import declaration, lookup, references, selection
from gnomon.harness.studies import preflight
from gnomon.harness.system.limitations import need_fork
from gnomon.harness.system.supervisor import Job, Send, run, sender
from gnomon.harness.verification import (
    call_claims,
    control_claims,
    convergence_claims,
    equation_claims,
    event_claims,
    quadrature_claim,
    relation_claims,
    structure_claims,
)
from gnomon.harness.verification.claims import (
    DEPTHS,
    TEXTS,
    TIME,
    Claim,
    Depth,
    Finding,
    Outcome,
    fail_claim,
    not_applicable,
    not_checked,
    pass_claim,
)
from gnomon.harness.verification.diagnosis import Facts, Failures, conclude, digest, facts, of_many_calls
from gnomon.harness.verification.function_adapter import FunctionAdapter, Stepped

from gnomon import cases

_MODULES = (
    convergence_claims, quadrature_claim, control_claims, structure_claims, relation_claims, call_claims,
    equation_claims, event_claims,
)  # fmt: skip
_DECLARED = [value for module in _MODULES for value in vars(module).values() if isinstance(value, Claim)]
CLAIMS = {
    name: next(claim for claim in _DECLARED if claim.id == name)
    for name in TEXTS
    if name not in (TIME, *preflight.TEXTS)
}
"""All claims about one integrator by id, the most informative first."""
CASES = (
    "pendulum_simple", "forced_oscillator", "kepler_orbit", "bouncing_ball", "sliding_can",
    "block_incline_friction", "euler_top", "charge_in_E_and_B", "holonomic_constraint_dae",
    "rotating_pendulum_swept", "damped_oscillator", "duffing_unforced", "cycloidal_pendulum",
    "foucault_pendulum_linear", "projectile_parabola", "coulomb_friction_oscillator", "two_body",
    "lagrange_top_attitude",
)  # fmt: skip
"""A depth takes the first of these cases that an integrator accepts; each has another form or difficulty."""
FOLLOWS = "follows"
ACCURACY = (
    "order",
    "order_short",
    "error",
    "event_order",
    "tolerance",
    "tolerance_short",
    "proportional",
    "work_order",
    "hard",
)
"""Claims that compare errors with settings. On each case `FOLLOWS` and one of these must pass."""
SETTLED = (Outcome.PASSED, Outcome.FAILED)
NO_ANSWER = "no answer within"
"""The beginning of the reason for which a process that is late is ended."""
DECISIVE = ("runs", FOLLOWS)
"""Claims whose failure ends the other claims on a case: without states near the motion these find nothing more."""
UNCLAIMED = ("long", "engines", "speed", "turns", "orbits", "precessions", "revolutions")
"""Prefixes of the names of variants that are long rather than hard."""
CLAIM_SECONDS = {"low": 20.0, "normal": 60.0, "high": 600.0}
"""Processor seconds of a claim on a case. A claim that takes longer is tried once more; then the integrator hangs."""
REFERENCE_SECONDS = 600.0
FIRST = "first trial"
OVER = "the time of --max-seconds is over"


Measure = Callable[[Trials], Finding]


class FirstTrialError(Exception):
    """Raised if the integrator raises at its first trial; the message is the traceback.

    Examples
    --------
    >>> from gnomon.verify import from_step, verify
    >>> try:
    ...     verify(from_step(lambda f, t, y, h: y / "h", name="typo", order=1), ["pendulum_simple"], "low")
    ... except FirstTrialError as error:
    ...     print(str(error).splitlines()[-1][:9])
    TypeError
    """


@dataclass(frozen=True)
class Row:
    """The result of one claim on one case."""

    claim: str
    case: str
    finding: Finding


@dataclass(repr=False)
class Report:
    """The result of a verification; `print` shows the failures and the number of claims.

    Attributes
    ----------
    integrator : str
        The id of the integrator.
    depth : str
        The depth of the verification.
    rows : list of Row
        One row for each claim on each case.
    against : tuple of str, optional
        The other version as the user named it, and the files of both versions; None without another version.
    claims, cases : tuple of str
        The claims, and the cases, that the user named; empty if all were verified, or the cases of the depth.
    more_seconds : float
        The time (s) that the claims that were not checked would take, by the mean time of the others.
    diagnosis : str, optional
        The likely cause of all failures, as ``id: sentence``; None without failures or without a known cause.
    notes : tuple of str
        Further results in sentences, such as the change of the energy at practical steps. They are not failures.

    Examples
    --------
    >>> report = Report("mine:Euler", "low", [Row("order", "pendulum_simple", pass_claim("1.00"))])
    >>> report.checked, len(report.of(Outcome.FAILED))
    (1, 0)
    """

    integrator: str
    depth: str
    rows: list[Row] = field(default_factory=list)
    against: tuple[str, str] | None = None
    claims: tuple[str, ...] = ()
    cases: tuple[str, ...] = ()
    more_seconds: float = 0.0
    diagnosis: str | None = None
    notes: tuple[str, ...] = ()

    def __repr__(self) -> str:
        failed = [
            f"failed: {row.claim} on {row.case}{' at ' * bool(row.finding.setting)}{row.finding.setting}:"
            f" {row.finding.got}, expected {row.finding.expected}"
            for row in self.of(Outcome.FAILED)
        ]
        counts = ", ".join(f"{len(self.of(each))} {each.value}" for each in Outcome)
        cause = [f"likely cause: {self.diagnosis}"] if self.diagnosis else []
        checked = f"{self.checked} claims checked on {self.cases_checked} cases"
        return "\n".join([*failed, *cause, f"{self.integrator}: {checked}: {counts}"])

    def of(self, outcome: Outcome) -> list[Row]:
        """The rows with this outcome."""
        return [row for row in self.rows if row.finding.outcome == outcome]

    @property
    def checked(self) -> int:
        """The number of claims that passed or failed."""
        return len(self.of(Outcome.PASSED)) + len(self.of(Outcome.FAILED))

    @property
    def cases_checked(self) -> int:
        """The number of cases on which a claim passed or failed."""
        return len({row.case for row in self.rows if row.finding.outcome in SETTLED})

    def gaps(self) -> list[str]:
        """The checks that are missing before the integrator counts as verified, a sentence each. A failure is not a gap.

        All claims that the user named must be checked. If the user named none, each named or accepted case needs `FOLLOWS`
        and a claim of `ACCURACY`, except hard variants without a solution that the user did not name.
        """
        if self.claims:
            return [gap for name in self.claims for gap in self._gaps_of_claim(name)]
        by_case: dict[str, dict[str, Finding]] = {}
        for row in self.rows:
            if row.claim in CLAIMS and (self.cases or "/" not in row.case):
                by_case.setdefault(row.case, {})[row.claim] = row.finding
        if not self.cases:  # of a depth's own cases those that the integrator supports
            lacks = [case for case, of in by_case.items() if _outcome(of, FOLLOWS) == Outcome.NOT_APPLICABLE]
            by_case = {case: of for case, of in by_case.items() if case not in lacks}
        gaps = [] if by_case else ["no case takes this integrator"]
        for case, of in by_case.items():
            if _outcome(of, FOLLOWS) not in SETTLED:
                why = of[FOLLOWS].why if FOLLOWS in of else "it was not among the claims"
                gaps.append(f"{case}: {FOLLOWS} was not checked: {why}")
            elif not any(_outcome(of, name) in SETTLED for name in ACCURACY):
                why = "; ".join(f"{name}: {of[name].why}" for name in ACCURACY if name in of)
                gaps.append(f"{case}: no claim about accuracy was checked ({why})")
        return gaps

    def _gaps_of_claim(self, name: str) -> list[str]:
        rows = [row for row in self.rows if row.claim == name]
        each = self.cases and name in CLAIMS  # a pre-flight has scenes of its own
        enough = not each and any(row.finding.outcome in SETTLED for row in rows)
        open_ = [
            row
            for row in rows
            if row.finding.outcome not in SETTLED and not (enough and row.finding.outcome == Outcome.NOT_APPLICABLE)
        ]
        return (
            [f"{row.case}: {name} was not checked: {row.finding.why}" for row in open_]
            if rows
            else [f"{name} is made on no case"]
        )


def _outcome(findings: Mapping[str, Finding], name: str) -> Outcome | None:
    return findings[name].outcome if name in findings else None


def verify(
    integrator: Integrator,
    names: Sequence[selection.CaseLike] | None = None,
    depth: str = "normal",
    claims: Sequence[str] | None = None,
    max_seconds: float | None = None,
    workers: int = 2,
    progress: Callable[[Row], None] = lambda row: None,
    every: bool = False,
) -> Report:
    """Verify the claims about an integrator.

    Parameters
    ----------
    integrator : Integrator
        The integrator to verify.
    names : sequence of str, Case or ExactCase, optional
        Cases by name, as ``case`` or ``case/variant``, or as `gnomon.case` gives them; by default the cases of the depth.
    depth : {"low", "normal", "high"}
        The number of cases and the shortest steps.
    claims : sequence of str, optional
        Ids of claims, see `CLAIMS`; by default all claims.
    max_seconds : float, optional
        The time limit (s). Claims that are not verified by then are "not checked".
    workers : int
        The number of processes.
    progress : callable, optional
        It is called with each row when it is known.
    every : bool
        Whether all claims are verified on all cases. By default a failure whose cause is known ends the verification
        once the cases that have begun are complete, and a failure of `DECISIVE` ends the claims on its case.

    Returns
    -------
    Report
        The rows in order of cases and claims, and the likely cause of failures.

    Raises
    ------
    ValueError
        For an unknown name or a wrong declaration.
    FirstTrialError
        If the integrator raises at its first trial.

    Examples
    --------
    >>> from gnomon.verify import from_step, verify
    >>> euler = from_step(lambda f, t, y, h: y + h * f(t, y), name="Euler", order=1)
    >>> verify(euler, ["pendulum_simple"], "low", ["order_short"]).checked
    1
    """
    need_fork()
    chosen = plan_verification(integrator, names, depth, claims)
    report = Report(
        integrator.id, depth, claims=tuple(claims or ()), cases=tuple(case.id for case, _ in chosen) if names else ()
    )
    if not chosen:
        return report
    if isinstance(integrator, FunctionAdapter):
        integrator.compile()  # so that forks need not
    _first_trial(integrator, chosen[0][0], DEPTHS[depth])
    began = monotonic()

    def add(row: Row) -> None:
        report.rows.append(row)
        progress(row)

    ends = math.inf if max_seconds is None else began + max_seconds
    on = {case.id: case for case, _ in chosen}
    waiting = [CaseJob(integrator, case, DEPTHS[depth], add, ids, every=every) for case, ids in chosen]
    while waiting and monotonic() <= ends:
        known = len(report.of(Outcome.FAILED))

        def has_failed(known: int = known) -> bool:
            return not every and len(report.of(Outcome.FAILED)) > known

        waiting = run(waiting, workers, ends, has_failed)
        if has_failed() or (every and report.of(Outcome.FAILED)):
            report.diagnosis = _diagnose(integrator, report, on, ends)
        if report.diagnosis is not None and not every:
            break
    seconds = (monotonic() - began) / max(1, len(report.rows))
    for job in waiting:
        job.stop("a known cause ended the run; --all goes on" if report.diagnosis else OVER)
    report.more_seconds = seconds * len(report.of(Outcome.NOT_CHECKED))
    places = {name: place for place, name in enumerate([*on, *CLAIMS])}
    report.rows.sort(key=lambda row: (places[row.case], places[row.claim]))
    report.notes = _compare_orders(integrator, report)
    return report


def _compare_orders(integrator: Integrator, report: Report) -> tuple[str, ...]:
    """The sentence that compares the order of the errors at fixed steps with the declared order; none after a failure."""
    powers = [
        float(number[0]) - (row.claim == "step_order" and isinstance(integrator, Stepped))
        for row in report.of(Outcome.PASSED)
        if row.claim in ("order", "step_order", "order_short", "error")
        and (number := re.search(r"-?\d+\.\d+", row.finding.got))
    ]
    if not powers or report.of(Outcome.FAILED):
        return ()
    least, order = min(powers), integrator.order
    declared = "no order" if order is None else f"order {order}"
    text = f"errors fall as h^{least:.1f} at the slowest, h the step; {declared} is declared"
    higher = order is None or least >= order + convergence_claims.MARGIN
    return (text + f": declare order={round(least)} to verify it" * higher,)


def _diagnose(integrator: Integrator, report: Report, on: dict[str, Case], ends: float) -> str | None:
    """The likely cause of a report's failures, from solutions on one case in two new processes; None if time is over."""
    stopped = next(
        (row.finding.got for row in report.of(Outcome.FAILED) if TooManyCalls.__name__ in row.finding.got), None
    )
    if stopped is not None:
        return of_many_calls(stopped.partition(": ")[2])
    pairs = {outcome: frozenset((row.claim, row.case) for row in report.of(outcome)) for outcome in Outcome}
    got = tuple(
        row.finding.got for row in report.of(Outcome.FAILED) if row.claim in ("order", "order_short", "work_order")
    )
    failures = Failures(pairs[Outcome.FAILED], pairs[Outcome.PASSED], on, got)
    case = on[failures.probed()]
    fact_sets: list[Facts] = []
    for probe in (digest, facts):
        rows: list[Row] = []
        run([CaseJob(integrator, case, DEPTHS[report.depth], rows.append, [FIRST], partial(_probe, probe))], 1, ends)
        finding = rows[0].finding
        if finding.outcome == Outcome.NOT_CHECKED:
            return None
        fact_sets.append(json.loads(finding.got) if finding.outcome == Outcome.PASSED else {"raises": True})
    alone, rest = fact_sets
    declared = {"order": integrator.order, "stepped": isinstance(integrator, Stepped)}
    declared["may_take_differences"] = any(
        quadrature_claim.DIFFERENCES in row.finding.expected for row in report.of(Outcome.FAILED)
    )
    return conclude(failures, rest | declared | {"alone": alone, "steps": isinstance(integrator.sweep, Steps)})


def _probe(probe: Callable[[Trials], Facts], trials: Trials) -> Finding:
    return pass_claim(json.dumps(probe(trials)))


def plan_verification(
    integrator: Integrator, names: Sequence[selection.CaseLike] | None, depth: str, claims: Sequence[str] | None = None
) -> list[tuple[Case, list[str]]]:
    """The cases on which an integrator is verified, each with its claim ids; arguments and errors as in `verify`."""
    declaration.validate(integrator)
    absent = lookup.missing(integrator)
    if absent is not None:
        raise ValueError(f"{integrator.id} cannot run here: {absent}")
    if depth not in DEPTHS:
        raise ValueError(f"no depth is called {depth!r}; {nearest(depth, DEPTHS)}")
    ids = _claim_ids(claims)
    chosen = [case.rounded() for case in _cases(integrator, names, DEPTHS[depth])]
    first = next((case for case in chosen if case.variant is None), None)
    planned = [(case, [i for i in ids if _is_made(CLAIMS[i], case, first, bool(names))]) for case in chosen]
    return [(case, ids) for case, ids in planned if ids]


def _is_made(claim: Claim, case: Case, first: Case | None, named: bool) -> bool:
    """Whether a claim is made on a case; `first` is the first default variant.

    On a hard variant that the user `named` the claims about accuracy are made too.
    """
    if case.variant is not None:
        return claim.hard or (named and claim.id in (FOLLOWS, *ACCURACY))
    return not claim.hard and (case is first or not claim.once)


def _claim_ids(names: Sequence[str] | None) -> list[str]:
    for name in names or ():
        if name in preflight.TEXTS:
            raise ValueError(f"{name} is a pre-flight of an engine; name the engine with --engine")
        if name not in TEXTS:
            raise ValueError(f"no claim is called {name!r}; {nearest(name, TEXTS)}")
    return [name for name in CLAIMS if not names or name in names]


def _cases(integrator: Integrator, names: Sequence[selection.CaseLike] | None, depth: Depth) -> list[Case]:
    if not names:
        accepted = [case for case in map(cases.get, CASES) if takes(integrator, case)]
        if VelocityForces in integrator.accepts:  # forces with velocities and without, in turn
            with_velocities = [case for case in accepted if case.second_order is None and _has_velocities(case)]
            without = [case for case in accepted if case.second_order is not None]
            accepted = [case for pair in zip_longest(with_velocities, without) for case in pair if case is not None]
        accepted = accepted[: depth.cases]
        return accepted + _hard(accepted, depth.variants)
    chosen = selection.find_cases(names)
    for case in chosen:
        if not takes(integrator, case):
            accepted_names = " or ".join(kind.__name__ for kind in integrator.accepts)
            raise ValueError(
                f"{integrator.id} takes {accepted_names}, which {case.id} does not offer; name another case"
            )
    return chosen


def _has_velocities(case: Case) -> bool:
    try:
        require_velocities(problem_of(case.rounded(), (FirstOrder,)))
    except (Unsupported, ValueError):
        return False
    return True


def _hard(chosen: Sequence[Case], most: int) -> list[Case]:
    """Hard variants of the chosen cases, one of each case in turn."""
    lists = [[(case.name, v.name) for v in case.variants if not v.name.startswith(UNCLAIMED)] for case in chosen]
    longest = max(map(len, lists), default=0)
    return [cases.get(*each[k]) for k in range(longest) for each in lists if k < len(each)][:most]


def _first_trial(integrator: Integrator, case: Case, depth: Depth) -> None:
    """Raise FirstTrialError if the integrator raises on a case, at the coarsest and at a usual setting."""
    rows: list[Row] = []
    run([CaseJob(integrator, case, depth, rows.append, [FIRST], _first)], workers=1)
    if rows[0].finding.outcome == Outcome.FAILED:
        raise FirstTrialError(rows[0].finding.got)


@dataclass(eq=False)
class CaseJob(Job):
    """The claims still to be verified on one case. A claim that takes too long, or ends the process, fails.

    With `measure`, the process calls it for each name in `pending` instead of verifying a claim.
    """

    integrator: Integrator
    case: Case
    depth: Depth
    add: Callable[[Row], None]
    pending: list[str]
    measure: Measure | None = None
    runs: int = 1
    """Time limit of each name in `pending`, as a multiple of the limit of a claim."""
    limit: float = REFERENCE_SECONDS
    ready: bool = False
    """Whether the exact motion has been computed; the first message says so."""
    repeated: str | None = None
    """The claim that had no answer in time once and is tried again."""
    every: bool = True
    """Whether the other claims are verified after one of `DECISIVE` failed, or one had no answer in time."""

    def work(self, send: Send) -> None:
        _work(self.integrator, CaseSpec.of(self.case), self.depth, self.pending, self.measure, send)

    def process(self) -> tuple[str, Callable[[Connection], object]]:
        if references.process_method(self.integrator) == "fork":
            return super().process()
        work = partial(_serve, references.reference(self.integrator), CaseSpec.of(self.case), self.depth, self.pending)
        return "forkserver", partial(work, self.measure)

    def receive(self, message: Any) -> None:
        self.ready, self.limit = True, self.runs * CLAIM_SECONDS[self.depth.name]
        if message:
            self._row(Finding(**{**message, "outcome": Outcome(message["outcome"])}))

    def lose(self, why: str, late: bool = False) -> None:
        # A first trial of a hard variant may take as long as its claims may, but not end its process.
        slow = late and self.measure is _first and self.case.variant is not None
        again, silent = self.repeated == self.pending[0], self._may_be_silent or slow
        if late and not (again or silent):
            self.ready, self.limit, self.repeated = False, REFERENCE_SECONDS, self.pending[0]
            return
        why = f"{why}, twice" if late and again else why
        if not self.ready:
            raise ValueError(f"{self.case.id}: the exact motion could not be computed: {why}")
        self.ready, self.limit = False, REFERENCE_SECONDS
        a_hang = fail_claim("", "an answer", why, "A hang or a crash gives no answer.")
        self._row(not_applicable(f"no answer: {why}") if silent else a_hang, decisive=late and not silent)

    @property
    def _may_be_silent(self) -> bool:
        claim = CLAIMS.get(self.pending[0])
        return claim is not None and claim.no_answer

    def stop(self, why: str = OVER) -> None:
        while self.pending:
            self._row(not_checked(why))

    def _row(self, finding: Finding, decisive: bool = False) -> None:
        claim = self.pending.pop(0)
        self.add(Row(claim, self.case.id, finding))
        decisive |= claim in DECISIVE or TooManyCalls.__name__ in finding.got
        if decisive and finding.outcome == Outcome.FAILED and not self.every:
            self.stop(f"{claim} failed; --all verifies the other claims too")


def _work(
    integrator: Integrator, spec: CaseSpec, depth: Depth, pending: Sequence[str], measure: Measure | None, send: Send
) -> None:
    trials = Trials.of(integrator, spec, depth)
    send({})
    for name in pending:
        send(asdict(CLAIMS[name].check(trials) if measure is None else measure(trials)))


def _serve(
    reference: references.Reference,
    spec: CaseSpec,
    depth: Depth,
    pending: Sequence[str],
    measure: Measure | None,
    connection: Connection,
) -> None:
    """The work of a CaseJob in a process that imports the user's module again."""
    _work(references.dereference(reference), spec, depth, pending, measure, sender(connection))


def _first(trials: Trials) -> Finding:
    """Failed if the integrator raises both at the coarsest and at a usual setting.

    The text is the traceback, or the fault of the answer.
    """
    text = ""
    for setting in (trials.settings[0], trials.usual()):
        try:
            trials.solutions(trials.problem(), setting, [trials.start])
        except (Refused, TooManyCalls):  # which the claims judge
            return Finding(Outcome.PASSED)
        except Unusable as error:  # an answer of the user's code, which has no traceback
            text = f"{trials.integrator.id}: {error}"
        except Exception as error:  # the user's code may raise anything: it is shown
            shown = traceback.TracebackException.from_exception(error)
            modules = (frame.f_globals.get("__name__", "") for frame, _ in traceback.walk_tb(error.__traceback__))
            pairs = zip(shown.stack, modules, strict=True)
            shown.stack[:] = [line for line, module in pairs if not module.startswith("gnomon.harness.")] or shown.stack
            text = "".join(shown.format())
        else:
            return Finding(Outcome.PASSED)
    return fail_claim("", "states", text)
