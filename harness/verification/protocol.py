"""The lines that gnomon and a program in any language exchange: one JSON object each, stated by `protocol.schema.json`.

Messages of the program are data, whose shape is verified here before they are used. The schema validates a description. It
does not validate a reply, because that is part of the time of a call, and the schema would take 6 ms for 64 states where the
code here takes 0.1 ms. A test holds that both accept equal replies.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from functools import cache
from importlib.resources import files
from typing import Any, NoReturn

import numpy as np
from gnomon.cases.core.forms import FirstOrder, Form, RigidBody, SecondOrder
from gnomon.cases.core.scene import SceneForm
from gnomon.harness.contract.integrator import Floats, Names, Problem, Refused, Steps, Tolerance, Unsupported
from gnomon.harness.contract.status import Status
from gnomon.harness.contract.validation import TEXT, Unusable, count, short
from gnomon.harness.kernels.equation_text import equation_text

VERSION = 1
FORMS: Mapping[str, type] = {"FirstOrder": FirstOrder, "SecondOrder": SecondOrder}
"""The forms that a program may take; the equations of both are sent as first-order equations."""
SWEEPS: Mapping[str, type[Steps] | type[Tolerance]] = {"step": Steps, "tolerance": Tolerance}
SPECIAL = {"nan": math.nan, "inf": math.inf, "-inf": -math.inf}
"""Strings for values that JSON numbers cannot express."""


@dataclass(frozen=True)
class Description:
    """The declarations of a program, with the meaning of the attributes of `Integrator`."""

    name: str
    sweep: Steps | Tolerance
    order: int | None = None
    forms: tuple[str, ...] = ("FirstOrder",)
    counts_rhs: bool = False
    sampling: str = "grid"
    conserves: tuple[str, ...] = ()
    version: str = ""
    jacobian: str = "exact"


@dataclass(frozen=True)
class Reply:
    """The states (len(times), dimension) of one problem, counts if the program gives them, and why it stopped early."""

    states: Floats
    steps: int | None
    rhs_calls: int | None
    stopped: str | None


def describe_line() -> str:
    return json.dumps({"protocol": VERSION, "request": "describe"})


def description(line: str) -> Description:
    """The description in a line. Raises Unusable for an invalid one."""
    data = _object(line)
    check, wrong = _check_of_descriptions()
    try:
        check(data)
    except RecursionError:
        raise Unusable("wrote JSON that is nested too deeply") from None
    except wrong as error:
        if error.rule == "required":
            missing = next(name for name in error.rule_definition if name not in error.value)
            raise Unusable(f"wrote {short(error.value)}: {missing!r} is a required property") from None
        _wrong(error.name.removeprefix("data").lstrip("."), error.value, f"it is {error.definition['description']}")
    sweep = data["sweep"]
    kind = SWEEPS[sweep["kind"]]
    known = {name: sweep[name] for name in kind.__dataclass_fields__ if name in sweep and name != "kind"}
    declared: dict[str, Any] = {field.name: data[field.name] for field in fields(Description) if data.get(field.name)}
    texts: dict[str, Any] = {name: tuple(data[name]) for name in ("forms", "conserves") if name in declared}
    return Description(**declared | texts | {"sweep": kind(**known)})


@cache
def _check_of_descriptions() -> tuple[Callable[[Any], Any], type[Any]]:
    """(function, exception): the function raises the exception for a description that violates the schema."""
    import fastjsonschema  # slow to load: only where a program describes itself

    schema = json.loads((files("gnomon.harness.verification") / "protocol.schema.json").read_text("utf-8"))
    description = schema["$defs"]["description"] | {"$defs": schema["$defs"]}
    return fastjsonschema.compile(description), fastjsonschema.JsonSchemaValueException


def problem_parts(problem: Problem, kind: str, setting: float) -> tuple[str, str]:
    """The text of a problem before and after its number and start, which change with each call."""
    names = problem.names or _name_by_number(problem)
    parameters = dict(zip(names.parameters, problem.parameters.tolist(), strict=True))
    times = problem.times.tolist()
    rest = {
        "case": names.case,
        "setting": {"kind": kind, "value": _encode(setting), "hex": setting.hex()},
        "coordinates": names.coordinates,
        "parameters": parameters,
        "parameters_hex": {name: value.hex() for name, value in parameters.items()},
        "t0": problem.t0,
        "t0_hex": problem.t0.hex(),
        "times": times,
        "times_hex": [t.hex() for t in times],
        "time_scale": float(problem.time_scale),
        "equations": _equations(problem.form, names),
    }
    return json.dumps({"protocol": VERSION, "request": "solve"})[:-1], json.dumps(rest)[1:]


def problem_line(parts: tuple[str, str], number: int, start: Floats) -> str:
    """The line of one problem; `start` has the shape (dimension,)."""
    values = start.tolist()
    own = json.dumps({"number": number, "start": [_encode(x) for x in values], "start_hex": [x.hex() for x in values]})
    return f"{parts[0]}, {own[1:-1]}, {parts[1]}"


def reply(line: str, number: int, shape: tuple[int, int]) -> Reply:
    """The reply in a line to problem `number`; its states must have the shape (times, dimension).

    Raises Refused or Unsupported if the program says so, and Unusable for an invalid reply.
    """
    data = _object(line)
    if data.get("number") != number or isinstance(data.get("number"), bool):
        raise Unusable(f"replied to number {short(data.get('number'))} where {number} was asked")
    status = data.get("status")
    if status == Status.REFUSED:
        raise Refused(_text(data, "reason")[:TEXT])
    if status == Status.UNSUPPORTED:
        raise Unsupported(f"lacks {_text(data, 'lacks')[:TEXT]}")
    if status not in (Status.OK, "stopped"):
        _wrong("status", status, "it is ok, stopped, refused or unsupported")
    stopped = _text(data, "reason")[:TEXT] if status == "stopped" else None
    states = _states(data.get("states"), shape, complete=stopped is None)
    counts = {n: None if data.get(n) is None else count(data[n], n) for n in ("steps", "rhs_calls")}
    return Reply(states, counts["steps"], counts["rhs_calls"], stopped)


def _states(rows: Any, shape: tuple[int, int], complete: bool) -> Floats:
    """The states as an array of this shape; nan after an early end."""
    times, dimension = shape
    if not isinstance(rows, list):
        _wrong("states", rows, f"they are a list of {times} lists")
    if len(rows) > times or (complete and len(rows) < times):
        raise Unusable(f'wrote {len(rows)} states for {times} times; one that ends early has the status "stopped"')
    states = np.full(shape, np.nan)
    for k, row in enumerate(rows):
        if not isinstance(row, list) or len(row) != dimension:
            _wrong(f"states[{k}]", row, f"it is a list of {dimension} numbers")
        for i, value in enumerate(row):
            states[k, i] = value if type(value) is float else _number(value, f"states[{k}][{i}]")
    return states


def _number(value: Any, name: str) -> float:
    """A number, or a text of SPECIAL or of hexadecimal digits. Raises Unusable, with `name`, for another value."""
    if isinstance(value, str):
        if value in SPECIAL:
            return SPECIAL[value]
        if "0x" in value:
            try:
                return float.fromhex(value)
            except (ValueError, OverflowError):
                pass
    elif isinstance(value, int | float) and not isinstance(value, bool):
        try:
            return float(value)
        except OverflowError:
            return math.inf if value > 0 else -math.inf
    _wrong(name, value, 'it is a number, its hexadecimal digits as a text ("0x1.8p+1"), "nan", "inf" or "-inf"')


def _encode(value: float) -> float | str:
    """The number, or its name if JSON has no such number."""
    return value if math.isfinite(value) else repr(value)


def _object(line: str) -> dict[str, Any]:
    """The JSON object in a line of a program. Raises Unusable if the line is not a JSON object."""
    try:
        value = json.loads(line, parse_constant=_constant)
    except RecursionError:
        raise Unusable("wrote JSON that is nested too deeply") from None
    except ValueError as error:
        raise Unusable(
            f"wrote {short(line)}, which is not JSON ({error}); standard output is for replies, standard error for all else"
        ) from None
    if not isinstance(value, dict):
        raise Unusable(f"wrote {short(value)}: a reply is a JSON object")
    return value


def _constant(name: str) -> NoReturn:
    """Refuse NaN and Infinity, which Python's reader would accept."""
    raise ValueError(f'{name} is not JSON: write "nan", "inf" or "-inf" in quotes')


def _text(reply: Mapping[str, Any], key: str) -> str:
    """The text under a key. Raises Unusable for another value."""
    value = reply.get(key)
    if not isinstance(value, str):
        _wrong(key, value, "it is a text")
    return value


def _wrong(key: str, value: Any, rule: str) -> NoReturn:
    raise Unusable(f"wrote {key} = {short(value)}: {rule}")


def _name_by_number(problem: Problem) -> Names:
    """Coordinates y1, y2, ... and parameters p1, p2, ..."""
    counts = {"y": problem.dimension, "p": len(problem.parameters)}
    return Names("", *(tuple(f"{letter}{k}" for k in range(1, n + 1)) for letter, n in counts.items()))


def _equations(form: Form | SceneForm, names: Names) -> dict[str, Sequence[str]] | None:
    """The equations as text; None for a form without plain equations, and for equations that branch."""
    if not isinstance(form, FirstOrder | SecondOrder | RigidBody):
        return None
    try:
        return asdict(equation_text(form, names.coordinates, names.parameters))
    except ValueError:
        return None
