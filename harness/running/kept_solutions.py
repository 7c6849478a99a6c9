"""Writes the exact states and the errors of simpler models that come with gnomon: `make solutions`.

They belong to all default cases and to the hard variants of the suite `standard`, in all formulations, and to the hard
variants of the panel of digits.
"""

import os
import sys
from pathlib import Path

from gnomon.harness.measuring.reference_solution import CaseSpec, make_entry, reference_solutions
from gnomon.harness.registry import selection
from gnomon.harness.running import plan
from gnomon.harness.stability.digits import every_variant
from gnomon.harness.studies import model_hierarchy
from gnomon.harness.system.supervisor import calls, require
from gnomon.reference.storage import diskcache

from gnomon import cases


def specs() -> list[CaseSpec]:
    """The cases whose exact states the file holds."""
    shown = [case for case, _ in selection.choose(plan.suite("standard").names(), False)]
    shown_specs = [CaseSpec.of(case, own) for case in shown for own in (None, *case.formulations)]
    return list(dict.fromkeys([*shown_specs, *(CaseSpec.of(cases.get(*pair).rounded()) for pair in every_variant())]))


def write(path: Path) -> None:
    """Write the file. Raises ValueError if a case has no reference solution."""
    solutions = reference_solutions(specs(), lambda: None)
    entries = dict(make_entry(spec, solution) for spec, solution in solutions.items())
    every = [case for case, _ in selection.choose(cases.names(), False) if case.hierarchy]
    workers = min(os.cpu_count() or 1, len(every))
    for _, answer in calls(model_hierarchy.make_entry, every, workers):
        key, entry = require(answer)
        entries[key] = entry
    diskcache.write_pack(path, entries)


if __name__ == "__main__":
    write(Path(sys.argv[1]))
