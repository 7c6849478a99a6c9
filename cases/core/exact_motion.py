"""The exact motion of a case, bound to the numbers of the case by their names."""

from collections.abc import Callable, Mapping
from dataclasses import MISSING, fields, is_dataclass
from fractions import Fraction
from typing import Any, TypeVar, cast

from gnomon.cases.core.declared import Declared
from gnomon.reference.numerics.motion import Motion

M = TypeVar("M", bound=Motion)
ATTITUDE = " ".join(f"R{row}{column}" for row in "123" for column in "123")


def bind(motion: Callable[..., M], **names: str) -> M:
    """The exact motion of a case, declared as a class attribute: `exact_motion = bind(Pendulum, length="L")`.

    Parameters
    ----------
    motion : type or Callable
        A dataclass whose fields take the parameters and initial values of their names: a 0 at the end of the name of a
        field is left out (theta0: theta), and `attitude` are the nine numbers of a rotation matrix. Where names do not
        suffice, a function of the case that returns the motion.
    **names : str
        For a field with another name, the name of its number; for a field that is a tuple, several names: "x y z".

    Returns
    -------
    Motion
        An instance of the case reads its own motion from the attribute, which is made once.

    Examples
    --------
    >>> from gnomon.cases import get
    >>> type(get("pendulum_simple").exact_motion).__name__
    'Pendulum'
    """
    return cast(M, Bound(motion, names))


class Bound:
    """The descriptor that `bind` leaves in the class of a case: an instance reads its motion there."""

    def __init__(self, motion: Callable[..., Motion], names: Mapping[str, str]) -> None:
        self._motion = motion
        self._names = names

    def __set_name__(self, owner: type, name: str) -> None:
        self._attribute = name

    def __get__(self, case: Declared | None, owner: type) -> Any:
        if case is None:
            return self
        motion = self.of(case.numbers) if is_dataclass(self._motion) else self._motion(case)
        case.__dict__[self._attribute] = motion  # read from there from now on
        return motion

    def of(self, numbers: Mapping[str, Fraction]) -> Motion:
        """The motion of parameters and initial values by name."""
        assert is_dataclass(self._motion)
        arguments = {}
        for field in fields(self._motion):
            own = ATTITUDE if field.name == "attitude" else field.name
            names = self._names.get(field.name, own if own in numbers else own.removesuffix("0")).split()
            if field.init and (field.name in self._names or names[0] in numbers or field.default is MISSING):
                values = tuple(numbers[name] for name in names)
                arguments[field.name] = values if len(names) > 1 else values[0]
        return self._motion(**arguments)
