"""Finds abilities that gnomon uses and this system lacks: on macOS and Windows `gnomon doctor` shows them."""

import os
import sys

from gnomon.reference.storage import cachefolder


def limitations() -> dict[str, str]:
    """The abilities that this system lacks, and the consequence in one line each; empty on Linux."""
    lacking = {}
    if not hasattr(os, "fork"):
        lacking["worker processes"] = "none, they need fork: no `gnomon run` and no `gnomon verify`; use WSL"
    elif sys.platform != "linux":
        lacking["memory limit of trials"] = "none: the system enforces no limit of the address space (RLIMIT_AS)"
        lacking["processes of an integrator"] = (
            "not killed if they leave the process group of their worker; programs of --command not if started before the run"
        )
        lacking["waits for the processor"] = "not measured: on a busy machine they count towards time limits"
        lacking["processor time of an integrator"] = (
            "not measured by `gnomon verify`: a hang ends after ten times its limit"
        )
    if not cachefolder.KEEPS:
        lacking["kept results"] = "none, as no folder can be verified: each process computes and compiles anew"
    return lacking


def need_fork() -> None:
    """Raise ValueError on a system that cannot fork processes."""
    if not hasattr(os, "fork"):
        raise ValueError(
            f"integrators run in forked processes, which {sys.platform} does not have; use Linux, macOS or WSL"
        )
