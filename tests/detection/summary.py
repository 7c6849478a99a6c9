"""What `make verification` publishes of its rows: shares with their intervals, survivors with reasons, false alarms."""

from __future__ import annotations

import math
import subprocess
import tomllib
from collections import Counter, defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
NEEDED = {"mutants": 0.9, "defects": 0.95}
"""The share that must be found of each."""
_WORDS = tomllib.loads((HERE / "survivors.toml").read_text())
REASONS: dict[str, str] = _WORDS["reasons"]
"""Why a fault is not found, by the beginning of its name."""
TRUE_ALARMS: dict[str, str] = _WORDS["true_alarms"]
"""Claims that fail for an integrator of a library because it is wrong there, by `name: claim on case`, with what is wrong."""
Z = 1.959963984540054
"""The normal distribution lies within so many deviations with a probability of 0.95."""

Rows = Sequence[Mapping[str, Any]]


def wilson(found: int, of: int) -> tuple[float, float]:
    """Wilson's interval of a share, at 95 %: (0, 1) where nothing was measured."""
    if not of:
        return 0.0, 1.0
    share, z2 = found / of, Z * Z
    middle, half = share + z2 / (2 * of), Z * math.sqrt(share * (1 - share) / of + z2 / (4 * of * of))
    return max(0.0, (middle - half) / (1 + z2 / of)), min(1.0, (middle + half) / (1 + z2 / of))


def most_alarms(alarms: int, runs: int) -> float:
    """The upper bound of the rate of false alarms, at 95 %, one-sided (Clopper and Pearson)."""
    if alarms >= runs:
        return 1.0
    low, high = alarms / runs, 1.0
    for _ in range(60):
        middle = (low + high) / 2
        few = sum(math.comb(runs, k) * middle**k * (1 - middle) ** (runs - k) for k in range(alarms + 1))
        low, high = (middle, high) if few > 0.05 else (low, middle)
    return high


def share(rows: Rows) -> dict[str, Any]:
    found = sum(row["claim"] is not None for row in rows)
    low, high = wilson(found, len(rows))
    value = found / len(rows) if rows else 0.0
    return {"found": found, "of": len(rows), "share": round(value, 4), "interval": [round(low, 4), round(high, 4)]}


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


def published(rows: Rows, depth: str, right_depth: str) -> dict[str, Any]:
    """The whole of reports/verification.json."""
    measured = [row for row in rows if row["error"] is None]
    mutants = [row for row in measured if row["kind"] == "mutant"]
    changed = [row for row in mutants if row["changed"]]
    defects = [row for row in measured if row["kind"] == "defect"]
    runs = [row for row in measured if row["kind"] == "right"]
    right = [row for row in runs if row["checked"] or row["claim"]]
    failing = [row for row in right if row["claim"] is not None]
    true_ = [row for row in failing if alarm(row) in TRUE_ALARMS]
    alarms = [row for row in failing if alarm(row) not in TRUE_ALARMS]
    alive = [row["name"] for row in [*changed, *defects] if row["claim"] is None]
    found = {
        "revision": revision(),
        "rows_by_sources": dict(Counter(row["sources"] for row in measured)),
        "depth": depth,
        "depth_of_right_integrators": right_depth,
        "seconds": round(sum(row["seconds"] for row in measured)),
        "mutants": share(changed),
        "by_method": by(changed, 0),
        "by_fault": by(changed, 1),
        "by_claim": dict(Counter(row["claim"] for row in [*changed, *defects] if row["claim"]).most_common()),
        "without_change": [row["name"] for row in mutants if not row["changed"]],
        "defects": share(defects),
        "survivors": {name: reason(name) for name in alive},
        "survivors_without_reason": [name for name in alive if reason(name) is None],
        "right_runs": dict(Counter(row["condition"] for row in right)),
        "right_runs_that_checked_nothing": [row["name"] for row in runs if row not in right],
        "false_alarms": [f"{alarm(row)} ({row['condition']})" for row in alarms],
        "true_alarms": {alarm(row): TRUE_ALARMS[alarm(row)] for row in true_},
        "false_alarm_rate_at_most": round(most_alarms(len(alarms), len(right)), 4) if right else 1.0,
        "not_measured": {f"{row['name']} ({row['condition']})": row["error"] for row in rows if row["error"]},
    }
    found["text"] = (
        f"{found['mutants']['found']} of {found['mutants']['of']} mutants that change a result and"
        f" {found['defects']['found']} of {found['defects']['of']} real defects are found;"
        f" {len(alarms)} false alarms in {len(right)} runs"
    )
    return found


def revision() -> str:
    """The commit of the sources; with + where files differ from it, and unknown outside git."""
    command = ["git", "-C", str(HERE), "describe", "--always", "--dirty=+", "--abbrev=12"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return done.stdout.strip() or "unknown"
