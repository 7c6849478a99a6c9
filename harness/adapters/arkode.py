"""ARKODE of SUNDIALS by its C interface: Runge-Kutta methods, explicit and diagonally implicit.

The library comes from the system, as no wheel has it (Debian: libsundials-dev). What is not said here is as in `sundials`.

How it is driven, and why:

- ERKStep for equations that are not stiff: it "admits a more efficient and memory-friendly implementation" than ARKStep.
  Its pairs of orders 6 and 8 lose orders by a fault that SUNDIALS 6.7 repairs, so ARKStep takes the order 8.
- For stiff equations ARKStep with an implicit part only, iterated by Newton's method with a dense matrix and the compiled
  Jacobian. The matrix is set up in each step: with a kept one, steps were accepted before the iteration converged.
- The methods are those that the library has for an order: 4 is its default.
- Samples in the mode `ARK_NORMAL`: steps go past a sample, which an interpolant gives: "for non-stiff problems" in Hermite's
  form, for stiff ones in Lagrange's. Their degree is 5 at most, so the method of order 8 ends a step at each sample, by
  a stop time.
- The setting is `reltol`; `abstol` = 1e-5 `reltol`, the ratio of the library's defaults (1e-4 and 1e-9), in SI units.

Traps: only the VERSIONS that were tried are driven; 7 has another interface.
"""

import ctypes
from collections.abc import Mapping
from ctypes import util
from functools import cache
from typing import Any, ClassVar

from gnomon.harness.adapters import sundials
from gnomon.harness.adapters.installed import not_installed
from gnomon.harness.adapters.scipy_ivp import STEP_SIZES
from gnomon.harness.adapters.sundials import EQUATIONS, NORMAL, Motion, Native, Parts, Session, load_functions
from gnomon.harness.contract.integrator import Integrator, Problem
from gnomon.harness.kernels.equations import right_hand_side

VERSIONS = ("6.4.1",)
"""The versions of SUNDIALS whose interface was tried."""
DATA = 2
"""As `sundials.DATA`, for indices of 64 bits."""
LAGRANGE = 1
"""The interpolant for stiff equations."""
SIGNATURES = sundials.SIGNATURES | {
    "ERKStepCreate": "p pdpp", "ARKStepCreate": "p ppdpp", "ERKStepReInit": "i ppdp", "ARKStepReInit": "i pppdp",
} | {
    f"{solver}{name}": signature for solver in ("ERKStep", "ARKStep") for name, signature in {
        "Evolve": "i pdppi", "SetOrder": "i pi", "SetErrFile": "i pp", "SetInterpolantType": "i pi",
        "SetLSetupFrequency": "i pi",
    }.items()
}  # fmt: skip


class Arkode(Native):
    """A method of ARKODE, the library's own of its `order`. Reynolds et al., ACM Trans. Math. Softw. 49 (2023) 19."""

    library, policy = "arkode", ""
    solver, advance = "ARKStep", "ARKStepEvolve"
    atol_ratio = 1e-5
    takes: ClassVar[tuple[str, ...]] = STEP_SIZES
    order: ClassVar[int]

    def versions(self) -> Mapping[str, str]:
        return {"SUNDIALS": interface().version}

    def library_parts(self) -> Parts:
        return interface()

    def right_sides(self, slope: int) -> tuple[int | None, ...]:
        """The right-hand sides that the solver takes."""
        return (slope,)

    def connect(self, session: Session, problem: Problem) -> tuple[dict[str, Any], Motion]:
        equations = *self.right_sides(session.functions["slope"]), problem.t0, session.y
        session.user[EQUATIONS] = right_hand_side(problem).address
        session.create_memory(*equations)
        session.set("SetErrFile", None)
        session.set("SetOrder", self.order)
        arguments = session.y, ctypes.addressof(session.reached), NORMAL
        return {"order": self.order}, (lambda: session.set("ReInit", *equations), arguments)


class Erk4(Arkode):
    """Zonneveld's explicit Runge-Kutta pair of orders 4 and 3 (1963)."""

    name: ClassVar[str] = "ERKStep 4"
    solver, advance, order = "ERKStep", "ERKStepEvolve", 4


class Erk5(Erk4):
    """Cash's and Karp's explicit Runge-Kutta pair of orders 5 and 4. ACM Trans. Math. Softw. 16 (1990) 201."""

    name, order = "ERKStep 5", 5


class Erk8(Arkode):
    """Fehlberg's explicit Runge-Kutta pair of orders 8 and 7, NASA TR R-287 (1968)."""

    name: ClassVar[str] = "ARKStep explicit 8"
    order, sampling = 8, "stops at samples"

    def right_sides(self, slope: int) -> tuple[int | None, ...]:
        return slope, None


class Dirk4(Arkode):
    """A diagonally implicit Runge-Kutta pair of orders 4 and 3. Hairer, Wanner, Solving ODEs II, IV.6."""

    name: ClassVar[str] = "ARKStep DIRK 4"
    order = 4
    takes = (*STEP_SIZES, "jac")

    def right_sides(self, slope: int) -> tuple[int | None, ...]:
        return None, slope

    def connect(self, session: Session, problem: Problem) -> tuple[dict[str, Any], Motion]:
        dense = session.create_dense()
        options, motion = super().connect(session, problem)
        options |= {
            "jac": session.use_newton(dense, problem, "partial"),
            "interpolant": "Lagrange",
            "lsetup_frequency": 1,
        }
        session.set("SetInterpolantType", LAGRANGE)
        session.set("SetLSetupFrequency", 1)
        return options, motion


class Dirk5(Dirk4):
    """The implicit part of the pair of orders 5 and 4 of Kennedy and Carpenter, Appl. Numer. Math. 44 (2003) 139."""

    name, order = "ARKStep DIRK 5", 5


@cache
def interface() -> Parts:
    """The library. Raises ImportError if it is not found, or has another version."""
    name = util.find_library("sundials_arkode")
    if name is None:
        raise ImportError(not_installed("arkode"))
    functions, version = load_functions([ctypes.CDLL(name)], SIGNATURES)
    if version not in VERSIONS:
        raise ImportError(
            f"arkode {version}: its C interface was tried with {', '.join(VERSIONS)} only; install that one"
        )
    return Parts(functions, version, DATA)


INTEGRATORS: tuple[type[Integrator], ...] = (Erk4, Erk5, Erk8, Dirk4, Dirk5)
