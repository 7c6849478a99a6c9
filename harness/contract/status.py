"""The status of a trial: one word for each measurement, in memory, in results files and on the page."""

from enum import StrEnum


class Status(StrEnum):
    """The statuses of trials. A member is a `str`, equal to its word.

    The page lists them in this sequence and explains each in `MEANINGS`.
    """

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
"""Statuses of trials with an error, as the integrator answered; from the best to the worst."""
STOPPED = (Status.TIMEOUT, Status.SKIPPED)
"""Statuses of trials that the time limit ended or kept from starting: a run with a higher limit repeats them."""
NOT_BROKEN = (Status.OK, Status.SKIPPED, Status.INTERRUPTED)
"""Statuses of trials in which the integrator did not fail: it answered, did not start, or was ended from outside."""
CANNOT_RUN = (Status.UNSUPPORTED, Status.NOT_INSTALLED)
"""Statuses of pairs of case and integrator that cannot run on this machine: each has one row, without a setting."""
AGAIN = "times before"
"""The last words of the reason of a trial that crashed because it was interrupted again and again. Results files hold
this text, so it must not change."""

TRIES = 3
"""Number of attempts at a trial with a short limit before it is a timeout: a stall of the machine is not a timeout."""
THROUGHOUT = ", in which it ran all the time"
"""The end of the reason of a timeout in which the machine did not stall, which then needs one try. Results files hold it."""


def is_from_outside(status: str, reason: object) -> bool:
    """Whether a cause outside the integrator may have ended a trial.

    Such causes are the limit of its memory or, again and again, a signal, a full disk, or the loss of the server of the
    workers.
    """
    return status == Status.OUT_OF_MEMORY or (status == Status.CRASHED and str(reason).endswith(AGAIN))


def is_certain_timeout(status: str, reason: object, tries: int) -> bool:
    """Whether a trial timed out, and not because the machine stalled."""
    return status == Status.TIMEOUT and (tries >= TRIES or str(reason).endswith(THROUGHOUT))
