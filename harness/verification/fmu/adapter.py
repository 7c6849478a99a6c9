"""Integrators made of an FMU: co-simulation by its own steps, model exchange by a method of gnomon's list.

An FMU is a program: it is loaded in worker processes only, where a hang or a crash ends the trial and not gnomon.
`from_fmu` of `gnomon.harness.trajectories.fmu_columns` maps the variables of an FMU to the numbers of a case.
"""

from __future__ import annotations

import contextlib
import ctypes
import math
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np
from gnomon.cases.core.forms import FirstOrder, Hybrid
from gnomon.harness.contract.integrator import (
    Floats,
    Integrator,
    Problem,
    Refused,
    Solution,
    Solver,
    Steps,
    Unsupported,
    each_start,
    solver_of,
)
from gnomon.harness.contract.validation import Unusable, require_positive
from gnomon.harness.kernels.called_equations import Called
from gnomon.harness.registry import declaration
from gnomon.harness.verification.fmu.archive import Archive

MOST_STEPS = 10**8
"""More steps are refused as a mistake."""
LONGEST = 1 + 2.0**-10
"""Longest communication step, in sampling intervals: more than the rounding of times."""
MOST_EVENTS = 100
"""Iterations of the events at the start, after which an FMU is given up."""
DECLARED = (
    "order", "sampling", "dense_order", "sweep", "counts_rhs", "conserves", "jacobian", "compensated", "atol_ratio",
)  # fmt: skip
"""The declarations of a method that hold for model exchange by it."""
SAME = 8 * 2.0**-52
"""Largest relative difference of a start that cannot be set from the start of the case: roundings of its unit."""

_loaded: dict[tuple[str, str], _Loaded] = {}
"""The FMUs of this process by folder and kind."""


@dataclass(frozen=True)
class Variable:
    """A variable of an FMU, and the factor from its value to the number of the case."""

    name: str
    reference: int
    factor: float = 1.0


@dataclass(frozen=True)
class Links:
    """The variables of an FMU for the numbers of a case, in the sequence of its state and of its parameters.

    Attributes
    ----------
    case : str
        The name of the case.
    states : tuple of Variable
        The variable that is read for each coordinate.
    starts : tuple of Variable or None
        The variable that sets the start of each coordinate; None if none does.
    coordinates : mapping of str to float
        The start of the case by coordinate.
    parameters : tuple of Variable or None
        The variable that sets each parameter; None if none does.
    numbers : mapping of str to float
        The parameters of the case by name; a parameter without variable keeps this number.

    Examples
    --------
    >>> angle = Variable("phi", 0, 0.017453292519943295)
    >>> links = Links("decay", (angle,), (angle,), {"theta": 1.0}, (None,), {"rate": 2.0})
    >>> links.states[0].name
    'phi'
    """

    case: str
    states: tuple[Variable, ...]
    starts: tuple[Variable | None, ...]
    coordinates: Mapping[str, float]
    parameters: tuple[Variable | None, ...]
    numbers: Mapping[str, float]

    def find_values(self, problem: Problem) -> dict[int, float]:
        """The values of the FMU's parameters for a problem, by reference.

        Raises Unsupported for a problem with other equations, or with other numbers where they cannot be set.
        """
        if problem.names is None or problem.names.case != self.case:
            raise Unsupported(f"an FMU has the equations of {self.case} in it, and takes no others")
        values = problem.parameters.tolist()
        for name, own, value, variable in zip(
            self.numbers, self.numbers.values(), values, self.parameters, strict=True
        ):
            if variable is None and value != own:
                raise Unsupported(f"no variable sets {name}, which is {own:g} in the FMU")
        pairs = zip(self.parameters, values, strict=True)
        return {variable.reference: value / variable.factor for variable, value in pairs if variable is not None}


class _Loaded:
    """An FMU that is loaded in this process, with one instance at a time."""

    def __init__(self, archive: Archive) -> None:
        from fmpy.fmi2 import FMU2Model, FMU2Slave  # of the extra `fmu`, like the imports below
        from fmpy.fmi3 import FMU3Model, FMU3Slave

        kinds = {
            (2, "CoSimulation"): FMU2Slave,
            (2, "ModelExchange"): FMU2Model,
            (3, "CoSimulation"): FMU3Slave,
            (3, "ModelExchange"): FMU3Model,
        }
        self.archive, self.messages = archive, deque[str](maxlen=2)
        self.owner: object = None
        """Whoever began the present instance: another one begins a new instance."""
        try:
            self.fmu = kinds[archive.version, archive.kind](
                guid=archive.description.guid,
                modelIdentifier=archive.interface.modelIdentifier,
                unzipDirectory=archive.folder,
                instanceName="gnomon",
            )
        except Exception as error:  # a library that cannot be loaded, or that lacks a function
            raise Unusable(f"the FMU cannot be loaded: {' '.join(str(error).split())}") from None
        self.instances = 0
        self.get: Callable[[list[int]], list[float]]
        self.get = self.fmu.getReal if archive.version == 2 else self.fmu.getFloat64

    def begin(self, owner: object, values: Mapping[int, float], t0: float) -> None:
        """Make a new instance, set variables by reference, and initialize it at t0. Passes on the errors of fmpy.

        A reset does not suffice, because fmi2Reset keeps other things in each tool. Only an FMU that allows one instance in a
        process is reset.
        """
        fmu, is_2 = self.fmu, self.archive.version == 2
        self.owner = None
        self.messages.clear()
        if self.instances and self.archive.interface.canBeInstantiatedOnlyOncePerProcess:
            fmu.reset()
        else:
            if self.instances:
                (fmu.fmi2FreeInstance if is_2 else fmu.fmi3FreeInstance)(fmu.component)
                self.instances = 0
            fmu.instantiate(**({"callbacks": self._callbacks()} if is_2 else {"logMessage": self._log}))
            self.instances = 1
        if is_2:
            fmu.setupExperiment(startTime=t0)
        (fmu.setReal if is_2 else fmu.setFloat64)(list(values), list(values.values()))
        fmu.enterInitializationMode(**({} if is_2 else {"startTime": t0}))
        fmu.exitInitializationMode()
        if self.archive.kind == "ModelExchange":
            settle = fmu.newDiscreteStates if is_2 else fmu.updateDiscreteStates
            for _ in range(MOST_EVENTS):
                if not settle()[0]:
                    break
            else:
                raise Unusable(f"the FMU does not settle in {MOST_EVENTS} iterations of events at the start")
            fmu.enterContinuousTimeMode()
        self.owner = owner

    def _callbacks(self) -> Any:
        from fmpy import calloc, fmi2, free

        callbacks = fmi2.fmi2CallbackFunctions()
        callbacks.logger = fmi2.fmi2CallbackLoggerTYPE(self._log)
        callbacks.allocateMemory = fmi2.fmi2CallbackAllocateMemoryTYPE(calloc)
        callbacks.freeMemory = fmi2.fmi2CallbackFreeMemoryTYPE(free)
        with contextlib.suppress(ImportError, OSError):  # only it fills in the numbers of a message
            from fmpy.logging import addLoggerProxy

            addLoggerProxy(ctypes.byref(callbacks))
        return callbacks

    def _log(self, *arguments: Any) -> None:
        """Keep a message of the FMU: the last argument of FMI 2.0 and 3.0 alike."""
        self.messages.append(arguments[-1].decode(errors="replace") if isinstance(arguments[-1], bytes) else "")

    def explain(self, error: BaseException) -> str:
        """The text of an error, with the last messages of the FMU."""
        return "; ".join([" ".join(str(error).split()), *self.messages])


def _load(archive: Archive) -> _Loaded:
    key = (archive.folder, archive.kind)
    if key not in _loaded:
        _loaded[key] = _Loaded(archive)
    return _loaded[key]


class FmuIntegrator(Integrator):
    """An FMU as an integrator of one case; see `CoSimulation` and `ModelExchange`."""

    library = "fmu"
    accepts: ClassVar[tuple[type, ...]] = (FirstOrder,)

    def __init__(self, name: str, archive: Archive, links: Links) -> None:
        self.archive, self.links = archive, links
        self.__dict__.update(name=name)

    def versions(self) -> Mapping[str, Any]:
        """A hash of the FMU, and the version of fmpy."""
        import fmpy

        return {"fmu": self.archive.digest, "fmpy": fmpy.__version__}


class CoSimulation(FmuIntegrator):
    """An FMU for co-simulation: the setting is the communication step."""

    accepts = (FirstOrder, Hybrid)
    sampling, counts_rhs, sweep = "grid", False, Steps(coarsest=0.5, halvings=9)

    def __init__(self, name: str, archive: Archive, links: Links, order: int | None = None) -> None:
        super().__init__(name, archive, links)
        self.__dict__.update(order=order)
        declaration.validate(self, f"--fmu {archive.path}")

    def prepare(self, problem: Problem, setting: float) -> Solver:
        require_positive(setting, "communication step")
        if float(problem.elapsed[-1]) / setting > MOST_STEPS or setting > LONGEST * problem.interval:
            raise Refused(
                f"communication step {setting:g} is longer than the sampling interval, {problem.interval:g},"
                f" or makes more than {MOST_STEPS:g} steps"
            )
        links, values, loaded = self.links, self.links.find_values(problem), _load(self.archive)
        ends, step = problem.times.tolist(), loaded.fmu.doStep
        references, factors = (
            [each.reference for each in links.states],
            np.array([each.factor for each in links.states]),
        )

        def follow(start: Floats, rows: Floats) -> tuple[int, str | None]:
            self._begin(loaded, values, start, problem.t0)
            time, steps = problem.t0, 0
            try:
                for row, end in zip(rows, ends, strict=True):
                    count = max(1, round((end - time) / setting))
                    h = (end - time) / count
                    for k in range(count):
                        status = step(time + k * h, h)
                        if status is not None and status[1]:  # of FMI 3.0
                            return steps + k, f"the FMU ends the simulation at t = {time + k * h:g}"
                    time, steps = end, steps + count
                    row[:] = factors * loaded.get(references)
            except Exception as error:  # fmpy's error for the status of a call
                return steps, f"after t = {time:g} {loaded.explain(error)}"
            return steps, None

        return Solver(each_start(problem, follow))

    def _begin(self, loaded: _Loaded, parameters: Mapping[int, float], start: Floats, t0: float) -> None:
        """Begin an instance at a start. Raises Unusable if the FMU declines it, or has another start that it keeps."""
        links, values = self.links, dict(parameters)
        numbers = start.tolist()
        for variable, number in zip(links.starts, numbers, strict=True):
            if variable is not None:
                values[variable.reference] = number / variable.factor
        try:
            loaded.begin(self, values, t0)
            readings = loaded.get([each.reference for each in links.states])
        except Unusable:
            raise
        except Exception as error:
            if not np.all(np.isfinite(start)):
                raise Refused(f"a start that is not finite: {loaded.explain(error)}") from None
            raise Unusable(f"the FMU cannot be initialized: {loaded.explain(error)}") from None
        rows = zip(links.coordinates.items(), links.states, numbers, readings, links.starts, strict=True)
        for (name, usual), own, initial, read, sets in rows:
            if sets is None and not math.isclose(own.factor * read, initial, rel_tol=SAME, abs_tol=0.0):
                what = (
                    f"no variable sets the start of {name}: {own.name} starts at {own.factor * read:.17g}, not at"
                    f" {initial:.17g}; map a parameter, as --columns VARIABLE={name}"
                )
                raise Unusable(what) if initial == usual else Unsupported(what)


class ModelExchange(FmuIntegrator):
    """The equations of an FMU for model exchange, integrated by a method of gnomon's list."""

    def __init__(self, name: str, archive: Archive, links: Links, method: Integrator) -> None:
        super().__init__(name, archive, links)
        self.method = method
        self.__dict__.update({each: getattr(method, each) for each in DECLARED}, policy=method.id)
        if FirstOrder not in method.accepts:
            names = " or ".join(kind.__name__ for kind in method.accepts)
            raise ValueError(
                f"--integrator {method.id}: it takes {names}; an FMU gives equations of first order, as gnomon:RK4 takes"
            )
        declaration.validate(self, f"--fmu {archive.path}")

    def prepare(self, problem: Problem, setting: float) -> Solver:
        loaded, values = _load(self.archive), self.links.find_values(problem)
        called = Called(_Derivatives(loaded, self.archive, self.links, values).at, problem.dimension)
        own = replace(problem, form=FirstOrder(called))
        vars(own)["buffer"] = problem.buffer  # right-hand sides are counted in it
        try:
            solver = solver_of(self.method, own, setting)
        except (ValueError, Refused) as error:
            if repr(called) not in str(error):  # which the compiler of equations names, as it cannot read it
                raise
            raise Refused(
                f"{self.method.id} needs the formulas of equations, which an FMU does not show; name another method, as"
                " --integrator gnomon:RK4"
            ) from None

        def solve(starts: Floats) -> Solution:
            called.failure = None
            solution = solver.solve(starts)
            if called.failure is None:
                return solution
            error, t, _ = called.failure
            return replace(solution, stopped=f"at t = {t:g} {loaded.explain(error)}")

        return replace(solver, solve=solve)


class _Derivatives:
    """The right-hand sides of an FMU with these parameters, by the coordinates of a case."""

    def __init__(self, loaded: _Loaded, archive: Archive, links: Links, values: Mapping[int, float]) -> None:
        self.loaded, self.values = loaded, values
        states = [each.variable.derivative.valueReference for each in archive.description.derivatives]
        self.places = [states.index(each.reference) for each in links.states]
        self.factors = np.array([each.factor for each in links.states])
        self.state, self.rates = np.zeros(len(states)), np.zeros(len(states))
        pointer = ctypes.POINTER(ctypes.c_double)
        self.pointers = [each.ctypes.data_as(pointer) for each in (self.state, self.rates)]
        fmu = loaded.fmu
        self.derivatives = fmu.getDerivatives if archive.version == 2 else fmu.getContinuousStateDerivatives

    def at(self, t: float, y: Floats) -> Floats:
        if self.loaded.owner is not self:
            self.loaded.begin(self, self.values, t)
        state, rates = self.pointers
        self.state[self.places] = y / self.factors
        self.loaded.fmu.setTime(t)
        self.loaded.fmu.setContinuousStates(state, len(self.state))
        self.derivatives(rates, len(self.state))
        derivatives: Floats = self.rates[self.places] * self.factors
        return derivatives
