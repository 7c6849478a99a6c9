"""The distribution installs in an empty environment without the checkout, is small, and runs; so do the steps in `ci/`."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

ROOT = Path(__file__).parents[1]
VERSIONS = ("3.11", "3.12", "3.13")
MOST_MEGABYTES, MOST_PACKAGES = 500, 25
SHIPPED = ("src", "reference", "cases", "harness", "ci", "pyproject.toml", "README.md", "LICENSE")
MINE = """
from gnomon.verify import from_step

def step(f, t, y, h):
    a = f(t, y)
    b = f(t + h / 2, y + h / 2 * a)
    c = f(t + h / 2, y + h / 2 * b)
    d = f(t + h, y + h * c)
    return y + h / 6 * (a + 2 * b + 2 * c + d)

RK4 = from_step(step, name="RK4", order=4)
"""
FIRST = (
    "run --case pendulum_simple --suite quick --limit 300 --integrator gnomon:DOP853 --integrator scipy:DOP853"
    " --out runs/a.sqlite"
)
SOLVE = """
import importlib.util
import math
import gnomon

found = gnomon.solve(lambda t, y: [y[1], -y[0]], (0, 2), [1, 0], rtol=1e-9)
assert abs(found.y[0, -1] - math.cos(2.0)) < 1e-7
assert "site-packages" in gnomon.__file__
print(gnomon.compare("pendulum_simple", ["gnomon:RK4", "scipy:LSODA"], limit_seconds=300))
print(gnomon.case("kepler_orbit").exact(1.5, 30), gnomon.case("kepler_orbit").equations)
absent = ("pandas", "pyarrow", "altair", "vl_convert", "pytest", "hypothesis", "pybullet", "rebound")
assert [name for name in absent if importlib.util.find_spec(name)] == []
"""


def variables(folder: Path, **more: str) -> dict[str, str]:
    """The environment of a user's process: nothing leads to this checkout, or to its caches."""
    own = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "VIRTUAL_ENV")}
    packages = subprocess.run(
        [sys.executable, "-m", "pip", "cache", "dir"], capture_output=True, text=True, check=False
    )
    caches = {"NUMBA_CACHE_DIR": "numba", "XDG_CACHE_HOME": "cache"}
    own |= {name: str(folder / place) for name, place in caches.items()}
    return own | {"PIP_CACHE_DIR": packages.stdout.strip()} | more


@pytest.fixture(scope="module")
def source(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("source")
    for name in SHIPPED:
        copy: Any = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        ignored = {"ignore": shutil.ignore_patterns("__pycache__", "*.egg-info")} if (ROOT / name).is_dir() else {}
        copy(ROOT / name, folder / name, **ignored)
    return folder


@pytest.fixture(scope="module")
def distribution(source: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The wheel, built from the sdist; `twine check` reads both."""
    pytest.importorskip("build")
    pytest.importorskip("twine")
    folder = tmp_path_factory.mktemp("dist")
    subprocess.run([sys.executable, "-m", "build", "--outdir", folder, source], check=True, stdout=subprocess.DEVNULL)
    files = sorted(folder.iterdir())
    assert [file.suffix for file in files] == [".whl", ".gz"]
    subprocess.run([sys.executable, "-m", "twine", "check", "--strict", *files], check=True)
    return files[0]


def environment(folder: Path, version: str) -> Path:
    """The folder of the programs of an empty environment with this version of Python."""
    names = [f"python{version}"] + [sys.executable] * (version == "{}.{}".format(*sys.version_info))
    for name in names:
        made = subprocess.run([shutil.which(name) or "false", "-m", "venv", folder / "venv"], check=False)
        if made.returncode == 0:
            return folder / "venv" / "bin"
    pytest.skip(f"no python{version} here")


@pytest.mark.slow
@pytest.mark.parametrize("version", VERSIONS)
def test_the_wheel_is_small_and_runs_without_the_checkout(version: str, distribution: Path, tmp_path: Path) -> None:
    programs = environment(tmp_path, version)
    user = variables(tmp_path)

    def call(*words: str | Path) -> str:
        done = subprocess.run(words, cwd=tmp_path, env=user, capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    call(programs / "pip", "install", "--quiet", distribution)
    packages = call(programs / "python", "-c", "import sysconfig; print(sysconfig.get_path('purelib'))").strip()
    tools = ("pip", "setuptools", "pkg_resources", "_distutils_hack")
    kept = [one for one in Path(packages).iterdir() if one.name.partition("-")[0] not in tools]
    assert len([one for one in kept if one.suffix == ".dist-info"]) <= MOST_PACKAGES
    files = {file for one in kept for file in [one, *one.rglob("*")] if file.is_file()}
    assert sum(file.stat().st_size for file in files) <= MOST_MEGABYTES * 10**6

    (tmp_path / "mine.py").write_text(MINE)
    assert "results: runs/a.sqlite" in call(programs / "gnomon", *FIRST.split())
    assert " 0 failed" in call(programs / "gnomon", "verify", "mine:RK4", "--depth", "low")
    (tmp_path / "solved.py").write_text(SOLVE)
    call(programs / "python", "solved.py")

    call(programs / "pip", "install", "--quiet", f"{distribution}[report]")
    cells = json.loads((ROOT / "docs" / "quickstart.ipynb").read_text(encoding="utf-8"))["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    (tmp_path / "quickstart.py").write_text("\n\n".join(code))
    assert "theta =" in call(programs / "python", "quickstart.py")


def steps(name: str) -> tuple[list[str], dict[str, str]]:
    """The commands of a file in `ci/`, or of the hook, and the values of its variables for a user's `mine:RK4`."""
    read = yaml.safe_load((ROOT / name).read_text(encoding="utf-8"))
    given = {"INTEGRATOR": "mine:RK4", "DEPTH": "low", "OPTIONS": "--case pendulum_simple --claim order"}
    if name == "ci/action.yml":
        (described,) = [step["env"] for step in read["runs"]["steps"] if "env" in step]
        assert described == {each: f"${{{{ inputs.{each.lower()} }}}}" for each in given}
        assert {*read["inputs"]} == {each.lower() for each in given}
        return [step["run"] for step in read["runs"]["steps"]], given
    if name == "ci/gitlab.yml":
        job = read[".gnomon"]
        assert job["artifacts"]["reports"]["junit"] == "gnomon-verify.xml"
        return job["script"], {"GNOMON": job["variables"]["GNOMON"]} | given
    (hook,) = read
    return [f"{hook['entry']} mine:RK4 {given['OPTIONS']}"], given


FILES = ("ci/action.yml", "ci/gitlab.yml", ".pre-commit-hooks.yaml")


def passed(name: str, installs: bool, programs: Path, folder: Path, **more: str) -> str:
    """Run the steps as the service does, in the user's folder; without those that install. Returns what they print."""
    commands, given = steps(name)
    (folder / "mine.py").write_text(MINE)
    path = f"{programs}{os.pathsep}{os.environ['PATH']}"
    told = ""
    for command in commands:
        if installs or "pip install" not in command:
            user = os.environ | given | more | {"PATH": path, "GITHUB_STEP_SUMMARY": str(folder / "summary.md")}
            done = subprocess.run(
                ["bash", "-euo", "pipefail", "-c", command], cwd=folder, env=user,
                capture_output=True, text=True, check=False,
            )  # fmt: skip
            assert done.returncode == 0, f"{command}\n{done.stdout}{done.stderr}"
            told += done.stdout
    return told


@pytest.mark.parametrize("name", [*FILES[:2], pytest.param(FILES[2], marks=pytest.mark.slow)])
def test_the_steps_for_continuous_integration_verify(name: str, tmp_path: Path) -> None:
    """Their installation is tested with `make test-all`."""
    assert "mine:RK4: 1 claims checked on 1 cases, 1 passed" in passed(
        name, False, Path(sys.executable).parent, tmp_path
    )
    if name == "ci/action.yml":
        assert "mine:RK4" in (tmp_path / "summary.md").read_text()
    if name == "ci/gitlab.yml":
        assert "<testsuite" in (tmp_path / "gnomon-verify.xml").read_text()


@pytest.mark.slow
@pytest.mark.parametrize("name", FILES[:2])
def test_the_steps_for_continuous_integration_install(name: str, source: Path, tmp_path: Path) -> None:
    """From this checkout in place of the index of packages."""
    programs = environment(tmp_path, "{}.{}".format(*sys.version_info))
    more = variables(tmp_path, GNOMON=str(source), GITHUB_ACTION_PATH=str(source / "ci"), PYTHONPATH="")
    assert "1 passed" in passed(name, True, programs, tmp_path, **more)


def test_the_workflow_of_the_project_runs_the_whole_check() -> None:
    (workflow,) = (ROOT / ".github" / "workflows").iterdir()
    (job,) = yaml.safe_load(workflow.read_text(encoding="utf-8"))["jobs"].values()
    commands = [step["run"] for step in job["steps"] if "run" in step]
    assert commands == [".ci/run"]
    assert os.access(ROOT / commands[0], os.X_OK)
