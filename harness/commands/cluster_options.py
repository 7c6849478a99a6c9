"""The options of `gnomon run` that divide a plan between machines."""

from __future__ import annotations

import re
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from gnomon.harness.running.plan import Suite

MOST_SHARDS = 10**6


class TimingChoice(StrEnum):
    """The times that `gnomon run` records."""

    full = "full"
    none = "none"


Shard = Annotated[
    str | None, typer.Option(help="k/n: only the k-th of n parts of about equal cost; see `gnomon merge`.")
]
TimingOption = Annotated[TimingChoice, typer.Option(help="none: errors alone, each trial in one call and one launch.")]
Dask = Annotated[
    str | None,
    typer.Option(
        help="Run on a Dask cluster: the address of its scheduler, tcp://host:8786, or local: --workers processes."
    ),
]


def part(suite: Suite, shard: str | None, timing: TimingChoice) -> Suite:
    """The part of a suite that these options ask for; ValueError for an invalid shard."""
    suite = suite if timing == TimingChoice.full else suite.untimed()
    if shard is None:
        return suite
    numbers = re.fullmatch(r"([0-9]{1,7})/([0-9]{1,7})", shard, re.ASCII)
    place, count = map(int, numbers.groups()) if numbers else (0, 0)
    if not 1 <= place <= count <= MOST_SHARDS:
        raise ValueError(f"--shard {shard[:40]}: write k/n with 1 <= k <= n <= {MOST_SHARDS}, as 3/10")
    return suite.change(shard=(place, count))
