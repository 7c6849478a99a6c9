"""The order of a run: some cases of each kind of system first, with all integrators, so that complete slices exist early.

Ranks rest on the scatter between launches (see `gnomon.harness.results.time_ratios`). To measure it, one setting of some series
of each library is launched several times, in blocks that are spread over the run. Launches of a setting are then as far apart
as launches of the methods that are compared, and never back to back. Each block has all libraries, so that an effect on all
launches of the same time can be separated from the scatter.
"""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import TypeVar

from gnomon.cases import Case
from gnomon.harness.contract.status import SCORED
from gnomon.harness.registry.kinds import KINDS, kind_of
from gnomon.harness.results.store import Known
from gnomon.harness.running.plan import Series, Trial

Place = tuple[int, int, int]


def places(all_series: Iterable[Series]) -> dict[str, Place]:
    """The place of each series by its id; all series of one case variant have the same place.

    Default variants come first: the first case of each kind of system, then the second case of each kind, and so on. Their
    copies over timing spans come next, and hard variants last. A case runs with all integrators before the next case begins.
    """
    order: dict[str, Place] = {}
    ranks: dict[str, tuple[int, int]] = {}
    counts = Counter[int]()
    for series in all_series:
        if series.case.name not in ranks:
            kind = _kind(series.case)
            ranks[series.case.name] = counts[kind], kind
            counts[kind] += 1
        stage = 2 if series.case.variant is not None else int(series.over_timing_span)
        order[series.id] = stage, *ranks[series.case.name]
    return order


def _kind(case: Case) -> int:
    """The position of a case's kind of system among KINDS; after all of them without one."""
    kind = kind_of({type(form).__name__ for form in case.all_forms()})
    return len(KINDS) if kind is None else [*KINDS].index(kind)


SERIES_OF_A_LIBRARY = 6
"""Number of series of each library that are launched again for the scatter."""

Item = TypeVar("Item")


def choose_for_scatter(all_series: Iterable[Series]) -> list[Series]:
    """SERIES_OF_A_LIBRARY series of each library, on default variants: each one on the next case, by the next integrator."""
    by_library: dict[str, dict[str, list[Series]]] = {}
    for series in all_series:
        if series.left_out is None and series.formulation is None and series.case.variant is None and not series.label:
            by_library.setdefault(series.integrator.library, {}).setdefault(series.case.name, []).append(series)
    chosen = []
    for by_case in by_library.values():
        cases = [*by_case.values()]
        turns = (own[k % len(own)] for k, own in enumerate(cases * SERIES_OF_A_LIBRARY))
        chosen += list({series.id: series for series in turns}.values())[:SERIES_OF_A_LIBRARY]
    return chosen


def middle_trial(trials: Sequence[Trial], history: Mapping[tuple[str, int], Known]) -> tuple[Trial, ...]:
    """The middle one of the trials that the first launch of a series timed, as a tuple; () if it timed none."""
    timed = [
        trial
        for trial in trials
        for known in [history.get((trial.key, 1))]
        if known is not None and known.status in SCORED and known.seconds is not None
    ]
    return tuple(timed[len(timed) // 2 :][:1])


def spread(launches: Sequence[Item], blocks: Sequence[Sequence[Item]]) -> list[Item]:
    """The launches with the blocks among them, at equal distances and the last block at the end."""
    order, begin = list[Item](), 0
    for number, block in enumerate(blocks, 1):
        until = round(len(launches) * number / len(blocks))
        order += [*launches[begin:until], *block]
        begin = until
    return [*order, *launches[begin:]]
