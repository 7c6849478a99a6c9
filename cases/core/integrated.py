"""Cases without a closed form: their exact motion is a certified integration of their own equations."""

from __future__ import annotations

from functools import cached_property
from typing import Any, ClassVar
from uuid import uuid4

from gnomon.cases.core.arithmetic import rebind
from gnomon.cases.core.case import Case
from gnomon.cases.core.forms import Equations, FirstOrder
from gnomon.cases.core.numbers import OutOfReachError
from gnomon.reference.numerics.certified import CertifiedMotion
from gnomon.reference.numerics.taylor import ball, flint_arithmetic
from gnomon.reference.storage.import_closure import closure


class IntegratedCase(Case):
    """A case whose motion follows from its own equations; a subclass states its forms as any other does."""

    certified_digits: ClassVar[int] = 30
    longest: ClassVar[int] = 1000
    """How many of its shortest times an integration may last: each costs a tenth of a second or more."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        with self._within_reach():
            most = self.longest * self.fastest_time
            if self.span > most:
                raise OutOfReachError(
                    f"span = {float(self.span):g} s is more than {self.longest} of its shortest times "
                    f"({self.fastest_time:g} s); give at most {most:g} s, or other numbers"
                )

    @cached_property
    def _exact(self) -> CertifiedMotion:
        equations = self.equations_of_motion
        values = self.parameter_values()
        rebound = rebind(equations, flint_arithmetic())

        def rates(t: Any, state: tuple[Any, ...]) -> tuple[Any, ...]:
            return tuple(rebound(t, state, tuple(map(ball, values))))

        kind = type(self)
        source = closure(kind.__module__) or uuid4().hex  # without a file: no key on disk may be met again
        label = f"{kind.__module__}.{kind.__qualname__} {source} {', '.join(map(str, values))}"
        return CertifiedMotion(label, self.initial_state, self.span, rates)

    @property
    def equations_of_motion(self) -> Equations:
        """The first-order equations."""
        return next(form for form in self.all_forms() if isinstance(form, FirstOrder)).equations

    def motion(self) -> CertifiedMotion:
        return self._exact
