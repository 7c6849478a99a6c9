"""Dormand and Prince's method of order 8 with error control and dense output."""

from __future__ import annotations

from typing import Any

from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.integrators.base.fixed_step import Table
from gnomon.harness.integrators.base.step_control import MOST_STEPS as MOST_STEPS
from gnomon.harness.integrators.runge_kutta import dop853_table
from gnomon.harness.integrators.runge_kutta.embedded import Embedded, full

# Rows of the table: twelve stages, the end of the step, three stages for dense output, two errors, dense output.
WEIGHTS, LAST, ERROR_5, ERROR_3, DENSE = 12, 16, 16, 17, 18


class Dop853(Embedded):
    """Dormand and Prince's 8(5,3) pair, predictive step control, dense output of order 7. Order 8.

    Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, 1993, II.5 and II.10. The tolerance is both
    relative and absolute, the error the root mean square over the components. Sums are compensated.
    """

    name, order = "DOP853", 8
    stages, weights, extra = dop853_table.STAGES, dop853_table.WEIGHTS, dop853_table.EXTRA_STAGES
    errors, dense = (dop853_table.ERROR_5, {}), dop853_table.DENSE

    @classmethod
    def rows(cls, mp: Any) -> Table:
        """As in every pair; the error estimate of order 3 is the difference of two formulas."""
        table = list(super().rows(mp))
        third = full(mp, dop853_table.WEIGHTS_3, LAST)
        table[ERROR_3] = [mp.mpf(0), *(b - d for b, d in zip(table[WEIGHTS][1:], third, strict=True))]
        return table


def rows(mp: Any) -> Table:
    """The 22 rows of the table: c_j, a_j1, ... for the stages; 0 and the weights for the others."""
    return Dop853.rows(mp)


INTEGRATORS: tuple[type[Integrator], ...] = (Dop853,)
