"""Which parameters of a wide test run in `make test`. The others are marked slow: they run in `make test-all`."""

from __future__ import annotations

import random
from collections.abc import Iterable
from typing import Any

import pytest

SEED = 18
"""Another number selects other parameters."""


def tenth(values: Iterable[Any]) -> list[Any]:
    """The values for `parametrize`. A seeded tenth of them, rounded up, runs in `make test`; it is the same in every run."""
    every = list(values)
    chosen = set(random.Random(SEED).sample(range(len(every)), -(-len(every) // 10)))
    return [pytest.param(value, marks=() if index in chosen else pytest.mark.slow) for index, value in enumerate(every)]
