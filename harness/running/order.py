"""The order of a run: some cases of each kind of system first, with all integrators, so that complete slices exist early.

Launches that measure the scatter between launches, on which ranks rest (see `gnomon.harness.results.separation`), are spread
over it: of one setting of some series of each library. They lie as far from each other as those of the members of a cell,
never back to back, and each block of them has all libraries, so that an effect that all launches of a time share can be told
from it.
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


SERIES_OF_A_LIBRARY = 6
"""Number of series of each library, on as many problems as it takes."""

Item = TypeVar("Item")


def choose_for_scatter(series: Iterable[Series]) -> list[Series]:
    """Of each library the series that are launched again: its problems in their order, its integrators in turn."""
    found: dict[str, dict[str, list[Series]]] = {}
    for one in series:
        if one.left_out is None and one.formulation is None and one.case.variant is None and not one.label:
            found.setdefault(one.integrator.library, {}).setdefault(one.case.name, []).append(one)
    chosen = []
    for problems in found.values():
        of = [*problems.values()]
        turns = (of[k % len(of)][k % len(of[k % len(of)])] for k in range(SERIES_OF_A_LIBRARY * len(of)))
        chosen += list({one.id: one for one in turns}.values())[:SERIES_OF_A_LIBRARY]
    return chosen


def middle_trial(trials: Sequence[Trial], history: Mapping[tuple[str, int], Known]) -> tuple[Trial, ...]:
    """The trial in the middle of those that the first launch of a series timed; empty without one."""
    timed = [
        trial
        for trial in trials
        for known in [history.get((trial.key, 1))]
        if known is not None and known.status in SCORED and known.seconds is not None
    ]
    return tuple(timed[len(timed) // 2 :][:1])


def spread(launches: Sequence[Item], blocks: Sequence[Sequence[Item]]) -> list[Item]:
    """The launches with the blocks at equal distances among them, the last one at the end."""
    found, done = list[Item](), 0
    for number, block in enumerate(blocks, 1):
        until = round(len(launches) * number / len(blocks))
        found += [*launches[done:until], *block]
        done = until
    return [*found, *launches[done:]]
