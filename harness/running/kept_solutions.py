"""Writes the exact states that come with gnomon: `make solutions`.

They belong to all default cases and to the hard variants of the suite `standard`, in all formulations, and to the hard
variants of the panel of digits.
"""

import sys
from pathlib import Path

from gnomon.harness.measuring.reference_solution import CaseSpec, kept_entry, reference_solutions
from gnomon.harness.registry import selection
from gnomon.harness.running import plan
from gnomon.harness.stability.digits import every_variant
from gnomon.reference.storage import diskcache

from gnomon import cases


def specs() -> list[CaseSpec]:
    """The cases whose exact states the file holds."""
    shown = [case for case, _ in selection.choose([*cases.names(), *plan.suite("standard").hardest], False)]
    found = [CaseSpec.of(case, own) for case in shown for own in (None, *case.formulations)]
    return list(dict.fromkeys([*found, *(CaseSpec.of(cases.get(*pair).rounded()) for pair in every_variant())]))


def write(path: Path) -> None:
    """Write the file. Raises ValueError if a case has no reference solution."""
    found = reference_solutions(specs(), lambda: None)
    diskcache.write_pack(path, dict(kept_entry(spec, solution) for spec, solution in found.items()))


if __name__ == "__main__":
    write(Path(sys.argv[1]))
