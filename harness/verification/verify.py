"""Verifies an integrator: which claims on which cases, each case in a process of its own that can be killed."""

from __future__ import annotations

import json
import math
import multiprocessing
import os
import sys
import traceback
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, field
from functools import partial
from multiprocessing.connection import Connection, wait
from time import monotonic
from typing import Any

from gnomon.cases import Case
from gnomon.cases.core.numbers import nearest
from gnomon.harness.contract.integrator import Integrator, Refused
from gnomon.harness.contract.problem import accepted_form
from gnomon.harness.registry import declaration, lookup
from gnomon.harness.scoring.reference_solution import CaseSpec, reference_solution
from gnomon.harness.system.child_process import guarded, queued_seconds
from gnomon.harness.verification import conduct_claims, convergence_claims, structure_claims
from gnomon.harness.verification.claims import TEXTS, Claim, Finding, Outcome, failed, not_applicable
from gnomon.harness.verification.trials import DEPTHS, Depth, Trials

from gnomon import cases

_DECLARED = [*vars(convergence_claims).values(), *vars(structure_claims).values(), *vars(conduct_claims).values()]
CLAIMS = {name: next(c for c in _DECLARED if isinstance(c, Claim) and c.id == name) for name in TEXTS}
"""All claims by id, from the most telling."""
CASES = (
    "pendulum_simple", "forced_oscillator", "kepler_orbit", "bouncing_ball", "block_incline_friction", "euler_top",
    "charge_in_E_and_B", "holonomic_constraint_dae", "damped_oscillator", "duffing_unforced", "cycloidal_pendulum",
    "foucault_pendulum_linear", "projectile_parabola", "coulomb_friction_oscillator", "two_body",
)  # fmt: skip
"""Cases in the sequence in which a depth takes those that an integrator accepts: each has another form or difficulty."""
UNCLAIMED = ("long", "engines", "speed", "turns", "orbits", "precessions", "revolutions")
"""Beginnings of names of variants that are long rather than hard."""
CLAIM_SECONDS = {"low": 20.0, "normal": 60.0, "high": 600.0}
"""Seconds, without waits for the processor, after which a claim on a case ends as failed: the integrator hangs."""
REFERENCE_SECONDS = 600.0
FIRST = "first trial"


class FirstTrialError(Exception):
    """The integrator raises at its first trial; the message is the traceback."""


@dataclass(frozen=True)
class Row:
    """What became of one claim on one case."""

    claim: str
    case: str
    finding: Finding


@dataclass
class Report:
    """All rows of a verification, and what is needed to repeat one of them."""

    integrator: str
    depth: str
    rows: list[Row] = field(default_factory=list)

    def of(self, outcome: Outcome) -> list[Row]:
        return [row for row in self.rows if row.finding.outcome == outcome]

    @property
    def checked(self) -> int:
        """The number of claims that passed or failed."""
        return len(self.of(Outcome.PASSED)) + len(self.of(Outcome.FAILED))


@dataclass
class _Job:
    """The claims that are still to be verified on one case, and the process that does it."""

    case: Case
    pending: list[str]
    process: Any = None
    connection: Connection | None = None
    deadline: float = math.inf
    queued: float = 0.0
    ready: bool = False


def verify(
    integrator: Integrator,
    names: Sequence[str] | None = None,
    depth: str = "normal",
    claims: Sequence[str] | None = None,
    max_seconds: float | None = None,
    workers: int = 2,
    progress: Callable[[Row], None] = lambda row: None,
) -> Report:
    """Verify the claims about an integrator, on the cases named (`case` or `case/variant`) or on those of the depth.

    Raises ValueError for wrong names or a wrong declaration, FirstTrialError if its first trial raises.
    """
    declaration.validate(integrator)
    absent = lookup.missing(integrator)
    if absent is not None:
        raise ValueError(f"{integrator.id} cannot run here: {absent}")
    chosen_depth, ids = _depth(depth), _claim_ids(claims)
    jobs = _jobs(integrator, names, chosen_depth, ids)
    report = Report(integrator.id, depth)
    if not jobs:
        return report
    _first_trial(integrator, jobs[0].case, chosen_depth)

    def add(row: Row) -> None:
        report.rows.append(row)
        progress(row)

    ends = math.inf if max_seconds is None else monotonic() + max_seconds
    _Runner(integrator, chosen_depth, workers, add, ends).run(jobs)
    places = {name: place for place, name in enumerate(CLAIMS)}
    report.rows.sort(key=lambda row: ([job.case.id for job in jobs].index(row.case), places[row.claim]))
    return report


def _depth(name: str) -> Depth:
    if name not in DEPTHS:
        raise ValueError(f"no depth is called {name!r}; {nearest(name, DEPTHS)}")
    return DEPTHS[name]


def _claim_ids(given: Sequence[str] | None) -> list[str]:
    for name in given or ():
        if name not in CLAIMS:
            raise ValueError(f"no claim is called {name!r}; {nearest(name, CLAIMS)}")
    return [name for name in CLAIMS if not given or name in given]


def _jobs(integrator: Integrator, names: Sequence[str] | None, depth: Depth, ids: list[str]) -> list[_Job]:
    if names:
        chosen = [cases.get(*_case_and_variant(name)) for name in names]
        for case in chosen:
            if not _takes(integrator, case):
                accepted_names = " or ".join(kind.__name__ for kind in integrator.accepts)
                raise ValueError(
                    f"{integrator.id} takes {accepted_names}, which {case.id} does not offer; name another case"
                )
    else:
        accepted = [case for case in map(cases.get, CASES) if _takes(integrator, case)][: depth.cases]
        chosen = accepted + _hard(accepted, depth.variants)
    found = [_Job(case.rounded(), [i for i in ids if CLAIMS[i].hard == (case.variant is not None)]) for case in chosen]
    return [job for job in found if job.pending]


def _case_and_variant(name: str) -> tuple[str, str | None]:
    base, _, variant = name.partition("/")
    return base, variant or None


def _takes(integrator: Integrator, case: Case) -> bool:
    form = accepted_form(case, integrator.accepts)
    return form is not None and integrator.unsupported(form) is None


def _hard(chosen: Sequence[Case], most: int) -> list[Case]:
    """Hard variants of the chosen cases, one of each in turn."""
    lists = [[(case.name, v.name) for v in case.variants if not v.name.startswith(UNCLAIMED)] for case in chosen]
    longest = max(map(len, lists), default=0)
    return [cases.get(*each[k]) for k in range(longest) for each in lists if k < len(each)][:most]


def _first_trial(integrator: Integrator, case: Case, depth: Depth) -> None:
    """Raise FirstTrialError if the integrator raises on a case, at the coarsest and at a usual setting."""
    found: list[Row] = []
    _Runner(integrator, depth, 1, found.append, math.inf).run([_Job(case, [FIRST])])
    if found[0].finding.outcome == Outcome.FAILED:
        raise FirstTrialError(found[0].finding.got)


class _Runner:
    """Runs jobs in up to `workers` processes. A claim that takes too long, or ends the process, has failed."""

    def __init__(
        self, integrator: Integrator, depth: Depth, workers: int, add: Callable[[Row], None], ends: float
    ) -> None:
        self.integrator, self.depth, self.workers, self.add, self.ends = integrator, depth, workers, add, ends
        self._running: list[_Job] = []

    def run(self, jobs: Sequence[_Job]) -> None:
        waiting = list(jobs)
        try:
            while waiting or self._running:
                while waiting and len(self._running) < self.workers:
                    self._start(waiting.pop(0))
                self._listen()
        finally:
            for job in list(self._running):
                self._end(job)

    def _start(self, job: _Job) -> None:
        context = multiprocessing.get_context("fork")  # the user's object need not be found again by name
        ours, theirs = context.Pipe()
        work = partial(_serve, theirs, self.integrator, CaseSpec.of(job.case), list(job.pending), self.depth)
        job.process, job.connection, job.ready = context.Process(target=guarded, args=(work,)), ours, False
        sys.stdout.flush()
        job.process.start()
        theirs.close()
        job.deadline, job.queued = monotonic() + REFERENCE_SECONDS, 0.0
        self._running.append(job)

    def _listen(self) -> None:
        connections = [job.connection for job in self._running if job.connection is not None]
        nearest_end = min([self.ends, *(job.deadline for job in self._running)])
        wait(connections, max(0.0, min(nearest_end - monotonic(), 1.0)))
        for job in list(self._running):
            self._read(job)
        now = monotonic()
        for job in [job for job in self._running if now > min(job.deadline, self.ends)]:
            waited = queued_seconds(job.process.pid) - job.queued
            if now > self.ends:
                self._end(job)
                for claim in job.pending:
                    self.add(Row(claim, job.case.id, not_applicable("the time of --max-seconds is over")))
            elif waited > 1e-3:
                job.deadline, job.queued = job.deadline + waited, job.queued + waited
            else:
                seconds = CLAIM_SECONDS[self.depth.name]
                self._lost(job, f"none within {seconds:g} s")

    def _read(self, job: _Job) -> None:
        assert job.connection is not None
        try:
            while job.connection.poll():
                message = json.loads(job.connection.recv_bytes(2**20))  # data only: the user's code runs in the process
                job.deadline = monotonic() + CLAIM_SECONDS[self.depth.name]
                job.queued = queued_seconds(job.process.pid)
                job.ready = True
                if message:
                    claim = job.pending.pop(0)
                    finding = Finding(**{**message, "outcome": Outcome(message["outcome"])})
                    self.add(Row(claim, job.case.id, finding))
        except (EOFError, OSError):
            job.process.join()
            if job.pending:
                self._lost(job, f"its process ended with exit code {job.process.exitcode}")
            else:
                self._end(job)

    def _lost(self, job: _Job, got: str) -> None:
        """The process hangs or has ended: the claim that it was at has failed, the others are verified in a new one."""
        self._end(job)
        claim = job.pending.pop(0)
        if not job.ready:
            raise ValueError(f"{job.case.id}: the exact motion could not be computed: {got}")
        if claim in CLAIMS and CLAIMS[claim].hard:
            self.add(Row(claim, job.case.id, not_applicable(f"no answer: {got}")))
        else:
            self.add(Row(claim, job.case.id, failed("", "an answer", got, "A hang or a crash gives no answer.")))
        if job.pending:
            self._start(job)

    def _end(self, job: _Job) -> None:
        self._running.remove(job)
        if job.process.is_alive():
            job.process.terminate()
        job.process.join()
        if job.connection is not None:
            job.connection.close()


def _serve(connection: Connection, integrator: Integrator, spec: CaseSpec, ids: list[str], depth: Depth) -> None:
    """Verify claims in a child process, and send each finding; what the integrator prints is discarded."""
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 1)
    os.dup2(null, 2)
    case, _ = spec.build()
    trials = Trials(integrator, case, reference_solution(spec), depth)
    connection.send_bytes(b"{}")
    for name in ids:
        finding = _first(trials) if name == FIRST else CLAIMS[name].check(trials)
        connection.send_bytes(json.dumps(asdict(finding)).encode())


def _first(trials: Trials) -> Finding:
    """Failed, with the traceback, if the integrator raises at the coarsest and at a usual setting."""
    text = ""
    for setting in (trials.settings[0], trials.usual()):
        try:
            trials.solutions(trials.problem(), setting, [trials.start])
        except Refused:
            return Finding(Outcome.PASSED)
        except Exception as error:  # the user's code may raise anything: it is shown
            frames = error.__traceback__
            while frames is not None and frames.tb_frame.f_globals.get("__name__", "").startswith(__package__ or " "):
                frames = frames.tb_next
            text = "".join(traceback.format_exception(type(error), error, frames or error.__traceback__))
        else:
            return Finding(Outcome.PASSED)
    return failed("", "states", text)
