"""Dormand and Prince's method of order 8 with error control and dense output."""

from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.integrators.runge_kutta import dop853_table
from gnomon.harness.integrators.runge_kutta.embedded import Embedded


class Dop853(Embedded):
    """Dormand and Prince's 8(5,3) pair, predictive step control, dense output of order 7. Order 8.

    Hairer, Norsett, Wanner, Solving Ordinary Differential Equations I, 1993, II.5 and II.10.
    """

    name, order = "DOP853", 8
    tableau = dop853_table.DOP853


INTEGRATORS: tuple[type[Integrator], ...] = (Dop853,)
