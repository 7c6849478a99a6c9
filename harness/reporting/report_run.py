"""A results file, loaded and reduced once for all parts of a report."""

import json
import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Self

import numpy as np
import pandas as pd
from gnomon.cases.core.case import Case
from gnomon.cases.core.registry import case_class, installed_names
from gnomon.harness.contract.declared import read_declared
from gnomon.harness.contract.status import Status
from gnomon.harness.own_systems.own_system import OwnSystem
from gnomon.harness.registry import kinds
from gnomon.harness.reporting import style, tables
from gnomon.harness.results import analysis, families, rankings, store, summary
from gnomon.harness.results.advice import needs
from gnomon.harness.results.outstanding import Outstanding, outstanding
from gnomon.harness.results.time_ratios import Scatter
from gnomon.harness.running.plan import NEAR_DUPLICATE
from gnomon.harness.studies import constraint_errors, horizon, model_hierarchy
from gnomon.harness.studies.drift import rebuild_case

DECIMAL_STEPS = (1e-2, 1e-3, 1e-4)
"""Step sizes (s) at which the policies of an engine are compared."""

CHAPTERS: dict[str, str] = read_declared("reporting", "templates/page.toml")["chapters"]


@dataclass(frozen=True)
class Run:
    """The measurements of a results file, and the frames that are computed from them."""

    path: Path
    frame: pd.DataFrame
    reduced: pd.DataFrame
    users_classes: Mapping[str, type[Case]] = field(default_factory=dict)
    """Cases that are not installed, by the name under which they ran."""

    @classmethod
    def read(cls, path: Path, users_classes: Mapping[str, type[Case]] | None = None) -> Self:
        """Load and reduce a results file. Raises ValueError for an empty file, or a file without results."""
        frame = analysis.tidy(store.load(path))
        # Strings as Python objects: tables are read row by row, which takes several times longer from Arrow's arrays.
        frame = frame.astype({name: object for name, kind in frame.dtypes.items() if kind == "str"})
        # Pairs outside the suite are not failures of an integrator, and would fill the maps.
        frame = frame[frame["reason"] != NEAR_DUPLICATE[1]]
        if frame.empty:
            raise ValueError(f"{path}: holds no measurement yet; run `gnomon run` first")
        why = summary.nothing_ran(zip(frame["status"], frame["reason"], strict=True))
        if why is not None:
            raise ValueError(f"{path}: nothing in it ran, so there is nothing to report ({why})")
        frame = analysis.own_spans(frame)
        return cls(path, frame, analysis.settings(frame), users_classes or {})

    @cached_property
    def outstanding(self) -> Outstanding:
        return outstanding(self.path)

    @cached_property
    def along_the_way(self) -> pd.DataFrame:
        """The measurements of chaotic cases, judged against the conditioning along the way."""
        return horizon.judge(self.path)

    @cached_property
    def constraints(self) -> pd.DataFrame:
        """The measurements of constrained cases, with their errors apart."""
        return constraint_errors.judge(self.path)

    @cached_property
    def look(self) -> pd.DataFrame:
        return style.styles(self.frame)

    @cached_property
    def equal_error(self) -> pd.DataFrame:
        return analysis.equal_error(self.frame)

    @cached_property
    def scatter(self) -> dict[str, Scatter]:
        """The scatter of times between launches, by division."""
        return rankings.scatter(self.frame[self.frame["case"].isin(self.complete)])

    @cached_property
    def complete(self) -> list[str]:
        """The cases without outstanding trials: statements about several cases do not speak of the others."""
        lost = {row.case for row in self.outstanding.planned if row.measured < row.trials}
        return [name for name in self.names if name not in lost]

    @cached_property
    def equal(self) -> pd.DataFrame:
        """The times at equal error, ranked within divisions."""
        return rankings.divisions(self.equal_error, self.scatter)

    @cached_property
    def equal_later(self) -> pd.DataFrame:
        """The times of one more period at equal error, where they were measured, ranked within divisions."""
        return rankings.one_more_period(self.equal_error, self.scatter)

    @cached_property
    def counted(self) -> pd.DataFrame:
        """The evaluations of the equations at equal error, ranked within divisions."""
        return rankings.divisions(self.equal_error, self.scatter, rankings.rank_by_counts)

    @cached_property
    def sweeps(self) -> dict[families.Problem, list[families.Sweep]]:
        """The methods that ran on each problem, see `families.sweeps`."""
        return families.sweeps(self.frame)

    @cached_property
    def kinds(self) -> dict[str, list[str]]:
        """The cases of each kind of system."""
        return kinds.kinds(self.forms, [name for name in self.names if name not in self.own])

    @cached_property
    def kind_of(self) -> dict[str, str]:
        """The kind of each case that is of one; a user's own equations are not a sample of a kind."""
        return needs.kind_of({name: forms for name, forms in self.forms.items() if name not in self.own})

    @cached_property
    def matrix(self) -> pd.DataFrame:
        """The status matrix, and the hard variants of installed cases that were not run."""
        ran = analysis.status_matrix(self.reduced)
        missing = analysis.not_run(
            ran, {name: [variant.name for variant in case.variants] for name, case in self.classes.items()}
        )
        return tables.with_problems(pd.concat([ran, missing], ignore_index=True) if len(missing) else ran)

    @cached_property
    def classes(self) -> dict[str, type[Case]]:
        """The classes of the cases that are installed or were given. Code that a results file names is not imported."""
        installed = installed_names()
        own = {name: case_class(name) for name in self.names if name in installed}
        return own | {name: case for name, case in self.users_classes.items() if name in self.names}

    @cached_property
    def trusted(self) -> pd.DataFrame:
        return tables.with_problems(analysis.trust(self.reduced))

    @cached_property
    def orders(self) -> pd.DataFrame:
        return analysis.orders(self.reduced[self.reduced["variant"] == ""])

    @cached_property
    def names(self) -> list[str]:
        """The cases in the order of the book."""
        return sorted(dict.fromkeys(self.frame["case"]), key=lambda name: _place(self.sections[name]))

    @cached_property
    def chapters(self) -> dict[str, list[str]]:
        """The cases of each chapter, by its number and title."""
        by_chapter: dict[str, list[str]] = {}
        for name in self.names:
            by_chapter.setdefault(CHAPTERS.get(str(_place(self.sections[name])[0]), "Other cases"), []).append(name)
        return by_chapter

    @cached_property
    def titles(self) -> dict[str, str]:
        return dict(self.frame.drop_duplicates("case")[["case", "title"]].to_numpy())

    @cached_property
    def own(self) -> list[str]:
        """The problems of a user's own equations among the cases."""
        return [name for name in self.names if self.sections[name] == OwnSystem.section]

    @cached_property
    def sections(self) -> dict[str, str]:
        """The section of each case in Beatty, Dynamics."""
        return dict(self.frame.drop_duplicates("case")[["case", "section"]].to_numpy())

    @cached_property
    def problems(self) -> pd.DataFrame:
        """Every problem that was run, in the order of the book, variants of a case together: case, variant, problem."""
        ran = tables.with_problems(self.frame.drop_duplicates(["case", "variant", "formulation"]))
        place = {name: i for i, name in enumerate(self.names)}
        return ran.sort_values("case", key=lambda column: column.map(place), kind="stable")

    @cached_property
    def cases(self) -> list[Case]:
        """The default variants of the run in the order of the book, rebuilt from their stored parameters.

        Cases that are neither installed nor given are left out.
        """
        rebuilt = []
        own = self.frame[self.frame["variant"] == ""].drop_duplicates("case").set_index("case", drop=False)
        for row in own.loc[[name for name in self.names if name in own.index and name in self.classes]].to_dict(
            "records"
        ):
            try:
                rebuilt.append(
                    rebuild_case(self.classes[row["case"]], "", json.loads(row["numbers"]), float(row["span"]))
                )
            except ValueError:
                continue
        return rebuilt

    @cached_property
    def forms(self) -> dict[str, set[str]]:
        """The forms that each case offers; for an unknown case, the forms in which integrators accepted it."""
        accepted = {str(name): set(forms) for name, forms in self.frame.groupby("case")["form"]}
        return accepted | {case.name: {type(form).__name__ for form in case.all_forms()} for case in self.cases}

    @cached_property
    def hierarchies(self) -> pd.DataFrame:
        """Model hierarchies, with the shortest times of all integrators and of third parties."""
        # Only rows that a level can look up: it takes a twentieth of the time.
        equal = self.equal_error[self.equal_error["target"] == model_hierarchy.COST_AT]
        default = self.frame[self.frame["variant"] == ""]
        spans = default.groupby("case", as_index=False)[["span", "time_scale"]].first().assign(variant="")
        return model_hierarchy.hierarchies(self.cases, equal, spans)

    @cached_property
    def policies(self) -> pd.DataFrame:
        """Engines under each policy at the decimal steps, if two policies gave an answer (diverged is one)."""
        table = tables.with_problems(analysis.policies(self.reduced).assign(formulation=""))
        near = np.zeros(len(table), dtype=bool)
        for step in DECIMAL_STEPS:
            near |= np.isclose(table["setting"].to_numpy(float), step, rtol=1e-9)
        answered = table[near & (table["error"].notna() | (table["status"] == Status.DIVERGED))]
        several = answered.groupby(["problem", "library", "setting"])["policy"].transform("nunique") > 1
        return answered[several].rename(columns={"library": "engine", "setting": "step"})


def _place(section: str) -> tuple[int, ...]:
    """The numbers of the first section named, as a sort key; a section without numbers is sorted last."""
    first = re.match(r"\d+(\.\d+)*", section)
    return tuple(map(int, first[0].split("."))) if first else (99,)
