"""The recipes of CONTRIBUTING.md work as they stand: a copy of the project gets their files, and runs their commands."""

import os
import re
import shlex
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from recipes import read_recipes

ROOT = Path(__file__).parents[1]
COPIED = ("cases", "docs", "harness", "reference", "src", "tests", "CONTRIBUTING.md", "README.md", "pyproject.toml")
TINYODE = """
def rk4(f, t, y, h):
    a = f(t, y)
    b = f(t + h / 2, y + h / 2 * a)
    c = f(t + h / 2, y + h / 2 * b)
    return y + h / 6 * (a + 2 * b + 2 * c + f(t + h, y + h * c))
"""
"""The library that CONTRIBUTING.md invents."""
RECIPES = read_recipes()
MAKEFILE = ROOT / "Makefile"
GNOMON = "from gnomon.harness.commands.cli import main; main()"
QUICKLY = ("-q", "-p", "no:cacheprovider", "-m", "not slow")
INDEPENDENT, DECLARED = "tests/cases/mass_points/independent_sech_well.py", "harness/adapters/libraries.toml"


class Project:
    """A copy of the sources, the tests and the documents, with the import name."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        for name in COPIED:
            copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy2
            copy(ROOT / name, folder / name)
        package = shutil.copytree(folder / "src" / "gnomon", folder / "path" / "gnomon")
        for name in ("cases", "harness", "reference"):
            (package / name).symlink_to(folder / name)
        (folder / "path" / "tinyode.py").write_text(TINYODE)
        about = folder / "path" / "tinyode-1.0.dist-info"
        about.mkdir()
        (about / "METADATA").write_text("Metadata-Version: 2.1\nName: tinyode\nVersion: 1.0\n")

    def write(self, files: dict[str, str]) -> None:
        """Write files, or append to those that exist."""
        for name, text in files.items():
            path = self.folder / name
            before = path.read_text(encoding="utf-8") + "\n" if path.exists() else ""
            path.write_text(before + text, encoding="utf-8")

    def run(self, command: str, typed: str = "") -> subprocess.CompletedProcess[str]:
        """Run a command of CONTRIBUTING.md on the copy, with the lines that are typed into it."""
        program, *words = shlex.split(command)
        if program == "make":  # it would install the copy
            (line,) = re.findall(rf"^{words[0]}: .*\n\t\$\(BIN\)/python (.*)$", MAKEFILE.read_text(), re.M)
            words = shlex.split(line)
        words = {"gnomon": ["-c", GNOMON], "pytest": ["-m", "pytest", *QUICKLY]}.get(program, []) + words
        return subprocess.run(
            [sys.executable, *words], cwd=self.folder, capture_output=True, text=True, check=False,
            input=typed.replace("(Pdb) ", ""), env=os.environ | {"PYTHONPATH": str(self.folder / "path")},
        )  # fmt: skip


@pytest.fixture(scope="module")
def project(tmp_path_factory: pytest.TempPathFactory) -> Project:
    """A copy with the files of all recipes."""
    found = Project(tmp_path_factory.mktemp("project"))
    for recipe in RECIPES:
        found.write(recipe.files)
    return found


def test_there_is_a_recipe_for_a_case_a_method_and_a_library() -> None:
    titles = " ".join(recipe.title for recipe in RECIPES)
    assert all(word in titles for word in ("case", "pair", "method", "library"))
    assert all(recipe.commands for recipe in RECIPES)
    assert all(len(recipe.files) <= 3 for recipe in RECIPES if "case" not in recipe.title)


@pytest.mark.parametrize(
    ("command", "typed"),
    [pytest.param(*each, id=each[0]) for recipe in RECIPES for each in recipe.commands.items()],
)
def test_a_command_of_a_recipe_succeeds(project: Project, command: str, typed: str) -> None:
    done = project.run(command, typed)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "\n(Pdb) ***" not in done.stdout, done.stdout


@pytest.mark.slow
@pytest.mark.parametrize(
    ("path", "left_out", "command", "told"),
    [
        (INDEPENDENT, "", "pytest tests/cases/test_equations.py -k sech_well", INDEPENDENT),
        ("docs/cases.md", "sech_well", "pytest tests/cases/test_catalogue.py -k page", "make catalogue"),
        (DECLARED, 'families = { "*"', "pytest tests/harness/results/test_families.py", DECLARED),
        ("docs/libraries.md", "tinyode", "pytest tests/harness/adapters/test_library_lists.py", "make libraries"),
    ],
)
def test_what_is_left_out_is_named(project: Project, path: str, left_out: str, command: str, told: str) -> None:
    """A contributor who forgets a file or a line reads which one to write, or which command writes it."""
    file = project.folder / path
    text = file.read_text(encoding="utf-8")
    lines = text.splitlines(keepends=True)
    try:
        file.write_text("".join(line for line in lines if left_out not in line), encoding="utf-8")
        done = project.run(command)
    finally:
        file.write_text(text, encoding="utf-8")
    assert done.returncode == 1
    assert told in done.stdout
