"""Messages from a worker to its parent: JSON and arrays of float64, each with the number of the request it answers.

An integrator's code runs in the worker and can write to the pipe. The parent therefore reads data only, no pickles,
which could execute code.
"""

import json
import os
import struct
from collections.abc import Iterator, Mapping
from math import prod
from typing import Any, NamedTuple

import numpy as np
from gnomon.harness.contract.integrator import Floats

_HEADER = struct.Struct("<4sQQ")
"""The mark, the number of bytes of JSON, the number of bytes of arrays."""
_MARK = b"gnom"
MOST_BYTES = 2**28
"""Maximum size of a message: the states of the largest trial take a thousandth of it."""


class Garbled(Exception):  # noqa: N818 (it names what arrived)
    """Bytes arrived that are not a valid message of a worker."""


class Message(NamedTuple):
    """An answer to request number `request`: the stage that the trial has reached, and its data."""

    request: int
    stage: str
    content: dict[str, Any]
    arrays: dict[str, Floats]


def encode(message: Message) -> bytes:
    shapes = {name: list(array.shape) for name, array in message.arrays.items()}
    text = json.dumps([message.request, message.stage, message.content, shapes]).encode()
    raw = b"".join(np.ascontiguousarray(array, dtype="<f8").tobytes() for array in message.arrays.values())
    return _HEADER.pack(_MARK, len(text), len(raw)) + text + raw


def send(descriptor: int, message: Message) -> None:
    """Write a whole message to a pipe."""
    rest = memoryview(encode(message))
    while rest:
        rest = rest[os.write(descriptor, rest) :]


class Inbox:
    """Assembles messages from the pieces in which they arrive; the parent never waits for the rest of a message."""

    def __init__(self) -> None:
        self._content = bytearray()

    def take(self, piece: bytes) -> Iterator[Message]:
        """The messages that `piece` completes. Raises Garbled for bytes that are not a message."""
        self._content += piece
        while len(self._content) >= _HEADER.size:
            mark, text, raw = _HEADER.unpack_from(self._content)
            if mark != _MARK or text + raw > MOST_BYTES:
                raise Garbled("something that is no message of a worker")
            end = _HEADER.size + text + raw
            if len(self._content) < end:
                return
            content = bytes(self._content[_HEADER.size : end])
            del self._content[:end]
            yield _decoded(content[:text], content[text:])


def _decoded(text: bytes, raw: bytes) -> Message:
    try:
        request, stage, content, shapes = json.loads(text)
        if not (isinstance(request, int) and isinstance(stage, str) and isinstance(content, dict)):
            raise TypeError("not a message")
        arrays: dict[str, Floats] = {}
        values, taken = np.frombuffer(raw, dtype="<f8"), 0
        for name, shape in shapes.items():
            if min(shape, default=0) < 0:
                raise ValueError("a length below zero")
            size = prod(shape)
            arrays[name] = values[taken : taken + size].reshape(shape)
            taken += size
    except (ValueError, TypeError, AttributeError, RecursionError) as error:
        raise Garbled(f"a message that cannot be read ({type(error).__name__})") from None
    return Message(request, stage, content, arrays)


def number(content: Mapping[str, Any], name: str) -> float:
    """The number called `name` in a message's content; raises Garbled for anything else."""
    value = content.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise Garbled(f"a message whose {name} is no number")
    return float(value)
