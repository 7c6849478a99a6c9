"""The findings about engines hold: each reproduction runs without gnomon, prints what it found, and asserts it.

A reproduction that fails after an update of the engine is good news; its page then says up to which version it held.
"""

import re
import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import pytest

FOLDER = Path(__file__).parent.parent / "docs" / "findings"
LIMIT = 3000.0
"""Seconds after which a script that hangs fails its test; Newton compiles for half a minute at first."""
SCRIPTS = sorted(FOLDER.glob("*.py"))


@pytest.mark.parametrize("script", SCRIPTS, ids=[path.stem for path in SCRIPTS])
def test_a_finding_is_reproduced(script: Path) -> None:
    text = script.read_text(encoding="utf-8")
    assert "gnomon" not in text, "its reader has the engine alone"
    for library in re.findall(r"^import (\w+)", text, re.MULTILINE):
        if find_spec(library) is None:
            pytest.skip(f"{library} is not installed")
    ran = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, timeout=LIMIT)
    assert ran.returncode == 0, ran.stderr


def test_every_finding_has_a_row_with_its_version_and_the_words_of_the_manual() -> None:
    page = (FOLDER / "index.md").read_text(encoding="utf-8")
    rows = [line for line in page.splitlines() if line.startswith("| [")]
    assert {re.findall(r"\((\w+)\.py\)", row)[0] for row in rows} == {path.stem for path in SCRIPTS}
    for row in rows:
        assert re.search(r"\d+\.\d+", row.split("|")[2]), f"no version: {row}"
