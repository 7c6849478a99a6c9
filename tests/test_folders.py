"""A folder holds so few files that its list can be read whole."""

from collections import Counter
from pathlib import Path

ROOT = Path(__file__).parents[1]
FOLDERS = ("reference", "cases", "harness", "src", "tests")
MOST_FILES = 25
"""A folder with more files is divided by the tasks of its files."""


def test_no_folder_holds_more_than_25_files_of_code() -> None:
    held = Counter(path.parent for folder in FOLDERS for path in (ROOT / folder).rglob("*.py"))
    full = [f"{folder.relative_to(ROOT)} ({count})" for folder, count in held.items() if count > MOST_FILES]
    assert held
    assert not full, f"more than {MOST_FILES} files of code, divide by their tasks: {', '.join(full)}"
