"""REBOUND on gravitating bodies: leapfrog, WHFast, TRACE, IAS15 and BS, with the library's own gravity.

How it is driven, and why:

- G = 1 and masses that are G*m, so that no product is rounded twice. Bodies without mass come last and are declared
  test particles (`N_active`).
- Methods with a fixed step divide the sampling interval exactly and advance by `steps(n)`: the interval has 20
  significant bits, so every time of a step is exact. `integrate` would end with a shortened step.
- Adaptive methods advance by `integrate(t)`, which shortens the last step before a sample and resumes with the full
  one.
- The simulation is made once; before each trajectory the integrator is set again, which clears its state (the predictor
  of IAS15, the order of BS, the unsynchronised state of WHFast). Tests verify that repeated runs give the same bits.
- The loop over samples is compiled (`rebound_loop`). REBOUND has no interpolant: its manual stops at each sample too.

Traps, seen in 5.2.2:

- Options of a method are in `sim.integrator` (`sim.integrator.epsilon`), not in structures such as `ri_ias15`, as in
  REBOUND 4. There is no `step()`; setting `sim.integrator` again resets the options.
- The first step, 1e-3 by default, is in the units of the problem: here it is a hundredth of the time scale.
- `steps_done` also counts the steps that IAS15 and BS rejected.
- `integrate` may end within 1e-12 of the requested time; tests show that it is met to the bit.
"""

import ctypes
from typing import Any, ClassVar

import numpy as np
from gnomon.cases.core.forms import NBody
from gnomon.harness.adapters.installed import Installed
from gnomon.harness.adapters.rebound_loop import Layout, follower, restarter
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Refused, Solution, Solver, Steps, Tolerance
from gnomon.harness.contract.validation import require_positive

FIRST_STEP = 0.01
"""The first step of adaptive methods, in time scales; later steps come from their step-size control."""


class Native(Installed):
    """A method of REBOUND on its own N-body equations; `engine` is its name there."""

    library = "rebound"
    accepts = (NBody,)
    counts_rhs = False
    engine: ClassVar[str]
    by_steps: ClassVar[bool] = False

    def options(self, setting: float) -> dict[str, Any]:
        """Options of the engine that differ from its defaults."""
        return {}

    def first_dt(self, problem: Problem, setting: float) -> float:
        return FIRST_STEP * problem.time_scale

    def ends(self, problem: Problem, setting: float) -> Floats:
        """The times of the samples, or the numbers of steps between them if `by_steps`."""
        return np.ascontiguousarray(problem.times)

    def prepare(self, problem: Problem, setting: float) -> Solver:
        import rebound  # without the library the status is `not_installed`

        require_positive(setting, type(self.sweep).kind)
        form, parameters = problem.form, tuple(problem.parameters.tolist())
        assert isinstance(form, NBody)
        masses = form.masses(parameters)
        options = self.options(setting)
        simulation = rebound.Simulation()
        restart = restarter(simulation, self.engine, options)
        for mass in masses:
            simulation.add(m=mass)
        active = len(np.trim_zeros(masses, "b"))
        if active < len(masses):
            simulation.N_active = active
        first_step = self.first_dt(problem, setting)
        layout, bodies = bodies_of(simulation)
        follow = follower(simulation, self.ends(problem, setting), layout, self.by_steps)

        def solve_one(start: Floats, path: Floats) -> str | None:
            restart()
            bodies[:] = form.bodies(tuple(start.tolist()))
            simulation.t, simulation.dt = problem.t0, first_step
            return follow(path)

        def solve(initial_states: Floats) -> Solution:
            count, samples = len(initial_states), len(problem.times)
            paths = np.full((count, samples, *bodies.shape), np.nan)
            before, stopped = simulation.steps_done, None
            for start, path in zip(initial_states, paths, strict=True):
                stopped = solve_one(start, path) or stopped
            # All samples are converted at once: a body's components are arrays (n, samples).
            moved = tuple(tuple(body) for body in paths.transpose(2, 3, 0, 1))
            states = np.empty((count, samples, problem.dimension))
            for i, component in enumerate(form.state(moved)):
                states[:, :, i] = component
            return Solution(states, simulation.steps_done - before, stopped)

        few = {"N_active": active} if active < len(masses) else {}
        return Solver(solve, {"dt": first_step, **options, **few})


class FixedSteps(Native):
    """A method whose setting is the step size."""

    by_steps = True
    sampling = "grid"

    def first_dt(self, problem: Problem, setting: float) -> float:
        return setting

    def ends(self, problem: Problem, setting: float) -> Floats:
        return np.array(step_counts(problem.elapsed, setting), dtype=np.float64)


class Leapfrog(FixedSteps):
    """Drift, kick, drift. Symplectic. Rein and Liu, Astron. Astrophys. 537 (2012) A128."""

    name, engine, order = "leapfrog", "leapfrog", 2
    sweep = Steps(0.5, 14)
    conserves = ("symplectic", "reversible", "momentum")


class WHFast(FixedSteps):
    """Wisdom and Holman's splitting. Rein and Tamayo, MNRAS 452 (2015) 376.

    For two bodies the method is exact at any step: its error comes from its solver of Kepler's equation and from
    round-off, which grows with the number of steps, and shows no order. `safe_mode` = 0, as its manual recommends for
    speed, with `synchronize()` before each sample is read.
    """

    name, engine = "WHFast", "whfast"
    sweep = Steps(8.0, 10)
    conserves = ("symplectic", "reversible", "momentum")

    def options(self, setting: float) -> dict[str, Any]:
        return {"safe_mode": 0}


class CorrectedWHFast(WHFast):
    """WHFast with symplectic correctors of order 17. Rein, Tamayo, Brown, MNRAS 489 (2019) 4632.

    The correctors remove the terms of the error that are linear in the masses of the planets, at no cost a step.
    """

    policy = "corrector 17"
    primary = False

    def options(self, setting: float) -> dict[str, Any]:
        return {"safe_mode": 0, "corrector": 17}


class Trace(FixedSteps):
    """Wisdom and Holman's splitting, which close encounters interrupt. Lu, Hernandez, Rein, MNRAS 533 (2024) 3708.

    With its defaults: BS integrates close encounters and pericentre passages. The first body is the star.
    """

    name, engine = "TRACE", "trace"
    primary = False
    sweep = Steps(8.0, 10)


class IAS15(Native):
    """Everhart's Gauss-Radau method with adaptive steps. Order 15. Rein and Spiegel, MNRAS 446 (2015) 1424.

    The setting is `epsilon`, default 1e-9: not an error but the size of the last term of the acceleration's series,
    whose seventh root the step follows. With the default the error is round-off, and the manual advises to keep it.
    Above 1e-3 its predictor does not converge, and on close approaches (e = 0.999999) it may never end.
    """

    name, engine, order = "IAS15", "ias15", 15
    sampling = "stops at samples"
    sweep = Tolerance(1e-3, 1e-12, name="epsilon")

    def options(self, setting: float) -> dict[str, Any]:
        return {"epsilon": setting}


class BulirschStoer(Native):
    """Gragg, Bulirsch and Stoer's extrapolation, step and order adaptive. Hairer, Norsett, Wanner (1993), II.9.

    The setting is `eps_rel`; `eps_abs` equals it, as in the defaults (1e-8 both).
    """

    name, engine = "BS", "bs"
    sampling = "stops at samples"
    sweep = Tolerance(1e-3, 1e-13)

    def options(self, setting: float) -> dict[str, Any]:
        return {"eps_rel": setting, "eps_abs": setting}


def step_counts(times: Floats, step: float) -> list[int]:
    """The numbers of steps from one sample to the next. Raises Refused if a time is not a multiple of the step."""
    ends = np.rint(times / step) if step > 0 else np.zeros_like(times)
    if not np.allclose(ends * step, times, rtol=4 * np.finfo(float).eps, atol=0):
        raise Refused(
            f"a step of {step:.17g} s does not divide the sampling interval of {times[0]:.17g} s; "
            "give the interval over a power of two"
        )
    return [int(count) for count in np.diff(ends, prepend=0)]


def bodies_of(simulation: Any) -> tuple[Layout, Floats]:
    """Positions and velocities of all bodies in REBOUND's own memory: their place, and a view (n, 6) of them.

    The view is valid until a body is added.
    """
    from rebound.particle import Particle

    size = ctypes.sizeof(ctypes.c_double)
    width, first = ctypes.sizeof(Particle) // size, Particle.x.offset // size
    place = ctypes.addressof(simulation) + type(simulation)._particles.offset
    numbers = ctypes.cast(simulation._particles, ctypes.POINTER(ctypes.c_double))
    return Layout(place, width, first), np.ctypeslib.as_array(numbers, (simulation.N, width))[:, first : first + 6]


INTEGRATORS: tuple[type[Integrator], ...] = (Leapfrog, WHFast, CorrectedWHFast, Trace, IAS15, BulirschStoer)
