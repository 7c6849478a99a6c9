"""Finds outstanding trials of a results file: planned, but without a measurement, as interrupted or not run yet."""

import re
import sqlite3
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import NamedTuple

from gnomon.harness.contract.status import SCORED, Status
from gnomon.harness.results import opening
from gnomon.harness.results.reading import LAST_PLANNED
from gnomon.harness.results.visible import visible

SHARD = "shard"
"""The name of a run's shards in its environment, as `shard_text` writes them; a run of a whole plan lacks it."""
SHOWN = 3
"""Largest number of shards of a plan, and of plans, that are named."""
_SCORED = ", ".join(repr(status.value) for status in SCORED)
_PLANNED = f"""
WITH latest AS (SELECT trial_key, launch, status, max(measurement) FROM measurements GROUP BY trial_key, launch),
launches AS (
    SELECT "case", library, series, setting, launch, min(trials.rowid) AS place,
        coalesce(max(status != '{Status.INTERRUPTED.value}'), 0) AS measured,
        coalesce(max(status IN ({_SCORED})), 0) AS scored
    FROM trials LEFT JOIN latest USING (trial_key) WHERE trial_key IN ({LAST_PLANNED})
    GROUP BY series, setting, launch),
settings AS (
    SELECT "case", library, min(place) AS place, coalesce(max(launch = 1 AND measured), 0) AS measured,
        coalesce(max(launch = 1 AND scored) * sum(launch > 1 AND NOT measured), 0) AS interrupted
    FROM launches GROUP BY series, setting)
SELECT "case", library, count(*), sum(measured), sum(interrupted) FROM settings
GROUP BY "case", library ORDER BY min(place)
"""
"""Later launches repeat trials that the first launch scored: missing launches of other trials are not outstanding."""
_SHARDS = f"""
WITH whole AS (SELECT run FROM runs WHERE run NOT IN (SELECT run FROM environment WHERE name = '{SHARD}'))
SELECT value FROM environment AS own WHERE name = '{SHARD}' AND (
    NOT EXISTS (SELECT 1 FROM whole WHERE whole.run > own.run)
    OR EXISTS (SELECT series FROM planned WHERE planned.run = own.run
        EXCEPT SELECT series FROM planned WHERE planned.run > own.run AND planned.run IN whole))
"""
"""The shards of all runs, except shards whose series are also part of a later run of the whole plan."""
_COMPLETE = f"""
WITH done AS (
    SELECT trial_key FROM measurements WHERE launch = 1 AND measurement IN (
        SELECT max(measurement) FROM measurements WHERE launch = 1 GROUP BY trial_key)
    AND status != '{Status.INTERRUPTED.value}')
SELECT "case", variant FROM (
    SELECT "case", variant, series, setting, max(trial_key IN done) AS measured
    FROM trials WHERE trial_key IN ({LAST_PLANNED}) GROUP BY series, setting)
GROUP BY "case", variant HAVING min(measured) = 1
"""
_TEXT = re.compile(r"([0-9]{1,7})/([0-9]{1,7}) of ([0-9a-f]{8})")

Shards = dict[tuple[str, int], set[int]]
"""The shards that were run, by plan and number of its shards."""


class Planned(NamedTuple):
    """The planned trials of one case and library: the numbers of all, of measured ones, and of interrupted launches."""

    case: str
    library: str
    trials: int
    measured: int
    interrupted: int


@dataclass(frozen=True)
class Outstanding:
    """The outstanding trials, shards and launches of a file."""

    planned: list[Planned]
    """In the order of the plan."""
    shards: list[str]
    """A clause about the missing shards of each plan."""
    ended: bool
    """Whether the last run of the file has ended."""

    @property
    def trials(self) -> int:
        return sum(row.trials - row.measured for row in self.planned)

    @property
    def others(self) -> list[str]:
        """Outstanding shards and repeated launches, a clause each."""
        launches, clauses = sum(row.interrupted for row in self.planned), list(self.shards)
        if launches:
            clauses.append(f"{launches} repeated launches were interrupted")
        if not (self.ended or self.trials or launches):
            clauses.append("its last run has not ended, so that repeated launches may be missing")
        return clauses

    @property
    def text(self) -> str:
        """All that is outstanding, in words; empty without anything."""
        planned = sum(row.trials for row in self.planned)
        trials = [f"{self.trials} of {planned} planned trials have no measurement"] if self.trials else []
        return "; ".join([*self.others, *trials])


def outstanding(path: str | Path) -> Outstanding:
    """The outstanding trials, shards and launches of a results file. Raises ValueError as `load` does.

    The last plan of a series counts. A trial that is planned on several machines is measured if one of them measured
    it.
    """
    with opening.reading(path, ["runs", "environment", "trials", "planned", "measurements"]) as db:
        rows = [Planned(visible(case), visible(library), *counts) for case, library, *counts in db.execute(_PLANNED)]
        last = db.execute("SELECT ended FROM runs ORDER BY run DESC LIMIT 1").fetchone()
        return Outstanding(rows, _missing(shards(db)), last is None or last[0] is not None)


def complete(path: str | Path) -> set[tuple[str, str]]:
    """The (case, variant) pairs, as in rows, whose planned trials all have a measurement of the first launch.

    A page of an unfinished run ranks methods on these only, because no planned method is missing there. A series over a
    timing span counts as another variant. Raises ValueError as `load` does.
    """
    with opening.reading(path, ["trials", "planned", "measurements"]) as db:
        return {(visible(case), visible(variant)) for case, variant in db.execute(_COMPLETE)}


def shard_text(place: int, count: int, plan: str) -> str:
    """A shard in the form of a run's environment; `plan` is 8 hexadecimal digits."""
    return f"{place}/{count} of {plan}"


def shards(db: sqlite3.Connection) -> Shards:
    """The shards that a file has."""
    by_plan: Shards = {}
    for (value,) in db.execute(_SHARDS):
        for place, count, plan in _TEXT.findall(value or ""):
            by_plan.setdefault((plan, int(count)), set()).add(int(place))
    return by_plan


def shards_text(by_plan: Shards) -> str:
    """Shards of several files in the form of the merged file's environment."""
    return ", ".join(shard_text(place, count, plan) for (plan, count), own in by_plan.items() for place in sorted(own))


def _missing(by_plan: Shards) -> list[str]:
    """A clause about the missing shards of each plan; plans after the first SHOWN are counted."""
    clauses = []
    for (plan, count), own in by_plan.items():
        number = count - sum(1 <= place <= count for place in own)
        if number <= 0:
            continue
        names = islice((f"{place}/{count}" for place in range(1, count + 1) if place not in own), SHOWN)
        more = f" and {number - SHOWN} more" if number > SHOWN else ""
        of = f" of the plan {plan}" if len(by_plan) > 1 else ""
        clauses.append(
            f"shard{'s' * (number > 1)} {', '.join(names)}{more}{of} {'is' if number == 1 else 'are'} missing"
        )
    others = len(clauses) - SHOWN
    return [*clauses[:SHOWN], *([f"shards of {others} other plans are missing"] if others > 0 else [])]
