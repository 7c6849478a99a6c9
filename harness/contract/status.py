"""What became of a trial: the one word of each measurement, the same in memory, in results files and on the page."""

from enum import StrEnum


class Status(StrEnum):
    """A member is a `str`, equal to its word. The page lists them in this sequence; `MEANINGS` there explains each."""

    OK = "ok"
    INACCURATE = "inaccurate"
    DIVERGED = "diverged"
    REFUSED = "refused"
    TIMEOUT = "timeout"
    CRASHED = "crashed"
    OUT_OF_MEMORY = "out_of_memory"
    INTERRUPTED = "interrupted"
    SKIPPED = "skipped"
    UNSUPPORTED = "unsupported"
    NOT_INSTALLED = "not_installed"


SCORED = (Status.OK, Status.INACCURATE, Status.DIVERGED)
"""The integrator answered, so that the trial has an error; from the best to the worst."""
STOPPED = (Status.TIMEOUT, Status.SKIPPED)
"""The time limit ended the trial or kept it from starting: a run with a higher limit repeats it."""
NOT_BROKEN = (Status.OK, Status.SKIPPED, Status.INTERRUPTED)
"""The integrator did not fail: it answered well, was not started, or was ended from outside."""
CANNOT_RUN = (Status.UNSUPPORTED, Status.NOT_INSTALLED)
"""The pair of case and integrator cannot run on this machine: it has one row, without a setting."""
AGAIN = "times before"
"""The end of the reason of a trial that crashed because it was interrupted again and again. Results files hold this text: it
must not change."""


def from_outside(status: str, reason: object) -> bool:
    """Whether a cause outside the integrator may have ended a trial: the memory that it was allowed or, again and again, a
    signal, a full disk or the loss of the server of the workers."""
    return status == Status.OUT_OF_MEMORY or (status == Status.CRASHED and str(reason).endswith(AGAIN))
