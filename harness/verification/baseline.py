"""Baselines: a small committed text file records the results of an integrator; later runs are compared with it.

A row is one setting on one case. Errors, right-hand sides and steps are ranges over RUNS runs whose starts are
perturbed by ulps. A later value far outside its range is not noise of rounding, of a compiler or of a mathematical
library.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, fields
from functools import partial
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from gnomon.cases.core.registry import case_class, installed_names
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.contract.status import SCORED, Status
from gnomon.harness.measuring.failures import status_of
from gnomon.harness.measuring.perturbed_starts import perturb_start
from gnomon.harness.measuring.score import INACCURATE
from gnomon.harness.measuring.trials import Floats, Trials
from gnomon.harness.results.regression import Verdict, compare
from gnomon.harness.system.files import read_text
from gnomon.harness.system.supervisor import run
from gnomon.harness.verification.claims import DEPTHS, Finding, Outcome
from gnomon.harness.verification.verify import CaseJob, Row, plan_verification
from gnomon.reference.numerics.precision import shortened
from gnomon.reference.storage.version import VERSION

FORMAT = "gnomon baseline 1"
RUNS = 16
RANGES = {"error": "errors", "rhs": "right-hand sides", "steps": "steps"}
ENDS = ("low", "high")
NOISE = 0.01
"""Largest relative difference of counts between two builds of equal code; 0.3 % was observed."""
CONDITIONED = 10.0
"""Another compiler or library changes an error by at most this many times the conditioning (effect of half an ulp)."""


@dataclass(frozen=True)
class Entry:
    """One setting on one case. `numbers` is a hash of the case's numbers; `floor` and `conditioning` are its largest.

    Ranges without a measurement are nan.
    """

    case: str
    variant: str
    numbers: str
    setting_kind: str
    setting: float
    status: Status
    floor: float
    conditioning: float
    error_low: float = math.nan
    error_high: float = math.nan
    rhs_low: float = math.nan
    rhs_high: float = math.nan
    steps_low: float = math.nan
    steps_high: float = math.nan

    @property
    def case_id(self) -> str:
        return self.case if self.variant == "default" else f"{self.case}/{self.variant}"

    @property
    def fault(self) -> str | None:
        """Why the entry cannot be compared; None if it is valid."""
        if not (0 < self.setting < math.inf and 0 <= self.floor < math.inf and 0 <= self.conditioning < math.inf):
            return "a setting is a positive number, floor and conditioning are finite numbers from 0"
        for name in RANGES:
            low, high = (getattr(self, f"{name}_{end}") for end in ENDS)
            if math.isnan(low) and math.isnan(high) and not (name == "error" and self.status in SCORED):
                continue
            endless = name == "error" and self.status in (Status.INACCURATE, Status.DIVERGED)
            if not (0 <= low <= high and (high < math.inf or endless)):
                return f"{name}_low and {name}_high of a setting that is {self.status} are not a range of finite numbers from 0"
        return None


COLUMNS = tuple(field.name for field in fields(Entry))
TEXTS = ("case", "variant", "numbers", "setting_kind", "status")


@dataclass(frozen=True)
class Baseline:
    """The entries of one integrator, with the depth of their measurement and the version of gnomon."""

    integrator: str
    depth: str
    version: str
    entries: tuple[Entry, ...]


def measure(
    integrator: Integrator,
    names: Sequence[str] | None,
    depth: str,
    runs: int = RUNS,
    workers: int = 2,
    progress: Callable[[str], None] = lambda case: None,
) -> Baseline:
    """Measure an integrator on the given cases, or on the cases of a depth, in `runs` runs at each setting.

    Raises ValueError if no case offers a form that the integrator accepts, if it solves nothing, hangs or ends its
    process.
    """
    entries: list[Entry] = []

    def add(row: Row) -> None:
        if row.finding.outcome == Outcome.FAILED:
            raise ValueError(f"{integrator.id} on {row.case}: {row.finding.got}; name other cases with --case")
        case_entries = [Entry(**each | {"status": Status(each["status"])}) for each in json.loads(row.finding.got)]
        for entry in case_entries:
            if entry.fault is not None:
                raise ValueError(f"{integrator.id} on {row.case}: {entry.fault}; name other cases with --case")
        entries.extend(case_entries)
        progress(row.case)

    measured = partial(_find_measured, runs)
    chosen = [case for case, _ in plan_verification(integrator, names, depth)]
    if not chosen:
        raise ValueError(f"no case has a form that {integrator.id} accepts, so there is nothing to measure")
    run([CaseJob(integrator, case, DEPTHS[depth], add, ["measured"], measured, runs) for case in chosen], workers)
    if not any(entry.status in SCORED for entry in entries):
        statuses = ", ".join(sorted({entry.status for entry in entries}))
        raise ValueError(f"{integrator.id} has no solution at any setting ({statuses}), so there is nothing to keep")
    if Status.OK not in [entry.status for entry in entries]:
        raise ValueError(
            f"{integrator.id} follows no exact motion at any setting (errors above {INACCURATE:g} of its size), so there is"
            " nothing to keep; look for the cause with gnomon verify"
        )
    places = [case.id for case in chosen]
    entries.sort(key=lambda entry: (places.index(entry.case_id), -entry.setting))
    return Baseline(integrator.id, depth, VERSION, tuple(entries))


def _find_measured(runs: int, trials: Trials) -> Finding:
    return Finding(Outcome.PASSED, got=json.dumps(_entries(trials, runs)))


def _entries(trials: Trials, runs: int) -> list[dict[str, Any]]:
    case = trials.case
    numbers = json.dumps({name: str(value) for name, value in case.numbers.items()} | {"span": str(case.span)})
    starts = [trials.start, *islice(perturb_start(case, None, trials.reference.sizes), runs - 1)]
    return [
        asdict(
            Entry(
                case.name,
                case.variant or "default",
                hashlib.sha256(numbers.encode()).hexdigest()[:12],
                type(trials.integrator.sweep).kind,
                setting,
                status,
                float(trials.reference.floor.max()),
                float(trials.reference.conditioning.max()),
                **ranges,
            )
        )
        for setting in trials.settings
        for status, ranges in [_runs(trials, setting, starts)]
    ]


def _runs(trials: Trials, setting: float, starts: Sequence[Floats]) -> tuple[Status, dict[str, float]]:
    """The status from the case's own start, and the ranges over all starts."""
    try:
        solved = trials.solved(trials.counting, setting, starts)
    except Exception as error:  # the user's code may raise anything
        return status_of(error)[0], {}
    status = Status(trials.scorer.score(solved[0][0].states[0])["status"])
    numbers = [
        (
            trials.scorer.largest_error(solution.states[0]),
            calls if trials.integrator.counts_rhs else math.nan,
            math.nan if solution.steps is None else solution.steps,
        )
        for solution, calls in solved
    ]
    named = zip(RANGES, np.array(numbers, dtype=np.float64).T, strict=True)
    return status, {
        f"{name}_{end}": float(of(values))
        for name, values in named
        for end, of in zip(ENDS, (np.min, np.max), strict=True)
    }


def case_names(base: Baseline, names: Sequence[str] = ()) -> list[str]:
    """The names of a baseline's cases, for `measure`.

    A file must not make gnomon import code: a case that is not installed must be in `names`, as package.module:Class,
    else ValueError is raised.
    """
    own = {case_class(name).name: name for name in (each.partition("/")[0] for each in names) if ":" in name}
    known = {name: name for name in installed_names()} | own
    for entry in base.entries:
        if entry.case not in known:
            raise ValueError(
                f"the baseline has the case {shortened(entry.case)}, which is not installed, and a file cannot name code to"
                " import; give --case package.module:Class of this case"
            )
    return list(dict.fromkeys(known[entry.case] + entry.case_id.removeprefix(entry.case) for entry in base.entries))


def compare_with_baseline(base: Baseline, run: Baseline) -> Verdict:
    """The verdict of the regression check on a run against a baseline, with all changes of numbers, better or worse.

    Notes name bounds that another version of gnomon changed. Raises ValueError if nothing can be compared.
    """
    if base.integrator != run.integrator:
        raise ValueError(f"the baseline is of {base.integrator}, not of {run.integrator}; write one for it")
    verdict = compare(_rows(base), _rows(run))
    _changes(base, run, verdict)
    now = {entry.case_id: entry for entry in run.entries}
    for case, entry in {entry.case_id: entry for entry in base.entries}.items():
        for bound in ("floor", "conditioning"):
            before, after = getattr(entry, bound), getattr(now.get(case, entry), bound)
            if not math.isclose(before, after, rel_tol=1e-3):
                verdict.notes.append(
                    f"{case}: {bound} {before:.3g} of gnomon {base.version} is {after:.3g} in {run.version}"
                )
    return verdict


def _changes(base: Baseline, run: Baseline, verdict: Verdict) -> None:
    """Add a line for each case and number that changed beyond noise at more than half of the settings.

    Also count the settings whose steps only one of the two counts.
    """
    after = {(entry.case_id, entry.setting): entry for entry in run.entries}
    for case in dict.fromkeys(entry.case_id for entry in base.entries):
        pairs = [(e, after[case, e.setting]) for e in base.entries if e.case_id == case and (case, e.setting) in after]
        pairs = [pair for pair in pairs if Status.OK == pair[0].status == pair[1].status]
        lacking = sum(math.isnan(before.steps_high) != math.isnan(now.steps_high) for before, now in pairs)
        if lacking:
            verdict.not_compared["steps are counted in one of the two alone"] += lacking
        for name, what in RANGES.items():
            changes = [_change(name, *pair) for pair in pairs]
            changes = [change for change in changes if not math.isnan(change)]
            if 2 * sum(change != 0 for change in changes) > len(changes):
                verdict.regressions.append(
                    f"changed: {case}: {what}, in the median over {len(changes)} settings by {np.median(changes):+.1e} of those"
                    " of the baseline; if it is meant, write the baseline anew"
                )


def _change(name: str, before: Entry, after: Entry) -> float:
    """Relative distance of a number from the middle of its range.

    It is 0 within the range, widened by its own width on both sides and by noise, and nan if one side lacks the number.
    """
    low, high = (getattr(before, f"{name}_{end}") for end in ENDS)
    now = getattr(after, f"{name}_high")
    if math.isnan(low) or math.isnan(now):
        return math.nan
    conditioning = min(before.conditioning, after.conditioning)
    noise = CONDITIONED * conditioning if name == "error" else NOISE * high
    near = min(max(now, low - (high - low) - noise), high + (high - low) + noise)
    middle = (low + high) / 2
    if now == near:
        return 0.0
    return float((now - middle) / middle) if middle else math.inf


def _rows(baseline: Baseline) -> list[dict[str, Any]]:
    """The entries as the measurements that the regression check reads."""
    fixed = {"formulation": "", "integrator_id": baseline.integrator, "launch": 1, "reason": "", "span": 0.0}
    fixed |= dict.fromkeys(("machine", "limit_seconds", "repeats", "turned_starts", "seconds_median"))
    renamed = {"error_max": "error_high", "rhs_calls": "rhs_high"}
    return [
        asdict(entry) | fixed | {name: getattr(entry, other) for name, other in renamed.items()}
        for entry in baseline.entries
    ]


def as_text(baseline: Baseline) -> str:
    """The text of a baseline file: comments that identify it, then a table with aligned columns, easy to review."""
    table = [COLUMNS] + [tuple(str(getattr(entry, name)) for name in COLUMNS) for entry in baseline.entries]
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    lines = ["  ".join(word.ljust(width) for word, width in zip(row, widths, strict=True)).rstrip() for row in table]
    head = [
        f"# {FORMAT}",
        f"# integrator {baseline.integrator}",
        f"# depth {baseline.depth}",
        f"# gnomon {baseline.version}",
    ]
    return "\n".join([*head, *lines]) + "\n"


def read(path: Path) -> Baseline:
    """Read a baseline from a file. Raises ValueError, with the line, for an invalid file."""
    lines = read_text(path).splitlines()
    if not lines or lines[0] != f"# {FORMAT}":
        raise ValueError(f"{path}: its first line is not '# {FORMAT}'; write it with gnomon baseline write")
    words = dict(line[2:].split(" ", 1) for line in lines[1:4] if line.startswith("# ") and line.count(" ") > 1)
    if set(words) != {"integrator", "depth", "gnomon"} or words["depth"] not in DEPTHS or len(lines) < 6:
        raise ValueError(f"{path}: lines 2 to 5 are not integrator, depth, gnomon and columns; write it anew")
    if tuple(lines[4].split()) != COLUMNS:
        raise ValueError(f"{path}:5: this version has other columns; write it anew")
    entries = [_entry(line, f"{path}:{number}") for number, line in enumerate(lines[5:], 6)]
    return Baseline(words["integrator"], words["depth"], words["gnomon"], tuple(entries))


def _entry(line: str, place: str) -> Entry:
    words = line.split()
    if len(words) != len(COLUMNS):
        raise ValueError(f"{place}: {len(words)} columns, not {len(COLUMNS)}")
    fields: dict[str, Any] = dict(zip(COLUMNS, words, strict=True))
    try:
        fields |= {name: float(fields[name]) for name in COLUMNS if name not in TEXTS}
        fields["status"] = Status(fields["status"])
    except ValueError as error:
        raise ValueError(f"{place}: {str(error)[:200]}; write it anew") from None
    entry = Entry(**fields)
    if entry.fault is not None:
        raise ValueError(f"{place}: {entry.fault}; write it anew")
    return entry
