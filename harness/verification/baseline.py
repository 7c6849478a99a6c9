"""Baselines: what an integrator does today, as a small text file to be committed; a later run is compared with it.

A row is one setting on one case. Errors, right-hand sides and steps are the ranges over RUNS runs whose starts are
perturbed by ulps: what lies far outside cannot be noise of rounding, of a compiler or of a mathematical library.
"""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, fields
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
from gnomon.harness.contract.integrator import Integrator, Refused
from gnomon.harness.contract.status import SCORED, Status
from gnomon.harness.results.regression import Verdict, compare
from gnomon.harness.scoring.perturbed_starts import perturbed_states
from gnomon.harness.system.jobs import run
from gnomon.harness.verification.claims import Finding, Outcome
from gnomon.harness.verification.trials import DEPTHS, Floats, Trials
from gnomon.harness.verification.verify import CaseJob, Row, planned

from gnomon import __version__

FORMAT = "gnomon baseline 1"
RUNS = 16
MOST_BYTES = 2**24
ENDS = ("low", "high")
NOISE = 0.01
"""Share by which counts differ between builds of the same code; .3 % was seen."""
CONDITIONED = 10.0
"""Another compiler or library rounds this many halves of an ulp differently, at most, with an effect on the error."""


@dataclass(frozen=True)
class Entry:
    """One setting on one case: `numbers` identifies the case's numbers, `floor` and `conditioning` are its bounds.

    The ranges are nan where nothing was measured.
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


COLUMNS = tuple(field.name for field in fields(Entry))
TEXTS = ("case", "variant", "numbers", "setting_kind", "status")


@dataclass(frozen=True)
class Baseline:
    """The entries of one integrator, the depth at which they were measured, and the version of gnomon that did it."""

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
    """The entries of an integrator on the cases of a depth, or on those named, from `runs` runs at each setting.

    Raises ValueError where no case takes the integrator, or where it hangs or ends its process.
    """
    entries: list[Entry] = []

    def add(row: Row) -> None:
        if row.finding.outcome == Outcome.FAILED:
            raise ValueError(f"{integrator.id} on {row.case}: {row.finding.got}; name other cases with --case")
        entries.extend(Entry(**each | {"status": Status(each["status"])}) for each in json.loads(row.finding.got))
        progress(row.case)

    def measured(trials: Trials) -> Finding:
        return Finding(Outcome.PASSED, got=json.dumps(_entries(trials, runs)))

    chosen = [case for case, _ in planned(integrator, names, depth)]
    if not chosen:
        raise ValueError(f"no case offers what {integrator.id} accepts, so there is nothing to measure")
    run([CaseJob(integrator, case, DEPTHS[depth], add, ["measured"], measured, runs) for case in chosen], workers)
    if not any(entry.status in SCORED for entry in entries):
        found = ", ".join(sorted({entry.status for entry in entries}))
        raise ValueError(f"{integrator.id} has no solution at any setting ({found}), so there is nothing to keep")
    places = [case.id for case in chosen]
    entries.sort(key=lambda entry: (places.index(entry.case_id), -entry.setting))
    return Baseline(integrator.id, depth, __version__, tuple(entries))


def _entries(trials: Trials, runs: int) -> list[dict[str, Any]]:
    case = trials.case
    numbers = json.dumps({name: str(value) for name, value in case.numbers.items()} | {"span": str(case.span)})
    starts = [trials.start, *islice(perturbed_states(case, None, trials.reference.sizes), runs - 1)]
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
    counts = trials.integrator.counts_rhs
    try:
        solved = trials.solved(trials.problem(counted=counts), setting, starts)
    except Refused:
        return Status.REFUSED, {}
    except Exception:  # the user's code may raise anything
        return Status.CRASHED, {}
    status = Status(trials.scorer.score(solved[0][0].states[0])["status"])
    found = [
        (
            trials.scorer.largest_error(solution.states[0]),
            calls if counts else math.nan,
            math.nan if solution.steps is None else solution.steps,
        )
        for solution, calls in solved
    ]
    named = zip(("error", "rhs", "steps"), np.array(found, dtype=np.float64).T, strict=True)
    return status, {
        f"{name}_{end}": float(of(values))
        for name, values in named
        for end, of in zip(ENDS, (np.min, np.max), strict=True)
    }


def compared(base: Baseline, run: Baseline) -> Verdict:
    """The verdict of the regression check on a run against a baseline, and what changed otherwise, for worse or for better.
    Notes name bounds that another version changed.

    Raises ValueError where nothing can be compared.
    """
    if base.integrator != run.integrator:
        raise ValueError(f"the baseline is of {base.integrator}, not of {run.integrator}; write one for it")
    verdict = compare(_frame(base), _frame(run))
    verdict.regressions += _changes(base, run)
    now = {entry.case_id: entry for entry in run.entries}
    for case, entry in {entry.case_id: entry for entry in base.entries}.items():
        for bound in ("floor", "conditioning"):
            before, after = getattr(entry, bound), getattr(now.get(case, entry), bound)
            if not math.isclose(before, after, rel_tol=1e-3):
                verdict.notes.append(
                    f"{case}: {bound} {before:.3g} of gnomon {base.version} is {after:.3g} in {run.version}"
                )
    return verdict


def _changes(base: Baseline, run: Baseline) -> list[str]:
    """A line for each case and number that is outside the range of the base, and what noise explains, at most settings."""
    after = {(entry.case_id, entry.setting): entry for entry in run.entries}
    found: list[str] = []
    for case in dict.fromkeys(entry.case_id for entry in base.entries):
        pairs = [(e, after[case, e.setting]) for e in base.entries if e.case_id == case and (case, e.setting) in after]
        for name, what in (("error", "errors"), ("rhs", "right-hand sides"), ("steps", "steps")):
            changes = [_change(name, *pair) for pair in pairs if Status.OK == pair[0].status == pair[1].status]
            changes = [change for change in changes if not math.isnan(change)]
            if 2 * sum(change != 0 for change in changes) > len(changes):
                found.append(
                    f"changed: {case}: {what}, in the median over {len(changes)} settings by {np.median(changes):+.1e} of those"
                    " of the baseline; if it is meant, write the baseline anew"
                )
    return found


def _change(name: str, before: Entry, after: Entry) -> float:
    """By how much of itself a number is beyond its range, twice as wide on both sides, and noise; 0 within these."""
    low, high = (getattr(before, f"{name}_{end}") for end in ENDS)
    noise = CONDITIONED * before.conditioning if name == "error" else NOISE * high
    now = getattr(after, f"{name}_high")
    near = min(max(now, low - (high - low) - noise), high + (high - low) + noise)
    return float((now - (low + high) / 2) / ((low + high) / 2)) if now != near else 0.0 * float(now)


def _frame(baseline: Baseline) -> Any:
    """The entries as the frame that the regression check reads."""
    import pandas as pd  # takes longer than most claims

    rows = pd.DataFrame([asdict(entry) for entry in baseline.entries])
    rows = rows.rename(columns={"error_high": "error_max", "rhs_high": "rhs_calls", "steps_high": "steps"})
    fixed = {"formulation": "", "integrator_id": baseline.integrator, "launch": 1, "reason": "", "span": 0.0}
    missing = dict.fromkeys(("limit_seconds", "repeats", "turned_starts", "seconds_median"), math.nan)
    return rows.assign(**fixed, **missing)


def as_text(baseline: Baseline) -> str:
    """The file: comments with what it is, then a table of columns that are separated by spaces, for a review by eye."""
    table = [COLUMNS] + [tuple(_word(getattr(entry, name)) for name in COLUMNS) for entry in baseline.entries]
    widths = [max(map(len, column)) for column in zip(*table, strict=True)]
    lines = ["  ".join(word.ljust(width) for word, width in zip(row, widths, strict=True)).rstrip() for row in table]
    head = [
        f"# {FORMAT}",
        f"# integrator {baseline.integrator}",
        f"# depth {baseline.depth}",
        f"# gnomon {baseline.version}",
    ]
    return "\n".join([*head, *lines]) + "\n"


def _word(value: Any) -> str:
    return repr(value) if isinstance(value, float) else str(value)


def read(path: Path) -> Baseline:
    """The baseline in a file. Raises ValueError, with the line, for what is none."""
    if path.stat().st_size > MOST_BYTES:
        raise ValueError(f"{path}: a baseline has at most {MOST_BYTES} bytes")
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except UnicodeDecodeError as error:
        raise ValueError(f"{path}: not a text file: {error.reason}") from None
    if not lines or lines[0] != f"# {FORMAT}":
        raise ValueError(f"{path}: its first line is not '# {FORMAT}'; write it with gnomon baseline write")
    words = dict(line[2:].split(" ", 1) for line in lines[1:4] if line.startswith("# ") and line.count(" ") > 1)
    if set(words) != {"integrator", "depth", "gnomon"} or words["depth"] not in DEPTHS or len(lines) < 6:
        raise ValueError(f"{path}: lines 2 to 5 are not integrator, depth, gnomon and columns; write it anew")
    if tuple(lines[4].split()) != COLUMNS:
        raise ValueError(f"{path}:5: its columns are not those of this version; write it anew")
    entries = [_entry(line, f"{path}:{number}") for number, line in enumerate(lines[5:], 6)]
    return Baseline(words["integrator"], words["depth"], words["gnomon"], tuple(entries))


def _entry(line: str, place: str) -> Entry:
    words = line.split()
    if len(words) != len(COLUMNS):
        raise ValueError(f"{place}: {len(words)} columns, not {len(COLUMNS)}")
    found: dict[str, Any] = dict(zip(COLUMNS, words, strict=True))
    try:
        found |= {name: float(found[name]) for name in COLUMNS if name not in TEXTS}
        found["status"] = Status(found["status"])
    except ValueError as error:
        raise ValueError(f"{place}: {error}") from None
    if not found["setting"] > 0 or (found["status"] in SCORED and math.isnan(found["error_high"])):
        raise ValueError(f"{place}: a setting is positive, and {found['status']} has an error")
    return Entry(**found)
