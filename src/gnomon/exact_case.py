"""`gnomon.case`: a case by its name, with its exact motion, its equations and a picture; and the lists of names."""

from collections.abc import Iterable, Sequence
from decimal import Decimal
from functools import cached_property
from typing import Any

import numpy as np
from mpmath.libmp import to_str

from gnomon.cases.core import registry
from gnomon.cases.core.case import Case
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.contract.validation import short
from gnomon.harness.kernels.case_equations import equations_in_latex, formulas
from gnomon.harness.registry import lookup, selection
from gnomon.harness.running.own_functions import CaseEquations
from gnomon.harness.system.extras import require
from gnomon.harness.system.notebook import view
from gnomon.reference.numerics.precision import Number, exact

MOST_DIGITS = 1000


class ExactCase:
    """A case with given numbers: an initial value problem whose exact motion is known.

    Its numbers are rounded to binary64, as integrators get them. `gnomon.case` makes it.

    Attributes
    ----------
    case : gnomon.cases.Case
        The declaration with these numbers.
    coordinates : tuple of str
        The names of the coordinates of the state.
    start : ndarray, shape (dim,)
        The initial state.
    times : ndarray, shape (64,)
        The sample times in s, over the span of the case.

    Examples
    --------
    >>> import gnomon
    >>> swing = gnomon.case("pendulum_simple", L=2)
    >>> print(swing.exact(1.5, digits=30))
    theta = -1.66220343990834854387903446503
    omega = -1.78520163125831186890431114758
    """

    def __init__(self, case: Case) -> None:
        self.case = case.rounded()

    def __repr__(self) -> str:
        return repr(self.case)

    def _repr_mimebundle_(self, **kwargs: Any) -> dict[str, Any]:
        return view(repr(self), self.plot)

    @property
    def coordinates(self) -> tuple[str, ...]:
        return tuple(each.name for each in self.case.state)

    @property
    def start(self) -> Floats:
        return np.array([float(x) for x in self.case.initial_state])

    @property
    def times(self) -> Floats:
        return self.case.times

    def exact(self, t: Number | Iterable[Number], digits: int = 15) -> Any:
        """The exact state at a time, or the states at several times.

        Parameters
        ----------
        t : number or sequence of numbers
            Times in s. A float is that double; a text as "0.1" is that decimal number.
        digits : int
            Significant digits.

        Returns
        -------
        ExactState or list of ExactState
            The coordinates as Decimal with these digits. At an event, the state after it.

        Raises
        ------
        ValueError
            For a time that is not a number from 0 on, and for a number of digits out of range.

        Examples
        --------
        >>> import gnomon
        >>> oscillator = gnomon.case("harmonic_oscillator")
        >>> len(oscillator.exact(["0.1", 0.2]))
        2
        """
        if not isinstance(digits, int) or not 1 <= digits <= MOST_DIGITS:
            raise ValueError(f"digits={digits!r}: give a whole number from 1 to {MOST_DIGITS}")
        if isinstance(t, str) or not isinstance(t, Iterable):
            return self._state(t, digits)
        return [self._state(each, digits) for each in np.ravel(np.array(t, dtype=object)).tolist()]

    def _state(self, t: Any, digits: int) -> "ExactState":
        time = exact(t, "t")
        if time < 0:
            raise ValueError(f"t={t!r}: the motion starts at 0; give times from 0 on")
        values = [Decimal(to_str(x._mpf_, digits, strip_zeros=False)) for x in self.case.exact(time, digits)]
        return ExactState(dict(zip(self.coordinates, values, strict=True)))

    def sample(self, times: Sequence[float] | Floats) -> Floats:
        """Exact states in binary64, fast for many times.

        Parameters
        ----------
        times : array_like, shape (n,)
            Times in s.

        Returns
        -------
        ndarray, shape (n, dim)
            The states, each value within .51 ulp.

        Raises
        ------
        ValueError
            For anything but a sequence of finite times from 0 on.

        Examples
        --------
        >>> import gnomon
        >>> gnomon.case("harmonic_oscillator").sample([0.0, 0.5, 1.0]).shape
        (3, 2)
        """
        try:
            moments = np.array(times, dtype=np.float64)
        except (TypeError, ValueError):
            moments = np.empty(0)
        if moments.ndim != 1 or not len(moments) or not (np.isfinite(moments) & (moments >= 0)).all():
            raise ValueError(f"times={short(times)}: give a sequence of finite times from 0 on, in s")
        return self.case.sample(moments)

    def quantities(self, digits: int = 15) -> dict[str, Any]:
        """Derived quantities by name, such as the period, in SI units.

        Parameters
        ----------
        digits : int
            Significant digits.

        Returns
        -------
        dict of str to Decimal
            The quantities that the motion has.

        Examples
        --------
        >>> import gnomon
        >>> gnomon.case("harmonic_oscillator").quantities(20)["period"]
        Decimal('6.2831853071795864769')
        """
        return {name: _decimal(value, digits) for name, value in self.case.quantities(digits).items()}

    @cached_property
    def equations(self) -> CaseEquations:
        """The equations of motion: `print` shows them, a call (t, y) gives the derivatives, `gnomon.solve` takes them."""
        return CaseEquations(self.case.all_forms(), self.case.name, self.coordinates, self._parameters, self._text)

    def _text(self) -> tuple[list[str], list[str]]:
        """The lines of the equations, and their LaTeX."""
        return formulas(self.case) or [f"gnomon show {self.case.name} prints them"], [*equations_in_latex(self.case)]

    @property
    def _parameters(self) -> dict[str, float]:
        values = map(float, self.case.parameter_values())
        return dict(zip((each.name for each in self.case.parameter_list), values, strict=True))

    def plot(self) -> Any:
        """Draw the exact motion.

        Returns
        -------
        altair.Chart
            A chart, which a notebook shows and whose `save` writes .html, .svg or .png.

        Raises
        ------
        ValueError
            Without the packages of the extra `report`.

        Examples
        --------
        >>> import gnomon
        >>> gnomon.case("kepler_orbit").plot().save("orbit.svg")
        """
        require("report", "a chart")
        from gnomon.harness.reporting.pictures.motion_picture import chart  # loads Altair, an optional package

        return chart(self.case)


class ExactState(dict[str, Decimal]):
    """The coordinates of an exact state by name, as Decimal; `print` shows all their digits.

    Examples
    --------
    >>> ExactState(x=Decimal("0.10"))["x"]
    Decimal('0.10')
    """

    def __str__(self) -> str:
        width = max(map(len, self), default=0)
        return "\n".join(f"{name:{width}} = {value}" for name, value in self.items())

    def __repr__(self) -> str:
        return f"<{', '.join(f'{name} = {value}' for name, value in self.items())}>"


def _decimal(value: Any, digits: int) -> Any:
    return Decimal(to_str(value._mpf_, digits, strip_zeros=False)) if hasattr(value, "_mpf_") else value


def case(
    name: str | type[Case] | Case,
    variant: str | None = None,
    initial_state: Sequence[Number] | None = None,
    span: Number | None = None,
    **parameters: Number,
) -> ExactCase:
    """A case with its exact motion.

    Parameters
    ----------
    name : str, type or Case
        A name of `gnomon.list_cases`, `name/variant`, `package.module:Class`, or a subclass of `gnomon.cases.Case`.
    variant : str, optional
        The name of a variant, whose numbers replace the defaults.
    initial_state : sequence of number, optional
        The initial state in the order of the case's coordinates, in their units.
    span : number, optional
        The duration in s.
    **parameters : number
        Parameters, and starts of coordinates, by name, in their units, rounded to binary64.

    Returns
    -------
    ExactCase
        The case with `exact`, `sample`, `equations`, `quantities` and `plot`.

    Raises
    ------
    ValueError
        For an unknown name, variant or parameter, and for numbers outside the domain.

    Examples
    --------
    >>> import gnomon
    >>> gnomon.case("kepler_orbit/e09").coordinates
    ('x', 'y', 'vx', 'vy')
    """
    if isinstance(name, ExactCase):
        name = name.case
    if isinstance(name, Case):
        if variant is not None or initial_state is not None or span is not None or parameters:
            raise ValueError(f"name={name!r}: this case has its numbers; give its name to change them")
        return ExactCase(name)
    if isinstance(name, str):
        known, slash, after = name.partition("/")
        if slash and variant is not None:
            raise ValueError(f"variant={variant!r}: {name!r} names a variant already")
        kind, variant = registry.case_class(known), after if slash and after != selection.DEFAULT else variant
    elif isinstance(name, type) and issubclass(name, Case):
        kind = name
    else:
        raise ValueError(f"name={name!r}: give the name of a case; gnomon.list_cases() has all")
    return ExactCase(kind(variant, initial_state, span, **parameters))


def list_cases(pattern: str = "") -> list[str]:
    """The names of the cases.

    Parameters
    ----------
    pattern : str
        A part of a name, or a pattern with * and ?; `name/*` gives the variants of a case.

    Returns
    -------
    list of str
        The names, in the order of reports.

    Raises
    ------
    ValueError
        If no name has this part.

    Examples
    --------
    >>> import gnomon
    >>> gnomon.list_cases("kepler")
    ['kepler_orbit']
    """
    if not isinstance(pattern, str):
        raise ValueError(f"pattern={pattern!r}: give a part of a name")
    if "/" in pattern:
        return selection.expand([pattern])
    return selection.containing(pattern, registry.names())


def list_integrators(pattern: str = "") -> list[str]:
    """The ids of the integrators, whether or not their libraries are installed.

    Parameters
    ----------
    pattern : str
        A part of an id, or a pattern with * and ?.

    Returns
    -------
    list of str
        The ids, gnomon's own first.

    Raises
    ------
    ValueError
        If no id has this part.

    Examples
    --------
    >>> import gnomon
    >>> gnomon.list_integrators("scipy:R*")
    ['scipy:RK45', 'scipy:Radau', 'scipy:RK45 [events]', 'scipy:Radau [events]']
    """
    if not isinstance(pattern, str):
        raise ValueError(f"pattern={pattern!r}: give a part of an id")
    return selection.containing(pattern, lookup.everything())
