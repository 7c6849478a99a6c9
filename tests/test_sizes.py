"""The base of gnomon works without its extras, and what needs one names it: the extras are hidden from a process."""

import os
import subprocess
import sys
import tomllib
from pathlib import Path
from typing import Any

import pytest
import synthetic
from gnomon.harness.adapters.libraries import LIBRARIES
from gnomon.harness.system import extras

ROOT = Path(__file__).parents[1]
PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
HIDDEN = {name for names in extras.EXTRAS.values() for name in names} | {
    *("hypothesis", "pytest_benchmark", "rebound", "pybullet", "heyoka", "sksundae", "diffrax", "jax")
}
PROGRAM = f"""
import sys

class Without:
    "Finds what another finder finds, but for the hidden modules: as if they were not installed."
    def __init__(self, finder): self.finder = finder
    def __getattr__(self, name): return getattr(self.finder, name)
    def find_spec(self, name, *place):
        return None if name.partition(".")[0] in {HIDDEN} else self.finder.find_spec(name, *place)

sys.meta_path[:] = map(Without, sys.meta_path)
from gnomon.harness.commands import cli

for line in sys.stdin.read().splitlines():
    sys.argv = ["gnomon", *line.split()]
    code = 0
    try:
        cli.main()
    except SystemExit as end:
        code = end.code or 0
    print("ended with", code, flush=True)
import gnomon
for needs in (
    lambda: gnomon.verify.parametrize(None), lambda: gnomon.load("run.sqlite"), gnomon.case("pendulum_simple").plot,
):
    try:
        needs()
    except ValueError as error:
        print(error)
solved = gnomon.solve(lambda t, y: [y[1], -y[0]], (0, 1), [1, 0], "scipy:RK45")
compared = gnomon.compare("pendulum_simple", "gnomon:RK4", limit_seconds=300)
assert solved.success and "gnomon:RK4" in str(compared)
assert not {HIDDEN} & set(sys.modules)
"""


def without_extras(folder: Path, *commands: str) -> tuple[list[int], str]:
    """Run commands in one process that finds no extra: their exit codes, and all that they print."""
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM], input="\n".join(commands), cwd=folder, text=True,
        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False, env=os.environ | {"COLUMNS": "300"},
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
    return [int(line.split()[-1]) for line in done.stdout.splitlines() if line.startswith("ended with")], done.stdout


def test_the_base_commands_need_no_extra(tmp_path: Path) -> None:
    synthetic.write(tmp_path / "run.sqlite")
    (tmp_path / "swing.csv").write_text("t,theta,omega\n0,2,0\n0.1,1.955,-0.898\n")
    one = "--case pendulum_simple --integrator gnomon:RK4"
    codes, told = without_extras(
        tmp_path,
        f"run {one} --suite quick --limit 300 --out own.sqlite",
        "compare own.sqlite own.sqlite",
        "export own.sqlite --format csv",
        "export own.sqlite --format json",
        "baseline write gnomon:RK4 --case pendulum_simple --out base.txt",
        "verify gnomon:RK4 --case pendulum_simple --claim order --baseline base.txt",
        "certify com_rigid_body --out certificates.json --independent checks.json",
        "exact pendulum_simple --times 1",
        "check --template pendulum_simple",
        "check swing.csv --case pendulum_simple --within 1",
        "list",
        "show pendulum_simple",
        "doctor",
    )
    assert codes == [0] * 13, told
    assert "pip install 'gnomon[report]', then gnomon report own.sqlite" in told
    assert "parametrize needs the extra test" in told
    assert "a table of results needs the extra report" in told
    assert "a chart needs the extra report" in told


def test_what_needs_an_extra_names_it(tmp_path: Path) -> None:
    """One line, before anything is computed or written."""
    synthetic.write(tmp_path / "run.sqlite")
    for name in ("a.h5", "a.parquet"):
        (tmp_path / name).write_bytes(b"12345678")
    (tmp_path / "swing.csv").write_text("t,theta,omega\n0,2,0\n0.1,1.955,-0.898\n")
    before = {*tmp_path.iterdir()}
    wanted = {
        "report run.sqlite": "report",
        "export run.sqlite --format parquet": "report",
        "show pendulum_simple --plot a.svg": "report",
        "verify gnomon:RK4 --case pendulum_simple --claim order --picture a.svg": "report",
        "run --case pendulum_simple --integrator gnomon:RK4 --report page": "report",
        "run --case pendulum_simple --integrator gnomon:RK4 --dask local": "cluster",
        "run --case pendulum_simple --integrator rebound:IAS15": "nbody",
        "check a.h5 --case pendulum_simple": "files",
        "check a.parquet --case pendulum_simple": "files",
        "verify --fmu swing.csv --case pendulum_simple": "fmu",
        "check swing.csv --case pendulum_simple --picture a.svg": "report",
        "ensemble --case pendulum_simple --integrator gnomon:RK4 --samples 2 --parquet a": "report",
    }
    codes, told = without_extras(tmp_path, *wanted)
    assert codes == [2] * len(wanted), told
    errors = [line for line in told.splitlines() if line.startswith("error:")]
    assert len(errors) == len(wanted)
    for (command, extra), line in zip(wanted.items(), errors, strict=True):
        assert f"pip install 'gnomon[{extra}]'" in line, command
    assert {*tmp_path.iterdir()} - before <= {tmp_path / "runs"}


def test_every_extra_that_is_named_is_declared() -> None:
    declared = PROJECT["optional-dependencies"]
    assert {*extras.EXTRAS, *(one.extra for one in LIBRARIES.values() if one.extra)} <= {*declared}


@pytest.mark.parametrize("extra", sorted(extras.EXTRAS))
def test_all_holds_every_extra_of_the_commands(extra: str) -> None:
    """`all` is what gnomon is built on; `peers` are libraries to compare with, and stay a choice."""
    (everything,) = PROJECT["optional-dependencies"]["all"]
    held = everything.partition("[")[2].strip("]").split(",")
    assert extra in held
    assert {"nbody", "engines"} <= {*held}
    assert "peers" not in held
