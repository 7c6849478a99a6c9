"""The rows of `make verification` as published: shares and their populations, survivors with reasons, false alarms."""

import math
import tomllib
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from gnomon.harness.registry import environment

HERE = Path(__file__).parent
NEEDED = {"mutants": 0.97, "mutants_at_low": 0.92, "defects": 0.95}
"""The share that must be found of each."""
POPULATION = """\
Mutants: faults that the authors chose and planted, and a seeded draw from the places of right methods where an operator \
applies (a digit, a sign, a term, a time argument). Defects: rebuilt from threads of public trackers that the authors \
chose. Neither is a random sample of the mistakes that users make, so a share is that of these faults and of no others. Runs of \
one right integrator under several conditions are not independent, so the bound of false alarms counts integrators: those that \
are registered here, which the authors of the claims knew."""
_WORDS = tomllib.loads((HERE / "survivors.toml").read_text())
REASONS: dict[str, str] = _WORDS["reasons"]
"""Why a fault is not found, by the beginning of its name."""
TRUE_ALARMS: dict[str, str] = _WORDS["true_alarms"]
"""Claims that fail for an integrator of a library as it is wrong there, by `name: claim on case`, with the fault."""
Rows = Sequence[Mapping[str, Any]]


def most_alarms(alarms: int, runs: int, beyond: float = 0.05) -> float:
    """The upper bound (Clopper and Pearson), by default at 95 %, of a rate of which so many of independent runs show one."""
    if alarms >= runs:
        return 1.0
    low, high = alarms / runs, 1.0
    for _ in range(60):
        middle = (low + high) / 2
        few = sum(math.comb(runs, k) * middle**k * (1 - middle) ** (runs - k) for k in range(alarms + 1))
        low, high = (middle, high) if few > beyond else (low, middle)
    return high


def interval(found: int, of: int) -> tuple[float, float]:
    """The interval at 95 % (Clopper and Pearson) of the share of which a random draw found so many."""
    return 1.0 - most_alarms(of - found, of, 0.025), most_alarms(found, of, 0.025)


def share(rows: Rows) -> dict[str, Any]:
    found = sum(row["claim"] is not None for row in rows)
    return {"found": found, "of": len(rows), "share": round(found / len(rows), 4) if rows else 0.0}


def of_drawn(rows: Rows, draw: Mapping[str, int] | None) -> dict[str, Any]:
    """The share of mutants; where they are a draw, also its seed, its population, and the interval of the share in that."""
    found = share(rows)
    if draw is None or not rows:
        return found
    return found | {"draw": draw, "interval": [round(x, 4) for x in interval(found["found"], found["of"])]}


def alarm(row: Mapping[str, Any]) -> str:
    return f"{row['name']}: {row['claim']} on {row['case']}"


def reason(name: str) -> str | None:
    return next((why for begins, why in REASONS.items() if name.startswith(begins)), None)


def by(rows: Rows, part: int) -> dict[str, Any]:
    """Shares by the method (part 0) or by the fault (part 1) of mutants; chosen faults are one kind."""
    groups: dict[str, list[Mapping[str, Any]]] = defaultdict(list)
    for row in rows:
        method, fault = row["name"].split(": ", 1)
        groups[method if part == 0 else fault.split(", line ")[0] if ", line " in fault else "chosen"].append(row)
    return {name: share(some) for name, some in groups.items()}


def published(
    rows: Rows, depths: Sequence[str], right_depth: str, draw: Mapping[str, int] | None = None
) -> dict[str, Any]:
    """The whole of reports/verification.json; `depths` of the faults, the lowest first. Only the last has details.

    `draw`: the seed, number and population of a draw of mutants; None for all.
    """
    measured = [row for row in rows if row["error"] is None]
    at = {depth: [row for row in measured if row["kind"] != "right" and row["depth"] == depth] for depth in depths}
    low, mutants = ([row for row in at[depth] if row["kind"] == "mutant"] for depth in (depths[0], depths[-1]))
    changing = {row["name"] for row in (*low, *mutants) if row["changed"]}
    changed = [row for row in mutants if row["name"] in changing]
    defects = [row for row in at[depths[-1]] if row["kind"] == "defect"]
    runs = [row for row in measured if row["kind"] == "right"]
    right = [row for row in runs if row["checked"] or row["claim"]]
    failing = [row for row in right if row["claim"] is not None]
    true_ = [row for row in failing if alarm(row) in TRUE_ALARMS]
    alarms = [row for row in failing if alarm(row) not in TRUE_ALARMS]
    alive = [row["name"] for row in [*changed, *defects] if row["claim"] is None]
    integrators, alarming = ({row["name"] for row in some} for some in (right, alarms))
    found = {
        "environment": environment.record(),
        "rows_by_sources": dict(Counter(row["sources"] for row in measured)),
        "population": POPULATION,
        "depth": depths[-1],
        "depth_of_right_integrators": right_depth,
        "seconds": round(sum(row["seconds"] for row in measured)),
        "mutants": of_drawn(changed, draw),
        f"mutants_at_{depths[0]}": of_drawn([row for row in low if row["name"] in changing], draw),
        "by_method": by(changed, 0),
        "by_fault": by(changed, 1),
        "by_claim": dict(Counter(row["claim"] for row in [*changed, *defects] if row["claim"]).most_common()),
        "without_change": [row["name"] for row in mutants if row["name"] not in changing],
        "defects": share(defects),
        "survivors": {name: reason(name) for name in alive},
        "survivors_without_reason": [name for name in alive if reason(name) is None],
        "right_runs": dict(Counter(condition(row) for row in right)),
        "right_integrators": len(integrators),
        "right_runs_that_checked_nothing": [row["name"] for row in runs if row not in right],
        "false_alarms": [f"{alarm(row)} ({condition(row)})" for row in alarms],
        "true_alarms": {alarm(row): TRUE_ALARMS[alarm(row)] for row in true_},
        "false_alarm_rate_at_most": round(most_alarms(len(alarming), len(integrators)), 3) if right else 1.0,
        "not_measured": {f"{row['name']} ({condition(row)})": row["error"] for row in rows if row["error"]},
    }
    found["text"] = (
        f"{found['mutants']['found']} of {found['mutants']['of']} chosen and drawn mutants that change a result and"
        f" {found['defects']['found']} of {found['defects']['of']} chosen defects are found at {depths[-1]};"
        f" {len(alarms)} false alarms in {len(right)} runs of {len(integrators)} integrators"
    )
    return found


def condition(row: Mapping[str, Any]) -> str:
    return row["condition"] + (f", load {row['load']}" if row["load"] else "")
