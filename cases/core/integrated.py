"""Cases without a closed form: their exact motion is a certified integration of their equations."""

from __future__ import annotations

from typing import Any, ClassVar
from uuid import uuid4

from gnomon.cases.core.arithmetic import rebind
from gnomon.cases.core.case import Case
from gnomon.cases.core.exact_motion import bind
from gnomon.cases.core.forms import Equations, FirstOrder
from gnomon.cases.core.numbers import OutOfReachError
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.certified import MOST_WORK, CertifiedMotion
from gnomon.reference.numerics.motion import Motion
from gnomon.reference.numerics.taylor import flint_arithmetic
from gnomon.reference.storage.import_closure import closure


def integrate(case: IntegratedCase) -> CertifiedMotion:
    """The motion of a case over its span, by integration of its equations."""
    values = case.parameter_values()
    rebound = rebind(case.equations_of_motion, flint_arithmetic())

    def rates(t: Any, state: tuple[Any, ...]) -> tuple[Any, ...]:
        return tuple(rebound(t, state, tuple(map(ball, values))))

    kind = type(case)
    source = closure(kind.__module__) or uuid4().hex  # without a file: no key on disk may be met again
    label = f"{kind.__module__}.{kind.__qualname__} {source} {', '.join(map(str, values))}"
    return CertifiedMotion(label, case.initial_state, case.span, rates, case.most_work)


class IntegratedCase(Case):
    """A case whose exact motion is a certified integration of its equations; a subclass states its forms as usual.

    Examples
    --------
    >>> from gnomon.cases import get
    >>> isinstance(get("double_pendulum"), IntegratedCase)
    True
    """

    exact_motion: Motion = bind(integrate)
    certified_digits: ClassVar[int] = 30
    longest: ClassVar[int] = 1000
    """The longest span in units of `fastest_time`: each unit takes 0.1 s or more to integrate."""
    most_work: ClassVar[int] = MOST_WORK
    """Steps times operations of the equations that its integrations may take (see `CertifiedMotion`)."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        with self._within_reach():
            most = self.longest * self.fastest_time
            if self.span > most:
                raise OutOfReachError(
                    f"span = {float(self.span):g} s is more than {self.longest} of its shortest times "
                    f"({self.fastest_time:g} s); give at most {most:g} s, or other numbers"
                )

    @property
    def equations_of_motion(self) -> Equations:
        """The equations of the first-order form."""
        return next(form for form in self.all_forms() if isinstance(form, FirstOrder)).equations
