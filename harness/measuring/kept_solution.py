"""The reference solutions that need no computation: in the cache on disk, or in the pack that comes with gnomon."""

from gnomon.harness.measuring import reference_solution
from gnomon.harness.measuring.reference_solution import CaseSpec, ReferenceSolution
from gnomon.reference.storage import diskcache


def kept_solution(spec: CaseSpec) -> ReferenceSolution | None:
    """The kept reference solution of a case; None if it would have to be computed."""
    # Its own module may not change for this function: its source is a part of the keys of the pack.
    key = reference_solution._key(spec)
    entry = None if key is None else diskcache.load(key, reference_solution.PACK)
    return None if entry is None else reference_solution._read(entry)
