"""Boost's odeint: a shared library of its templates, compiled at the first use and kept with the other machine code.

Compiler and headers come from the system (Debian: g++ and libboost-dev). The C++ source is below; it has no equation.

How it is driven, and why:

- One call of compiled code solves a motion: `integrate_times` over all samples. The equations and their derivatives are
  the compiled functions of the case, which odeint's system calls by address.
- As the tutorial does: `make_controlled` with a relative error and an absolute one of 1e-4 of it for the Runge-Kutta pairs
  (1e-6 and 1e-10), and with both equal for the others (the defaults of bulirsch_stoer, the tutorial's rosenbrock4).
- dopri5 has dense output and goes past a sample. fehlberg78 has none, so it ends a step there. So do two whose dense output
  costs more than it saves: with bulirsch_stoer_dense_out a motion takes 2.6 to 3.3 times as long at 1e-9 (pendulum,
  Kepler's orbit); on stiff equations rosenbrock4 takes 7 long steps at 1e-7, between which its dense output errs by 1e-2.
- The first step is .01 time scales of the case: the tutorial's .01, in equations with a time scale of about 1.
- rosenbrock4 needs the Jacobian, and df/dt. Equations that cannot be traced are refused.
- A derivative that is not finite ends the motion, by an exception.

Traps: rosenbrock4 has order 1 on equations that depend on time, as its coefficient `d4` is .0362, where RODAS of Hairer and
Wanner has -.0362; with that one the order is 4. 500 refused steps in a row end a motion.
"""

import ctypes
import shutil
import subprocess
from collections.abc import Mapping
from functools import cache
from typing import ClassVar

import numpy as np
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.adapters.compiled_source import load_compiled
from gnomon.harness.adapters.installed import Installed, not_installed
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Refused, Solver, Tolerance, each_start
from gnomon.harness.contract.validation import require_positive
from gnomon.harness.kernels.equations import right_hand_side
from gnomon.harness.kernels.straight_line import derivatives_if_traced

FIRST_STEP = 0.01
"""In time scales of the case."""
REASON = 200
"""The length of a message."""
OPTIONS = "-std=c++14", "-O3", "-march=native", "-DNDEBUG", "-fPIC", "-shared"
"""Without NDEBUG uBLAS checks every product of matrices, which takes ten times as long as rosenbrock4 itself."""
SOURCE = r"""
#include <boost/numeric/odeint.hpp>
#include <boost/version.hpp>
#include <cmath>
#include <cstdio>
#include <stdexcept>
#include <vector>

using namespace boost::numeric::odeint;
using State = std::vector<double>;
using Vector = boost::numeric::ublas::vector<double>;
using Matrix = boost::numeric::ublas::matrix<double>;
typedef void Function(double t, const double *y, const double *p, double *out);

struct Problem {
    Function *slopes, *derivatives;
    const double *parameters, *start, *times;
    double *states, *work;
    long dimension, samples, steps;
    double begin, first_step, absolute, relative;
    char reason[200];
};

static void slopes(const Problem *problem, const double *y, double *out, double t) {
    problem->slopes(t, y, problem->parameters, out);
    for (long i = 0; i < problem->dimension; i++)
        if (!std::isfinite(out[i])) throw std::runtime_error("a derivative is not finite at t = " + std::to_string(t));
}

template <class Stepper, class System, class Y>
static long integrate(Problem *problem, Stepper stepper, System system, Y y) {
    std::vector<double> times(1, problem->begin);
    times.insert(times.end(), problem->times, problem->times + problem->samples);
    std::copy(problem->start, problem->start + y.size(), y.begin());
    long reached = -1;
    const auto keep = [&](const Y &at, double) {
        if (reached >= 0) std::copy(at.begin(), at.end(), problem->states + reached * problem->dimension);
        reached++;
    };
    problem->steps = 0;
    problem->reason[0] = 0;
    try {
        problem->steps = integrate_times(stepper, system, y, times.begin(), times.end(), problem->first_step, keep);
    } catch (const std::exception &error) {
        std::snprintf(problem->reason, sizeof problem->reason, "%s", error.what());
    }
    return reached;
}

template <class Stepper>
static long explicitly(Problem *problem, Stepper stepper) {
    const auto system = [=](const State &y, State &out, double t) { slopes(problem, y.data(), out.data(), t); };
    return integrate(problem, stepper, system, State(problem->dimension));
}

extern "C" {
long dopri5(Problem *problem) {
    return explicitly(
        problem, make_dense_output<runge_kutta_dopri5<State>>(problem->absolute, problem->relative));
}

long fehlberg78(Problem *problem) {
    return explicitly(
        problem, make_controlled<runge_kutta_fehlberg78<State>>(problem->absolute, problem->relative));
}

long bulirsch_stoer_(Problem *problem) {
    return explicitly(problem, bulirsch_stoer<State>(problem->absolute, problem->relative));
}

long rosenbrock4_(Problem *problem) {
    const auto system = [=](const Vector &y, Vector &out, double t) { slopes(problem, &y[0], &out[0], t); };
    const auto jacobian = [=](const Vector &y, Matrix &J, double t, Vector &by_time) {
        const long n = problem->dimension;
        problem->derivatives(t, &y[0], problem->parameters, problem->work);
        for (long i = 0; i < n; i++) {
            for (long j = 0; j < n; j++) J(i, j) = problem->work[(n + 1) * i + j];
            by_time[i] = problem->work[(n + 1) * i + n];
        }
    };
    const auto stepper = make_controlled<rosenbrock4<double>>(problem->absolute, problem->relative);
    return integrate(problem, stepper, std::make_pair(system, jacobian), Vector(problem->dimension));
}

const char *version() { return BOOST_LIB_VERSION; }
}
"""


class Facts(ctypes.Structure):
    """The `Problem` of SOURCE."""

    _fields_ = (
        *((name, ctypes.c_void_p) for name in ("slopes", "derivatives", "parameters", "start", "times", "states", "work")),
        *((name, ctypes.c_long) for name in ("dimension", "samples", "steps")),
        *((name, ctypes.c_double) for name in ("begin", "first_step", "absolute", "relative")),
        ("reason", ctypes.c_char * REASON),
    )  # fmt: skip


class Stepper(Installed):
    """A stepper of odeint. `symbol` is its function in SOURCE."""

    library = "odeint"
    accepts: ClassVar[tuple[type[FirstOrder], ...]] = (FirstOrder,)
    sampling = "stops at samples"
    sweep = Tolerance(1e-3, 1e-13)
    takes: ClassVar[tuple[str, ...]] = ("first_step",)
    symbol: ClassVar[str]
    atol_ratio: float = 1.0
    needs_jacobian: ClassVar[bool] = False

    def versions(self) -> Mapping[str, str]:
        return {"Boost": interface()[1]}

    def prepare(self, problem: Problem, setting: float) -> Solver:
        solve = interface()[0][self.symbol]
        require_positive(setting, "tolerance")
        assert isinstance(problem.form, FirstOrder)
        n, kernel = problem.dimension, None
        work, times = np.empty(n * (n + 1)), np.ascontiguousarray(problem.times)
        if self.needs_jacobian:
            kernel = derivatives_if_traced(problem.form, n, len(problem.parameters), by_time=True)
            if kernel is None:
                raise Refused(f"{self.name} needs derivatives, and these equations cannot be traced; take dopri5")
        first_step = FIRST_STEP * problem.time_scale if self.first_step is None else self.first_step
        errors = {"eps_rel": setting, "eps_abs": self.atol_ratio * setting}
        facts = Facts(
            slopes=right_hand_side(problem).address,
            derivatives=kernel and kernel.address,
            parameters=problem.buffer.ctypes.data,
            times=times.ctypes.data,
            work=work.ctypes.data,
            dimension=n,
            samples=len(times),
            begin=problem.t0,
            first_step=first_step,
            absolute=errors["eps_abs"],
            relative=setting,
        )
        place = ctypes.byref(facts)

        def solve_one(
            start: Floats,
            samples: Floats,
            alive: object = (problem.buffer, times, work),  # C holds their addresses
        ) -> tuple[int | None, str | None]:
            begin = np.ascontiguousarray(start)
            facts.start, facts.states = begin.ctypes.data, samples.ctypes.data
            solve(place)
            reason = facts.reason.decode(errors="replace")
            return None if reason else facts.steps, reason or None

        return Solver(each_start(problem, solve_one), errors | {"first_step": first_step})


class Dopri5(Stepper):
    """Dormand's and Prince's Runge-Kutta pair of orders 5 and 4. J. Comput. Appl. Math. 6 (1980) 19."""

    name: ClassVar[str] = "dopri5"
    symbol, sampling, atol_ratio = "dopri5", "dense output", 1e-4


class Fehlberg78(Stepper):
    """Fehlberg's Runge-Kutta pair of orders 7 and 8, NASA TR R-287 (1968)."""

    name: ClassVar[str] = "fehlberg78"
    symbol, atol_ratio = "fehlberg78", 1e-4


class BulirschStoer(Stepper):
    """Extrapolation of the midpoint rule, of variable order and step. Hairer, Norsett, Wanner, Solving ODEs I, II.9."""

    name: ClassVar[str] = "bulirsch_stoer"
    symbol = "bulirsch_stoer_"


class Rosenbrock4(Stepper):
    """A Rosenbrock method of order 4. Hairer, Wanner, Solving ODEs II, IV.7."""

    name: ClassVar[str] = "rosenbrock4"
    symbol, needs_jacobian = "rosenbrock4_", True


_ABSENT = list[str]()
"""Why there is no interface: the compiler is asked once in a process."""


@cache
def interface() -> tuple[ctypes.CDLL, str]:
    """The compiled templates, and the version of Boost. Raises ImportError without a compiler or headers."""
    if _ABSENT:
        raise ImportError(_ABSENT[0])
    compiler = shutil.which("c++")
    text = "#include <boost/version.hpp>\nBOOST_LIB_VERSION __VERSION__"
    asked = [f"{compiler}", "-E", "-P", "-x", "c++", "-"]
    completed = compiler and subprocess.run(asked, input=text, capture_output=True, text=True)
    if not compiler or not completed or completed.returncode:
        _ABSENT.append(not_installed("odeint"))
        raise ImportError(_ABSENT[0])
    c = load_compiled("odeint", compiler, f"{completed.stdout}", OPTIONS, {"odeint.cpp": SOURCE.encode()})
    for name in ("dopri5", "fehlberg78", "bulirsch_stoer_", "rosenbrock4_"):
        c[name].restype, c[name].argtypes = ctypes.c_long, [ctypes.c_void_p]
    c.version.restype = ctypes.c_char_p
    return c, c.version().decode().replace("_", ".")


INTEGRATORS: tuple[type[Integrator], ...] = (Dopri5, Fehlberg78, BulirschStoer, Rosenbrock4)
