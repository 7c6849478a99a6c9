"""Validate the declaration of an integrator when it is loaded, so that errors appear before anything runs."""

from collections.abc import Callable, Mapping
from numbers import Integral
from typing import Any

from gnomon.harness.contract.integrator import Integrator, Steps, Tolerance
from gnomon.harness.contract.validation import is_finite, short

MOST_ORDER, MOST_HALVINGS, MOST_PER_DECADE = 1000, 60, 100


def validate(integrator: Integrator, origin: str = "") -> None:
    """Raise ValueError with one line that names the integrator, the attribute, its value and the rule.

    `origin`: the path that the user gave; if it is empty, the message has the name of the class.
    """
    kind = type(integrator)
    who = origin or f"{kind.__module__}:{kind.__qualname__}"
    if kind.__hash__ is None:
        raise ValueError(f"{who}: its objects have no hash; with @dataclass write @dataclass(eq=False)")
    for attribute, (holds, rule) in _RULES.items():
        try:
            value = getattr(integrator, attribute)
        except Exception as error:  # a user's property may raise anything
            raise ValueError(f"{who}: {attribute} raises {type(error).__name__}: {error}; {rule}") from None
        if not holds(value):
            raise ValueError(f"{who}: {attribute} = {short(value)}; {rule}")
    wrong = _wrong_sweep(integrator.sweep)
    if wrong is not None:
        raise ValueError(f"{who}: sweep = {short(integrator.sweep)}; {wrong}")
    try:
        versions = integrator.versions()
    except ImportError:
        return  # the library is missing: not an error of the declaration
    except Exception as error:  # a user's method may raise anything
        raise ValueError(f"{who}: versions() raises {type(error).__name__}: {error}") from None
    if not isinstance(versions, Mapping):
        raise ValueError(f"{who}: versions() returns {short(versions)}; it is a mapping of names to versions")


def _is_text(value: Any) -> bool:
    return isinstance(value, str) and bool(value.strip()) and value.isprintable()


def _is_order(value: Any) -> bool:
    return value is None or (
        isinstance(value, Integral) and not isinstance(value, bool) and 0 < int(value) <= MOST_ORDER
    )


def _are_kinds(value: Any) -> bool:
    return isinstance(value, tuple) and bool(value) and all(isinstance(kind, type) for kind in value)


_RULES: dict[str, tuple[Callable[[Any], bool], str]] = {
    "name": (_is_text, "it is a text in one line"),
    "library": (_is_text, "it is a text in one line"),
    "policy": (lambda value: value == "" or _is_text(value), "it is a text in one line, or empty"),
    "sampling": (_is_text, "it is a text in one line"),
    "order": (_is_order, f"it is a whole number from 1 to {MOST_ORDER}, or None"),
    "dense_order": (_is_order, f"it is a whole number from 1 to {MOST_ORDER}, or None"),
    "accepts": (_are_kinds, "it is a tuple of the forms that it takes, as (FirstOrder,)"),
    "sweep": (lambda value: isinstance(value, Tolerance | Steps), "it is a Tolerance(...) or a Steps(...)"),
    **dict.fromkeys(
        ("counts_rhs", "compensated", "primary"), (lambda value: isinstance(value, bool), "it is True or False")
    ),
    "jacobian": (lambda value: value in ("exact", "differences"), "it is exact or differences"),
    "conserves": (
        lambda value: isinstance(value, tuple) and all(isinstance(word, str) for word in value),
        "it is a tuple of texts",
    ),
}


def _wrong_sweep(sweep: Tolerance | Steps) -> str | None:
    """The rule that a sweep without settings breaks; None for a valid sweep."""
    if isinstance(sweep, Tolerance):
        if not (_is_positive(sweep.tightest) and _is_positive(sweep.loosest) and sweep.tightest < sweep.loosest):
            return "tolerances are finite, positive, and the tightest is below the loosest"
        return None if _is_whole(sweep.per_decade, 1, MOST_PER_DECADE) else f"per_decade is from 1 to {MOST_PER_DECADE}"
    if not _is_positive(sweep.coarsest):
        return "coarsest is a finite, positive number of time scales"
    return None if _is_whole(sweep.halvings, 0, MOST_HALVINGS) else f"halvings is from 0 to {MOST_HALVINGS}"


def _is_positive(value: Any) -> bool:
    return is_finite(value) and float(value) > 0


def _is_whole(value: Any, low: int, high: int) -> bool:
    return isinstance(value, Integral) and not isinstance(value, bool) and low <= int(value) <= high
