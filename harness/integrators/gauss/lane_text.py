"""The notation of the generated functions of lanes: named parts of text, expanded for the equations of one case.

A part is a method that returns text. In the text

- `{name}` stands for the part of that name; if it fills a line, the part has the indentation of the line;
- a line that ends with `#? name` is kept, with the lines indented below it, only if that property of the layout is
  true; `#? name and not other` is possible too;
- a line with an index is repeated for each value of the index, and so is the text between `<|` and `|>` within a line:
  `(<|x@, |>)` becomes `(x0, x1, )`. The indices: `@`, a slope; `&`, the velocity that belongs to that slope, in the
  state of second-order equations; `%`, a component of the state that moves; `~`, the place of that component in the
  case's own state; `$`, one of the stages 1 to 7;
- a name in capitals is a number of the module: a field of `Tuning`, or another number of `gauss_fast_constants`.

So a step has no inner loop over components and stores nothing in memory, whatever the dimension.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict

from gnomon.harness.integrators.gauss import gauss_fast_constants
from gnomon.harness.integrators.gauss.gauss_fast_layout import Layout
from gnomon.harness.kernels.equations import INNER, OPTIONS

HOLE = re.compile(r"\{(\w+)\}")
CONDITION = " #? "


class LaneText:
    """The parts of text that all functions of lanes share, for one layout."""

    def __init__(self, layout: Layout) -> None:
        self.layout = layout

    def written(self, name: str) -> str:
        """The whole text of a part. Raises AttributeError for a part or a property that does not exist."""
        return expanded(self.filled(f"{{{name}}}\n"), self.layout.indices)

    def filled(self, text: str) -> str:
        """The text with the parts in their places."""

        def found(hole: re.Match[str]) -> str:
            margin = text[text.rfind("\n", 0, hole.start()) + 1 : hole.start()]
            method: Callable[[], str] = getattr(self, hole[1])
            part = self.filled(self.chosen(textwrap.dedent(method()).strip("\n")))
            return part if margin.strip() else part.replace("\n", f"\n{margin}")

        return HOLE.sub(found, text)

    def chosen(self, text: str) -> str:
        """The text without the lines whose condition is false."""
        if CONDITION not in text:
            return text
        lines: list[str] = []
        left_out: int | None = None
        for line in text.split("\n"):
            depth = len(line) - len(line.lstrip())
            if left_out is None or depth <= left_out:
                line, _, condition = line.partition(CONDITION)
                holds = all(self.holds(one) for one in condition.split(" and ") if one)
                left_out = None if holds else depth
                lines += [line.rstrip()] * holds
        return "\n".join(lines)

    def holds(self, condition: str) -> bool:
        name = condition.removeprefix("not ")
        return bool(getattr(self.layout, name)) is (name == condition)

    def constants(self) -> str:
        """The numbers of the method; N is the number of slopes."""
        tuned = {name.upper(): value for name, value in asdict(gauss_fast_constants.TUNING).items()}
        every = {name: value for name, value in vars(gauss_fast_constants).items() if name.isupper()} | tuned
        numbers = {"N": self.layout.count} | {name: x for name, x in every.items() if isinstance(x, int | float)}
        return "\n".join(f"{name} = {value!r}" for name, value in numbers.items())

    def parameters(self) -> str:
        """The parameters of the equations, then the components of the state that never change."""
        own = [f"p_[{i}], " for i in range(self.layout.parameters)]
        return "".join(own + [f"initial[n, {i}], " for i in self.layout.frozen])

    def options(self) -> str:
        return OPTIONS

    def inner(self) -> str:
        return INNER


def expanded(text: str, indices: Sequence[Sequence[Mapping[str, str]]]) -> str:
    """Repeat the lines with an index, and the text between `<|` and `|>`, for each value of the index."""
    tables = [(frozenset(each[0]), [str.maketrans(dict(one)) for one in each]) for each in indices]

    def repeated(piece: str) -> str:
        for marks, each in tables:
            if not marks.isdisjoint(piece):
                return "".join(repeated(piece.translate(table)) for table in each)
        return piece

    text = re.sub(r"<\|(.*?)\|>", lambda found: repeated(found[1]), text)
    return "".join(x if x.startswith("@") else repeated(x) for x in text.splitlines(keepends=True))
