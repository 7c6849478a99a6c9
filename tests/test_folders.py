"""A folder can be taken in at a glance."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

ROOT = Path(__file__).parents[1]
MOST_FILES = 25
"""What a reader takes in without searching; a folder that grows beyond it is divided by what its files do."""


def test_no_folder_holds_more_files_of_code_than_a_reader_takes_in() -> None:
    folders = ("reference", "cases", "harness", "src", "tests")
    held = Counter(path.parent for folder in folders for path in (ROOT / folder).rglob("*.py"))
    assert held
    full = [f"{folder.relative_to(ROOT)} holds {count}" for folder, count in held.items() if count > MOST_FILES]
    assert not full, f"at most {MOST_FILES} files of code a folder: " + ", ".join(full)
