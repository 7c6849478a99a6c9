"""The options that an engine's adapter records on the scenes of the suite `engines`."""

from typing import Any

from gnomon.cases import get
from gnomon.harness.adapters.engines.scene_run import SceneIntegrator, SceneRun
from gnomon.harness.contract.declared import declared
from gnomon.harness.contract.integrator import Refused
from gnomon.harness.contract.problem import initial_state, problem_of


def recorded(policy: type[SceneIntegrator]) -> dict[str, Any]:
    """Each option with the value of the last scene that has it."""
    options: dict[str, Any] = {}
    for name in declared("running", "suites.toml")["engines"]["cases"]:
        case = get(*name.split("/")).rounded()
        if case.scene is None or policy().unsupported(case.scene) is not None:
            continue
        try:
            run = policy().prepare(problem_of(case, policy.accepts), float(case.times[0]))
        except Refused:
            continue
        assert isinstance(run, SceneRun)
        run.world.place(run.form.build(tuple(initial_state(case).tolist()), run.parameters))
        options |= run.options
        run.close()
    return options
