"""The command line as a function, and the numbers that it prints, for tests."""

import re
import sys

from gnomon.harness.commands import cli


def gnomon(*arguments: str) -> int:
    """Run the command line in this process and return its exit code."""
    before, sys.argv = sys.argv, ["gnomon", *arguments]
    try:
        cli.main()
    except SystemExit as end:
        return int(end.code or 0)
    finally:
        sys.argv = before
    return 0


def numbers_in(text: str) -> list[str]:
    """The numbers of a text, as they are printed, so that a test holds these and leaves the words free."""
    return re.findall(r"(?<![\w.:])\d+(?:\.\d+)?(?:e-?\d+)?", text)
