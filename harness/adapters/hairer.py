"""The Fortran codes of Hairer and Wanner: RADAU5, RODAS, SEULEX, ODEX.

gnomon has none of them. FOLDER, a variable of the environment, names the folder with the files, as their authors offer
them on their page; `gfortran` compiles those of a code at its first use (Debian: gfortran).

How they are driven, and why:

- One call of compiled code solves a motion. The Fortran below has the subroutines that a code calls: they call the compiled
  equations and derivatives of the case by address, and SOLOUT reads each sample from the continuous output of its step
  (CONTR5, CONTRO, CONTEX), so that no step ends at a sample.
- SEULEX is called from sample to sample, each time with the "PREDICTED STEP SIZE OF THE LAST ACCEPTED STEP". Its error test is
  of the ends of steps alone, and its steps are long: at 1e-11 its continuous output errs by 1e-5 between ends that err by 1e-11.
- Defaults: "FOR STANDARD USE, SET IWORK(1),..,IWORK(20) TO ZERO BEFORE CALLING." Only the limit of steps is raised, as
  100,000 (ODEX: 10,000) end long intervals early.
- "THE CODE KEEPS, ROUGHLY, THE LOCAL ERROR OF Y(I) BELOW RTOL*ABS(Y(I))+ATOL": the setting is RTOL, and ATOL is equal to it,
  as in the authors' drivers of RADAU5, SEULEX and ODEX, in SI units. Their driver of RODAS has ATOL = 1e-6 RTOL.
- The first step is 1e-3 time scales of the case: "USUALLY 1.D-3 OR 1.D-5, IS GOOD" (RADAU5), "1.D-2 OR 1.D-3" (RODAS,
  SEULEX), "1.D-1 OR 1.D-3" (ODEX).
- All but ODEX get the Jacobian, and RODAS df/dx too. If equations cannot be traced, the codes compute differences.
- The codes know no failure of a derivative. A derivative that is not finite is therefore replaced by a huge one, which
  no error test accepts, so that the step is repeated with a shorter one; unless the state is as huge, so that a component
  beyond 1e100 ends the motion.

Traps: the codes share variables in COMMON, so calls keep the lock of the interpreter. They write their reasons for a failure
to unit 6, which is closed to them. ODEX and SEULEX know no shortest step: before a singularity they would take millions in which
the time does not change. The first such step ends a motion.
"""

import ctypes
import os
import shutil
import subprocess
from collections.abc import Mapping
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import ClassVar

import numpy as np
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.adapters.compiled_source import load_compiled
from gnomon.harness.adapters.installed import Installed, not_installed
from gnomon.harness.adapters.scipy_ivp import STEP_SIZES, step_sizes
from gnomon.harness.adapters.scipy_ode import STEPS
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Solver, Tolerance, each_start
from gnomon.harness.contract.validation import require_positive
from gnomon.harness.kernels.equations import right_hand_side
from gnomon.harness.kernels.straight_line import derivatives_if_traced

FOLDER = "GNOMON_HAIRER_WANNER"
LINEAR_ALGEBRA = ("decsol.f", "dc_decsol.f"), ("lapack.f", "lapackc.f", "dc_lapack.f")
"""The files of the linear algebra, of which the authors link either."""
FIRST_STEP = 1e-3
"""In time scales of the case."""
OPTIONS = "-std=legacy", "-w", "-O3", "-march=native", "-fPIC", "-shared"
TOO_SMALL = -3
REASONS = {-1: "the input is not consistent, or more steps are needed", -2: "more steps are needed",
           TOO_SMALL: "the step became too small", -4: "the matrix is repeatedly singular"}  # fmt: skip
"""By IDID; ODEX and SEULEX return -1 for all."""
SOURCE = """
module given
  use iso_c_binding
  implicit none
  type, bind(c) :: facts
    type(c_funptr) :: slopes, derivatives
    type(c_ptr) :: parameters, start, times, states
    integer(c_long) :: dimension, samples, steps, reached, most_steps, idid
    real(c_double) :: begin, first_step, longest_step, absolute, relative, time, not_finite
  end type
  abstract interface
    subroutine equations(t, y, p, out) bind(c)
      import
      real(c_double), value :: t
      type(c_ptr), value :: p
      real(c_double) :: y(*), out(*)
    end subroutine
  end interface
  type(facts), pointer :: problem
  procedure(equations), pointer :: slopes, derivatives
  real(c_double), pointer :: times(:), states(:, :)
  integer(c_long) :: before
contains
  subroutine fcn(n, x, y, f, rpar, ipar)
    integer :: n, ipar(*)
    real(c_double) :: x, y(n), f(n), rpar(*)
    call slopes(x, y, problem%parameters, f)
    if (all(abs(f) <= huge(f))) return
    problem%not_finite = x
    f = sqrt(huge(f))
  end subroutine
  subroutine jac(n, x, y, dfy, ldfy, rpar, ipar)
    integer :: n, ldfy, ipar(*)
    real(c_double) :: x, y(n), dfy(ldfy, n), rpar(*), found(n + 1, n)
    call derivatives(x, y, problem%parameters, found)
    dfy(1:n, :) = transpose(found(1:n, :))
  end subroutine
  subroutine dfx(n, x, y, fx, rpar, ipar)
    integer :: n, ipar(*)
    real(c_double) :: x, y(n), fx(n), rpar(*), found(n + 1, n)
    call derivatives(x, y, problem%parameters, found)
    fx = found(n + 1, :)
  end subroutine
  subroutine mas(n, am, lmas, rpar, ipar)
    integer :: n, lmas, ipar(*)
    real(c_double) :: am(lmas, n), rpar(*)
  end subroutine
  subroutine solout(nr, xold, x, y, {arguments}, rpar, ipar, irtrn)
    integer :: i, nr, n, irtrn, ipar(*), {integers}
    real(c_double) :: at, xold, x, y(*), rpar(*), {reals}
    real(c_double), external :: {continuous}
    if (.not. all(abs(y(1:n)) <= 1d100)) then
      problem%not_finite = x
      irtrn = -1
      return
    end if
    if (nr > 1 .and. x == xold) then
      problem%idid = {too_small}
      irtrn = -1
      return
    end if
    problem%steps = before + nr - 1
    problem%time = x
    do while (problem%reached < problem%samples)
      at = times(problem%reached + 1)
      if (at > x) exit
      problem%reached = problem%reached + 1
      do i = 1, n
        states(i, problem%reached) = y(i)
        if (at < x) states(i, problem%reached) = {output}
      end do
    end do
  end subroutine
end module

subroutine solve(place) bind(c)
  use given
  type(facts), target :: place
  integer :: n, idid, ijac, ml, mu, mlmas, mumas, i, ipar(1)
  real(c_double) :: x, xend, h, rtol(1), atol(1), rpar(1)
  real(c_double), pointer :: start(:)
  real(c_double), allocatable :: y(:), work(:)
  integer, allocatable :: iwork(:)
  logical, save :: silent = .false.
  if (.not. silent) open(unit=6, file='/dev/null')
  silent = .true.
  problem => place
  n = int(place%dimension)
  call c_f_procpointer(place%slopes, slopes)
  if (c_associated(place%derivatives)) call c_f_procpointer(place%derivatives, derivatives)
  call c_f_pointer(place%start, start, [n])
  call c_f_pointer(place%times, times, [place%samples])
  call c_f_pointer(place%states, states, [place%dimension, place%samples])
  allocate(y(n), work({reals_of_work}), iwork({integers_of_work}))
  y = start
  work = 0
  iwork = 0
  work({longest}) = place%longest_step
  {settings}
  x = place%begin
  h = place%first_step
  rtol = place%relative
  atol = place%absolute
  ijac = merge(1, 0, c_associated(place%derivatives))
  ml = n
  mu = n
  mlmas = n
  mumas = n
  place%steps = 0
  place%reached = 0
  place%time = x
  place%not_finite = -huge(x)
  place%idid = 0
  do while (place%reached < place%samples)
    before = place%steps
    iwork({most}) = int(place%most_steps - before)
    xend = times({until})
    call {call}
    if (place%idid == 0 .and. idid /= 1) place%idid = idid
    if (place%idid /= 0) return
    do while (place%reached < place%samples)  ! rounding can end the last step just before xend
      if (times(place%reached + 1) > xend) exit
      place%reached = place%reached + 1
      states(:, place%reached) = y
    end do
    x = xend
  end do
end subroutine
"""


class Facts(ctypes.Structure):
    """The `facts` of SOURCE."""

    _fields_ = (
        *((name, ctypes.c_void_p) for name in ("slopes", "derivatives", "parameters", "start", "times", "states")),
        *((name, ctypes.c_long) for name in ("dimension", "samples", "steps", "reached", "most_steps", "idid")),
        *((name, ctypes.c_double) for name in ("begin", "first_step", "longest_step", "absolute", "relative")),
        *((name, ctypes.c_double) for name in ("time", "not_finite")),
    )  # fmt: skip


class Code(Installed):
    """A code of Hairer and Wanner.

    `name` is its subroutine, and its file. The words complete SOURCE: the arguments of SOLOUT by which the continuous output
    is read, with their types, its function and a call of it; the sample until which the code is called; the sizes of WORK and IWORK, the places of the longest step and
    of the limit of steps in them, other settings, and the call.
    """

    library = "hairer"
    accepts: ClassVar[tuple[type[FirstOrder], ...]] = (FirstOrder,)
    sampling = "dense output"
    sweep = Tolerance(1e-3, 1e-13)
    takes: ClassVar[tuple[str, ...]] = (*STEP_SIZES, "jac")
    needs: ClassVar[tuple[tuple[str, ...], ...]] = LINEAR_ALGEBRA
    atol_ratio: float = 1.0
    words: ClassVar[Mapping[str, str]]

    def versions(self) -> Mapping[str, str]:
        sources, compiler = find_files(self.name, self.needs)
        return {self.name: sha256(b"".join(sources.values())).hexdigest()[:12], "gfortran": version_of(compiler)}

    def prepare(self, problem: Problem, setting: float) -> Solver:
        solve = interface(type(self))
        require_positive(setting, "tolerance")
        assert isinstance(problem.form, FirstOrder)
        n, times = problem.dimension, np.ascontiguousarray(problem.times)
        kernel = derivatives_if_traced(problem.form, n, len(problem.parameters), by_time=True) if self.needs else None
        sizes = step_sizes(self)
        first_step = sizes.get("first_step", FIRST_STEP * problem.time_scale)
        facts = Facts(
            slopes=right_hand_side(problem).address,
            derivatives=kernel and kernel.address,
            parameters=problem.buffer.ctypes.data,
            times=times.ctypes.data,
            dimension=n,
            samples=len(times),
            most_steps=STEPS,
            begin=problem.t0,
            first_step=first_step,
            longest_step=sizes.get("max_step", 0),
            absolute=self.atol_ratio * setting,
            relative=setting,
        )
        place = ctypes.byref(facts)

        def solve_one(
            start: Floats,
            samples: Floats,
            alive: object = (problem.buffer, times),  # Fortran holds their addresses
        ) -> tuple[int, str | None]:
            begin = np.ascontiguousarray(start)
            facts.start, facts.states = begin.ctypes.data, samples.ctypes.data
            solve(place)
            return facts.steps, None if facts.reached == len(times) else reason(facts)

        options = {"rtol": setting, "atol": self.atol_ratio * setting, "first_step": first_step} | sizes
        return Solver(each_start(problem, solve_one), options | ({"jac": kernel and "compiled"} if self.needs else {}))


STIFF_CALL = (
    "(n, fcn, {autonomous}x, y, xend, h, rtol, atol, 0, jac, ijac, ml, mu, {by_time}mas, 0, mlmas, mumas, &\n"
    "      solout, 1, work, size(work), iwork, size(iwork), rpar, ipar, idid)"
)
CONTINUOUS = {"arguments": "cont, lrc, n", "integers": "lrc", "reals": "cont(*)", "until": "place%samples"}


class Radau5(Code):
    """An implicit Runge-Kutta method of order 5, Radau IIA. Hairer, Wanner, Solving ODEs II, IV.8."""

    name: ClassVar[str] = "RADAU5"
    order = 5
    words = CONTINUOUS | {
        "continuous": "contr5", "output": "contr5(i, at, cont, lrc)", "reals_of_work": "4*n*n + 12*n + 20",
        "integers_of_work": "3*n + 20", "longest": "7", "most": "2", "settings": "",
        "call": "radau5" + STIFF_CALL.format(autonomous="", by_time=""),
    }  # fmt: skip


class Rodas(Code):
    """A Rosenbrock method of order 4 with an embedded one of order 3. Hairer, Wanner, Solving ODEs II, VI.4."""

    name: ClassVar[str] = "RODAS"
    order = 4
    atol_ratio = 1e-6
    words = CONTINUOUS | {
        "continuous": "contro", "output": "contro(i, at, cont, lrc)", "reals_of_work": "2*n*n + 14*n + 20",
        "integers_of_work": "n + 20", "longest": "2", "most": "1", "settings": "",
        "call": "rodas" + STIFF_CALL.format(autonomous="1, ", by_time="dfx, ijac, "),
    }  # fmt: skip


class Seulex(Code):
    """Extrapolation of the linearly implicit Euler method. Hairer, Wanner, Solving ODEs II, IV.9."""

    name: ClassVar[str] = "SEULEX"
    sampling = "stops at samples"
    words: ClassVar[Mapping[str, str]] = {
        "arguments": "rc, lrc, ic, lic, n", "integers": "lrc, lic, ic(*)", "reals": "rc(*)",
        "continuous": "contex", "output": "contex(i, at, rc, lrc, ic, lic)", "until": "place%reached + 1",
        "reals_of_work": "2*n*n + 20*n + 68", "integers_of_work": "2*n + 32", "longest": "2", "most": "2", "settings": "",
        "call": "seulex" + STIFF_CALL.format(autonomous="1, ", by_time=""),
    }  # fmt: skip


class Odex(Code):
    """Extrapolation of the explicit midpoint rule. Hairer, Norsett, Wanner, Solving ODEs I, II.9."""

    name: ClassVar[str] = "ODEX"
    needs = ()
    takes = STEP_SIZES
    words: ClassVar[Mapping[str, str]] = {
        "arguments": "n, con, ncon, icomp, nd", "integers": "ncon, nd, icomp(*)", "reals": "con(*)",
        "continuous": "contex", "output": "contex(i, at, con, ncon, icomp, nd)", "until": "place%samples",
        "reals_of_work": "217*n + 65", "integers_of_work": "n + 39", "longest": "2", "most": "1",
        "settings": "iwork(8) = n\n  iwork(21:20 + n) = [(i, i = 1, n)]",
        "call": "odex(n, fcn, x, y, xend, h, rtol, atol, 0, solout, 2, work, size(work), iwork, size(iwork), rpar, ipar, idid)",
    }  # fmt: skip


def reason(facts: Facts) -> str:
    """Why a motion ended early."""
    if facts.not_finite >= facts.time:  # since the last step
        return f"a derivative is not finite, or a component beyond 1e100, at t = {facts.not_finite:g}"
    return f"{REASONS.get(facts.idid, f'IDID = {facts.idid}')}, at t = {facts.time:g}"


def find_files(name: str, needs: tuple[tuple[str, ...], ...]) -> tuple[dict[str, bytes], str]:
    """The files of a code, and the compiler. Raises ImportError if one of them is missing."""
    folder, compiler = os.environ.get(FOLDER), shutil.which("gfortran")
    if compiler is None:
        raise ImportError(not_installed("hairer"))
    if folder is None:
        raise ImportError(f"hairer: the variable {FOLDER} must name the folder with {name.lower()}.f")
    choices = [(f"{name.lower()}.f", *files) for files in needs or ((),)]
    for files in choices:
        paths = [Path(folder) / file for file in files]
        if all(path.is_file() for path in paths):
            return {path.name: path.read_bytes() for path in paths}, compiler
    raise ImportError(f"hairer: {FOLDER} = {folder} has no {' or no '.join(map(', '.join, choices))}")


@cache
def version_of(compiler: str) -> str:
    return subprocess.run([compiler, "-dumpfullversion"], capture_output=True, text=True).stdout.strip()


@cache
def interface(code: type[Code]) -> "ctypes._NamedFuncPointer":
    """The function `solve` of SOURCE with a code. Raises ImportError if a file or the compiler is missing."""
    sources, compiler = find_files(code.name, code.needs)
    text = SOURCE
    for word, value in {**code.words, "too_small": f"{TOO_SMALL}"}.items():
        text = text.replace("{" + word + "}", value)
    files = {"solve.f90": text.encode()} | sources
    solve = load_compiled("hairer", compiler, version_of(compiler), OPTIONS, files, ctypes.PyDLL)["solve"]
    solve.restype, solve.argtypes = None, [ctypes.c_void_p]
    return solve


INTEGRATORS: tuple[type[Integrator], ...] = (Radau5, Rodas, Seulex, Odex)
