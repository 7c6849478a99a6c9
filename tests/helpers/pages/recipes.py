"""The recipes of CONTRIBUTING.md: the files that they write, and the commands that show that they work."""

import re
from pathlib import Path
from typing import NamedTuple

CONTRIBUTING = Path(__file__).parents[3] / "CONTRIBUTING.md"
_PART = re.compile(r"^\d\. `([^`\n]+)`|^```(\w*)\n(.*?)^```$", re.M | re.S)

_COMMAND = re.compile(r"^((?!\(Pdb\)).+)\n((?:\(Pdb\) .*\n)*)", re.M)


class Recipe(NamedTuple):
    """A section with files, by their paths, and commands, with the lines that the reader types into them."""

    title: str
    files: dict[str, str]
    commands: dict[str, str]


def read_recipes() -> list[Recipe]:
    """The sections with steps "1. `path` ...", each of which is followed by its file as a block."""
    found = []
    for section in CONTRIBUTING.read_text(encoding="utf-8").split("\n## ")[1:]:
        recipe, path = Recipe(section.partition("\n")[0], {}, {}), ""
        for step, language, text in _PART.findall(section):
            if language:
                recipe.files[path] = text
            elif text:
                recipe.commands.update(_COMMAND.findall(text))
            path = step
        if recipe.files:
            found.append(recipe)
    return found
