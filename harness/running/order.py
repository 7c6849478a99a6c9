"""The order of a run: some cases of each kind of system first, with all integrators, so that complete slices exist early."""

from collections import Counter
from collections.abc import Iterable

from gnomon.cases import Case
from gnomon.harness.registry.kinds import KINDS, kind_of
from gnomon.harness.running.plan import Series

Place = tuple[int, int, int]


def places(series: Iterable[Series]) -> dict[str, Place]:
    """The place of each series by its id; series of one case variant have the same.

    Default variants come first: of each kind of system the first case, then of each kind the second one, and so on. Their
    copies over timing spans come next, and hard variants last. An integrator that is missing leaves no gap: a case is
    measured with all that take it before the next case begins.
    """
    found: dict[str, Place] = {}
    ranks: dict[str, tuple[int, int]] = {}
    counts = Counter[int]()
    for one in series:
        if one.case.name not in ranks:
            kind = _kind(one.case)
            ranks[one.case.name] = counts[kind], kind
            counts[kind] += 1
        stage = 2 if one.case.variant is not None else int(one.over_timing_span)
        found[one.id] = stage, *ranks[one.case.name]
    return found


def _kind(case: Case) -> int:
    kind = kind_of({type(form).__name__ for form in case.all_forms()})
    return len(KINDS) if kind is None else [*KINDS].index(kind)
