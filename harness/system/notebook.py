"""The view of a result in a notebook: its text and, with the packages of the extra `report`, its picture."""

import html
from collections.abc import Callable
from typing import Any


def view(text: str, plot: Callable[[], Any]) -> dict[str, Any]:
    """The contents by their MIME type, as Jupyter takes them; `plot` raises ValueError where there is no picture."""
    contents: dict[str, Any] = {"text/plain": text, "text/html": f"<pre>{html.escape(text)}</pre>"}
    try:
        chart = plot()._repr_mimebundle_()
    except ValueError:
        return contents
    return contents | dict(chart[0] if isinstance(chart, tuple) else chart)
