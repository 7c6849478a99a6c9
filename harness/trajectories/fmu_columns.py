"""The variables of an FMU as the numbers of a case, in the language of `gnomon check --columns`: VARIABLE=NUMBER:UNIT.

The numbers are the coordinates and the parameters of the case. A parameter or an input of the FMU that is mapped to a
coordinate sets its start, any other variable is its value. Variables that have the name of a number need no text.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gnomon.cases import Case
from gnomon.cases.core.numbers import nearest
from gnomon.harness.contract.integrator import Integrator
from gnomon.harness.registry import lookup
from gnomon.harness.results.visible import shorten
from gnomon.harness.trajectories.columns import GREEK, split_columns
from gnomon.harness.trajectories.units import factor_to
from gnomon.harness.verification.fmu.adapter import SAME, CoSimulation, FmuIntegrator, Links, ModelExchange, Variable
from gnomon.harness.verification.fmu.archive import Archive, unpack

SYNTAX = "write VARIABLE=COORDINATE or VARIABLE=PARAMETER, with a unit as phi=theta:deg, or fixed=PARAMETER"
FIXED, NEGATIVE = "fixed", "negative"
"""The word in place of a variable for a parameter whose value is in the FMU; the option that changes the sign."""
METHOD = "gnomon:RK4"
"""The method that integrates an FMU for model exchange if none is named."""
STARTS = ("{}_0", "{}0", "{}_start", "start_{}")
"""Names of parameters that set the start of a coordinate."""


def from_fmu(
    path: str | Path,
    case: Case,
    columns: Iterable[str] | Mapping[str, str] | None = None,
    *,
    order: int | None = None,
    method: str | None = None,
) -> tuple[FmuIntegrator, list[str]]:
    """Make an integrator from an FMU and a case; returns it with the lines that tell the mapping.

    `order`: the order of convergence in the communication step that an FMU for co-simulation claims. `method`: the
    integrator for model exchange, `METHOD` by default; if it is named, an FMU of both kinds is used for model exchange.
    Raises ValueError, in one line, for an FMU that cannot be used, and for a mapping that lacks a number or has a wrong
    one.
    """
    archive = unpack(Path(path), is_model_exchange=method is not None)
    mapping = _Mapping(archive, case.rounded())
    links = mapping.find_links(split_columns(columns))
    name = Path(path).stem
    if archive.kind == "CoSimulation":
        return CoSimulation(name, archive, links, order), mapping.lines
    if order is not None:
        raise ValueError(
            f"--order {order}: {path} is for model exchange, whose order is that of --integrator; leave it out"
        )
    chosen: Integrator = lookup.find_one(method or METHOD)
    return ModelExchange(name, archive, links, chosen), mapping.lines


@dataclass(frozen=True)
class _Number:
    """A coordinate or a parameter of the case."""

    name: str
    unit: str
    value: float

    def __str__(self) -> str:
        return f"{self.name} = {self.value:.9g} {self.unit}".rstrip()


class _Mapping:
    """Finds the variable for each number of a case; `lines`: the mapping, a line each."""

    def __init__(self, archive: Archive, case: Case) -> None:
        self.archive, self.case = archive, case
        scalars = [each for each in archive.description.modelVariables if each.type in ("Real", "Float64")]
        self.variables = {each.name: each for each in scalars if not each.dimensions}
        self.coordinates = {
            each.name: _Number(each.name, each.unit, float(value))
            for each, value in zip(case.state, case.initial_state, strict=True)
        }
        self.parameters = {
            each.name: _Number(each.name, each.unit, float(value))
            for each, value in zip(case.parameter_list, case.parameter_values(), strict=True)
        }
        self.lines = [f"its description breaks a rule of FMI: {archive.invalid}"] if archive.invalid else []
        self.states: dict[str, Variable] = {}
        self.starts: dict[str, Variable | None] = {}
        self.given: dict[str, Variable | None] = {}
        """The parameters, None for one whose value is in the FMU."""

    @property
    def _is_exchange(self) -> bool:
        return self.archive.kind == "ModelExchange"

    def find_links(self, texts: Iterable[str]) -> Links:
        for text in texts:
            self._read_text(text)
        for coordinate in self.coordinates.values():
            self._find_state(coordinate)
            if not self._is_exchange:
                self._find_start(coordinate)
        if self._is_exchange:
            self._require_all_states()
        for parameter in self.parameters.values():
            self._find_parameter(parameter)
        return Links(
            self.case.name,
            tuple(self.states[name] for name in self.coordinates),
            tuple(self.starts.get(name) for name in self.coordinates),
            {name: number.value for name, number in self.coordinates.items()},
            tuple(self.given[name] for name in self.parameters),
            {name: number.value for name, number in self.parameters.items()},
        )

    def _read_text(self, text: str) -> None:
        """Take one part of the mapping."""
        left, equals, right = text.rpartition("=")
        left, (target, *options) = left.strip(), (part.strip() for part in right.split(":"))
        if not equals or not left or not target:
            raise ValueError(f"--columns {shorten(text)!r}: {SYNTAX}")
        target = GREEK.get(target, target)
        number = self.coordinates.get(target) or self.parameters.get(target)
        if number is None:
            names = ", ".join([*self.coordinates, *self.parameters])
            raise ValueError(
                f"--columns {shorten(text)}: {self.case.name} has no number {shorten(target)!r}; it has {names}"
            )
        if left == FIXED and FIXED not in self.variables:
            if target in self.coordinates or options:
                raise ValueError(f"--columns {shorten(text)}: {FIXED} stands for the variable of a parameter; {SYNTAX}")
            self._take(self.given, number, None, f"{number} is in the FMU, as you say", text)
            return
        variable = self._find_variable(left)
        linked, unit = self._link(variable, number, options, f"--columns {shorten(text)}")
        if target in self.parameters:
            self._require_settable(variable, number)
            self._take(self.given, number, linked, f"{variable.name} sets {target}{unit}", text)
        elif _is_set(variable) and not self._is_exchange:
            self._take(self.starts, number, linked, f"{variable.name} sets the start of {target}{unit}", text)
        else:
            self._take(self.states, number, linked, f"{variable.name} is {target}{unit}", text)

    def _take(self, place: dict[str, Any], number: _Number, linked: Variable | None, line: str, text: str) -> None:
        if number.name in place:
            raise ValueError(f"--columns {shorten(text)}: {number.name} is given twice; give it one variable")
        place[number.name] = linked
        self.lines.append(line)

    def _find_variable(self, name: str) -> Any:
        """The variable of a name, or the only one whose name ends in it after a dot."""
        if name in self.variables:
            return self.variables[name]
        ending = [each for each in self.variables if each.rpartition(".")[2] == name]
        if len(ending) == 1:
            return self.variables[ending[0]]
        if ending:
            raise ValueError(
                f"--columns {name}: several variables end so ({shorten(', '.join(ending))}); write the whole name"
            )
        raise ValueError(
            f"--columns: {self.archive.path} has no real variable {shorten(name)!r}; {self._list_names(name)}"
        )

    def _list_names(self, name: str) -> str:
        return nearest(name, self.variables).removesuffix(": see gnomon list")

    def _link(self, variable: Any, number: _Number, options: Iterable[str], what: str) -> tuple[Variable, str]:
        """The variable with its factor, and the unit as text. Raises ValueError for a wrong unit."""
        units = [option for option in options if option != NEGATIVE]
        if len(units) > 1:
            raise ValueError(f"{what}: two units, {units[0]} and {units[1]}; give one")
        stated = variable.unit or getattr(variable.declaredType, "unit", None)
        own = number.unit or "1"
        if units:
            factor, unit = factor_to(units[0], own, what), units[0]
        elif stated:
            way = f"the unit {stated} of {variable.name} in the FMU; with --columns {variable.name}={number.name}:UNIT"
            factor, unit = factor_to(stated, own, way), f"{stated}, by the FMU"
        else:
            factor, unit = 1.0, own if own == "1" else f"{own}, as the FMU states no unit"
        sign = -1.0 if NEGATIVE in options else 1.0
        shown = ", ".join([unit] * (unit != "1") + [NEGATIVE] * (sign < 0))
        return Variable(variable.name, variable.valueReference, sign * factor), f" ({shown})" if shown else ""

    def _find_named(self, name: str) -> Iterator[Any]:
        """The variables that have a name: as it is, in Greek, or the only one in other letter case."""
        for each in (name, *(greek for greek, latin in GREEK.items() if latin == name)):
            if each in self.variables:
                yield self.variables[each]
        lower = [each for each in self.variables if each.lower() == name.lower() and each != name]
        if len(lower) == 1:
            yield self.variables[lower[0]]

    def _find_by_name(self, name: str, number: _Number) -> tuple[Any, Variable, str] | None:
        """The first variable of a name with its link, for a number."""
        variable = next(self._find_named(name), None)
        return None if variable is None else (variable, *self._link(variable, number, (), variable.name))

    def _find_state(self, coordinate: _Number) -> None:
        name = coordinate.name
        if name not in self.states:
            entry = self._find_by_name(name, coordinate)
            if entry is None or _is_set(entry[0]):
                raise ValueError(
                    f"{self.archive.path}: no variable for {name} of {self.case.name}; give --columns VARIABLE={name};"
                    f" {self._list_names(name)}"
                )
            self.states[name] = entry[1]
            self.lines.append(f"{entry[0].name} is {name}{entry[2]}")

    def _find_start(self, coordinate: _Number) -> None:
        """The variable that sets a start: as stated, the variable itself, or a parameter whose name says so."""
        name = coordinate.name
        if name in self.starts:
            return
        linked = self.states[name]
        variable = self.variables[linked.name]
        if variable.variability != "constant" and variable.initial in ("exact", "approx"):
            self.starts[name] = linked
            return
        for pattern in STARTS:
            entry = self._find_by_name(pattern.format(name), coordinate)
            if entry is not None and _is_set(entry[0]):
                self.starts[name] = entry[1]
                self.lines.append(f"{entry[0].name} sets the start of {name}{entry[2]}")
                return
        self.starts[name] = None
        reason = "it is compared right after the initialization"
        if variable.start is not None:
            self._require_same(variable, linked, coordinate, "starts at")
            reason = "it is that of the case"
        self.lines.append(f"no variable sets the start of {name}: {reason}")

    def _require_same(self, variable: Any, linked: Variable, number: _Number, what: str) -> None:
        """Raise ValueError if a number that cannot be set differs from the number of the case."""
        value = float(str(variable.start).split()[0]) * linked.factor
        if not math.isclose(value, number.value, rel_tol=SAME, abs_tol=0.0):
            raise ValueError(
                f"{self.archive.path}: {variable.name} cannot be set and {what} {value:.9g} {number.unit}, in the case"
                f" {number}: map a parameter, as --columns VARIABLE={number.name}, or give --set {number.name}={value:.17g}"
            )

    def _require_settable(self, variable: Any, number: _Number) -> None:
        if not _is_set(variable):
            raise ValueError(
                f"--columns {variable.name}={number.name}: {variable.name} is a {variable.causality}, which cannot be set;"
                f" map a parameter or an input, or write {FIXED}={number.name} if the FMU has {number} in it"
            )

    def _find_parameter(self, parameter: _Number) -> None:
        name = parameter.name
        if name in self.given:
            return
        entry = self._find_by_name(name, parameter)
        if entry is None:
            settable = [each for each, variable in self.variables.items() if variable.causality == "parameter"]
            raise ValueError(
                f"{self.archive.path}: no variable for {parameter}; give --columns VARIABLE={name}, or {FIXED}={name} if the"
                f" FMU has this number in it; its parameters: {shorten(', '.join(settable)) or 'none'}"
            )
        variable, linked, unit = entry
        if _is_set(variable):
            self.given[name] = linked
            self.lines.append(f"{variable.name} sets {name}{unit}")
            return
        if variable.start is None:
            self._require_settable(variable, parameter)
        self._require_same(variable, linked, parameter, "is")
        self.given[name] = None
        self.lines.append(f"{variable.name} is {name}{unit}, and cannot be set")

    def _require_all_states(self) -> None:
        """Raise ValueError unless the coordinates are the continuous states of the FMU, one by one."""
        own = [each.variable.derivative for each in self.archive.description.derivatives]
        left = [variable.reference for variable in self.states.values()]
        for name, variable in self.states.items():
            if variable.reference not in [state.valueReference for state in own]:
                raise ValueError(
                    f"{self.archive.path}: {variable.name}, mapped to {name}, is not a state of the FMU; its states are"
                    f" {shorten(', '.join(state.name for state in own)) or 'none'}"
                )
        if sorted(left) != sorted(state.valueReference for state in own):
            raise ValueError(
                f"{self.archive.path}: it has {len(own)} states ({shorten(', '.join(state.name for state in own))}),"
                f" {self.case.name} has {len(left)}; only an FMU with the states of the case can be verified"
            )


def _is_set(variable: Any) -> bool:
    """Whether a variable is a parameter or an input, which is set from outside."""
    return variable.causality in ("parameter", "input") and variable.variability != "constant"
