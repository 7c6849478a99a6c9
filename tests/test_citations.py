"""Names in backticks in docstrings exist: a renamed function would else leave a sentence that sends its reader nowhere."""

import ast
import re
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parent.parent
SOURCES = sorted(path for folder in ("reference", "cases", "harness", "src") for path in (ROOT / folder).rglob("*.py"))
CITED = re.compile(r"`(?:([a-z]\w*)\.)?([A-Za-z_]\w*)(?:\([^`]*\))?`")
"""A name, perhaps of a module, and perhaps with arguments; paths and formulas have other characters."""
LIBRARIES = ROOT / "harness" / "adapters"
"""Its docstrings cite names of other libraries."""


@cache
def tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text())


def docstrings(path: Path) -> list[str]:
    """Docstrings of the module, its classes and functions, and texts below its variables."""
    return [
        node.value.value
        for node in ast.walk(tree(path))
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant) and isinstance(node.value.value, str)
    ]


def words_of(path: Path) -> set[str]:
    """The identifiers of a file, and the words of its texts that are not docstrings."""
    found = {path.stem, path.parent.name}
    told = {id(node.value) for node in ast.walk(tree(path)) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree(path)):
        for field in ("id", "attr", "name", "asname", "arg", "module"):
            value = getattr(node, field, None)
            found |= set(re.findall(r"\w+", value)) if isinstance(value, str) else set()
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in told:
            found |= set(re.findall(r"\w+", node.value))
    return found


WORDS = {path: words_of(path) for path in SOURCES}
EVERYWHERE = set().union(*WORDS.values())


def test_names_in_docstrings_exist() -> None:
    modules: dict[str, set[str]] = {}
    for path, words in WORDS.items():
        modules.setdefault(path.parent.name if path.stem == "__init__" else path.stem, set()).update(words)
        modules.setdefault(path.parent.name, set()).add(path.stem)
    lost = []
    for path in SOURCES:
        cited = CITED.findall("\n".join(docstrings(path))) if LIBRARIES not in path.parents else []
        for module, name in cited:
            if module in modules and name == "py":
                continue
            known = modules[module] if module in modules and module not in WORDS[path] else EVERYWHERE
            if not {name, name.rstrip("0123456789")} & known:  # names with a number are made by a loop
                lost.append(f"{path.relative_to(ROOT)}: {module}{'.' * bool(module)}{name}")
    assert not lost
