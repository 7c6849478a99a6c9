"""Cases whose exact motion finds impact after impact: their number within the span, and the list of them."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cached_property
from typing import Any

from gnomon.cases.core.case import Case
from gnomon.reference.contact.flights import ImpactMotion


class ImpactCase(Case):
    """A case whose exact motion finds one impact after another."""

    exact_motion: ImpactMotion

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        with self._within_reach():
            _ = self.count

    @cached_property
    def count(self) -> int:
        """The number of impacts within the span."""
        try:
            return self.exact_motion.impacts(self.span)
        except ArithmeticError as error:
            raise ArithmeticError(f"span = {float(self.span):g} s holds {error}; give a shorter span") from None

    def impacts(self, digits: int) -> Iterator[tuple[Any, Any, Any]]:
        """Time of each impact within the span, and the rate before and after it."""
        return (self.exact_motion.impact(n, self.span, digits) for n in range(1, self.count + 1))

    def same_course(self, other: Case) -> bool:
        return isinstance(other, type(self)) and other.count == self.count
