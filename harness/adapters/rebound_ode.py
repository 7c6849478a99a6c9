"""REBOUND's "ODE mode": any smooth first-order problem through `create_ode`, always by its BS integrator.

How it is driven, and why:

- The right-hand side is a compiled C function. Set through the property (`ode.derivatives = f`) it would be called
  through Python, 35 times slower and slower than plain Python; so the C pointer itself is written into the structure,
  and a reference to it is kept.
- That function gets the ODE structure, and reads the addresses of the equations and of the parameters at its field
  `ref`, made for this. It is compiled once for all problems.
- No particles are needed (`needs_nbody=False`), with BS as the simulation's integrator.
- One simulation and one ODE serve all trajectories: REBOUND does not free an ODE with its simulation. The integrator is set
  again before each trajectory, which clears its state (order, rejection).
- The setting is `eps_rel`; `eps_abs` equals it, as in the defaults (1e-8 both), in SI units.

Traps, seen in 5.2.2: `ode.y` is another array after each step (BS swaps two), so its address is read for each sample. A
NaN ends the run with an error only if it is in the last component; in other components a maximum hides it, and the run
succeeds until it spreads. For more see `rebound_nbody`.
"""

import ctypes
from typing import Any

import numpy as np
from gnomon.cases.core.forms import FirstOrder
from gnomon.harness.adapters.installed import Installed
from gnomon.harness.adapters.rebound_loop import Layout, follower, restarter
from gnomon.harness.adapters.rebound_nbody import FIRST_STEP
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Solver, Tolerance, each_start
from gnomon.harness.contract.validation import require_positive
from gnomon.harness.kernels.c_structures import c_functions, run_at, word_at
from gnomon.harness.kernels.equations import right_hand_side

REF = 0
"""The word of the structure of an ODE that is its field `ref`, once the library is loaded."""


def derivatives(ode: Any, out: Any, y: Any, t: Any) -> int:
    """The right-hand side as REBOUND calls it. `ref` has the addresses of the equations and of their parameters."""
    user = word_at(ode, REF)
    run_at(word_at(user, 0), t, y, word_at(user, 1), out)
    return 0


class OdeMode(Installed):
    """Gragg, Bulirsch and Stoer's extrapolation, step and order adaptive. Hairer, Norsett, Wanner (1993), II.9."""

    name, library, policy = "BS", "rebound", "ODE mode"
    accepts = (FirstOrder,)
    sampling = "stops at samples"
    sweep = Tolerance(1e-3, 1e-13)

    def prepare(self, problem: Problem, setting: float) -> Solver:
        import rebound  # without the library the status is `not_installed`

        require_positive(setting, "tolerance")
        dimension, buffer = problem.dimension, problem.buffer
        options = {"eps_rel": setting, "eps_abs": setting}
        simulation = rebound.Simulation()
        restart = restarter(simulation, "bs", options)
        ode = simulation.create_ode(length=dimension, needs_nbody=False)
        function = c_pointer()
        user = np.array([right_hand_side(problem).address, buffer.ctypes.data])
        ode._derivatives = function
        ode.ref = user.ctypes.data
        first_step = FIRST_STEP * problem.time_scale
        layout = Layout(ctypes.addressof(ode) + type(ode).y.offset, dimension)
        follow = follower(simulation, np.ascontiguousarray(problem.times), layout)

        def solve_one(
            start: Floats,
            samples: Floats,
            alive: object = (function, user, buffer),  # C holds their addresses
        ) -> tuple[int, str | None]:
            restart()
            before = simulation.steps_done
            simulation.t, simulation.dt = problem.t0, first_step
            np.ctypeslib.as_array(ode.y, (dimension,))[:] = start
            stopped = follow(samples[:, np.newaxis])
            return simulation.steps_done - before, stopped

        return Solver(each_start(problem, solve_one), {"dt": first_step, **options})


def c_pointer() -> Any:
    """`derivatives` as a C function pointer of the type of `ode._derivatives`."""
    from rebound.ode import ODE, ODEDER

    numbers = (("REF", ODE.ref.offset // ctypes.sizeof(ctypes.c_void_p)),)
    return ODEDER(c_functions(((derivatives, "int int int float"),), numbers)["derivatives"])


INTEGRATORS: tuple[type[Integrator], ...] = (OdeMode,)
