"""The outcome of a trial before it is scored: a worker sends it and the scorer reads it."""

from dataclasses import dataclass, field

from gnomon.harness.contract.integrator import Floats

DELAYED = 0.02
"""A call that waits for a processor for more than this share of its time is repeated, and marked if it waits again."""


@dataclass
class Outcome:
    """The measurements of a trial. `states` (64, dim_y): the solution from the exact initial state, unperturbed.

    `turned` (n, 64, dim_y) are the solutions from the turned starts, None if they were not requested. Times are in
    seconds; `seconds` are the times of the timed calls. results/schema.toml explains the other fields.
    """

    states: Floats
    stopped: str | None
    events: tuple[tuple[float, str], ...] | None
    steps: int | None
    rhs_calls: int | None
    seconds: tuple[float, ...]
    prepare_seconds: float
    reset_seconds: float | None
    options: dict[str, str] = field(default_factory=dict)
    output: str = ""
    null_seconds: float | None = None
    null_work: int | None = None
    turned: Floats | None = None
    delay_seconds: float | None = None
    first_seconds: float | None = None
