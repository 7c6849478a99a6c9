"""How closely the families follow a chaotic motion, from an exact and from a spoilt solution."""

from types import SimpleNamespace
from typing import Any

import pandas as pd
from gnomon.harness.reporting.page.family_tables import horizon_rows

COLUMNS = ("case", "variant", "integrator_id", "horizon", "to_the_end", "times_conditioning")
ROWS = [
    ("henon_heiles", "default", "scipy:DOP853", 417.2, False, 3e3),
    ("henon_heiles", "default", "scipy:DOP853", 417.2, True, 7.0),
    ("henon_heiles", "default", "scipy:RK45", 417.2, False, 4e5),
    ("henon_heiles", "default", "gnomon:Taylor", 417.2, False, 42.0),
]


def told(rows: list[Any]) -> dict[tuple[str, str], str]:
    run: Any = SimpleNamespace(along_the_way=pd.DataFrame(rows, columns=COLUMNS))
    return horizon_rows(run)


def test_a_method_counts_with_its_best_setting_and_a_family_with_its_closest_method() -> None:
    (table,) = told(ROWS).values()
    runge_kutta, taylor = (table[table.index(name) :] for name in ("Explicit Runge-Kutta", "Taylor series"))
    assert "<td>1 of 2</td><td><b>SciPy DOP853</b></td><td>7.0e0</td>" in runge_kutta
    assert "<td>0 of 1</td>" in taylor
    assert "horizon, 417 s" in table


def test_a_run_without_chaotic_cases_has_no_such_rows() -> None:
    assert told([]) == {}
