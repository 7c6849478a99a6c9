"""The example project passes the steps of its own workflows beside a built wheel, and a planted fault fails by its claim."""

import os
import re
import shutil
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
EXAMPLE = Path(__file__).parent / "example_project"
WORKFLOWS = (".github/workflows/verify.yml", ".gitlab-ci.yml")

pytestmark = [pytest.mark.slow, pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")]


def steps(workflow: str) -> list[str]:
    """The commands of a workflow, in sequence, without the installation of packages."""
    text = (EXAMPLE / workflow).read_text()
    found = re.findall(r"^ +- run: (.*)$|^    - (?!uses|name)(.*)$", text, re.M)
    commands = [one or other for one, other in found]
    assert commands[0] == "pip install .[test]"
    return commands[1:]


def run(command: str, folder: Path, environment: Path) -> tuple[int, str]:
    path = f"{environment / 'bin'}{os.pathsep}{os.environ['PATH']}"
    variables = {name: value for name, value in os.environ.items() if name not in ("PYTHONPATH", "VIRTUAL_ENV")}
    done = subprocess.run(
        ["sh", "-c", command], cwd=folder, env=variables | {"PATH": path, "GITHUB_ACTIONS": "true"},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    return done.returncode, done.stdout + done.stderr


@pytest.fixture(scope="module")
def environment(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A new environment with a wheel of gnomon; it shares the dependencies of this environment."""
    folder = tmp_path_factory.mktemp("environment")
    source = folder / "source"
    for name in ("src", "reference", "cases", "harness"):
        shutil.copytree(ROOT / name, source / name, ignore=shutil.ignore_patterns("__pycache__", "*.egg-info"))
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, source / name)
    pip = [sys.executable, "-m", "pip"]
    subprocess.run([*pip, "wheel", "--quiet", "--no-deps", "--wheel-dir", folder, source], check=True)
    (wheel,) = folder.glob("*.whl")
    made = folder / "venv"
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", made], check=True)
    (packages,) = made.glob("lib/python*/site-packages")
    ours = [sysconfig.get_path("purelib"), *(path for path in sys.path if path.endswith("site-packages"))]
    (packages / "ours.pth").write_text("\n".join(dict.fromkeys(ours)))
    subprocess.run(
        [*pip, "--python", made / "bin" / "python", "install", "--quiet", "--no-deps", "--ignore-installed", wheel],
        check=True,
    )
    script = made / "bin" / "pytest"  # the `pytest` of this environment would run its own Python
    script.write_text(f"#!{made / 'bin' / 'python'}\nimport pytest\nraise SystemExit(pytest.console_main())\n")
    script.chmod(0o755)
    return made


def install(folder: Path, environment: Path) -> None:
    command = [sys.executable, "-m", "pip", "--python", environment / "bin" / "python", "install", "--quiet"]
    subprocess.run([*command, "--no-deps", "--ignore-installed", folder], check=True, cwd=folder.parent)


@pytest.fixture
def project(tmp_path: Path) -> Path:
    return Path(shutil.copytree(EXAMPLE, tmp_path / "project"))


@pytest.mark.parametrize("workflow", WORKFLOWS)
def test_the_steps_of_the_workflow_pass(workflow: str, project: Path, environment: Path) -> None:
    install(project, environment)
    commands = steps(workflow)
    assert sum(command.startswith("gnomon verify") for command in commands) == 2
    for command in commands:
        code, text = run(command, project, environment)
        assert code == 0, f"{command}\n{text}"
        if command.startswith("gnomon verify"):
            assert re.search(r"[1-9]\d* claims checked on \d+ cases, \d+ passed, 0 failed", text), text


@pytest.mark.parametrize(
    ("file", "before", "after", "claim"),
    [
        ("swing/__init__.py", "f(t + h, q)", "f(t + h, q - h * middle)", "symplectic"),
        ("swing/__init__.py", "q = q + h * middle", "q = q + 1.0001 * h * middle", "step_order"),
        ("swing/rk4.c", "h / 6 * (k[0][i] + 2", "h / 6 * (k[0][i] + 2.0001", "step_order"),
    ],
)
def test_a_planted_fault_fails_by_its_claim(
    file: str, before: str, after: str, claim: str, project: Path, environment: Path
) -> None:
    text = (project / file).read_text()
    assert text.count(before) == 1
    (project / file).write_text(text.replace(before, after))
    install(project, environment)
    compiled, verlet, program, tests = steps(WORKFLOWS[0])
    assert run(compiled, project, environment)[0] == 0
    code, text = run(program if file.endswith(".c") else verlet, project, environment)
    assert code == 1, text
    assert f"FAILED {claim} on pendulum_simple" in text
    assert "::error title=gnomon%3A" in text
    assert (run(tests, project, environment)[0] == 1) == file.endswith(".py")
