"""Attributes that do not depend on the numbers of a case are declared as data, to be read without an instance."""

import dis
from functools import cached_property

import pytest
from gnomon.cases import get, names
from gnomon.cases.core.case import Case


@pytest.mark.parametrize("name", names())
def test_a_property_depends_on_the_numbers_else_it_is_an_attribute(name: str) -> None:
    for kind in type(get(name)).__mro__:
        for label, value in vars(kind).items() if kind not in (Case, object) else ():
            read = value.func if isinstance(value, cached_property) else getattr(value, "fget", None)
            read = value if label == "natural_span" else read
            if read is not None:
                code = list(dis.get_instructions(read))
                used = [
                    name for one in code for name in (one.argval if isinstance(one.argval, tuple) else (one.argval,))
                ]
                own = ("self" in used or "super" in used) and read.__code__.co_names != ("default_span",)
                abstract = any(one.opname == "RAISE_VARARGS" for one in code)
                assert own or abstract, f"{kind.__name__}.{label} = ... in place of a function"


@pytest.mark.parametrize("name", [name for name in names() if get(name).reversal is not None])
def test_a_time_reversal_names_coordinates_and_parameters(name: str) -> None:
    """A time reversal that is applied twice changes nothing, with the numbers that admit it."""
    case = get(name)
    assert case.reversal is not None
    assert set(case.reversal) <= set(case.numbers)
    assert any(coordinate.name in case.reversal for coordinate in case.state)
    there = case.reversed(case.initial_state)
    if there is not None:
        assert case.with_numbers(*there).reversed(there[0]) == (case.initial_state, case.parameters)
