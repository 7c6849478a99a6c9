"""Messages of a worker are data: they are decoded as they were encoded, and all other bytes are rejected."""

import os
import pickle
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from gnomon.harness.measuring.outcome import Outcome
from gnomon.harness.running.messages import Message, decode, encode
from gnomon.harness.running.worker import answer, outcome_of
from gnomon.harness.system.supervisor import Garbled, Inbox, write

MESSAGE = Message(7, "done", {"steps": 3, "text": "\ud800é", "nothing": None}, {"states": np.eye(3)[:, :2] / 3})


def same(a: Message, b: Message) -> bool:
    arrays = all(np.array_equal(a.arrays[name], b.arrays[name]) for name in b.arrays)
    return a[:3] == b[:3] and arrays and a.arrays.keys() == b.arrays.keys()


@pytest.mark.parametrize("size", [1, 13, 10**6])
def test_messages_are_decoded_as_they_were_encoded_from_pieces_of_any_size(size: int) -> None:
    content, inbox = encode(MESSAGE) + encode(MESSAGE._replace(request=8, arrays={})), Inbox(decode)
    pieces = [content[at : at + size] for at in range(0, len(content), size)]
    first, second = [message for piece in pieces for message in inbox.take(piece)]
    assert same(first, MESSAGE)
    assert (second.request, second.arrays) == (8, {})


def test_a_message_longer_than_the_buffer_of_a_pipe_is_sent_completely() -> None:
    reading, writing = os.pipe()
    long = MESSAGE._replace(arrays={"states": np.arange(10**5, dtype=float)})
    if os.fork() == 0:
        write(writing, encode(long))
        os._exit(0)
    os.close(writing)
    inbox, found = Inbox(decode), []
    while piece := os.read(reading, 2**16):
        found += inbox.take(piece)
    os.close(reading)
    os.wait()
    assert len(found) == 1
    assert same(found[0], long)


@pytest.mark.parametrize(
    "content",
    [
        b"x" * 99,
        pickle.dumps(("done", 3)) * 9,
        b"gnom" + (2**60).to_bytes(8, "little") + bytes(8),
        b"gnom" + (2).to_bytes(8, "little") + bytes(8) + b"{}",
        b"gnom" + (16).to_bytes(8, "little") + bytes(8) + b'[1,"done",{},[]]'[:16],
        b"gnom" + (100_000).to_bytes(8, "little") + bytes(8) + b"[" * 100_000,
        encode(MESSAGE).replace(b"[3, 2]", b"[3, 9]"),
        encode(MESSAGE).replace(b"[3, 2]", b"[3,-2]"),
    ],
)
def test_bytes_that_are_not_a_message_are_rejected(content: bytes) -> None:
    inbox = Inbox(decode)
    with pytest.raises(Garbled):
        list(inbox.take(content))


@pytest.mark.parametrize(
    "changed",
    [
        {"steps": 10**400},
        {"rhs_calls": 10**400},
        {"events": [[10**400, "x"]]},
        {"seconds": [10**400]},
        {"prepare_seconds": 10**400},
    ],
    ids=lambda changed: next(iter(changed)),
)
def test_a_number_beyond_binary64_is_a_garbled_answer(changed: dict[str, Any]) -> None:
    """JSON has integers of any size; an OverflowError would end the run and not the trial."""
    states = np.zeros((64, 2))
    task: Any = SimpleNamespace(times=np.zeros(64), start=np.zeros(2))
    sent = answer(Outcome(states, None, None, 8, 32, (1e-3,), 0.0, None), 1)
    (message,) = Inbox(decode).take(encode(sent))
    assert outcome_of(message, task).steps == 8
    (message,) = Inbox(decode).take(encode(sent._replace(content=sent.content | changed)))
    with pytest.raises(Garbled):
        outcome_of(message, task)
