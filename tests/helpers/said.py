"""The numbers that a sentence names, so that a test holds these and leaves the words free."""

import re


def numbers_in(text: str) -> list[str]:
    """In sequence, as they are printed."""
    return re.findall(r"(?<![\w.:])\d+(?:\.\d+)?(?:e-?\d+)?", text)
