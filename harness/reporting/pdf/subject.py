"""The measurements of one integrator in a run, reduced for its accuracy report: one row a case."""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
import pandas as pd
from gnomon.harness.contract.status import SCORED
from gnomon.harness.reporting.report_run import Run
from gnomon.harness.reporting.report_words import together
from gnomon.harness.results import analysis, rankings, store
from gnomon.harness.results.contenders import OWN
from gnomon.harness.results.profiles import OURS
from gnomon.harness.studies.drift import Growth, Sampled, choose_samples, growth

OTHER = "Other systems"


@dataclass(frozen=True)
class Subject:
    """One integrator of a run."""

    run: Run
    name: str
    """Its id."""

    @classmethod
    def of(cls, run: Run, name: str) -> Self:
        """The integrator with this id, or the only one with this name. Raises ValueError if none of its trials ran."""
        ran = run.reduced[~run.reduced["status"].isin(analysis.NEVER_RAN)]
        present = dict(ran.drop_duplicates("integrator_id")[["integrator_id", "integrator"]].to_numpy())
        ids = [name] if name in present else sorted(full for full, short in present.items() if short == name)
        if len(ids) == 1:
            return cls(run, ids[0])
        if ids:
            raise ValueError(f"--pdf {name}: the run has {', '.join(ids)}; give one id")
        wanted = run.reduced[run.reduced["integrator_id"] == name]
        why = f"nothing of it ran ({wanted['reason'].iloc[0]})" if len(wanted) else f"{run.path} has no results of it"
        raise ValueError(f"--pdf {name}: {why}; it has results of {', '.join(sorted(present))}")

    @cached_property
    def frame(self) -> pd.DataFrame:
        return self.run.frame[self.run.frame["integrator_id"] == self.name]

    @cached_property
    def reduced(self) -> pd.DataFrame:
        """One row a setting of each series, also of series that could not run."""
        return self.run.reduced[self.run.reduced["integrator_id"] == self.name]

    @cached_property
    def ran(self) -> pd.DataFrame:
        return self.reduced[~self.reduced["status"].isin(analysis.NEVER_RAN)]

    @cached_property
    def history(self) -> list[dict[str, Any]]:
        """The runs of the file that measured this integrator, the oldest first."""
        return [run for run in store.runs(self.run.path) if run["run"] in set(self.frame["run"])]

    @cached_property
    def environment(self) -> dict[str, str]:
        """The machine and the versions of these runs; several values are listed."""
        return together([run["environment"] for run in self.history])

    @cached_property
    def library(self) -> str:
        return str(self.frame["library"].iloc[0])

    @cached_property
    def engine(self) -> bool:
        """Whether it has its own equations and is given scenes."""
        return bool((self.ran["form"] == "SceneForm").any())

    @cached_property
    def by_tolerance(self) -> bool:
        return bool((self.ran["setting_kind"] == "tolerance").any())

    def kind(self, case: str) -> str:
        """The kind of system of a case, in few words."""
        return self.run.kind_of.get(case, OTHER).partition(":")[0]

    @cached_property
    def kinds(self) -> list[str]:
        """The kinds of the cases of the run, in few words."""
        return [kind.partition(":")[0] for kind in (*self.run.kinds, OTHER)]

    @cached_property
    def defaults(self) -> pd.DataFrame:
        """The settings of default variants; of a case that did not run in its own formulation, another one."""
        own = self.ran[self.ran["variant"] == ""]
        chosen = own.groupby("case")["formulation"].transform("min")  # the own formulation has an empty name
        return own[own["formulation"] == chosen]

    @cached_property
    def cases(self) -> pd.DataFrame:
        """One row a case, the most digits first, by the case's name.

        To the columns of `analysis.trust` come: `floor`, `digits` (nan without an ok setting, and no more than the floor
        allows), `at_floor` (whether they are limited so), `tightest` (whether the best setting is the last one of the
        sweep), `declared`, `order`, `margin`, `flat` (an order with 0 in its interval is none: `order` is nan), `kind` and
        `verdict`.
        """
        rows = self.defaults
        table = analysis.trust(rows).set_index("case")
        matrix = analysis.status_matrix(rows).set_index("case")[["verdict"]]
        ordered = analysis.orders(rows).set_index("case").reindex(table.index)[["order", "margin"]]
        by_case = rows.groupby("case")
        table = table.join(matrix).join(ordered)
        table = table.assign(
            floor=by_case["floor"].max().reindex(table.index).fillna(0.0),
            declared=by_case["order_declared"].first().reindex(table.index),
            last=by_case["setting"].min().reindex(table.index),
            flat=table["order"] <= table["margin"],
            kind=[self.kind(str(case)) for case in table.index],
        )
        least = np.maximum(table["floor"], 1e-17)
        return table.assign(
            digits=-np.log10(np.maximum(table["best"], least)),
            at_floor=table["best"] <= least,
            tightest=table["at"] <= table["last"],
            order=table["order"].where(~table["flat"]),
        ).sort_values("digits", ascending=False, kind="stable", na_position="last")

    def used(self, rows: pd.DataFrame) -> pd.DataFrame:
        """The rows of default variants in the formulations of `cases`."""
        formulations = rows["case"].map(self.cases["formulation"])
        return rows[(rows["variant"] == "") & (rows["formulation"] == formulations)]

    @cached_property
    def answered(self) -> pd.DataFrame:
        """The rows of `cases` with an ok setting."""
        return self.cases[self.cases["best"].notna()]

    @cached_property
    def matrix(self) -> pd.DataFrame:
        """A row a problem: case, variant and formulation, also of those that it does not accept."""
        return analysis.status_matrix(self.reduced)

    @cached_property
    def accepted(self) -> list[str]:
        """Cases of which some problem ran."""
        return sorted(set(self.ran["case"]))

    @cached_property
    def refused(self) -> list[str]:
        """Cases of which none ran."""
        return sorted(set(self.reduced["case"]) - set(self.accepted))

    @cached_property
    def hard(self) -> pd.Series:
        """By hard variant (case, variant) 1 if it is solved, 0 if not; variants that are not known are left out."""
        table = rankings.find_solved(self.reduced)
        return table[self.name].dropna() if self.name in table else pd.Series(dtype=float)

    @cached_property
    def equal(self) -> pd.DataFrame:
        """Its rows of `rankings.rank_methods` on default variants, ranked within its division."""
        ours = self.run.equal["library"] == OURS
        division = rankings.rank_methods(self.run.equal[ours == (self.library == OURS)], self.run.scatter[OWN])
        return division[(division["integrator_id"] == self.name) & (division["variant"] == "")]

    @cached_property
    def times(self) -> dict[tuple[str, float], dict[str, Any]]:
        """The rows of `equal` in the formulations of `cases`, by case and error."""
        rows = analysis.records(self.used(self.equal))
        return {(row["case"], row["target"]): row for row in rows}

    @cached_property
    def grown(self) -> dict[str, tuple[Sampled, Growth]]:
        """By case the sizes of the error over time, at a setting with an error near 1e-5, and their law."""
        samples = choose_samples(self.run.path, self.used(self.frame), self.run.classes)
        return {sample.trial.case: (sample, growth(sample.times, sample.sizes["error"])) for sample in samples}

    @cached_property
    def telling(self) -> list[str]:
        """At most six cases, evenly spaced in the order of digits: the most, the fewest, and between them."""
        scored = self.defaults[self.defaults["status"].isin(SCORED)].groupby("case").size()
        names = [name for name in self.answered.index if scored.get(name, 0) >= 3]
        if len(names) <= 6:
            return names
        return [names[round(share * (len(names) - 1))] for share in np.linspace(0, 1, 6)]


def median(values: pd.Series) -> float:
    """The median of the finite values; nan without any."""
    finite = values[np.isfinite(values.astype(float))]
    return float(finite.median()) if len(finite) else math.nan
