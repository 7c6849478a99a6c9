"""The tables that compare integrators, twice: with all integrators, and without gnomon's own.

The page has a switch between the two. Without in-house integrators the third-party ones are ranked among themselves.
"""

from collections.abc import Mapping, Sequence
from typing import Any

from gnomon.harness.reporting import findings, report_integrators, tables
from gnomon.harness.reporting.report_run import Run
from gnomon.harness.results import rankings
from gnomon.harness.results.profiles import OURS

ALL, OTHERS = "all", "others"


def views(
    run: Run, problems: Sequence[tuple[str, str]], growth: Mapping[str, Any] | None, orders: Mapping[str, Any] | None
) -> dict[str, dict[str, Any]]:
    """The tables by view. There is one view if all integrators, or none, are gnomon's own.

    `problems`: case and formulation of the rows of the table of cases; `growth` and `orders`: see `report_integrators.integrator_rows`.
    """
    found = {ALL: _view(run, False, problems, growth, orders)}
    if run.equal["library"].eq(OURS).nunique() > 1:
        found[OTHERS] = _view(run, True, problems, None, None)
    return found


def _view(
    run: Run,
    third: bool,
    problems: Sequence[tuple[str, str]],
    growth: Mapping[str, Any] | None,
    orders: Mapping[str, Any] | None,
) -> dict[str, Any]:
    equal, reduced, trusted, slopes = run.equal, run.reduced, run.trusted, run.orders
    if third:
        reduced, trusted, slopes = (table[table["library"] != OURS] for table in (reduced, trusted, slopes))
        equal = rankings.third_party(equal)
    kinds = report_integrators.kind_rows(equal, reduced, run.kinds)
    return {
        "findings": findings.findings(equal, run.policies, kinds, reduced, trusted),
        "kinds": kinds,
        "lines": report_integrators.lines_of(kinds),
        "overall": tables.overall(equal),
        "card": report_integrators.integrator_rows(equal, trusted, slopes, reduced, growth, orders),
        "fastest": tables.fastest(equal, problems),
        "libraries": tables.libraries(equal),
    }
