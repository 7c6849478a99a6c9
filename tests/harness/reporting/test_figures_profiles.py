"""Profiles of libraries as charts: their data are the data of `results.profiles`, and few problems make no chart."""

import numpy as np
import pandas as pd
import vl_convert
from gnomon.harness.reporting import figures_profiles
from gnomon.harness.results import profiles
from launches import timed

NAMES = {"gnomon:A": "gnomon", "gnomon:B": "gnomon", "scipy:C": "scipy"}


def frames(cases: int) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Times at 1e-6 in which C takes three times as long as A and B fails on every other case; one hard variant each."""
    times, trials = [], []
    for case in range(cases):
        for name, library in NAMES.items():
            hard = {"case": f"case {case}", "variant": "hard", "formulation": "", "status": "ok", "error_max": 1e-8}
            trials.append(hard | {"integrator_id": name, "library": library})
            if name != "gnomon:B" or case % 2:
                row = {"case": f"case {case}", "library": library, "target": 1e-6}
                times.append(row | {"integrator_id": name, "seconds": {"gnomon:A": 1.0, "scipy:C": 3.0}.get(name, 2.0)})
    return timed(times), pd.DataFrame(trials)


def test_a_chart_has_a_line_a_library_and_one_of_the_best_third_party() -> None:
    charts = figures_profiles.profile_charts(*frames(2 * figures_profiles.FEWEST))
    names = {"profile_1e-6", "profile_digits"}
    assert set(charts) == names | {f"{name}_others" for name in names}
    drawn = charts["profile_1e-6"].to_dict(validate=False)
    rows = pd.DataFrame(drawn["datasets"]["profiles"])
    assert set(rows["library"]) == {"gnomon", "scipy", profiles.THIRD_PARTY}
    third = rows[rows["library"] == "scipy"].set_index("at")["share"]
    assert np.all(third[third.index < np.log10(2.99)] == 0)
    assert np.all(third[third.index > np.log10(3.01)] == 1)
    assert rows.loc[rows["library"] == "gnomon", "share"].eq(1).all()
    others = pd.DataFrame(charts["profile_1e-6_others"].to_dict(validate=False)["datasets"]["profiles"])
    assert set(others["library"]) == {"scipy"}
    assert others["share"].eq(1).all(), "without in-house methods it is the fastest itself"
    assert "<svg" in vl_convert.vegalite_to_svg(drawn)


def test_few_problems_make_no_profile() -> None:
    assert figures_profiles.profile_charts(*frames(figures_profiles.FEWEST - 1)) == {}
