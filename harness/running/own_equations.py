"""The lines of Python that run an integrator on equations like a reader's own, for each form that integrators accept."""

from gnomon.cases.core.forms import Charged
from gnomon.cases.core.scene import SceneForm
from gnomon.harness.contract.integrator import Integrator, Tolerance
from gnomon.harness.results.advice.code_lines import METHOD, SETTING, choose_system, code_of

TOLERANCE = 1e-9
SLOW = Charged(lambda t, state, p: (), fields=lambda t, place, p: ())
"""The form of a slow charge, which a method for relativistic charges declines."""


def form_names(integrator: Integrator) -> list[str]:
    """The names of the forms that an integrator accepts, as `systems.toml` has them; none for an engine."""
    relativistic = Charged in integrator.accepts and integrator.unsupported(SLOW) is not None
    names = ["Relativistic" if kind is Charged and relativistic else kind.__name__ for kind in integrator.accepts]
    return [name for name in names if name != SceneForm.__name__]


def lines(integrator: Integrator, setting: str | None = None, subject: str | None = None) -> str | None:
    """The lines for an integrator; None for an engine, which takes a scene in place of equations.

    `setting`: the argument of `gnomon.solve` for the accuracy, as rtol=1e-9 or epsilon=1e-9; by default a usual one. `subject`: the key
    of a subject of needs.toml, of whose systems the lines run one.
    """
    system = choose_system(form_names(integrator), subject)
    if system is None:
        return None
    sweep = integrator.sweep
    usual = "step=2**-7"
    if isinstance(sweep, Tolerance):
        usual = f"{sweep.name}={min(max(TOLERANCE, sweep.tightest), sweep.loosest):g}"
    return code_of(system).replace(METHOD, integrator.id).replace(SETTING, setting or usual)
