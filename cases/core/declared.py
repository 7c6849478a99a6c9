"""The declarations of a case or a check: its numbers as class attributes with unit, default and range, its variants."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import ClassVar, Self, overload

from gnomon.cases.core.numbers import Domain, Range, Rule, given, nearest, typical
from gnomon.reference.numerics.precision import Number

KINDS = {
    "m": "length",
    "m^(1/2)": "length",
    "m/s": "velocity",
    "m^(1/2)/s": "velocity",
    "rad": "angle",
    "rad/s": "angular velocity",
    "1": "dimensionless",
    "1/s": "rate",
}
"""The kind of a coordinate by its unit."""


class _Number:
    """A number that is declared as a class attribute: an instance of the case has its exact value under this name."""

    name: str

    def __set_name__(self, owner: type, name: str) -> None:
        object.__setattr__(self, "name", name)

    @overload
    def __get__(self, instance: None, owner: type) -> Self: ...
    @overload
    def __get__(self, instance: Declared, owner: type) -> Fraction: ...
    def __get__(self, instance: Declared | None, owner: type) -> Self | Fraction:
        return self if instance is None else instance.numbers[self.name]


@dataclass(frozen=True)
class Coordinate(_Number):
    """One component of a state, declared as a class attribute.

    An instance of the case has the exact initial value, a Fraction, under the attribute's name.

    Parameters
    ----------
    unit : str
        SI unit, such as "rad/s".
    start : Number
        Default initial value.
    allowed : Range, optional
        Range of initial values; any number without it.
    group : str
        Coordinates of one group share a norm and a scale; by default the kind.
    kind : str
        length, velocity, angle, angular velocity, rate, dimensionless or attitude; it follows from a unit in `KINDS`.
    name : str
        The attribute's name, which the class gives it.

    Raises
    ------
    ValueError
        If the kind is not given and does not follow from the unit.

    Examples
    --------
    >>> Coordinate("rad", 2, typical(-7, 7)).kind
    'angle'
    """

    unit: str
    start: Number = 0
    allowed: Range | None = None
    group: str = ""
    kind: str = ""
    name: str = ""

    def __post_init__(self) -> None:
        if not self.kind and self.unit not in KINDS:
            raise ValueError(f"a coordinate in {self.unit!r}: state its kind; it follows for {', '.join(KINDS)}")
        object.__setattr__(self, "kind", self.kind or KINDS[self.unit])
        object.__setattr__(self, "group", self.group or self.kind)


@dataclass(frozen=True)
class Parameter(_Number):
    """One parameter, declared as a class attribute.

    An instance of the case has the exact value, a Fraction, under the attribute's name.

    Parameters
    ----------
    unit : str
        SI unit.
    default : Number
        Default value; text and integers are exact, as "9.81".
    meaning : str
        A few words for tables.
    allowed : Range, optional
        Range of values; any number without it.
    name : str
        The attribute's name, which the class gives it.

    Examples
    --------
    >>> from gnomon.cases.declare import positive
    >>> g = Parameter("m/s^2", "9.81", "acceleration of gravity", positive())
    """

    unit: str
    default: Number
    meaning: str = ""
    allowed: Range | None = None
    name: str = ""


@dataclass(frozen=True)
class Attitude:
    """The nine coordinates R11, R12 ... R33 of a rotation matrix, row by row, body -> space: `attitude = Attitude()`.

    An instance of the case has the nine initial values as a tuple.

    Parameters
    ----------
    start : Sequence[Number]
        Default initial values; by default the axes of the body along the axes of space.
    fixed : bool
        Whether tests and searches draw the default attitude alone.
    axis : str
        Group of the third column, if it has its own.

    Examples
    --------
    >>> [coordinate.name for coordinate in Attitude().coordinates()][:4]
    ['R11', 'R12', 'R13', 'R21']
    """

    start: Sequence[Number] = (1, 0, 0, 0, 1, 0, 0, 0, 1)
    fixed: bool = False
    axis: str = ""

    def coordinates(self) -> Iterator[Coordinate]:
        """The nine coordinates, row by row."""
        for n, value in enumerate(self.start):
            row, column = divmod(n, 3)
            allowed = typical(float(value), float(value)) if self.fixed else typical(-1, 1)
            group = self.axis if column == 2 else ""
            yield Coordinate("1", value, allowed, group, "attitude", f"R{row + 1}{column + 1}")

    @overload
    def __get__(self, instance: None, owner: type) -> Self: ...
    @overload
    def __get__(self, instance: Declared, owner: type) -> tuple[Fraction, ...]: ...
    def __get__(self, instance: Declared | None, owner: type) -> Self | tuple[Fraction, ...]:
        return self if instance is None else tuple(instance.numbers[each.name] for each in self.coordinates())


@dataclass(frozen=True)
class Variant:
    """A case or a check with other numbers, chosen because they are hard. Only the numbers that differ are given.

    Parameters
    ----------
    name : str
        Name of the variant, as in "pendulum_simple/separatrix".
    stresses : str
        One line for the page: the difficulty of the variant.
    parameters : Mapping[str, Number]
        Parameters that differ from the default, by name.
    initial_state : Sequence[Number], optional
        Initial state, one number for each coordinate.
    span : Number, optional
        Span (s).
    periods : number, optional
        Number of units in the case's `Span`, in place of the case's own.
    scored : tuple[str, ...]
        Groups of the state that count in the distance; all groups if it is empty.
    horizon : Number, optional
        For a chaotic motion, the time (s) at which its conditioning reaches 1.

    Examples
    --------
    >>> long = Variant("long_1e4", "10,000 periods: phase error", periods=10000.37)
    """

    name: str
    stresses: str
    parameters: Mapping[str, Number] = field(default_factory=dict)
    initial_state: Sequence[Number] | None = None
    span: Number | None = None
    periods: Number | None = None
    scored: tuple[str, ...] = ()
    horizon: Number | None = None


class Declared:
    """The base of `Case` and `Check`. A subclass declares its numbers as class attributes, in sequence.

    The numbers of its bases come first; a number that it declares again keeps its place.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    section: ClassVar[str]
    conventions: ClassVar[str] = ""
    parameter_list: ClassVar[tuple[Parameter, ...]] = ()
    rules: ClassVar[tuple[Rule, ...]] = ()
    """Rules that join several numbers."""
    domain: ClassVar[Domain] = Domain({})
    """The ranges of all numbers, and the rules."""
    variants: ClassVar[tuple[Variant, ...]] = ()
    natural_sizes: ClassVar[Mapping[str, float]] = {}
    """The size of a group or quantity that stays exactly zero; 1 SI unit for one without an entry."""

    variant: str | None
    parameters: dict[str, Fraction]

    def __init_subclass__(cls) -> None:
        super().__init_subclass__()
        declared = cls._declared()
        if not declared:
            return
        core = next(kind for kind in cls.__mro__[::-1] if Declared in kind.__bases__)
        attributes = {label for kind in core.__mro__[:-1] for label in (*vars(kind), *kind.__annotations__)}
        for label in attributes & set(declared):
            raise TypeError(
                f"{cls.__name__}.{label}: a {core.__name__} has its own attribute {label}; choose another name"
            )
        cls.parameter_list = tuple(each for each in declared.values() if isinstance(each, Parameter))
        cls.domain = Domain({n: each.allowed for n, each in declared.items() if each.allowed is not None}, cls.rules)

    @classmethod
    def _declared(cls) -> dict[str, Coordinate | Parameter]:
        """The numbers that the class and its bases declare, by name."""
        declared: dict[str, Coordinate | Parameter] = {}
        for kind in reversed(cls.__mro__):
            for label, value in vars(kind).items():
                if isinstance(value, Coordinate | Parameter):
                    declared[label] = value
                elif isinstance(value, Attitude):
                    declared |= {each.name: each for each in value.coordinates()}
        return declared

    @property
    def numbers(self) -> dict[str, Fraction]:
        """All numbers by name."""
        return self.parameters

    @property
    def id(self) -> str:
        return f"{self.name}/{self.variant}" if self.variant else self.name

    @classmethod
    def _variant(cls, name: str | None) -> Variant:
        if name is None:
            return Variant("default", "")
        for variant in cls.variants:
            if variant.name == name:
                return variant
        raise ValueError(f"{cls.name} has no variant {name!r}; {nearest(name, [v.name for v in cls.variants])}")

    @classmethod
    def _given(cls, name: str, value: Number) -> Fraction:
        return given(value, f"{cls.name}: {name}", cls.domain.ranges.get(name, Range()))

    @classmethod
    def _parameters(
        cls, variant: Variant, chosen: Mapping[str, Number], coordinates: Sequence[str] = ()
    ) -> dict[str, Fraction]:
        """The exact value of each parameter: the chosen one, else the one of the variant, else the default.

        `coordinates`: the other names that a caller may have meant.
        """
        values: dict[str, Number] = {p.name: p.default for p in cls.parameter_list}
        for name in chosen:
            if name not in values:
                also = " and no coordinate of this name" if coordinates else ""
                raise ValueError(
                    f"{cls.name} has no parameter {name!r}{also}; {nearest(name, [*values, *coordinates])}"
                )
        return {
            name: cls._given(name, value) for name, value in (values | dict(variant.parameters) | dict(chosen)).items()
        }
