"""The sampled states of a results file, with the exact motions to judge them by."""

import json
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from gnomon.cases.core.case import Case
from gnomon.cases.core.registry import case_class, installed_names
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.measuring.score import Scorer
from gnomon.harness.results import reading
from gnomon.harness.studies.drift import rebuild_case

Row = dict[str, Any]


def read_scored_states(path: Path, wanted: Callable[[Case], bool]) -> list[tuple[Scorer, Row, Floats]]:
    """The measurements in the standard formulation of the installed cases that are `wanted`, with their states (64, dim).

    Left out are cases whose parameters have changed since they ran.
    """
    installed, scorers = set(installed_names()), dict[tuple[str, str, str], Scorer | None]()

    @cache
    def worthwhile(name: str) -> bool:
        kind = case_class(name)
        return any(wanted(kind(variant)) for variant in (None, *(variant.name for variant in kind.variants)))

    chosen: list[tuple[Scorer, Row]] = []
    for row in reading.rows(path):
        if row["case"] in installed and row["formulation"] == "standard" and worthwhile(row["case"]):
            key = row["case"], row["variant"], row["numbers"]
            if key not in scorers:
                scorers[key] = _scorer(row, wanted)
            scorer = scorers[key]
            if scorer is not None:
                chosen.append((scorer, row))
    states = reading.states(path, [row["measurement"] for _, row in chosen])
    scored = [(scorer, row, states.get(row["measurement"])) for scorer, row in chosen]
    return [(scorer, row, of) for scorer, row, of in scored if of is not None]


def _scorer(row: Row, wanted: Callable[[Case], bool]) -> Scorer | None:
    variant = "" if row["variant"] == "default" else row["variant"]
    try:
        case = rebuild_case(case_class(row["case"]), variant, json.loads(row["numbers"]), float(row["span"]))
    except ValueError:
        return None
    return Scorer.of(case) if wanted(case) else None
