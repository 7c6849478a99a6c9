"""Without the parts of Python that only Linux and macOS have, every module imports and commands work or say what is missing."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import gnomon
from gnomon.harness.commands import options
from gnomon.harness.system import limitations
from gnomon.reference.storage import cachefolder

WITHOUT = """
import importlib, os, pkgutil, shutil, signal, sys
from pathlib import Path
import gnomon.cases
import gnomon.harness
import gnomon.reference

MODULES = ("resource", "fcntl", "pwd", "grp", "termios", "tty", "pty", "syslog", "readline")
NAMES = {
    os: "fork forkpty register_at_fork getuid geteuid getgid getegid getpgid setpgid setsid killpg sysconf"
    " wait4 WIFSIGNALED WTERMSIG O_NOFOLLOW O_DIRECTORY O_CLOEXEC O_NONBLOCK set_blocking sched_getaffinity mkfifo nice",
    signal: "SIGKILL SIGHUP SIGQUIT SIGALRM SIGCHLD SIGXCPU pthread_sigmask alarm setitimer pause",
}
# The server of worker processes alone imports `preload`, which redirects the output, and methods of JAX alone `jax_calls`.
OURS = [
    one.name
    for package in (gnomon.reference, gnomon.cases, gnomon.harness)
    for one in pkgutil.walk_packages(package.__path__, f"{package.__name__}.")
    if not one.name.endswith((".preload", ".jax_calls"))
]


class Blocked:
    def find_spec(self, name, path=None, target=None):
        if name in MODULES:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)


def import_all():
    for name in OURS:
        importlib.import_module(name)


import_all()  # libraries are loaded as they are: only gnomon is tested
shutil.which = lambda *name, **how: None  # Windows has none of the programs that libraries look for here
sys.meta_path.insert(0, Blocked())
for module, names in NAMES.items():
    for name in names.split():
        delattr(module, name)
os.supports_dir_fd = set()
for platform in ("darwin", "win32"):
    sys.platform = platform
    for name in [name for name in sys.modules if name in MODULES or name.partition(".")[0] == "gnomon"]:
        del sys.modules[name]
    import_all()
print(len(OURS), "modules", flush=True)

from gnomon.harness.commands import cli

for line in sys.argv[1:]:
    sys.argv = line.split()
    try:
        cli.main()
    except SystemExit as end:
        print("exit code", end.code, flush=True)
"""


def test_without_what_windows_lacks_every_module_imports_and_only_integrators_do_not_run(tmp_path: Path) -> None:
    commands = [
        "gnomon doctor",
        "gnomon exact projectile_parabola --times 1",
        "gnomon run --case pendulum_simple --out x",
    ]
    run = subprocess.run(
        [sys.executable, "-c", WITHOUT, *commands],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        env=os.environ | {"COLUMNS": "300"},
        check=False,
    )
    assert run.returncode == 0, run.stderr
    assert int(run.stdout.split()[0]) > 300
    codes = [line for line in run.stdout.splitlines() if line.startswith("exit code")]
    assert codes == ["exit code 0", "exit code 0", "exit code 2"], run.stdout + run.stderr
    assert "none, they need fork: no `gnomon run` and no `gnomon verify`" in run.stdout
    assert "none, as no folder can be verified" in run.stdout
    assert "forked processes, which win32 does not have; use Linux, macOS or WSL" in run.stderr
    assert "Traceback" not in run.stderr


def test_doctor_names_what_macos_cannot_do_in_a_line_each(
    monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(options.out, "width", 300)
    assert limitations.limitations() == {}
    assert gnomon("doctor") == 0
    assert "memory limit of trials" not in capfd.readouterr().out
    monkeypatch.setattr(limitations.sys, "platform", "darwin")
    found = limitations.limitations()
    assert list(found) == [
        "memory limit of trials",
        "processes of an integrator",
        "waits for the processor",
        "processor time of an integrator",
    ]
    assert gnomon("doctor") == 0
    lines = capfd.readouterr().out.splitlines()
    for what, consequence in found.items():
        assert any(what in line and consequence in line for line in lines)


def test_without_a_folder_that_can_be_verified_nothing_is_kept_or_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, recwarn: pytest.WarningsRecorder
) -> None:
    """Code and numbers from files that another user could have written would be trusted."""
    cachefolder.store(tmp_path / "before", "name", b"content")
    monkeypatch.setattr(cachefolder, "KEEPS", False)
    assert cachefolder.load(tmp_path / "before", "name") is None
    cachefolder.prepare(tmp_path / "after")
    cachefolder.store_or_warn(tmp_path / "after", "name", b"content")
    assert [path.name for path in tmp_path.iterdir()] == ["before"]
    assert not recwarn.list
