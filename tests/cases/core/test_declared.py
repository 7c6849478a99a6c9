"""A declaration: numbers as class attributes, the exact motion by their names, spans, quantities, time reversal."""

import re
from dataclasses import dataclass
from fractions import Fraction
from math import inf, tau
from typing import Any

import pytest
from gnomon.cases.core.case import Case, Span
from gnomon.cases.core.declared import Attitude, Coordinate, Parameter, Variant
from gnomon.cases.core.exact_motion import bind
from gnomon.cases.core.forms import FirstOrder, SecondOrder, Values
from gnomon.cases.core.numbers import Rule, positive, typical
from gnomon.reference.numerics.motion import Motion


@dataclass(frozen=True)
class Spring(Motion):
    """A motion that is never evaluated: its fields, and quantities of every kind."""

    mass: Fraction
    k: Fraction
    x0: Fraction
    v0: Fraction
    ends: tuple[Fraction, ...]
    damped: bool = False

    @property
    def stiffness(self) -> Fraction:
        return self.k

    def period(self, digits: int) -> Any:
        return self._rational(digits, self.mass / 3)

    def collision(self, digits: int) -> None:
        return None

    def edges(self, digits: int) -> tuple[int, Fraction]:
        return -1, Fraction(1, 3)

    def _state(self, mp: Any, t: Fraction) -> tuple[Any, ...]:
        return mp.mpf(self.x0), mp.mpf(self.v0)


def pull(t: Any, q: Values, parameters: Values) -> Values:
    return (-parameters[1] / parameters[0] * q[0],)


class SpringCase(Case):
    name = "spring"
    title = "A mass on a spring"
    section = "none"
    x = Coordinate("m", "0.5", typical(-5, 5))
    v = Coordinate("m/s", 0)
    m = Parameter("kg", 2, "mass", positive())
    k = Parameter("N/m", "0.1", "stiffness", positive())
    rules = (Rule("the spring is soft", lambda n: SpringCase.motion_of(n).stiffness < 1),)
    exact_motion = bind(Spring, mass="m", ends="x v")
    default_span = Span(10, "turn")
    quantity_names = ("period", "spring=stiffness", "collision", "least largest=edges")
    variants = (Variant("long", "many periods", periods=1000.5),)
    forms = (SecondOrder(pull),)
    time_scale = 3.0

    def derived(self, digits: int) -> dict[str, Any]:
        return {"root": lambda mp: mp.sqrt(mp.mpf(self.m)), "ratio": self.k / 3, "absent": None}


def test_a_number_is_a_declaration_of_the_class_and_exact_in_an_instance() -> None:
    case = SpringCase(k="0.3")
    assert (SpringCase.k.name, SpringCase.k.unit, SpringCase.x.kind) == ("k", "N/m", "length")
    assert (case.k, case.x, case.m) == (Fraction(3, 10), Fraction(1, 2), 2)
    assert SpringCase.state == (SpringCase.x, SpringCase.v)
    assert SpringCase.parameter_list == (SpringCase.m, SpringCase.k)
    assert SpringCase.default_state == ("0.5", 0)
    assert SpringCase.domain.ranges.keys() == {"x", "m", "k"}, "a number without a range is unrestricted"


def test_a_number_that_is_declared_again_keeps_its_place() -> None:
    class Heavy(SpringCase):
        m = Parameter("kg", 9, "large mass", positive())

    assert [p.name for p in Heavy.parameter_list] == ["m", "k"]
    assert (Heavy().m, SpringCase().m) == (9, 2)


@pytest.mark.parametrize("name", ["span", "times", "parameters", "name"])
def test_a_number_may_not_hide_an_attribute_of_every_case(name: str) -> None:
    with pytest.raises(TypeError, match=f"{name}: a Case has its own attribute {name}"):
        type("Hiding", (SpringCase,), {name: Parameter("1", 1)})


def test_a_coordinate_in_another_unit_states_its_kind() -> None:
    with pytest.raises(ValueError, match="a coordinate in 'K': state its kind"):
        Coordinate("K")
    assert Coordinate("K", kind="rate").group == "rate"


def test_an_attitude_is_nine_coordinates() -> None:
    class Turned(SpringCase):
        attitude = Attitude(axis="third axis")

    assert [c.name for c in Turned.state[2:]] == [f"R{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)]
    assert [c.name for c in Turned.state if c.group == "third axis"] == ["R13", "R23", "R33"]
    assert Turned().attitude == (1, 0, 0, 0, 1, 0, 0, 0, 1)


def test_starts_that_are_stated_together_hold_in_a_subclass_too() -> None:
    class Started(SpringCase):
        x = Coordinate("m")
        default_state = (7, 8)

    class Same(Started):
        pass

    assert (Same().x, Same().v) == (7, 8)


def test_an_exact_motion_takes_the_numbers_by_their_names() -> None:
    case = SpringCase(initial_state=(1, 4))
    assert case.motion() == Spring(Fraction(2), Fraction(1, 10), Fraction(1), Fraction(4), (Fraction(1), Fraction(4)))
    assert case.motion() is case.exact_motion, "made once"


def test_a_rule_may_ask_the_exact_motion() -> None:
    with pytest.raises(ValueError, match="the spring is soft does not hold"):
        SpringCase(k=2)


def test_a_span_counts_turns_time_scales_or_a_time_of_the_motion() -> None:
    def span(span: Span, variant: str | None = None) -> Fraction:
        return type("Timed", (SpringCase,), {"default_span": span})(variant).span

    assert span(Span(10, "turn")) == Fraction(10 * tau * 3)
    assert span(Span(10, "turn"), "long") == Fraction(1000.5 * tau * 3)
    assert span(Span("0.1", "turn")) == span(Span(0.1, "turn"))
    assert span(Span(2, "time scale")) == 6
    assert span(Span(4, lambda motion: motion.mass)) == 8
    assert span(Span(4, lambda motion: None, otherwise=5)) == span(Span(4, lambda motion: inf, otherwise=5)) == 15


@pytest.mark.parametrize(
    ("wrong", "told"),
    [
        (Span("ten", "turn"), "spring: the periods of its span = 'ten' is not a number; give one, as 2.5"),
        (Span(10, "day"), "spring: Span has the unit 'day'; give 'time scale' or 'turn'"),
        (Span(10, lambda motion: None, otherwise="nine"), "spring: `otherwise` of its span = 'nine' is not a number"),
    ],
)
def test_a_span_that_is_none_is_refused_in_one_line_with_its_value(wrong: Span, told: str) -> None:
    with pytest.raises(ValueError, match=re.escape(told)) as raised:
        type("Timed", (SpringCase,), {"default_span": wrong})()
    assert "\n" not in str(raised.value)


def test_quantities_are_rounded_once_and_absent_ones_left_out() -> None:
    found = SpringCase().quantities(30)
    assert list(found) == ["period", "spring", "least", "largest", "root", "ratio"]
    exact = {"period": Fraction(2, 3), "spring": Fraction(1, 10), "least": -1, "largest": Fraction(1, 3)}
    for name, value in (exact | {"ratio": Fraction(1, 30)}).items():
        error = abs(Fraction(*found[name].as_integer_ratio()) - value)
        assert error <= abs(value) * Fraction(1, 10**30), name


def test_time_reversal_follows_for_an_acceleration_that_depends_on_position_alone() -> None:
    assert SpringCase().reversal == ("v",)
    for stated in ({"autonomous": False}, {"forms": (FirstOrder(pull),)}):
        assert type("Other", (SpringCase,), stated)().reversal is None
