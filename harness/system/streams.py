"""Standard input, output and error of a process that was started without them, as by a daemon or by `2>&-`."""

import os
import sys


def open_standard_streams() -> None:
    """Open closed standard streams on the null device, here and for processes that this one starts.

    Otherwise the next file that is opened gets the number of the closed stream, and the output of libraries is written
    into it.
    """
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        try:
            os.fstat(number)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)  # the lowest number that is free: this one
            if getattr(sys, name) is None:
                mode = "w" if number else "r"
                stream = os.fdopen(number, mode, encoding="utf-8", errors="backslashreplace", closefd=False)
                setattr(sys, name, stream)


def has_terminal() -> bool:
    """Whether standard error is a terminal; Python has no such stream in a process that was started without it."""
    return sys.stderr is not None and sys.stderr.isatty()


def redirect_output(path: str) -> None:
    """Redirect standard output and error of this process to a file."""
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_APPEND)
    os.dup2(descriptor, 1)
    os.dup2(descriptor, 2)
    os.close(descriptor)
