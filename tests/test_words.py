"""One meaning a word (docs/glossary.md): words that have another name here, and idiom, stand nowhere in the project."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
INSTEAD = {
    r"truths?": "reference solution",
    r"judg(e|es|ed|ing|ement|ment)": "score, or compute",
    r"opponents?": "independent computation",
    r"ladders?|rungs?": "model hierarchy, level",
    r"siblings?|everywhere": "near-duplicate method, primary",
    r"hunt(s|ed|ing)?": "search for the worst case",
    r"gates?": "regression check",
    r"worth": "what is meant: the score, the value, the reason",
    r"dear(er|est)?|dearly": "expensive",
    r"keen|calm|cloud|patience": "what it holds",
    r"what_is_taken": "rounding_residuals, compensation",
    r"taken for|told by|has no say|had its say|a say": "biased; determined by; is ignored",
    r"at the mercy|none of theirs|nobody's|no matter|for free|by hand|in vain|stands? still": "plain words",
    r"map of the house|rule of thumb|on the fly|out of the box|under the hood|sanity": "plain words",
}
"""Patterns of whole words, and what to say instead."""
PHYSICAL = re.compile(r"sliding[ _-]?ladder|ladder_(energy|mode|chart|scene)|the ladder between wall and floor", re.I)
"""A ladder that leans against a wall is one."""
TEXTS = (".py", ".md", ".j2", ".js", ".css", ".toml", ".yml")
SKIPPED = ("reports/", "tests/test_words.py", "tests/cases/catalogue_rows.json", "CHANGELOG.md")
"""What was printed by an earlier revision stays as it was."""


def words(text: str) -> str:
    """Text in which the words of identifiers stand apart: `ladder_rows` and `LadderRows` as "ladder rows"."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])|_", " ", PHYSICAL.sub(" ", text))


ANY = re.compile(rf"\b({'|'.join(INSTEAD)})\b", re.IGNORECASE)


def findings(path: Path) -> list[str]:
    """Lines with a word that has another name here."""
    found: list[str] = []
    text = path.read_text()
    if not ANY.search(words(text)):
        return found
    for number, line in enumerate(text.splitlines(), 1):
        for pattern, instead in INSTEAD.items():
            match = re.search(rf"\b({pattern})\b", words(line), re.IGNORECASE)
            if match:
                found.append(f"{path.relative_to(ROOT)}:{number}: {match.group(0)!r}: say {instead}")
    return found


def sources(folder: str) -> list[Path]:
    """The texts of a folder, in subfolders too."""
    inside = [ROOT / folder] if (ROOT / folder).is_file() else sorted((ROOT / folder).rglob("*"))
    return [
        path
        for path in inside
        if path.is_file() and path.suffix in TEXTS and not str(path.relative_to(ROOT)).startswith(SKIPPED)
    ]


def _places() -> list[str]:
    tops = ["reference", "cases", "harness", "tests"]
    places = [
        f"{top}/{path.name}" for top in tops for path in sorted((ROOT / top).iterdir()) if path.name[0] not in "._"
    ]
    return [*places, "src", "docs", "README.md", "CONTRIBUTING.md", "SECURITY.md", "mkdocs.yml"]


@pytest.mark.parametrize("folder", _places())
def test_a_word_has_one_meaning(folder: str) -> None:
    found = [line for path in sources(folder) for line in findings(path)]
    assert not found, "\n".join(found)


def test_words_are_found_in_names_and_in_sentences(tmp_path: Path) -> None:
    for text in ("def ladder_rows():", "class LadderRows:", "The ladder is high.", "Judged by the truth."):
        assert ANY.search(words(text)), text
    for text in ("SlidingLadder", "sliding_ladder", "runge_kutta", "conjugate", "surrogate"):
        assert not ANY.search(words(text)), text
