"""A Dask scheduler and its workers as processes of their own, on the loopback address."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from types import TracebackType

from waiting import LIMIT_SECONDS, wait_until

HELPERS = str(Path(__file__).parent)


class Processes:
    """Started in a `with` block, and all killed at its end."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.started: list[subprocess.Popen[bytes]] = []
        self.files = 0

    def scheduler(self) -> tuple[str, subprocess.Popen[bytes]]:
        """A new scheduler: its address and its process."""
        self.files += 1
        file = self.folder / f"scheduler_{self.files}.json"
        process = self._start("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(file))

        def written() -> bool:
            assert process.poll() is None, "the scheduler ended"
            return file.exists() and file.read_text().rstrip().endswith("}")

        wait_until(written, "a scheduler", LIMIT_SECONDS)
        return str(json.loads(file.read_text())["address"]), process

    def worker(self, address: str, *options: str) -> subprocess.Popen[bytes]:
        """A new worker process, which ends with its scheduler."""
        fixed = ("--nthreads", "1", "--no-nanny", "--death-timeout", "60", "--local-directory", str(self.folder))
        return self._start("dask_worker", address, "--host", "127.0.0.1", *fixed, *options)

    def _start(self, program: str, *options: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", f"distributed.cli.{program}", "--no-dashboard", *options]
        environment = os.environ | {"PYTHONPATH": HELPERS}
        quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
        process = subprocess.Popen(command, env=environment, cwd=self.folder, **quiet)  # type: ignore[call-overload]
        self.started.append(process)
        return process  # type: ignore[no-any-return]

    def __enter__(self) -> Processes:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for process in self.started:
            process.kill()
            process.wait()


def connected(address: str, workers: int) -> None:
    """Wait until a scheduler has this number of workers."""
    from distributed import Client

    with Client(address, set_as_default=False) as client:
        client.wait_for_workers(workers, timeout=LIMIT_SECONDS)
