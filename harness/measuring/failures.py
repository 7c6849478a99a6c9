"""The status of a trial that an exception ended, in a worker, in an ensemble, in a panel or in a baseline."""

import errno

from gnomon.harness.contract.integrator import Refused, Unsupported
from gnomon.harness.contract.status import Status
from gnomon.harness.contract.validation import TEXT, Unusable


def status_of(error: BaseException, memory_bytes: int | None = None) -> tuple[Status, str]:
    """The status and the reason of a trial that an exception ended; `memory_bytes`: the memory that it was allowed."""
    if isinstance(error, Unusable):
        return Status.CRASHED, str(error)
    if isinstance(error, Unsupported):
        return Status.UNSUPPORTED, str(error) or "lacks something that the problem needs, and does not name it"
    if isinstance(error, Refused):
        return Status.REFUSED, str(error) or "declined without a reason"
    if isinstance(error, ModuleNotFoundError):
        return Status.NOT_INSTALLED, str(error)
    if isinstance(error, OSError) and error.errno in (errno.ENOSPC, errno.EDQUOT):
        return Status.INTERRUPTED, f"the disk is full ({error.filename or error.strerror})"
    text = str(error).strip().replace("\n", " ")
    if isinstance(error, MemoryError):
        allowed = "there is" if memory_bytes is None else f"{memory_bytes / 2**30:.3g} GiB"
        return Status.OUT_OF_MEMORY, f"needed more than {allowed} ({text[:TEXT]})"
    return Status.CRASHED, f"{type(error).__name__}: {text[:TEXT]}" if text else type(error).__name__
