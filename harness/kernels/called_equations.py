"""Equations that stay functions of Python: compiled methods call them through an address, as they call compiled equations."""

from collections.abc import Callable
from typing import Any

import numpy as np
from gnomon.harness.contract.integrator import Floats


class Called:
    """A function of (t, state) to `outputs` numbers that compiled code calls.

    An exception cannot pass through compiled code: the first one is kept in `failure` with its time and state, and from
    then on the values are nan, which ends the integration.
    """

    refusal = "needs the formulas of equations, and these have none: they are called from Python"
    """The reason of a method that compiles or differentiates equations."""

    def __init__(self, function: Callable[[float, Floats], Any], outputs: int) -> None:
        self.function, self.outputs = function, outputs
        self.failure: tuple[BaseException, float, Floats] | None = None
        self.watch: Callable[[float, Floats, Floats], None] | None = None
        """Called with each time, state and values; an exception ends the integration as an exception of the function."""
        self.kernels: list[Any] = []
        """They live as long as the equations: compiled methods keep only their addresses."""

    def __call__(self, t: float, state: Any, parameters: Any) -> tuple[float, ...]:
        return tuple(self.values(float(t), np.array(state, dtype=np.float64)).tolist())

    def values(self, t: float, state: Floats) -> Floats:
        """The values at a time and a state (n,), which the function may keep or change."""
        if self.failure is None:
            try:
                values = np.asarray(self.function(t, state), dtype=np.float64).reshape(self.outputs)
                if self.watch is not None:
                    self.watch(t, state, values)
                return values
            except BaseException as error:  # Ctrl-C too; `solve` raises it after the integration has ended
                self.failure = error, t, state
        return np.full(self.outputs, np.nan)
