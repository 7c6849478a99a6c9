"""Facts of constrained forms that several methods and adapters need."""

import math
from typing import Any

from gnomon.cases.core.forms import Constrained, Equations, Values


def constraints_of(form: Constrained, n: int, parameters: int) -> int:
    """The number of constraints of a form with n coordinates."""
    return len(form.constraint(math.nan, (math.nan,) * n, (math.nan,) * parameters))


def rest(constraint: Equations) -> Equations:
    """The rates of constraints without time."""

    def rates(t: Any, q: Values, p: Values) -> Values:
        return tuple([0 for _ in constraint(t, q, p)])

    return rates
