"""Which faults `gnomon verify` finds: mutants of right methods, rebuilt real defects, and right methods without a fault.

    make verification                                       everything, resumed where it ended; hours
    python tests/detection/measure.py --only rk4            the mutants whose name has the word

Each is verified at depth normal until a claim fails. A mutant that changes no state beyond conditioning and round-off
changes no result: it is counted apart. The rows are kept, a line each, under the hash of the sources that they depend on.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import time
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np
from gnomon.harness.contract.integrator import Integrator, Refused
from gnomon.harness.scoring.reference_solution import CaseSpec
from gnomon.harness.verification.claims import Outcome
from gnomon.harness.verification.trials import DEPTHS, Trials
from gnomon.harness.verification.verify import FIRST, FirstTrialError, Row, planned, verify
from gnomon.reference.storage.import_closure import closure

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

import mutants  # noqa: E402 - beside this file
from defects import DEFECTS  # noqa: E402

DEPTH = "normal"
BEYOND = 10.0
"""A state is changed if it differs by more than so many times the error that rounding may cause."""
NEEDED = (("found", "changed", 0.9), ("defects_found", "defects", 0.95))
"""What must be found: (count, of which, share)."""


@dataclass(frozen=True)
class Measured:
    """What became of one faulty or right integrator."""

    kind: str
    name: str
    changed: bool
    claim: str | None
    case: str | None
    seconds: float
    sources: str


class Found(Exception):  # noqa: N818 - a result, not an error
    """Raised by the first claim that fails."""


def first_failure(integrator: Integrator) -> tuple[str, str] | None:
    """The first claim that fails, and its case; None if none does."""
    found: list[tuple[str, str]] = []

    def look(row: Row) -> None:
        if row.finding.outcome == Outcome.FAILED:
            found.append((row.claim, row.case))
            raise Found

    try:
        verify(integrator, depth=DEPTH, progress=look)
    except Found:
        return found[0]
    except FirstTrialError:
        return FIRST, ""
    return None


def changes(faulty: Integrator, right: Integrator) -> bool:
    """Whether any state at a coarse, a usual or the finest setting of the first cases differs beyond rounding."""
    for case, _ in planned(right, None, "low"):
        ours, theirs = (Trials.of(each, CaseSpec.of(case), DEPTHS["low"]) for each in (right, faulty))
        for setting in (ours.settings[0], ours.usual(), ours.settings[-1]):
            answer = ours.whole(setting)
            if answer.states is None or not math.isfinite(answer.error):
                continue
            try:
                (states,) = theirs.solutions(theirs.problem(), setting, [theirs.start])
            except Refused:
                return True
            except Exception:  # a fault may raise anything
                return True
            apart = ours.distance(states, answer.states)
            if not np.max(apart) <= BEYOND * answer.roundoff:
                return True
    return False


def rows(only: Sequence[str], known: dict[tuple[str, str], Measured], sources: str) -> Iterator[Measured]:
    """A row for each right method, each real defect and each mutant that has none yet."""
    right = mutants.right()
    wanted: list[tuple[str, str, Any]] = [("right", name, None) for name in right]
    wanted += [("defect", defect.link, defect) for defect in DEFECTS]
    wanted += [("mutant", mutant.id, mutant) for mutant in mutants.mutants()]
    for kind, name, faulty in wanted:
        if (kind, name) in known or (only and not any(word in f"{kind} {name}" for word in only)):
            continue
        began = time.monotonic()
        integrator = right[name] if faulty is None else faulty.integrator()
        claim, case = first_failure(integrator) or (None, None)
        changed = claim is not None or kind == "defect"
        if kind == "mutant" and claim is None:
            changed = changes(integrator, right[faulty.method.name])
        yield Measured(kind, name, changed, claim, case, round(time.monotonic() - began, 2), sources)


def summary(found: Sequence[Measured]) -> dict[str, Any]:
    """Counts, and the names of all that was not found or falsely found."""
    changed = [row for row in found if row.kind == "mutant" and row.changed]
    defects = [row for row in found if row.kind == "defect"]
    return {
        "depth": DEPTH,
        "mutants": sum(row.kind == "mutant" for row in found),
        "changed": len(changed),
        "found": sum(row.claim is not None for row in changed),
        "by_claim": dict(Counter(row.claim for row in changed if row.claim is not None).most_common()),
        "not_found": [row.name for row in changed if row.claim is None],
        "defects": len(defects),
        "defects_found": sum(row.claim is not None for row in defects),
        "defects_not_found": [row.name for row in defects if row.claim is None],
        "no_change": [row.name for row in found if row.kind == "mutant" and not row.changed],
        "false_alarms": [
            f"{row.name}: {row.claim} on {row.case}" for row in found if row.kind == "right" and row.claim
        ],
    }


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--only", action="append", default=[], help="a word of the name; repeatable")
    parser.add_argument("--rows", type=Path, default=Path("runs/verification.jsonl"))
    parser.add_argument("--to", type=Path, default=Path("reports/local/verification.json"))
    given = parser.parse_args()
    sources = closure("gnomon.harness.verification.verify") or ""
    given.rows.parent.mkdir(parents=True, exist_ok=True)
    given.rows.touch()
    kept = [Measured(**json.loads(line)) for line in given.rows.read_text().splitlines()]
    known = {(row.kind, row.name): row for row in kept if row.sources == sources}
    with given.rows.open("a") as file:
        for row in rows(given.only, known, sources):
            known[row.kind, row.name] = row
            file.write(json.dumps(asdict(row)) + "\n")
            file.flush()
            print(f"{row.claim or ('NOT FOUND' if row.changed else 'no change'):16} {row.name} ({row.seconds:.0f} s)")
    found = summary(list(known.values()))
    given.to.parent.mkdir(parents=True, exist_ok=True)
    given.to.write_text(json.dumps(found, indent=1) + "\n")
    print(f"{found['found']} of {found['changed']} mutants that change a result; false alarms: {found['false_alarms']}")
    return int(bool(found["false_alarms"]) or any(found[got] < max(share * found[of], 1) for got, of, share in NEEDED))


if __name__ == "__main__":
    sys.exit(main())
