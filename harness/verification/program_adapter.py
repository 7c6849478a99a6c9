"""An integrator that is a program in any language: it reads problems and writes states, one a line.

`protocol` defines the lines, docs/any_language.md explains them. One process of the program serves all trials of a
series. A time limit ends it together with the worker process that started it. The time to exchange lines is part of the
null call of the series (see `measuring.null_call`).
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import shlex
import shutil
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from gnomon.harness.contract.integrator import Floats, Integrator, Problem, Solution, Solver
from gnomon.harness.contract.validation import Unusable
from gnomon.harness.registry import declaration
from gnomon.harness.verification import protocol
from gnomon.harness.verification.program_process import DESCRIBE_SECONDS, NOTICE_SECONDS, ProgramProcess

_running: dict[tuple[Sequence[str], str], ProgramProcess] = {}
"""The programs of this process, by command and folder."""


class ProgramIntegrator(Integrator):
    """An integrator that is a program, with the declarations of the program's description."""

    library = "command"

    def __init__(self, command: Sequence[str], folder: str, described: str, seconds: float | None = None) -> None:
        self.command, self.folder, self.described, self.seconds = tuple(command), folder, described, seconds
        description = protocol.description(described)
        declared: dict[str, Any] = {
            "name": description.name,
            "order": description.order,
            "sampling": description.sampling,
            "sweep": description.sweep,
            "counts_rhs": description.counts_rhs,
            "conserves": description.conserves,
            "jacobian": description.jacobian,
            "accepts": tuple(protocol.FORMS[form] for form in description.forms),
        }
        self.__dict__.update(declared)
        self._version = description.version

    def versions(self) -> Mapping[str, Any]:
        """The version that the program declares, and a hash of the files that its command names."""
        content = hashlib.sha256(self.described.encode())
        for word in self.command:
            content.update(word.encode())
            with contextlib.suppress(OSError, ValueError):  # not every word is a file
                content.update(Path(self.folder, word).read_bytes())
        return {"program": self._version, "files": content.hexdigest()[:32]}

    def prepare(self, problem: Problem, setting: float) -> Solver:
        """Start the program if it does not run, and write the text of the problem."""
        parts = protocol.problem_parts(problem, self.sweep.kind, setting)
        shape = (len(problem.times), problem.dimension)
        self._program()
        numbers = iter(range(1, 2**62))

        def solve(initial_states: Floats) -> Solution:
            states = np.empty((len(initial_states), *shape))
            steps, stopped = 0, None
            counted = True
            for k, start in enumerate(initial_states):
                program, number = self._program(), next(numbers)
                line = program.ask(protocol.problem_line(parts, number, start), self.seconds)
                reply = protocol.reply(line, number, shape)
                if self.counts_rhs:
                    if reply.rhs_calls is None:
                        raise Unusable("wrote no rhs_calls, which it declares to count")
                    problem.buffer[-1] += reply.rhs_calls
                states[k], stopped = reply.states, reply.stopped or stopped
                counted = counted and reply.steps is not None
                steps += reply.steps or 0
            return Solution(states, steps if counted else None, stopped)

        return Solver(solve)

    def _program(self) -> ProgramProcess:
        """The running program. A new one describes itself first, so that it is ready before time is measured."""
        key = (self.command, self.folder)
        running = _running.get(key)
        if running is None or not running.usable:
            if running is not None:
                running.kill()
            running = _running[key] = ProgramProcess(*key)
            line = running.describe()
            if protocol.description(line) != protocol.description(self.described):
                running.kill()
                raise Unusable("describes itself in another way than before; start again")
        return running


def from_command(command: str | Sequence[str], seconds: float | None = None) -> ProgramIntegrator:
    """Make an integrator from a program in any language.

    Parameters
    ----------
    command : str or sequence of str
        A command line, or its words. The program is run once, to describe itself.
    seconds : float, optional
        The limit of processor time (s) for one problem (see `Child.allow`), for use outside a run; in a run, workers have
        their own limits.

    Returns
    -------
    ProgramIntegrator
        The program as an integrator. It starts when it is first prepared for a problem.

    Raises
    ------
    ValueError
        If the program cannot be started or does not describe itself.

    Examples
    --------
    >>> from_command("no_such_program --digits 17")
    Traceback (most recent call last):
    ValueError: --command 'no_such_program --digits 17': no program has this name; give the path of one that can be executed
    """
    shown = command if isinstance(command, str) else shlex.join(command)
    try:
        words = shlex.split(command) if isinstance(command, str) else list(command)
    except ValueError as error:
        raise ValueError(f"--command {shown!r}: {error}") from None
    program = shutil.which(words[0]) if words else None
    if program is None:
        raise ValueError(f"--command {shown!r}: no program has this name; give the path of one that can be executed")
    words[0] = os.path.abspath(program)
    try:
        asked = ProgramProcess(words, os.getcwd())
        described = asked.describe(lambda: warnings.warn(_late(shown), stacklevel=2))
        asked.close()
        integrator = ProgramIntegrator(words, os.getcwd(), described, seconds)
    except TimeoutError as over:
        raise ValueError(f"--command {shown!r}: does not describe itself: {over}") from None
    except Unusable as error:
        raise ValueError(f"--command {shown!r}: asked to describe itself, {error}") from None
    declaration.validate(integrator, f"--command {shown!r}")
    return integrator


def _late(shown: str) -> str:
    return (
        f"--command {shown!r}: has not described itself in {NOTICE_SECONDS:g} s, and has {DESCRIBE_SECONDS:g} s; it answers"
        f" {protocol.describe_line()} with one line"
    )
