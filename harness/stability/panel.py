"""Panels of numerical stability: each measures an integrator, and sentences follow from its numbers."""

from __future__ import annotations

import importlib
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.contract.status import Status
from gnomon.harness.measuring.failures import status_of

IDS = ("linear", "stiffness", "resonance", "tolerance", "relations", "events", "long_time", "digits")
"""The panels in the order of measurement and display. Each is in the module of this name."""


@dataclass(frozen=True)
class Column:
    """A quantity in the figure of a panel.

    `decades`: its axis is logarithmic. `ends`: the largest range of the axis; None if the numbers decide.
    """

    id: str
    title: str
    decades: bool = False
    ends: tuple[float, float] | None = None


@dataclass(frozen=True)
class Mark:
    """A number of an integrator in the figure of a panel, an interval, or both; `text` describes it, or stands alone.

    In a panel of `cells` the number is from 0, no objection, to 1, and the text is written into the cell.
    """

    column: str
    at: float | None = None
    low: float | None = None
    high: float | None = None
    text: str = ""


Data = Mapping[str, Any]


@dataclass(frozen=True)
class Panel:
    """A question of numerical stability about an integrator.

    `applies` returns why a panel is not measured for an integrator, or None if it is. `measure(integrator, seconds)`
    spends about `seconds` of processor time and returns data for JSON: numbers, strings, lists and dictionaries of
    them. It may raise the exceptions of the integrator; the method `measured` never does. `sentences` makes advice of such data:
    "use it for ..." and "not for ...", each with its number. `marks` makes the marks of the figure, which has
    `columns`.
    """

    id: str
    title: str
    applies: Callable[[Integrator], str | None]
    measure: Callable[[Integrator, float], dict[str, Any]]
    sentences: Callable[[Data], list[str]]
    columns: Sequence[Column] = ()
    marks: Callable[[Data], list[Mark]] = lambda data: []
    cells: bool = False

    def measured(self, integrator: Integrator, seconds: float) -> dict[str, Any]:
        """The data of `measure`, with nan and infinity as None.

        {"not_applicable": reason} if the panel does not apply, {Status.REFUSED: reason} if the integrator refuses or
        raises.
        """
        why = self.applies(integrator)
        if why is not None:
            return {"not_applicable": why}
        try:
            data: dict[str, Any] = for_json(self.measure(integrator, seconds))
        except Exception as error:  # the user's code may raise anything, and the next panel is measured all the same
            return {Status.REFUSED: status_of(error)[1]}
        return data


def panel(
    name: str,
    title: str,
    sentences: Callable[[Data], list[str]],
    columns: Sequence[Column],
    marks: Callable[[Data], list[Mark]],
    applies: Callable[[Integrator], str | None] = lambda integrator: None,
    cells: bool = False,
) -> Callable[[Callable[[Integrator, float], dict[str, Any]]], Panel]:
    """A decorator: the function measures the panel `name`, which has the name of its function and of its module."""
    return lambda measure: Panel(name, title, applies, measure, sentences, columns, marks, cells)


def panels() -> dict[str, Panel]:
    """All panels by id, in the order of `IDS`; imports their modules."""
    return {name: getattr(importlib.import_module(f"gnomon.harness.stability.{name}"), name) for name in IDS}


def for_json(value: Any) -> Any:
    """Plain numbers, lists and dictionaries: numpy values converted, nan and infinities as None."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, Mapping):
        return {str(key): for_json(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [for_json(each) for each in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
