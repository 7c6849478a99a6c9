"""SUNDIALS by its C interface: CVODE's Adams methods of orders 1 to 12 and BDF of orders 1 to 5, and IDA's BDF.

The libraries come from the wheel of scikit-sundae. `sksundae` drives them through that binding, from Python.

How it is driven, and why:

- Right-hand side and Jacobian are compiled. The functions with the signatures of C that call them, and the loop over
  samples, are compiled once for all problems: Python is entered once a solve.
- Adams iterates by the fixed point, BDF and IDA by Newton's method with a dense matrix, as the manual of SUNDIALS
  recommends for problems that are not stiff and for stiff ones. If equations cannot be traced, SUNDIALS computes the
  Jacobian by differences.
- Samples are taken in the mode `CV_NORMAL`: a step may go past a sample, where the polynomial of the step gives the
  state with the order of the step. No step goes past the last sample, which is the stop time.
- The setting is `rtol`; `atol` = .1 `rtol`, the ratio of the binding's defaults, in SI units; SUNDIALS has no defaults.
- IDA solves F(t, y, y') = 0, here y' - f(t, y) with the Jacobian c - df/dy and the slope at the start.
- A derivative that is not finite is returned as an error from which SUNDIALS recovers by a shorter step.
- `max_num_steps` is the limit of steps between two samples; its default of 500 ends long intervals early, so it is
  raised.

Compiled functions read addresses in `N_Vector` and `SUNMatrix` as the macros of SUNDIALS do, NV_DATA_S and SM_DATA_D.
Before the first call both places are compared with the library's answers, and only the VERSIONS that were tried are
driven.

Traps: towards a singularity SUNDIALS takes ever smaller steps. A motion ends if CHUNK steps advance by less than CHUNK
times the spacing of floating-point times, or at the limit of steps.
"""

import ctypes
import os
import weakref
from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from functools import cache
from importlib.metadata import files
from importlib.util import find_spec
from typing import Any, ClassVar, NamedTuple

import numpy as np
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.adapters.installed import Installed
from gnomon.harness.adapters.scipy_ivp import STEP_SIZES, step_sizes
from gnomon.harness.adapters.scipy_ode import STEPS
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Solver, Tolerance, each_start
from gnomon.harness.contract.validation import require_positive
from gnomon.harness.kernels import machine
from gnomon.harness.kernels.c_structures import c_functions, floats_at, result_at, run_at, word_at
from gnomon.harness.kernels.equations import right_hand_side
from gnomon.harness.kernels.straight_line import derivatives_if_traced

CHUNK, EPSILON = 10_000, 2.0**-52
"""CHUNK: the number of steps after which their advance is compared with EPSILON, the relative spacing of times."""
VERSIONS = ("7.5.0", "7.9.0")
"""The versions of SUNDIALS whose C interface was tried."""
CHUNKS = STEPS // CHUNK
DATA = 1
"""The word with the address of the numbers, in the content of a vector and of a matrix, for indices of 32 bits."""

SIGNATURES = {
    "SUNDIALSGetVersion": "i pi", "SUNContext_Create": "i lp", "SUNContext_ClearErrHandlers": "i p",
    "SUNContext_Free": "i p", "N_VMake_Serial": "p lpp", "N_VGetArrayPointer": "p p", "N_VDestroy": "v p",
    "SUNDenseMatrix": "p llp", "SUNDenseMatrix_Data": "p p", "SUNMatDestroy": "v p", "SUNLinSol_Dense": "p ppp",
    "SUNLinSolFree": "i p", "SUNNonlinSol_FixedPoint": "p pip", "SUNNonlinSolFree": "i p",
    "IDASetId": "i pp", "IDASetSuppressAlg": "i pi", "IDASVtolerances": "i pdp", "CVodeCreate": "p ip", "IDACreate": "p p", "CVodeInit": "i ppdp", "IDAInit": "i ppdpp", "CVodeReInit": "i pdp",
    "IDAReInit": "i pdpp", "CVode": "i pdppi", "IDASolve": "i pdpppi", "CVodeSetNonlinearSolver": "i pp",
} | {
    f"{solver}{name}": signature for solver in ("CVode", "IDA", "ERKStep", "ARKStep") for name, signature in {
        "Free": "v p", "SStolerances": "i pdd", "SetUserData": "i pp", "SetMaxNumSteps": "i pl",
        "SetLinearSolver": "i ppp", "SetJacFn": "i pp", "GetNumSteps": "i pp", "SetStopTime": "i pd",
        "SetMaxStep": "i pd", "SetInitStep": "i pd", "GetReturnFlagName": "p l",
    }.items()
}  # fmt: skip
"""The types of the C functions that are called: of the result, then of the arguments."""
TOO_MUCH_WORK = -1
"""The return code of a solver after CHUNK steps that did not reach a sample."""
NORMAL = 1
"""The mode of calls that step up to a time or past it and return the state at this time."""
TYPES = {"i": ctypes.c_int, "l": ctypes.c_long, "d": ctypes.c_double, "p": ctypes.c_void_p, "v": None}

EQUATIONS, JACOBIAN, PARAMETERS, DIMENSION = range(4)
"""The words of the user data of C functions: the addresses of the compiled equations, of their Jacobian and of the
parameters, and the number of components."""
ARGUMENTS = 3
"""The number of arguments, after the time, of the function that takes steps."""


def slope(t: Any, y: Any, out: Any, user: Any) -> int:
    """The right-hand side of CVODE. Like all these functions it returns 1 if a number is not finite."""
    evaluate(EQUATIONS, t, y, out, user)
    return bad(numbers(out, word_at(user, DIMENSION)))


def residual(t: Any, y: Any, slope: Any, out: Any, user: Any) -> int:
    """The equations of IDA, y' - f."""
    evaluate(EQUATIONS, t, y, out, user)
    left, slopes = numbers(out, word_at(user, DIMENSION)), numbers(slope, word_at(user, DIMENSION))
    for i in range(left.size):
        left[i] = slopes[i] - left[i]
    return bad(left)


def partial(t: Any, y: Any, slope: Any, matrix: Any, user: Any, free1: Any, free2: Any, free3: Any) -> int:
    """The Jacobian of CVODE, df/dy."""
    return bad(by_columns(t, y, matrix, user))


def implicit_partial(
    t: Any, c: Any, y: Any, slope: Any, left: Any, matrix: Any, user: Any, free1: Any, free2: Any, free3: Any
) -> int:
    """The Jacobian of IDA, c - df/dy."""
    out, n = by_columns(t, y, matrix, user), word_at(user, DIMENSION)
    for i in range(n * n):
        out[i] = -out[i]
    for i in range(n):
        out[n * i + i] += c
    return bad(out)


def by_columns(t: Any, y: Any, matrix: Any, user: Any) -> Any:
    """The Jacobian df/dy, transposed, as SUNDIALS stores a matrix by columns."""
    evaluate(JACOBIAN, t, y, matrix, user)
    n = word_at(user, DIMENSION)
    out = numbers(matrix, n * n)
    for i in range(n):
        for j in range(i):
            above, below = out[n * i + j], out[n * j + i]
            out[n * i + j] = below
            out[n * j + i] = above
    return out


def evaluate(which: int, t: Any, y: Any, out: Any, user: Any) -> None:
    """Call the compiled equations or their Jacobian at the numbers of y, and write the numbers of `out`."""
    run_at(word_at(user, which), t, data_of(y), word_at(user, PARAMETERS), data_of(out))


def data_of(structure: Any) -> Any:
    """The address of the numbers of a vector or of a matrix."""
    return word_at(word_at(structure, 0), DATA)


def numbers(structure: Any, count: Any) -> Any:
    return floats_at(data_of(structure), count)


def bad(out: Any) -> int:
    """1 if a number is not finite, else 0."""
    for i in range(out.size):
        if not np.isfinite(out[i]):
            return 1
    return 0


def follow(
    function: int, stop: int, memory: int, rest: Any, reached: Floats, times: Floats, state: Floats, samples: Floats
) -> int:
    """Call the C `function` for each of `times` (n,), and copy `state` into `samples` (n, dim): 0, or its code if it fails.

    `function`, `stop`: addresses of the functions that take steps and that set a stop time; `stop` is 0 unless steps end at
    samples. `memory`: the address of the solver's memory. `rest`: the other arguments of `function`, after the time.
    `reached` (1,): the time at which the last call ended.
    """
    for k in range(times.size):
        if stop != 0:
            result_at(stop, memory, times[k])
        for _ in range(CHUNKS):
            before = reached[0]
            code = result_at(function, memory, times[k], *tuple(rest[i] for i in range(ARGUMENTS)))
            if code != TOO_MUCH_WORK or reached[0] - before <= CHUNK * EPSILON * abs(reached[0]):
                break
        if code < 0:
            return int(code)
        for i in range(samples.shape[1]):
            samples[k, i] = state[i]
    return 0


def compile_functions(data: int) -> dict[str, int]:
    """The addresses of the functions that SUNDIALS calls, compiled once for all problems and each place of numbers."""
    functions = (
        (slope, "float int int int"), (residual, "float int int int int"), (partial, "float int int int int int int int"),
        (implicit_partial, "float float int int int int int int int int"),
    )  # fmt: skip
    return c_functions(functions, (("DATA", data),))


class Parts(NamedTuple):
    """A library of SUNDIALS: its functions, its version, and the word with the address of a vector's numbers."""

    functions: Mapping[str, Any]
    version: str
    data: int


Motion = tuple[Callable[[], None], tuple[int, ...]]
"""(restart, rest): a function that begins a solution from `Session.state`, and the argument `rest` of `follow`."""


class Sundials(Installed):
    """A solver of SUNDIALS. Hindmarsh et al., ACM Trans. Math. Softw. 31 (2005) 363."""

    library = "sksundae"
    accepts: ClassVar[tuple[type[FirstOrder], ...]] = (FirstOrder,)
    sampling = "dense output"
    sweep = Tolerance(1e-3, 1e-13)
    takes: ClassVar[tuple[str, ...]] = (*STEP_SIZES, "jac")
    atol_ratio: float = 0.1


class Native(Sundials):
    """A solver driven by its C interface.

    The names of its functions begin with `solver`; `advance` is the function that takes steps.
    """

    policy = "native"
    solver: ClassVar[str]
    advance: ClassVar[str]

    def versions(self) -> Mapping[str, str]:
        return {**super().versions(), "SUNDIALS": interface(self.solver)[1]}

    def library_parts(self) -> "Parts":
        """The library that has the solver."""
        if find_spec("sksundae") is None:
            raise ImportError("sksundae is not installed")
        return Parts(*interface(self.solver), DATA)

    def size(self, problem: Problem) -> int:
        """The number of variables, which begin with the state."""
        return problem.dimension

    def tolerate(self, session: "Session", problem: Problem, rtol: float, atol: float) -> None:
        """Set the tolerances."""
        session.set("SStolerances", rtol, atol)

    @abstractmethod
    def connect(self, session: "Session", problem: Problem) -> tuple[dict[str, Any], Motion]:
        """Create the solver's memory and give it the equations: (options that differ from its defaults, motion)."""

    def prepare(self, problem: Problem, setting: float) -> Solver:
        parts = self.library_parts()
        require_positive(setting, "tolerance")
        session = Session(self.solver, self.size(problem), parts)
        options, (restart, rest) = self.connect(session, problem)
        options |= {"rtol": setting, "atol": self.atol_ratio * setting, "max_num_steps": CHUNKS * CHUNK}
        self.tolerate(session, problem, setting, self.atol_ratio * setting)
        session.user[PARAMETERS] = problem.buffer.ctypes.data
        session.set("SetUserData", session.user.ctypes.data)
        session.set("SetMaxNumSteps", CHUNK)
        sizes = step_sizes(self)
        for name, function in (("max_step", "SetMaxStep"), ("first_step", "SetInitStep")):
            if name in sizes:
                session.set(function, sizes[name])
        options |= sizes
        stop = address_of(session.c[f"{self.solver}SetStopTime"]) if self.sampling == "stops at samples" else 0
        advance = address_of(session.c[self.advance]), stop, session.memory.value, np.array(rest)
        signature = "int int int int[1] float[1] float[1] float[1] float[2]"
        run = machine.function(follow, signature, replaced={"ARGUMENTS": len(rest)})
        state, reached, times = session.state, session.reached, np.ascontiguousarray(problem.times)
        advanced = np.ndarray(1, np.float64, memoryview(reached))  # the same number as an array

        def solve_one(
            start: Floats,
            samples: Floats,
            alive: object = problem.buffer,  # C holds its address
        ) -> tuple[int, str | None]:
            if not session.close.alive:
                raise RuntimeError("called after close; prepare again")
            state[: problem.dimension], reached.value = start, problem.t0
            restart()
            session.set("SetStopTime", times[-1])
            code = run(*advance, advanced, times, state, samples)
            return session.steps(), f"{session.name_code(code)} at t = {reached.value:g}" if code < 0 else None

        return Solver(each_start(problem, solve_one), options, close=session.close)


class Adams(Native):
    """CVODE's Adams-Moulton methods of variable order and step, iterated by the fixed point."""

    name: ClassVar[str] = "CVODE Adams"
    solver = advance = "CVode"
    method: ClassVar[int] = 1
    takes: ClassVar[tuple[str, ...]] = STEP_SIZES

    def connect(self, session: "Session", problem: Problem) -> tuple[dict[str, Any], Motion]:
        fixed_point = session.create("SUNNonlinSol_FixedPoint", session.y, 0, free="SUNNonlinSolFree")
        motion = self.create_solver(session, problem)
        session.set("SetNonlinearSolver", fixed_point)
        return {"nonlinear_solver": "fixed point"}, motion

    def create_solver(self, session: "Session", problem: Problem) -> Motion:
        """Create CVODE's memory for `method`, and give it the compiled equations and the start."""
        session.create_memory(self.method)
        session.user[EQUATIONS] = right_hand_side(problem).address
        session.set("Init", session.functions["slope"], problem.t0, session.y)

        def restart() -> None:
            session.set("ReInit", problem.t0, session.y)

        return restart, (session.y, ctypes.addressof(session.reached), NORMAL)  # CVode(memory, time, *these)


class Bdf(Adams):
    """CVODE's backward differentiation formulas of variable order and step, iterated by Newton's method."""

    name, method = "CVODE BDF", 2
    takes = (*STEP_SIZES, "jac")

    def connect(self, session: "Session", problem: Problem) -> tuple[dict[str, Any], Motion]:
        dense = session.create_dense()
        motion = self.create_solver(session, problem)
        return {"jac": session.use_newton(dense, problem, "partial")}, motion


class Ida(Native):
    """IDA's backward differentiation formulas of variable order and step, for implicit equations."""

    name, solver, advance = "IDA", "IDA", "IDASolve"

    def connect(self, session: "Session", problem: Problem) -> tuple[dict[str, Any], Motion]:
        dense, slope = session.create_dense(), np.zeros(problem.dimension)
        slopes = session.create_vector(slope)
        session.create_memory()
        kernel, buffer, t0, y = right_hand_side(problem), problem.buffer, problem.t0, session.y
        session.user[EQUATIONS] = kernel.address
        session.set("Init", session.functions["residual"], t0, y, slopes)
        options = {"jac": session.use_newton(dense, problem, "implicit_partial")}

        def restart() -> None:
            kernel.pointer(t0, session.state, buffer, slope)
            session.set("ReInit", t0, y, slopes)

        return options, (
            restart,
            (ctypes.addressof(session.reached), y, slopes, NORMAL),
        )  # IDASolve(memory, time, *these)


class Session:
    """The objects of SUNDIALS for one problem. `close` frees them, at the latest when the session is garbage-collected.

    `c`: the C functions of the library. `functions`: the addresses of the compiled functions that SUNDIALS calls.
    `memory`: the solver's memory. `y`: the vector of the state, whose numbers are the array `state` (dimension,). `user`: the
    user data (EQUATIONS, JACOBIAN, PARAMETERS, DIMENSION). `reached`: the time at which the last call ended.
    """

    def __init__(self, solver: str, dimension: int, parts: "Parts") -> None:
        self.solver, self.dimension, self.c, self.data = solver, dimension, parts.functions, parts.data
        self.functions = compile_functions(self.data)
        self._to_free = ExitStack()  # frees the last object first
        self.close = weakref.finalize(self, self._to_free.close)
        self.context, self.memory, self.reached = ctypes.c_void_p(), ctypes.c_void_p(), ctypes.c_double()
        verify("SUNContext_Create", self.c["SUNContext_Create"](0, ctypes.byref(self.context)))
        self._to_free.callback(self.c["SUNContext_Free"], ctypes.byref(self.context))
        if "SUNContext_ClearErrHandlers" in self.c:
            verify("SUNContext_ClearErrHandlers", self.c["SUNContext_ClearErrHandlers"](self.context))
        self.state, self.user = np.zeros(dimension), np.array([0, 0, 0, dimension])
        self.y = self.create_vector(self.state)

    def create(self, name: str, *arguments: Any, free: str) -> int:
        """Create an object by the C constructor `name`: its address. The C function `free` frees it.

        Raises MemoryError if the constructor does not return an object.
        """
        address: int | None = self.c[name](*arguments, self.context)
        if not address:
            raise MemoryError(f"SUNDIALS: {name} returned no object")
        self._to_free.callback(self.c[free], address)
        return address

    def create_vector(self, values: Floats) -> int:
        """A vector whose numbers are the array `values` itself."""
        vector = self.create("N_VMake_Serial", self.dimension, values.ctypes.data, free="N_VDestroy")
        self._to_free.callback(lambda _: None, values)  # keeps the array alive, as C holds its address
        self.verify_place(vector, self.c["N_VGetArrayPointer"](vector))
        return vector

    def create_dense(self) -> tuple[int, int]:
        """A dense linear solver, and its matrix."""
        matrix = self.create("SUNDenseMatrix", self.dimension, self.dimension, free="SUNMatDestroy")
        self.verify_place(matrix, self.c["SUNDenseMatrix_Data"](matrix))
        return self.create("SUNLinSol_Dense", self.y, matrix, free="SUNLinSolFree"), matrix

    def verify_place(self, structure: int, data: int) -> None:
        """Raise RuntimeError if compiled functions would read the numbers of a vector or a matrix at a wrong place."""
        words = ctypes.POINTER(ctypes.c_void_p)
        content = ctypes.cast(structure, words)[0]
        if ctypes.cast(content, words)[self.data] != data:
            raise RuntimeError("this build of SUNDIALS has another layout of vectors and matrices; use its binding")

    def create_memory(self, *arguments: Any) -> None:
        """Create the solver's memory, which is freed before the objects that were created earlier."""
        self.memory.value = self.c[f"{self.solver}Create"](*arguments, self.context)
        if not self.memory.value:
            raise MemoryError(f"SUNDIALS: {self.solver}Create returned no object")
        self._to_free.callback(self.c[f"{self.solver}Free"], ctypes.byref(self.memory))

    def use_newton(self, dense: tuple[int, int], problem: Problem, function: str) -> str | None:
        """Iterate by Newton's method; returns "compiled" for a compiled Jacobian, None if it cannot be compiled."""
        self.set("SetLinearSolver", *dense)
        assert isinstance(problem.form, FirstOrder)
        kernel = derivatives_if_traced(problem.form, problem.dimension, len(problem.parameters))
        if kernel is None:
            return None
        self.user[JACOBIAN] = kernel.address
        self.set("SetJacFn", self.functions[function])
        return "compiled"

    def set(self, name: str, *arguments: Any) -> None:
        """Call a function of the solver. Raises RuntimeError if it does not return 0."""
        verify(f"{self.solver}{name}", self.c[f"{self.solver}{name}"](self.memory, *arguments))

    def steps(self) -> int:
        """The number of steps since the start."""
        steps = ctypes.c_long()
        self.set("GetNumSteps", ctypes.byref(steps))
        return steps.value

    def name_code(self, code: int) -> str:
        """The solver's name of a return code."""
        return name_of(address_of(self.c[f"{self.solver}GetReturnFlagName"]), code)


def verify(name: str, code: int) -> None:
    """Raise RuntimeError unless the return code of a C function is 0."""
    if code:
        raise RuntimeError(f"SUNDIALS: {name} returned {code}")


def silence() -> None:
    """Switch off the log of SUNDIALS, which repeats return codes on standard error; call this before it is loaded."""
    for level in ("ERROR", "WARNING"):
        os.environ.setdefault(f"SUNLOGGER_{level}_FILENAME", os.devnull)


@cache
def interface(solver: str) -> tuple[dict[str, Any], str]:
    """The functions of a solver's library, and the version of SUNDIALS. Raises ImportError if it cannot be driven."""
    silence()
    part = {"CVode": "cvode", "IDA": "ida"}[solver]
    wheel = files("scikit-sundae") or ()
    libraries = [file for name in ("core", part) for file in wheel if f"sundials_{name}" in file.name]
    if len(libraries) != 2:
        raise ImportError("this scikit-sundae comes without libraries of SUNDIALS; its wheels have them")
    functions, version = load_functions([ctypes.CDLL(str(file.locate())) for file in libraries], SIGNATURES)
    if version not in VERSIONS:
        raise ImportError(
            f"SUNDIALS {version}: its C interface was tried with {', '.join(VERSIONS)} only; the binding runs"
        )
    return functions, version


def load_functions(libraries: Sequence[ctypes.CDLL], signatures: Mapping[str, str]) -> tuple[dict[str, Any], str]:
    """The functions of shared libraries that have these names, with their types, and the version of SUNDIALS."""
    functions = {}
    for name, signature in signatures.items():
        function = next((getattr(library, name) for library in libraries if hasattr(library, name)), None)
        if function is None:
            continue
        result, _, arguments = signature.partition(" ")
        function.restype, function.argtypes = TYPES[result], [TYPES[kind] for kind in arguments]
        functions[name] = function
    text = ctypes.create_string_buffer(64)
    verify("SUNDIALSGetVersion", functions["SUNDIALSGetVersion"](text, len(text)))
    return functions, text.value.decode()


@cache
def name_of(function: int, code: int) -> str:
    """The name of a return code by the function at an address, kept because SUNDIALS allocates it at each call."""
    return ctypes.string_at(ctypes.CFUNCTYPE(ctypes.c_void_p, ctypes.c_long)(function)(code)).decode()


def address_of(function: Any) -> int:
    return ctypes.cast(function, ctypes.c_void_p).value or 0


INTEGRATORS: tuple[type[Integrator], ...] = (Adams, Bdf, Ida)
