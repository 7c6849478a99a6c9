"""Messages from a worker to its parent: JSON and arrays of float64, each with the number of the request it answers.

An integrator's code runs in the worker and can write to the pipe. The parent therefore reads data only, no pickles,
which could execute code.
"""

import json
from collections.abc import Mapping
from math import prod
from typing import Any, NamedTuple

import numpy as np
from gnomon.harness.contract.integrator import Floats
from gnomon.harness.system.supervisor import Garbled, frame


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
    return frame(text, raw)


def decode(text: bytes, raw: bytes) -> Message:
    """The message in the two parts of a frame, for an `Inbox`."""
    request, stage, content, shapes = json.loads(text)
    if not (isinstance(request, int) and isinstance(stage, str) and isinstance(content, dict)):
        raise TypeError("not a message")
    arrays: dict[str, Floats] = {}
    values, start = np.frombuffer(raw, dtype="<f8"), 0
    for name, shape in shapes.items():
        if min(shape, default=0) < 0:
            raise ValueError("a length below zero")
        size = prod(shape)
        arrays[name] = values[start : start + size].reshape(shape)
        start += size
    return Message(request, stage, content, arrays)


def number(content: Mapping[str, Any], name: str) -> float:
    """The number called `name` in a message's content; raises Garbled for anything else."""
    value = content.get(name)
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise Garbled(f"a message whose {name} is not a number")
    try:
        return float(value)
    except OverflowError:
        raise Garbled(f"a message whose {name} is beyond binary64") from None
