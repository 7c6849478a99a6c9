"""`solve`: any integrator that gnomon knows, on equations of the reader's own."""

import math
from collections.abc import Callable, Sequence

import numpy as np
from gnomon.cases.core.arithmetic import calling
from gnomon.cases.core.forms import FirstOrder, Form, SecondOrder, Values, first_order
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Refused
from gnomon.harness.contract.problem import first_taken
from gnomon.harness.kernels.compiling import shown
from gnomon.harness.measuring.prepared import Prepared
from gnomon.harness.registry import lookup


def solve(
    f: Callable[..., Values] | Form,
    t0: float,
    y0: Sequence[float] | Floats,
    times: Sequence[float] | Floats,
    tolerance: float,
    method: str | Integrator = "gnomon:DOP853",
    *,
    parameters: Sequence[float] = (),
    accelerations: bool = False,
) -> Floats:
    """Solve an initial value problem with any integrator that gnomon knows.

    Parameters
    ----------
    f : callable or Form
        ``f(t, y)`` returns the derivatives as a tuple of plain arithmetic on the tuple y and functions of `math`,
        without branches: it is compiled. With `accelerations` it is ``f(t, q)``; with `parameters` it has the further
        argument p. A form of `gnomon.cases.core.forms` states rigid bodies, gravitating bodies or events.
    t0 : float
        The start time.
    y0 : array_like, shape (dim,)
        The state at `t0`; with `accelerations` (q..., q'...).
    times : array_like, shape (n,)
        Times after `t0`, increasing.
    tolerance : float
        The relative tolerance; for a method of fixed steps the step size, which is shortened so that steps end at the
        times.
    method : str or Integrator
        A name from `gnomon list integrators`, or an integrator.
    parameters : array_like
        The numbers p; other numbers do not compile f again.
    accelerations : bool
        Whether f returns accelerations, for methods that solve q'' = a(t, q).

    Returns
    -------
    ndarray, shape (n, dim)
        The states at `times`.

    Raises
    ------
    Refused
        If the method declines or gives up.
    ValueError
        For a wrong argument.

    Examples
    --------
    >>> from gnomon.harness import solve
    >>> def oscillator(t, y):
    ...     return y[1], -y[0]
    >>> solve(oscillator, 0.0, [1.0, 0.0], [1.0, 2.0], 1e-9).shape
    (2, 2)
    """
    start, at = np.array(y0, dtype=np.float64), np.array(times, dtype=np.float64)
    if start.ndim != 1 or not len(start) or not np.all(np.isfinite(start)) or (accelerations and len(start) % 2):
        raise ValueError(f"y0={y0!r}: give finite numbers, {'q and then q' if accelerations else 'one a component'}")
    if at.ndim != 1 or not len(at) or not np.all(np.isfinite(at)) or np.any(np.diff(at, prepend=t0) <= 0):
        raise ValueError(f"times={times!r}: give finite times that increase and are after t0={t0:g}")
    if not 0 < tolerance < math.inf:
        raise ValueError(f"tolerance={tolerance!r}: give a positive number")
    integrator = lookup.find_one(method) if isinstance(method, str) else method
    span = float(at[-1] - t0)
    numbers = np.array(parameters, dtype=np.float64)
    form = _form(f, bool(len(numbers)), accelerations, integrator)
    problem = Problem(form, len(start), numbers, at, span / len(at), t0=float(t0))
    with shown(integrator.id), Prepared(integrator, problem, float(tolerance)) as solver:
        found = solver(start[None])
    if found.stopped is not None:
        raise Refused(f"{integrator.id}: {found.stopped}")
    states: Floats = found.states[0]
    return states


def _form(f: Callable[..., Values] | Form, with_parameters: bool, accelerations: bool, integrator: Integrator) -> Form:
    """The most structured form of `f` that the integrator accepts."""
    if isinstance(f, Form):
        own: Form = f
    else:
        equations = f if with_parameters else calling(f, "t, state", "alone")
        own = SecondOrder(equations) if accelerations else FirstOrder(equations)
    form: Form | None = first_taken(integrator, (own, first_order(own)))
    if form is not None:
        return form
    needs = " or ".join(kind.__name__ for kind in integrator.accepts)
    raise ValueError(f"{integrator.id} needs equations as {needs}; see `gnomon list integrators`")
