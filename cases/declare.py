"""All that the file of a case or of a check needs to declare it; a user's own imports the same names from `gnomon.cases`.

The numbers and the functions of `math` that equations use, the classes of a case, its forms, and the parts of a scene.
"""

from collections.abc import Mapping
from fractions import Fraction
from math import acos, asinh, atan, atan2, cos, exp, hypot, inf, log, pi, sin, sqrt, tan, tau
from typing import Any

from gnomon.cases.core.case import Case, Event, Floats, Level, Span, conserved, decaying, same
from gnomon.cases.core.check import Check
from gnomon.cases.core.declared import Attitude, Coordinate, Parameter, Variant
from gnomon.cases.core.elimination import index_one, solve_linear
from gnomon.cases.core.exact_motion import bind
from gnomon.cases.core.forms import (
    Charged,
    Constrained,
    Equations,
    FirstOrder,
    Form,
    Friction,
    Hybrid,
    Impact,
    Mode,
    NBody,
    RigidBody,
    SecondOrder,
    SemiLinear,
    Separable,
    Transition,
    Values,
)
from gnomon.cases.core.formulation import Formulation
from gnomon.cases.core.integrated import IntegratedCase
from gnomon.cases.core.numbers import Range, Rule, nonnegative, positive, typical
from gnomon.cases.core.scene import (
    Body,
    Contact,
    Force,
    Guide,
    Hinge,
    Readings,
    Scene,
    SceneForm,
    Slider,
    Vector,
    free_body,
    joint,
)
from gnomon.cases.core.turning import Turning
from gnomon.reference.numerics.balls import ball
from gnomon.reference.numerics.motion import BallMotion
from gnomon.reference.numerics.precision import Number

__all__ = [
    "Any", "Attitude", "BallMotion", "Body", "Case", "Charged", "Check", "Constrained", "Contact", "Coordinate", "Equations", "Event",
    "FirstOrder", "Floats", "Force", "Form", "Formulation", "Fraction", "Friction", "Guide", "Hinge", "Hybrid", "Impact",
    "IntegratedCase", "Level", "Mapping", "Mode", "NBody", "Number", "Parameter", "Range", "Readings", "RigidBody", "Rule",
    "Scene", "SceneForm", "SecondOrder", "SemiLinear", "Separable", "Slider", "Span", "Transition", "Turning", "Values",
    "Variant", "Vector", "acos", "asinh", "atan", "atan2", "ball", "bind", "conserved", "cos", "decaying", "exp", "free_body",
    "hypot", "index_one", "inf", "joint", "log", "nonnegative", "pi", "positive", "same", "sin", "solve_linear", "sqrt", "tan", "tau", "typical",
]  # fmt: skip
