"""One short trial of each integrator of a user's own, before a run: shows the traceback of code that raises."""

from collections.abc import Sequence
from dataclasses import dataclass, field

from gnomon.cases import Case
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.contract.problem import problem_of
from gnomon.harness.contract.status import Status
from gnomon.harness.measuring.outcome import Outcome
from gnomon.harness.measuring.reference_solution import CaseSpec, ReferenceSolution, reference_solutions
from gnomon.harness.measuring.settings import sweep_settings
from gnomon.harness.registry.lookup import is_users_own
from gnomon.harness.registry.references import start_method
from gnomon.harness.running import plan
from gnomon.harness.running.plan import Suite
from gnomon.harness.running.pool import PREPARE_SECONDS, Pool
from gnomon.harness.running.sweep import task_of
from gnomon.harness.running.worker import Request, Task


@dataclass
class FirstTrial:
    """First trial of one integrator on one case: at the coarsest setting and, if that crashes, at the middle one.

    A correct method may fail at steps that are too large; wrong code fails at both settings.
    """

    integrator: Integrator
    case_id: str
    task: Task
    limit_seconds: float
    settings: list[float]
    crashes: list[str] = field(default_factory=list)
    """The traceback of each trial that crashed, or the reason if there is no traceback."""
    passed: bool = False

    def next(self) -> Request | None:
        if self.passed or not self.settings:
            return None
        return Request(self.settings.pop(0), self.integrator.counts_rhs, 0.0, 1, 0.0)

    def done(self, outcome: Outcome) -> None:
        self.passed = True

    def failed(self, status: Status, reason: str, output: str, tries: int | None = None) -> None:
        self.passed = status != Status.CRASHED  # the run itself reports other failures, such as a refusal or a timeout
        self.crashes.append(output.strip() if "Traceback (most recent call last)" in output else reason)


def crashes(
    chosen: Sequence[tuple[Case, str]],
    integrators: Sequence[Integrator],
    suite: Suite,
    prepare_seconds: float = PREPARE_SECONDS,
) -> list[str]:
    """One text for each integrator of a user's own whose first trials all crash: id, case, last traceback."""
    series = []
    for integrator in filter(is_users_own, integrators):
        pairs = plan.list_series(chosen, [integrator], formulations=False)
        series += [pair for pair in pairs if pair.left_out is None][:1]
    solutions = reference_solutions(list(dict.fromkeys(CaseSpec.of(pair.case) for pair in series)), lambda: None)
    trials = []
    for pair in series:
        case, integrator, exact = pair.case, pair.integrator, solutions[CaseSpec.of(pair.case)]
        if isinstance(exact, ReferenceSolution):  # else the run reports the error of the case
            problem = problem_of(case, integrator.accepts)
            settings = sweep_settings(integrator, case, problem, suite.scope.settings)
            chosen_two, limit = [settings[0], settings[len(settings) // 2]], suite.limit(case, integrator)
            trials.append(FirstTrial(integrator, case.id, task_of(pair, exact), limit, chosen_two))
    if trials:
        Pool(1, start_method(trial.integrator for trial in trials), prepare_seconds).run(trials)
    return [f"{trial.integrator.id} on {trial.case_id}: {trial.crashes[-1]}" for trial in trials if not trial.passed]
