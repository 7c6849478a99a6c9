"""The first use of an integrator: import of its library, preparation, first call, in a new process with empty caches.

Later preparations find the library in the process, and compiled code on disk (in-house methods, compiled equations) or
in the process (JAX); some libraries compile at each preparation (heyoka).
"""

import os
import pickle
import subprocess
import sys
import tempfile
from contextlib import suppress
from pathlib import Path
from time import perf_counter_ns

from gnomon.harness.contract.problem import initial_state, problem_of
from gnomon.harness.measuring.prepared import Prepared
from gnomon.harness.measuring.reference_solution import CaseSpec
from gnomon.harness.registry.references import Reference, dereference
from gnomon.harness.system.child_process import rely_on_guard, run_delays

MOST_SECONDS = 50.0
"""Below the deadline of a preparation: a longer first use is not measured, and the trial keeps its outcome."""
CACHES = ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME", "JAX_COMPILATION_CACHE_DIR")
"""The environment variables that name the folders of compiled code."""


def first_seconds(integrator: Reference, spec: CaseSpec, setting: float, folder: Path) -> float | None:
    """Seconds of the first use; None if the new process fails or takes longer than MOST_SECONDS.

    `integrator` is a reference (see `registry.references`). The empty caches are in a new folder in `folder`.
    """
    with tempfile.TemporaryDirectory(dir=folder) as empty, suppress(OSError, subprocess.SubprocessError, ValueError):
        places = {name: str(Path(empty) / name) for name in CACHES}
        paths = {"PYTHONPATH": os.pathsep.join(path or os.getcwd() for path in sys.path)}
        process = subprocess.run(
            [sys.executable, "-m", __name__],
            input=pickle.dumps((integrator, spec, setting)),
            env=os.environ | places | paths,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            timeout=MOST_SECONDS,
            check=True,
        )
        return float(process.stdout.split()[-1])
    return None


def measure_first_use(reference: Reference, spec: CaseSpec, setting: float) -> float:
    """Seconds of the first use, in this process, without the waits of its main thread for a processor."""
    case, formulation = spec.build()
    start = initial_state(case, formulation)[None]
    began, delay = perf_counter_ns(), _delay()
    integrator = dereference(reference)
    Prepared(integrator, problem_of(case, integrator.accepts, formulation), setting)(start)
    return (perf_counter_ns() - began - (_delay() - delay)) * 1e-9


def _delay() -> int:
    """Nanoseconds that the main thread was ready to run while others had the processor; 0 if unknown."""
    return (run_delays() or {}).get(str(os.getpid()), 0)


if __name__ == "__main__":
    rely_on_guard()  # on the guard of the worker that measures it
    print(measure_first_use(*pickle.load(sys.stdin.buffer)))
