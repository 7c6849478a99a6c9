"""The first-order equations of every case and of every mode, and random times, states and parameters for them."""

import random
from dataclasses import dataclass
from math import acos, acosh, asin, asinh, atan, atanh, cos, cosh, exp, hypot, log, sin, sinh, sqrt, tan, tanh
from typing import Any

from gnomon.cases.core import registry
from gnomon.cases.core.case import Case
from gnomon.cases.core.forms import FirstOrder, Values


@dataclass(frozen=True)
class Equations:
    """First-order equations of a case; the equations of a mode take its `constants` after the parameters."""

    case: Case
    form: FirstOrder
    constants: tuple[float, ...] = ()

    @property
    def dimension(self) -> int:
        return len(self.case.state)

    @property
    def parameters(self) -> int:
        return len(self.case.parameter_list) + len(self.constants)

    def at_random(self, seed: int) -> tuple[float, list[float], list[float]]:
        """A time, and a state and parameters in the domain of the case, without special values."""
        unit = random.Random(f"{self.case.name} {seed}").random
        states = [coordinate.name for coordinate in self.case.state]
        parameters = [parameter.name for parameter in self.case.parameter_list]
        drawn = self.case.domain.draw([*states, *parameters], unit)
        values = [[drawn[name] for name in names] for names in (states, parameters)]
        return unit(), values[0], [*values[1], *self.constants]


def every_function(t: Any, state: Values, parameters: Values) -> Values:
    """Equations with every function that equations may use, but atan2, and with powers of every kind."""
    x, y = state
    (a,) = parameters
    first = sin(x) * cos(y) + tan(x / 2) - asin(y / 2) + acos(x / 3) / (2 + atan(x * y))
    second = sinh(x) - cosh(y) * tanh(x + t) + asinh(x) + acosh(2 + y) - atanh(x / 4)
    third = sqrt(x + y) ** 3 - exp(-x) * log(1 + y) + hypot(x, y) * a + (x + 1) ** 2.5 - 3 / (y + a) ** 2
    last = (x + 1) ** -2 + sqrt(a) * t + (x + 1) ** a + 2**x
    return first + second, second * third / (sin(a) + 2) - last


def _every() -> dict[str, Equations]:
    found = {}
    for name in registry.names():
        case = registry.get(name)
        if case.hybrid is not None:
            modes = case.hybrid.modes
            found |= {f"{name} {x.name}": Equations(case, FirstOrder(x.equations), x.constants) for x in modes}
        form = next((form for form in case.all_forms() if isinstance(form, FirstOrder)), None)
        if form is not None:
            found[name] = Equations(case, form)
    return found


EVERY = _every()
"""The equations by the name of the case, and of its mode."""
