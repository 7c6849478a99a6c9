"""The exact motion at the samples of a shorter span, kept on disk: every integrator that is verified on a case needs it."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import astuple

import numpy as np
from gnomon.cases import Case
from gnomon.harness.measuring import growth
from gnomon.harness.measuring.reference_solution import CaseSpec
from gnomon.reference.storage import diskcache
from gnomon.reference.storage.import_closure import closure
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def exact_states(case: Case, times: Floats) -> Floats:
    """The exact states (n, dim) at the times (n,), as `Case.sample`."""
    return _keep_array(case, ["exact states", times.tolist()], lambda: case.sample(times))


def error_growth(case: Case, times: Floats, sizes: Floats) -> Floats | None:
    """The largest growth of an error to each time, as `growth.growth`; None where that gives None."""

    def build() -> Floats:
        largest = growth.growth(case, times, sizes)
        return np.empty(0) if largest is None else largest

    largest = _keep_array(case, ["growth", times.tolist(), sizes.tolist()], build)
    return largest if len(largest) else None


def _keep_array(case: Case, asked: list[object], build: Callable[[], Floats]) -> Floats:
    """The array from the disk, unless a source of the case, of its exact motion or of the growth changed."""
    spec = CaseSpec.of(case)
    code, own = closure(spec.path.partition(":")[0]), closure(growth.__name__, within=())
    if code is None or own is None:
        return build()
    key = f"shorter span 1\n{code}{own}\n{json.dumps([*astuple(spec), *asked])}"
    return diskcache.cached(key, lambda: diskcache.Entry({"found": build()})).arrays["found"]
