"""Measures everything under reports/ part by part, and assembles it when all parts are of these sources.

    make publication                 measures the parts that are not done, then assembles; Ctrl-C, and it goes on later
    make publication MINUTES=75      stops in time: a part that cannot be resumed is not begun if it would take longer
    python -m gnomon.harness.reporting.publication --list         the parts
    python -m gnomon.harness.reporting.publication --part growth  one part
    python -m gnomon.harness.reporting.publication --with-older   assembles at once; the page names older parts

Only the assembly writes into reports/, and the table of `gnomon recommend`.
"""

import argparse
import sys
import time
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from gnomon.harness.reporting import provenance
from gnomon.harness.reporting.publication import assembly
from gnomon.harness.reporting.publication.parts import Part, Place, State, measure
from gnomon.harness.results.outstanding import outstanding
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Column, Table

LEAST_MINUTES = 1.0
"""A part that can be resumed is not begun with less than this left."""


def main(arguments: Iterable[str] | None = None) -> int:
    """0 if all is done, 1 if parts remain, 2 for an error, 130 after Ctrl-C."""
    options = _parser().parse_args(None if arguments is None else list(arguments))
    console, place = Console(soft_wrap=True, emoji=False, highlight=False), Place(options.measured)
    try:
        if options.minutes is not None and not options.minutes > 0:
            raise ValueError(f"--minutes {options.minutes:g}: a number above 0 is needed")
        if options.results is not None and not options.with_older:
            raise ValueError(f"--results {options.results}: only with --with-older")
        chosen = place.part(options.part) if options.part else None
        console.print(table([*place.states()]))
        if options.list:
            return 0
        if options.with_older:
            publication = assembly.older(place, options.out, options.results)
        else:
            if not _measure_parts([chosen] if chosen else None, place, options.minutes, console):
                return 1
            if chosen:
                return 0
            publication = assembly.present(place)
        page = assembly.assemble(publication, options.out, options.raw, options.table)
    except KeyboardInterrupt:
        _remaining(place, console)
        return 130
    except (ValueError, OSError) as error:
        print(f"error: {' '.join(str(error).split())}", file=sys.stderr)
        return 2
    for line in _lacks(publication, options.out):
        console.print(line)
    console.print(
        f"The published report is {page}; look at every figure, and commit {options.out} and {options.table} alone"
    )
    return 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog="publication", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--list", action="store_true", help="print the table of parts, and measure nothing")
    parser.add_argument("--part", help="measure this part alone, if it is not done")
    parser.add_argument("--minutes", type=float, help="stop after so many")
    parser.add_argument(
        "--with-older", action="store_true", help="assemble now, with parts of other sources where needed"
    )
    parser.add_argument(
        "--results", type=Path, help="with --with-older: this results file, in place of the part full's"
    )
    parser.add_argument("--measured", type=Path, default=Place.root, help="the folder of the parts")
    parser.add_argument("--raw", type=Path, default=assembly.RAW, help="the raw results, as Parquet")
    parser.add_argument("--table", type=Path, default=assembly.TABLE, help="the table of `gnomon recommend`")
    parser.add_argument("--out", type=Path, default=Path("reports"))
    return parser


def _measure_parts(chosen: Sequence[Part] | None, place: Place, minutes: float | None, console: Console) -> bool:
    """Measure the parts that are not done, until the time is over; return whether all are done."""
    ends = None if minutes is None else time.monotonic() + 60.0 * minutes
    for state in place.states():
        part = state.part
        if state.word == "done" or (chosen is not None and part not in chosen):
            continue
        left = None if ends is None else (ends - time.monotonic()) / 60.0
        if left is not None and left < (LEAST_MINUTES if part.resumes else state.minutes):
            console.print(
                f"{part.name} is not begun: it takes about {state.minutes:.0f} minutes, and {max(0.0, left):.0f} are left"
            )
            break
        console.print(f"{part.name}: about {state.minutes:.0f} minutes on two cores")
        if not measure(part, place, ends):
            break
    else:
        return True
    _remaining(place, console)
    return False


def _lacks(publication: assembly.Found, to: Path) -> Iterator[str]:
    """What makes a publication less than one whole run of one revision, a line each: the page says it too."""
    missing = outstanding(publication.results).text
    if missing:
        yield f"not complete: {publication.results}: {missing}"
    for origin in provenance.origins([to], publication.run):
        if origin.older:
            yield f"older: {origin.file}, revision {origin.revision or 'unknown'} {origin.date}".rstrip()


def _remaining(place: Place, console: Console) -> None:
    """What is left to do, in one line."""
    left = [state for state in place.states() if state.word != "done"]
    minutes = sum(state.minutes for state in left)
    console.print(
        f"remaining: {', '.join(state.part.name for state in left)}; about {minutes:.0f} minutes;"
        " the same command goes on"
        if left
        else "all parts are done; the same command assembles them"
    )


def table(states: Sequence[State]) -> Table:
    """The parts: whether each is done, of which revision and day, and its time, predicted and measured."""
    printed = Table(
        Column("part", no_wrap=True), "state", "revision", "date", "minutes", "took", box=SIMPLE_HEAD, padding=(0, 1)
    )
    for each in states:
        took = "" if each.took is None else f"{each.took:.1f}"
        by = [each.by.get(name, "") for name in ("revision", "date")]
        printed.add_row(each.part.name, each.word, *by, f"{each.minutes:.0f}", took)
    left = sum(each.minutes for each in states if each.word != "done")
    printed.add_row(
        "all", f"{sum(each.word == 'done' for each in states)} of {len(states)} done", "", "", f"{left:.0f} left", ""
    )
    return printed


if __name__ == "__main__":
    sys.exit(main())
