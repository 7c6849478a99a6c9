"""The integrators that stand for their libraries: one a kind of system, chosen before the run.

A best of 54 methods is never set against a best of 2, so each library has one method for each kind of system, which its
manual names (harness/registry/representatives.toml).
"""

from collections.abc import Iterable, Mapping, Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from gnomon.harness.adapters.libraries import LIBRARIES, title
from gnomon.harness.registry.representatives import representative
from gnomon.harness.reporting.report_run import Run
from gnomon.harness.results import contenders, rankings
from gnomon.harness.results.advice.needs import Measurements
from gnomon.harness.results.analysis import NEVER_RAN, own, records
from gnomon.harness.results.contenders import OWN, THIRD, YOURS
from gnomon.harness.results.profiles import OURS
from gnomon.harness.results.time_ratios import EQUAL, FASTEST

NAMED = 7
"""The largest number of integrators in one picture: as many as there are colours that can be told apart."""


CLEARLY = 2.0
"""Factor from which another method of a library is named as clearly faster than the one that stands for it."""


class Stand(NamedTuple):
    """A library, or an integrator that the run was given, with the method that stands for it in each kind of system."""

    name: str
    title: str
    division: str
    methods: Mapping[str, str | None]
    """By kind, the integrator; None where the library takes no such system."""


class Faster(NamedTuple):
    """A method that takes less than half of the time of the method that stands for its library.

    `ratio` is the median of its time over the other's, `low` and `high` the extremes, over this number of `cases`.
    """

    library: str
    method: str
    than: str
    cases: int
    ratio: float
    low: float
    high: float


class Representatives:
    """The libraries of a run, each with one method a kind, and the cases that every one of them has run."""

    def __init__(self, run: Run) -> None:
        self.run = run

    @cached_property
    def stands(self) -> list[Stand]:
        """Integrators that the run was given first, then third-party libraries, then gnomon."""
        ran = self.run.frame
        yours = [
            Stand(name, name.partition(":")[2] or name, YOURS, dict.fromkeys(self.run.kinds, name))
            for name in ran.loc[ran["library"].map(contenders.division) == YOURS, "integrator_id"].unique()
        ]
        present = set(ran.loc[~ran["status"].isin(NEVER_RAN), "library"])
        libraries = []
        for library in (*LIBRARIES, OURS):
            chosen = {kind: representative(library, kind) for kind in self.run.kinds}
            methods = {kind: method.integrator if method is not None else None for kind, method in chosen.items()}
            if library in present and any(methods.values()):
                division = OWN if library == OURS else THIRD
                libraries.append(Stand(library, title(library), division, methods))
        return [*yours[:NAMED], *libraries]

    @cached_property
    def complete(self) -> list[str]:
        """The cases of the run without outstanding trials: the others are not spoken of."""
        return self.run.complete

    @cached_property
    def whole(self) -> list[Stand]:
        """The stands that ran on every complete case: of the others, it is not known what they would reach there."""
        default = own(self.run.frame)
        ran = set(default[["case", "integrator_id"]].itertuples(index=False, name=None))
        pairs = {
            stand.name: [(case, stand.methods.get(self.run.kind_of.get(case, ""))) for case in self.complete]
            for stand in self.stands
        }
        return [stand for stand in self.stands if all(pair in ran or pair[1] is None for pair in pairs[stand.name])]

    @cached_property
    def known(self) -> dict[tuple[str, str], dict[str, Any]]:
        """What is known of each pair of a case and an integrator, on default variants."""
        return {(row["case"], row["integrator_id"]): row for row in records(own(self.run.matrix))}

    @cached_property
    def measured(self) -> Measurements:
        """The measurements of the complete cases."""
        equal, rows = (table[table["case"].isin(self.complete)] for table in (self.run.equal, self.run.frame))
        return Measurements(equal, rows, self.run.kind_of)

    def method(self, stand: Stand, case: str) -> str | None:
        """The method that stands for a library on a case."""
        return stand.methods.get(self.run.kind_of.get(case, ""))

    def reaches(self, case: str, method: str, target: float) -> bool:
        """Whether a method reaches an error on a default variant: it has a time at this error, whatever others take."""
        return (case, method, target) in self._reached

    @cached_property
    def _reached(self) -> set[tuple[str, str, float]]:
        rows = own(self.run.equal_error)
        return set(rows[["case", "integrator_id", "target"]].itertuples(index=False, name=None))

    @cached_property
    def limits(self) -> str:
        """The time limits of a trial of this run, on default variants, in words."""
        return f"the time limit of a trial ({self.limit_seconds})"

    @cached_property
    def limit_seconds(self) -> str:
        return seconds_text(own(self.run.frame)["limit_seconds"])

    def limits_of(self, case: str) -> str:
        """The time limits of a trial of a case, on its default variant, in words."""
        rows = own(self.run.frame)
        return f"the time limit of a trial ({seconds_text(rows.loc[rows['case'] == case, 'limit_seconds'])})"

    @cached_property
    def third(self) -> list[str]:
        """The third-party libraries among `whole`."""
        return [stand.name for stand in self.whole if stand.division == THIRD]

    def faster(self, target: float) -> list[Faster]:
        """For each method that stands for a library the fastest of the others, on the cases that both bring to an error.

        A manual chooses the stand before the run; this shows a user of the library what the choice costs.
        """
        rows = own(self.run.equal)
        rows = rows[rows["target"] == target]
        table = rows[rows["case"].isin(self.complete)].pivot(index="case", columns="integrator_id", values="seconds")
        pairs = []
        for stand in self.stands:
            others = [name for name in table.columns if name.partition(":")[0] == stand.name]
            for method in dict.fromkeys(filter(None, stand.methods.values())):
                cases = [case for case in table.index if stand.methods.get(self.run.kind_of.get(case, "")) == method]
                if method not in table.columns:
                    continue
                ratios = table.loc[cases, others].div(table.loc[cases, method], axis=0)
                medians = ratios.median()[ratios.count() >= rankings.FEWEST]
                if len(medians) and medians.min() * CLEARLY < 1:
                    best = medians.idxmin()
                    at = ratios[best].dropna()
                    pairs.append(Faster(stand.title, best, method, len(at), medians[best], at.min(), at.max()))
        return pairs

    def rows(self, equal: pd.DataFrame) -> pd.DataFrame:
        """The rows of the default variants of complete cases by the method that stands for its library, with its `stand`.

        Third parties are ranked among themselves (see `rankings.divisions`). `equal`: `Run.equal` or `Run.counted`.
        """
        rank = rankings.rank_by_counts if equal is self.run.counted else rankings.rank_methods
        rows = own(equal[equal["case"].isin(self.complete)])
        by_pair = {
            (case, method): stand.name
            for stand in self.whole
            for case, kind in self.run.kind_of.items()
            if (method := stand.methods[kind]) is not None
        }
        named = [by_pair.get(pair) for pair in zip(rows["case"], rows["integrator_id"], strict=True)]
        rows = rows.assign(stand=named)
        return rankings.divisions(rows[rows["stand"].notna()], self.run.scatter, rank)

    def times(self, rows: pd.DataFrame, target: float, column: str) -> pd.DataFrame:
        """The time (or count) to an error: a row for each complete case, a column for each stand; inf if not reached.

        A method that is equal to the fastest of its division takes the least value. `rows`: from `rows`.
        """
        at = rows[rows["target"] == target]
        least = at.groupby(["case", "division"])[column].transform("min")  # a quotient would lose ties to round-off
        at = at.assign(value=at[column].where(~at["state"].isin([FASTEST, EQUAL]), least))
        table = at.pivot(index="case", columns="stand", values="value")
        return table.reindex(index=self.complete, columns=[stand.name for stand in self.whole]).fillna(np.inf)


def seconds_text(limits: Iterable[float]) -> str:
    """Time limits in words, with their range."""
    known = sorted({limit for limit in limits if limit > 0})
    if not known:
        return "not recorded"
    return f"{known[0]:g} s" + (f" to {known[-1]:g} s, longer for some cases and for engines" if len(known) > 1 else "")


def label(name: str) -> str:
    """The name of an integrator in texts: of its library, then its own."""
    library, _, own_name = name.partition(":")
    return f"{title(library)} {own_name}" if own_name else name


def choose_for(libraries: Representatives, case: str, several: Sequence[str]) -> list[str]:
    """The integrators in the picture of a case: all of `several` if they are few, else those that stand for libraries."""
    if len(several) <= NAMED:
        return list(several)
    kind = libraries.run.kind_of.get(case)
    names = [stand.methods.get(kind) for stand in libraries.stands] if kind else []
    return [name for name in names if name in set(several)]
