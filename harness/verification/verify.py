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
from gnomon.harness.running import plan
from gnomon.harness.scoring.reference_solution import CaseSpec
from gnomon.harness.system.child_process import guarded, queued_seconds
from gnomon.harness.system.limitations import need_fork
from gnomon.harness.verification import (
    conduct_claims,
    convergence_claims,
    event_claims,
    relation_claims,
    structure_claims,
)
from gnomon.harness.verification.claims import TEXTS, TIME, Claim, Finding, Outcome, failed, not_applicable
from gnomon.harness.verification.trials import DEPTHS, Depth, Trials

from gnomon import cases

_MODULES = (convergence_claims, structure_claims, relation_claims, conduct_claims, event_claims)
_DECLARED = [value for module in _MODULES for value in vars(module).values() if isinstance(value, Claim)]
CLAIMS = {name: next(claim for claim in _DECLARED if claim.id == name) for name in TEXTS if name != TIME}
"""All claims about one integrator by id, from the most telling."""
CASES = (
    "pendulum_simple", "forced_oscillator", "kepler_orbit", "bouncing_ball", "block_incline_friction", "euler_top",
    "charge_in_E_and_B", "holonomic_constraint_dae", "rotating_pendulum_swept", "damped_oscillator", "duffing_unforced",
    "cycloidal_pendulum", "foucault_pendulum_linear", "projectile_parabola", "coulomb_friction_oscillator", "two_body",
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
    against: tuple[str, str] | None = None
    """The other version as it was named, and which files the two versions are; None without one."""

    def of(self, outcome: Outcome) -> list[Row]:
        return [row for row in self.rows if row.finding.outcome == outcome]

    @property
    def checked(self) -> int:
        """The number of claims that passed or failed."""
        return len(self.of(Outcome.PASSED)) + len(self.of(Outcome.FAILED))


@dataclass
class Job:
    """The claims that are still to be verified on one case, and the process that does it.

    With `measure`, the process calls it instead for each name in `pending`, which is then no claim.
    """

    case: Case
    pending: list[str]
    measure: Callable[[Trials], Finding] | None = None
    runs: int = 1
    """Each name in `pending` may take so many times as long as a claim."""
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
    need_fork()
    jobs = [Job(case, ids) for case, ids in planned(integrator, names, depth, claims)]
    report, chosen_depth = Report(integrator.id, depth), DEPTHS[depth]
    if not jobs:
        return report
    _first_trial(integrator, jobs[0].case, chosen_depth)

    def add(row: Row) -> None:
        report.rows.append(row)
        progress(row)

    ends = math.inf if max_seconds is None else monotonic() + max_seconds
    Runner(integrator, chosen_depth, workers, add, ends).run(jobs)
    places = {name: place for place, name in enumerate(CLAIMS)}
    report.rows.sort(key=lambda row: ([job.case.id for job in jobs].index(row.case), places[row.claim]))
    return report


def planned(
    integrator: Integrator, names: Sequence[str] | None, depth: str, claims: Sequence[str] | None = None
) -> list[tuple[Case, list[str]]]:
    """The cases on which an integrator is verified, each with the ids of its claims; arguments and errors as `verify`."""
    declaration.validate(integrator)
    absent = lookup.missing(integrator)
    if absent is not None:
        raise ValueError(f"{integrator.id} cannot run here: {absent}")
    if depth not in DEPTHS:
        raise ValueError(f"no depth is called {depth!r}; {nearest(depth, DEPTHS)}")
    ids = _claim_ids(claims)
    chosen = [case.rounded() for case in _cases(integrator, names, DEPTHS[depth])]
    found = [(case, [i for i in ids if CLAIMS[i].hard == (case.variant is not None)]) for case in chosen]
    return [(case, ids) for case, ids in found if ids]


def _claim_ids(given: Sequence[str] | None) -> list[str]:
    for name in given or ():
        if name not in TEXTS:
            raise ValueError(f"no claim is called {name!r}; {nearest(name, TEXTS)}")
    return [name for name in CLAIMS if not given or name in given]


def _cases(integrator: Integrator, names: Sequence[str] | None, depth: Depth) -> list[Case]:
    if not names:
        accepted = [case for case in map(cases.get, CASES) if _takes(integrator, case)][: depth.cases]
        return accepted + _hard(accepted, depth.variants)
    chosen = [case for case, _ in plan.choose(names, variants=False)]
    for case in chosen:
        if not _takes(integrator, case):
            accepted_names = " or ".join(kind.__name__ for kind in integrator.accepts)
            raise ValueError(
                f"{integrator.id} takes {accepted_names}, which {case.id} does not offer; name another case"
            )
    return chosen


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
    Runner(integrator, depth, 1, found.append, math.inf).run([Job(case, [FIRST], _first)])
    if found[0].finding.outcome == Outcome.FAILED:
        raise FirstTrialError(found[0].finding.got)


class Runner:
    """Runs jobs in up to `workers` processes. A claim that takes too long, or ends the process, has failed."""

    def __init__(
        self, integrator: Integrator, depth: Depth, workers: int, add: Callable[[Row], None], ends: float
    ) -> None:
        self.integrator, self.depth, self.workers, self.add, self.ends = integrator, depth, workers, add, ends
        self._running: list[Job] = []

    def run(self, jobs: Sequence[Job]) -> None:
        waiting = list(jobs)
        try:
            while waiting or self._running:
                while waiting and len(self._running) < self.workers:
                    self._start(waiting.pop(0))
                self._listen()
        finally:
            for job in list(self._running):
                self._end(job)

    def _start(self, job: Job) -> None:
        context = multiprocessing.get_context("fork")  # the user's object need not be found again by name
        ours, theirs = context.Pipe()
        work = partial(
            _serve, theirs, self.integrator, CaseSpec.of(job.case), list(job.pending), self.depth, job.measure
        )
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
                seconds = job.runs * CLAIM_SECONDS[self.depth.name]
                self._lost(job, f"none within {seconds:g} s")

    def _read(self, job: Job) -> None:
        assert job.connection is not None
        try:
            while job.connection.poll():
                message = json.loads(job.connection.recv_bytes(2**20))  # data only: the user's code runs in the process
                job.deadline = monotonic() + job.runs * CLAIM_SECONDS[self.depth.name]
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

    def _lost(self, job: Job, got: str) -> None:
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

    def _end(self, job: Job) -> None:
        self._running.remove(job)
        if job.process.is_alive():
            job.process.terminate()
        job.process.join()
        if job.connection is not None:
            job.connection.close()


def _serve(
    connection: Connection,
    integrator: Integrator,
    spec: CaseSpec,
    ids: list[str],
    depth: Depth,
    measure: Callable[[Trials], Finding] | None,
) -> None:
    """Verify claims in a child process, and send each finding; what the integrator prints is discarded."""
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, 1)
    os.dup2(null, 2)
    trials = Trials.of(integrator, spec, depth)
    connection.send_bytes(b"{}")
    for name in ids:
        finding = CLAIMS[name].check(trials) if measure is None else measure(trials)
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
