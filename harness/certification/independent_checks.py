"""Independent computations of checks: common numerical routines for the same quantities, with their errors and times.

A computation gets the parameters rounded to binary64, and is compared with the closed form of these rounded parameters.
Its error is relative to the size of the quantity (of a vector or a tensor, to its largest component).
"""

import importlib.util
import math
import statistics
import timeit
import warnings
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from gnomon.cases import check_names, get_check
from gnomon.cases.core.check import Check
from gnomon.harness.certification.independent import IndependentComputation
from gnomon.harness.contract.integrator import Unsupported
from gnomon.harness.contract.status import Status
from gnomon.harness.registry import environment
from gnomon.harness.results import study_file
from gnomon.reference.numerics.precision import working

REPEATS = 5
INACCURATE = 0.1
COLUMNS = ("check", "variant", "computation", "library", "quantity", "error", "seconds", "status", "reason")

SUBJECTS = ("inertia", "bodies", "rigid", "fields", "frames", "particles")
COMPUTATIONS = tuple(
    item
    for subject in SUBJECTS
    for item in vars(importlib.import_module(f"gnomon.harness.certification.independent_{subject}")).values()
    if isinstance(item, IndependentComputation)
)


def run_checks(
    chosen: Iterable[Check] | None = None,
    computations: Iterable[IndependentComputation] = COMPUTATIONS,
    repeats: int = REPEATS,
) -> list[dict[str, Any]]:
    """Compare each check (all with their variants for None) with the independent computations declared for it.

    A dict for each quantity, with the names COLUMNS; `seconds` is the median of `repeats` calls, each of which computes
    all quantities of the computation. A failure is a row with its status: `refused` (it does not accept the numbers,
    with the reason), `crashed` (it raised), `inaccurate` (error above 0.1), `diverged` (not finite), `not_installed`.
    """
    rows = []
    for check in everything() if chosen is None else chosen:
        rounded = check.rounded()
        for computation in computations:
            if computation.check == check.name:
                rows += _measure(rounded, computation, repeats)
    return [dict(zip(COLUMNS, row, strict=True)) for row in rows]


def everything() -> list[Check]:
    """All checks, each with all its variants."""
    checks = []
    for name in check_names():
        default = get_check(name)
        checks += [default, *(get_check(name, variant.name) for variant in default.variants)]
    return checks


def write(rows: Iterable[Mapping[str, Any]], path: Path) -> None:
    """Write the rows as JSON for the report, with the environment of their measurement."""
    study_file.write({"environment": environment.record(), "rows": [*rows]}, path)


def _measure(check: Check, computation: IndependentComputation, repeats: int) -> list[tuple[Any, ...]]:
    subject = check.name, check.variant or "default", computation.name, computation.library

    def row(*measured: Any, status: Status = Status.OK, reason: str = "") -> tuple[Any, ...]:
        """Values of COLUMNS; `measured` holds quantity, error and seconds, or is empty."""
        return (*subject, *(measured or ("", None, None)), status, reason)

    if importlib.util.find_spec(computation.library) is None:
        return [row(status=Status.NOT_INSTALLED, reason=f"{computation.library} is not installed")]
    numbers = {name: float(value) for name, value in check.parameters.items()}
    try:
        # Warnings of libraries are suppressed, as the error shows their cause.
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            quantities = computation.compute(numbers)
            seconds = statistics.median(timeit.repeat(lambda: computation.compute(numbers), repeat=repeats, number=1))
    except Unsupported as refusal:
        return [row(status=Status.REFUSED, reason=str(refusal))]
    except Exception as failure:  # an exception of a library is a result
        return [row(status=Status.CRASHED, reason=f"{type(failure).__name__}: {failure}")]
    rows = []
    for name, error in errors(check, quantities).items():
        if error != error:
            rows.append(row(name, None, seconds, status=Status.DIVERGED, reason="not finite"))
        elif error > INACCURATE:
            rows.append(row(name, error, seconds, status=Status.INACCURATE, reason=f"an error above {INACCURATE}"))
        else:
            rows.append(row(name, error, seconds))
    return rows


def errors(check: Check, quantities: Mapping[str, Any]) -> dict[str, float]:
    """The error of each quantity in `quantities`, the largest over its components; nan if a number is not finite."""
    reference = check.exact(30)
    sizes = check.sizes(reference)
    worst: dict[str, float] = {}
    with working(40) as mp:
        for quantity, value in quantities.items():
            names = [name for name in reference if name.partition(".")[0] == quantity]
            numbers = np.ravel(value).tolist()
            if not np.isfinite(numbers).all():
                worst[quantity] = math.nan
                continue
            pairs = zip(names, map(mp.mpf, numbers), strict=True)
            worst[quantity] = max(float(abs(x - mp.mpf(reference[name])) / mp.mpf(sizes[name])) for name, x in pairs)
    return worst
