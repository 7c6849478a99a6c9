"""Elements of XML with numbers that are read back as the same doubles."""

from collections.abc import Iterable
from xml.etree.ElementTree import Element, indent, tostring


def number(value: float) -> str:
    """The shortest decimal number that rounds to this double."""
    return repr(float(value) + 0.0)  # no -0.0


def numbers(values: Iterable[float]) -> str:
    return " ".join(map(number, values))


def document(root: Element) -> str:
    indent(root)
    return f"{tostring(root, encoding='unicode')}\n"
