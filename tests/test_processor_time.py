"""The processor time of tests is summed by file over all workers, with the processes that they started."""

import subprocess
import sys
from pathlib import Path

PLUGINS = Path(__file__).parent / "helpers/plugins"
BUSY = """
import os, subprocess, sys

SPIN = "import os\\nwhile sum(os.times()[:2]) < .7: pass"

def test_here():
    begin = sum(os.times()[:2])
    while sum(os.times()[:2]) < begin + .7: pass

def test_in_a_child():
    subprocess.run([sys.executable, "-c", SPIN], check=True)
"""
CONFTEST = f"""
import sys
sys.path.insert(0, {str(PLUGINS)!r})
import processor_time
processor_time.FROM_SECONDS = 0.0

def pytest_configure(config):
    config.pluginmanager.register(processor_time.ProcessorTime())
"""


def test_of_two_workers(tmp_path: Path) -> None:
    """The test turns until the processor clock says so: the sum is at least 1.4 s, however busy the machine is."""
    (tmp_path / "conftest.py").write_text(CONFTEST)
    (tmp_path / "test_idle.py").write_text("def test_idle(): pass")
    (tmp_path / "test_busy.py").write_text(BUSY)
    command = [sys.executable, "-m", "pytest", "-n", "2", "-p", "no:cacheprovider", "-p", "no:gnomon"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    (line,) = [line for line in done.stdout.splitlines() if line.startswith("processor time: ")]
    assert int(line.split()[2]) >= 1
    names = [part.rpartition(" ")[0].rpartition(" ")[0] for part in line.partition("most in ")[2].split(", ")]
    assert names == ["test_busy.py", "test_idle.py"]
