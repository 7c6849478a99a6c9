"""The exact motion of a case, bound to the numbers of the case by their names."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields, is_dataclass
from fractions import Fraction
from typing import Generic, Self, TypeVar, overload

from gnomon.cases.core.declared import Declared
from gnomon.reference.numerics.motion import Motion

M_co = TypeVar("M_co", bound=Motion, covariant=True)


ATTITUDE = " ".join(f"R{row}{column}" for row in "123" for column in "123")


class ExactMotion(Generic[M_co]):
    """The exact motion of a case: `exact_motion = ExactMotion(Pendulum, length="L")`.

    Each field of the dataclass takes the parameter or the initial value of its name; a 0 at the end of the name of a field
    is left out (theta0: theta), and `attitude` are the nine numbers of a rotation matrix. Keywords give the names for
    fields with other names, several ("x y z") for a field that is a tuple. Where that does not suffice, the argument is a
    function of the case. An instance of the case has the motion, which is made once.
    """

    def __init__(self, make: Callable[..., M_co], **names: str) -> None:
        self._make = make
        self._names = names

    def __set_name__(self, owner: type, name: str) -> None:
        self._attribute = name

    @overload
    def __get__(self, case: None, owner: type) -> Self: ...
    @overload
    def __get__(self, case: Declared, owner: type) -> M_co: ...
    def __get__(self, case: Declared | None, owner: type) -> Self | M_co:
        if case is None:
            return self
        made = self.of(case.numbers) if is_dataclass(self._make) else self._make(case)
        case.__dict__[self._attribute] = made  # read from there from now on
        return made

    def of(self, numbers: Mapping[str, Fraction]) -> M_co:
        """The motion of parameters and initial values by name, for the rules of a domain."""
        assert is_dataclass(self._make)
        found = {}
        for field in fields(self._make):
            own = ATTITUDE if field.name == "attitude" else field.name
            names = self._names.get(field.name, own if own in numbers else own.removesuffix("0")).split()
            if field.init and (field.name in self._names or names[0] in numbers or field.default is MISSING):
                values = tuple(numbers[name] for name in names)
                found[field.name] = values if len(names) > 1 else values[0]
        return self._make(**found)
