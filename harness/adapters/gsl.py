"""The GNU Scientific Library by its C interface: the steppers of `gsl_odeiv2`.

The library comes from the system, as pip has none (Debian: libgsl-dev).

How it is driven, and why:

- Right-hand side and Jacobian are compiled. The functions with the signatures of C that call them, and the loop over
  samples, are compiled once for all problems: Python is entered once a solve.
- As the manual's example drives it: `gsl_odeiv2_driver_alloc_y_new`, and `gsl_odeiv2_driver_apply` from sample to sample.
  The library has no interpolant, so the driver shortens a step to end at a sample.
- The setting is the relative error, and the absolute error is equal to it, as in the manual's example with fixed steps
  (1e-8 and 1e-8), in SI units. With a relative error of 0, as in its first example, a tolerance below the rounding error
  of a large coordinate (a planet's in metres) could not be met.
- The first step is 1e-6 time scales of the case: the manual's 1e-6, in equations with a time scale of 1.
- `bsimp` and `msbdf` need the Jacobian, and df/dt. Equations that cannot be traced are refused.
- A derivative that is not finite is returned as an error, after which "the step is retried with a decreased step-size".

Traps: GSL's error handler ends the process, so it is switched off, for all that use the library in this process.
"""

import ctypes
import weakref
from collections.abc import Mapping
from ctypes import util
from functools import cache
from typing import Any, ClassVar

import numpy as np
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.adapters.installed import Installed, not_installed
from gnomon.harness.adapters.scipy_ivp import STEP_SIZES, step_sizes
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Refused, Solver, Tolerance, each_start
from gnomon.harness.contract.validation import require_positive
from gnomon.harness.kernels import machine
from gnomon.harness.kernels.c_structures import c_functions, floats_at, result_at, run_at, word_at
from gnomon.harness.kernels.equations import right_hand_side
from gnomon.harness.kernels.straight_line import derivatives_if_traced

EQUATIONS, JACOBIAN, PARAMETERS, DIMENSION, WORK = range(5)
"""The words of the `params` of C functions: the addresses of the compiled equations, of their derivatives and of the
parameters, the number of components, and the address of the derivatives' numbers."""
NOT_FINITE = 1000
"""What functions return for a number that is not finite: "values distinct from standard GSL error codes"."""
FIRST_STEP = 1e-6
"""In time scales of the case."""


def slopes(t: Any, y: Any, out: Any, user: Any) -> int:
    """The right-hand side, as GSL calls it."""
    run_at(word_at(user, EQUATIONS), t, y, word_at(user, PARAMETERS), out)
    return bad(floats_at(out, word_at(user, DIMENSION)))


def partial(t: Any, y: Any, matrix: Any, by_time: Any, user: Any) -> int:
    """df/dy by rows, and df/dt, which the compiled derivatives have as a last column."""
    n, work = word_at(user, DIMENSION), word_at(user, WORK)
    run_at(word_at(user, JACOBIAN), t, y, word_at(user, PARAMETERS), work)
    derivatives, out, last = floats_at(work, n * (n + 1)), floats_at(matrix, n * n), floats_at(by_time, n)
    for i in range(n):
        for j in range(n):
            out[n * i + j] = derivatives[(n + 1) * i + j]
        last[i] = derivatives[(n + 1) * i + n]
    return bad(derivatives)


def bad(out: Any) -> int:
    """NOT_FINITE if a number is not finite, else 0."""
    for i in range(out.size):
        if not np.isfinite(out[i]):
            return NOT_FINITE
    return 0


def follow(apply: int, driver: int, at: int, y: int, times: Floats, state: Floats, samples: Floats) -> int:
    """The loop over samples: the driver is applied up to each time, and the state copied."""
    for k in range(times.size):
        code = result_at(apply, driver, at, times[k], y)
        if code != 0:
            return int(code)
        for i in range(samples.shape[1]):
            samples[k, i] = state[i]
    return 0


def compile_functions() -> dict[str, int]:
    """The addresses of the functions that GSL calls, compiled once for all problems."""
    functions = (slopes, "float int int int"), (partial, "float int int int int")
    return c_functions(functions, (("NOT_FINITE", NOT_FINITE),))


class System(ctypes.Structure):
    """A `gsl_odeiv2_system`."""

    _fields_ = (
        ("function", ctypes.c_void_p), ("jacobian", ctypes.c_void_p), ("dimension", ctypes.c_size_t), ("params", ctypes.c_void_p),
    )  # fmt: skip


class Evolve(ctypes.Structure):
    """The public fields of a `gsl_odeiv2_evolve`, up to the number of steps."""

    _fields_ = (
        ("dimension", ctypes.c_size_t), *((name, ctypes.c_void_p) for name in ("y0", "yerr", "dydt_in", "dydt_out")),
        ("last_step", ctypes.c_double), ("count", ctypes.c_ulong),
    )  # fmt: skip


class Driver(ctypes.Structure):
    """The public fields of a `gsl_odeiv2_driver`, up to the evolution."""

    _fields_ = (*((name, ctypes.c_void_p) for name in ["sys", "s", "c"]), ("e", ctypes.POINTER(Evolve)))


class Stepper(Installed):
    """A stepper of `gsl_odeiv2`, which names it."""

    library = "gsl"
    accepts: ClassVar[tuple[type[FirstOrder], ...]] = (FirstOrder,)
    sampling = "stops at samples"
    sweep = Tolerance(1e-3, 1e-13)
    takes: ClassVar[tuple[str, ...]] = STEP_SIZES
    needs_jacobian: ClassVar[bool] = False

    def versions(self) -> Mapping[str, str]:
        return {"GSL": interface()[1]}

    def prepare(self, problem: Problem, setting: float) -> Solver:
        c, _ = interface()
        require_positive(setting, "tolerance")
        assert isinstance(problem.form, FirstOrder)
        n, sizes = problem.dimension, step_sizes(self)
        state, reached, work = np.zeros(n), ctypes.c_double(), np.empty(n * (n + 1))
        user = np.array([right_hand_side(problem).address, 0, problem.buffer.ctypes.data, n, work.ctypes.data])
        if self.needs_jacobian:
            kernel = derivatives_if_traced(problem.form, n, len(problem.parameters), by_time=True)
            if kernel is None:
                raise Refused(f"{self.name} needs derivatives, and these equations cannot be traced; take msadams")
            user[JACOBIAN] = kernel.address
        system = System(compile_functions()["slopes"], compile_functions()["partial"], n, user.ctypes.data)
        first_step = sizes.get("first_step", FIRST_STEP * problem.time_scale)
        kind = ctypes.c_void_p.in_dll(c, f"gsl_odeiv2_step_{self.name}")
        driver = c.gsl_odeiv2_driver_alloc_y_new(ctypes.byref(system), kind, first_step, setting, setting)
        if not driver:
            raise MemoryError("GSL: gsl_odeiv2_driver_alloc_y_new returned no object")
        if "max_step" in sizes:
            c.gsl_odeiv2_driver_set_hmax(driver, sizes["max_step"])
        evolution = ctypes.cast(driver, ctypes.POINTER(Driver)).contents.e.contents
        run = machine.function(follow, "int int int int float[1] float[1] float[2]")
        apply = ctypes.cast(c.gsl_odeiv2_driver_apply, ctypes.c_void_p).value
        arguments = apply, driver, ctypes.addressof(reached), state.ctypes.data
        times = np.ascontiguousarray(problem.times)
        close = weakref.finalize(system, c.gsl_odeiv2_driver_free, driver)

        def solve_one(
            start: Floats,
            samples: Floats,
            alive: object = (problem.buffer, system, user, work),  # C holds their addresses
        ) -> tuple[int, str | None]:
            if not close.alive:
                raise RuntimeError("called after close; prepare again")
            state[:], reached.value = start, problem.t0
            c.gsl_odeiv2_driver_reset_hstart(driver, first_step)
            code = run(*arguments, times, state, samples)
            return evolution.count, f"{name_code(code)} at t = {reached.value:g}" if code else None

        return Solver(each_start(problem, solve_one), {"eps_rel": setting, "eps_abs": setting} | sizes, close=close)


class Rkf45(Stepper):
    """Runge-Kutta-Fehlberg of orders 4 and 5. Fehlberg, NASA TR R-315 (1969)."""

    name: ClassVar[str] = "rkf45"


class Rk8pd(Stepper):
    """Dormand's and Prince's Runge-Kutta method of orders 8 and 9, RK8(7)-13. J. Comput. Appl. Math. 7 (1981) 67."""

    name = "rk8pd"


class Msadams(Stepper):
    """Adams-Moulton methods of orders 1 to 12 in Nordsieck form, iterated by the fixed point."""

    name = "msadams"


class Bsimp(Stepper):
    """The semi-implicit extrapolation of Bader and Deuflhard, Numer. Math. 41 (1983) 373."""

    name, needs_jacobian = "bsimp", True


class Msbdf(Stepper):
    """Backward differentiation of orders 1 to 5 in Nordsieck form, iterated by Newton's method."""

    name, needs_jacobian = "msbdf", True


@cache
def interface() -> tuple[ctypes.CDLL, str]:
    """The library, and its version. Raises ImportError if it is not found."""
    names = util.find_library("gslcblas"), util.find_library("gsl")
    if None in names:
        raise ImportError(not_installed("gsl"))
    _, c = (ctypes.CDLL(name, ctypes.RTLD_GLOBAL) for name in names)  # the second one needs the first one
    word, number = ctypes.c_void_p, ctypes.c_double
    allocate, text = c.gsl_odeiv2_driver_alloc_y_new, c.gsl_strerror
    allocate.restype, allocate.argtypes = word, [word, word, number, number, number]
    text.restype, text.argtypes = ctypes.c_char_p, [ctypes.c_int]
    for name in ("reset_hstart", "set_hmax"):
        getattr(c, f"gsl_odeiv2_driver_{name}").argtypes = [word, number]
    c.gsl_odeiv2_driver_free.restype, c.gsl_odeiv2_driver_free.argtypes = None, [word]
    c.gsl_set_error_handler_off.restype = word
    c.gsl_set_error_handler_off()
    return c, str((ctypes.c_char_p.in_dll(c, "gsl_version").value or b"").decode())


def name_code(code: int) -> str:
    """The library's words for a return code."""
    if code == NOT_FINITE:
        return "a derivative is not finite"
    words: bytes = interface()[0].gsl_strerror(code)
    return words.decode()


INTEGRATORS: tuple[type[Integrator], ...] = (Rkf45, Rk8pd, Msadams, Bsimp, Msbdf)
