"""All that the file of a case or of a check needs to declare it: `from gnomon.cases.declare import *`."""

from typing import Any

from gnomon.cases.core.case import Case, Event, Level, Span, conserved, decaying, same
from gnomon.cases.core.check import Check
from gnomon.cases.core.declared import Attitude, Coordinate, Parameter, Variant
from gnomon.cases.core.exact_motion import bind
from gnomon.cases.core.forms import FirstOrder, Hybrid, Mode, SecondOrder, SemiLinear, Separable, Transition, Values
from gnomon.cases.core.numbers import Range, Rule, nonnegative, positive, typical

__all__ = [
    "Any",
    "Attitude",
    "Case",
    "Check",
    "Coordinate",
    "Event",
    "FirstOrder",
    "Hybrid",
    "Level",
    "Mode",
    "Parameter",
    "Range",
    "Rule",
    "SecondOrder",
    "SemiLinear",
    "Separable",
    "Span",
    "Transition",
    "Values",
    "Variant",
    "bind",
    "conserved",
    "decaying",
    "nonnegative",
    "positive",
    "same",
    "typical",
]
