"""The command line as a function, for tests."""

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
