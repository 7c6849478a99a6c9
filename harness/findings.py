"""A run in a few sentences, each counted from its rows: nothing is said that the tables below do not show."""

from __future__ import annotations

import numpy as np
import pandas as pd
from gnomon.harness.analysis import CLAIM, TARGETS
from gnomon.harness.tables import ratio_text


def findings(equal: pd.DataFrame, policies: pd.DataFrame) -> list[str]:
    """The run in a few sentences, each counted from its rows."""
    own = equal[(equal["variant"] == "") & (equal["formulation"] == "")]
    said = []
    for target in (TARGETS[1], TARGETS[-1]):
        at = own[own["target"] == target]
        if at.empty:
            continue
        wins = at[at["tied"]].groupby("integrator_id")["case"].nunique().sort_values(ascending=False)
        said.append(
            f"At an error of {target:.0e}".replace("e-0", "e-")
            + f", {wins.index[0]} is the fastest or on a par with it on {wins.iloc[0]} of the {at['case'].nunique()}"
            f" cases where any integrator gets there"
            + (f", {wins.index[1]} on {wins.iloc[1]}." if len(wins) > 1 else ".")
        )
    middle = own[own["target"] == TARGETS[1]]
    slower = {
        library: part.groupby("case")["ratio"].min().median() for library, part in middle.groupby("library", sort=False)
    }
    slower = {library: ratio for library, ratio in slower.items() if ratio >= CLAIM}
    if slower:
        words = [
            f"{library} {ratio_text(ratio)} times" for library, ratio in sorted(slower.items(), key=lambda x: x[1])
        ]
        said.append(
            "At 1e-6 the best of each other library takes, as a median over the cases it reaches, "
            + " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)
            + " as long as the fastest."
        )
    if policies.empty:
        return said
    step = float(policies.groupby("step")["scene"].nunique().idxmax())  # the step that most scenes were compared at
    at = policies[np.isclose(policies["step"], step)]
    at = at.assign(error=at["error"].fillna(np.inf))  # it diverged, and not even to a number
    if {"as shipped", "configured"} <= set(at["policy"]):
        wide = at.pivot_table(index=["engine", "scene"], columns="policy", values="error", aggfunc="min")
        both = wide.dropna(subset=["as shipped", "configured"])
        if len(both):
            gain = float((both["as shipped"] / both["configured"]).median())
            worst = int((both["as shipped"] > 0.1).sum())
            said.append(
                f"At a step of {step:g} s an engine as shipped is off by more than a tenth of the motion on {worst} of"
                f" {len(both)} scenes"
                + (
                    f"; configured for the scene, its error is smaller by a median factor of {ratio_text(gain)}."
                    if np.isfinite(gain)
                    else "."
                )
            )
    return said
