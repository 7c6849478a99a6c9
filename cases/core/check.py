"""A check: numbers from closed forms, without motion, and an independent computation of the same numbers."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from types import SimpleNamespace
from typing import Any, ClassVar

from gnomon.cases.core.declared import Declared
from gnomon.reference.numerics.balls import ball, refined
from gnomon.reference.numerics.precision import Number, publish, working


class Check(Declared):
    """Closed forms with exact numbers. A subclass is one check; an instance is that check with given parameters.

    A subclass states the class attributes below and

    1. `formulas(p)`: the closed forms in balls of python-flint; `p` holds each parameter as a ball. They are evaluated
       with increasing precision until the balls prove the digits asked for, so they need no care about cancellation;
    2. `otherwise(mp, p)`: the same numbers in the mpmath context `mp`, by a computation that shares no formula with the
       first (quadrature, eigenvalues, linear systems, finite differences of an exact motion); `p` holds numbers of `mp`.

    Both return the same names. The part of a name after a dot is a component; the components of a quantity share a norm
    (`force.x`, `force.y`).

    Parameters
    ----------
    variant : str, optional
        The name of a variant, whose numbers replace the defaults.
    **parameters : number
        Parameters by name, in their units.

    Raises
    ------
    ValueError
        For an unknown variant or parameter, and for numbers outside the domain.

    Examples
    --------
    >>> from gnomon.cases import check_names, get_check
    >>> check = get_check(check_names()[0])
    >>> check.exact(20) == check.independent(20)
    True
    """

    guard: ClassVar[int] = 30
    """Extra digits for the independent computation: at least as many as it loses on any variant."""

    def __init__(self, variant: str | None = None, **parameters: Number) -> None:
        self.variant = variant
        self.parameters = self._parameters(self._variant(variant), parameters)
        self.domain.check(self.name, self.parameters)

    def formulas(self, p: Any) -> Mapping[str, Any]:
        """The closed forms in balls, at the current precision."""
        raise NotImplementedError

    def otherwise(self, mp: Any, p: Any) -> Mapping[str, Any]:
        """The same numbers by an independent computation in `mp`."""
        raise NotImplementedError

    def exact(self, digits: int = 15) -> dict[str, Any]:
        """The closed forms to `digits` significant digits each, as mpmath numbers by name."""
        names: list[str] = []

        def compute() -> list[Any]:
            numbers = self.formulas(SimpleNamespace(**{name: ball(v) for name, v in self.parameters.items()}))
            names[:] = numbers
            return list(numbers.values())

        with working(digits + 2) as mp:
            values = publish(refined(mp, compute), digits)
        return dict(zip(names, values, strict=True))

    def independent(self, digits: int = 15) -> dict[str, Any]:
        """The same numbers to `digits` significant digits, by a computation that shares no formula with `exact`."""
        with working(digits + self.guard) as mp:
            p = SimpleNamespace(**{name: mp.mpf(v.numerator) / v.denominator for name, v in self.parameters.items()})
            numbers = self.otherwise(mp, p)
            return dict(zip(numbers, publish(map(mp.mpf, numbers.values()), digits), strict=True))

    def sizes(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """The sizes by which errors of `values` are divided: the largest component of a quantity, its natural size if 0."""
        largest: dict[str, Any] = {}
        for name, value in values.items():
            quantity = name.partition(".")[0]
            largest[quantity] = max(largest.get(quantity, 0), abs(value))
        return {
            name: largest[name.partition(".")[0]] or self.natural_sizes.get(name.partition(".")[0], 1.0)
            for name in values
        }

    def rounded(self) -> Check:
        """The same check with every number rounded to binary64, as independent computations in binary64 take them."""
        numbers: dict[str, Any] = {name: float(value) for name, value in self.parameters.items()}
        copy = type(self)(**numbers)
        copy.variant = self.variant
        return copy

    def __repr__(self) -> str:
        return f"<{self.id}: {', '.join(f'{name}={float(value):g}' for name, value in self.parameters.items())}>"


Numbers = Mapping[str, Fraction]
"""The parameters of a check by name, as the rules of its domain take them."""
