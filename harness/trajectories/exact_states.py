"""Exact states of a case as text, with certificate and hash, for comparison with other programs."""

import csv
import hashlib
import io
import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

from gnomon.cases.core.case import Case
from gnomon.cases.core.numbers import LARGEST, show
from gnomon.harness.certification.certify import Certificate, certify
from gnomon.harness.system.files import read_text
from gnomon.reference.numerics.precision import exact, shortened
from gnomon.reference.storage.version import VERSION
from mpmath.libmp import to_str

SCHEMA_VERSION = 1
MOST_DIGITS, MOST_TIMES = 1000, 100_000
MOST_SCALES = 1_000_000
"""The latest time beyond the span, in time scales: to certify a longer motion may take hours."""


@dataclass(frozen=True)
class ExactStates:
    """States of one case. `times`: as the user wrote them; `states`: decimal numbers, one row a time."""

    case: Case
    digits: int
    times: tuple[str, ...]
    states: tuple[tuple[str, ...], ...]
    certificate: Certificate

    @property
    def hashed(self) -> str:
        """The text whose hash identifies both formats: the numbers of the case and the states, as CSV."""
        text = io.StringIO()
        text.write(f"# case {self.case.id}\n# digits {self.digits}\n")
        for name, value in self.numbers.items():
            label = name if name in self.case.parameters else f"{name}(0)"
            text.write(f"# {label} = {value['decimal']} = {value['hexadecimal']}\n")
        rows = csv.writer(text, lineterminator="\n")
        rows.writerow(["t", *(coordinate.name for coordinate in self.case.state)])
        rows.writerows((time, *state) for time, state in zip(self.times, self.states, strict=True))
        return text.getvalue()

    @property
    def numbers(self) -> dict[str, dict[str, str]]:
        """Parameters and initial values by name, in decimals that round to the double, and in hexadecimal."""
        return {
            name: {"decimal": repr(float(value)), "hexadecimal": float(value).hex()}
            for name, value in self.case.numbers.items()
        }

    @property
    def sha256(self) -> str:
        return hashlib.sha256(self.hashed.encode()).hexdigest()

    def as_csv(self) -> str:
        """Comment lines with certificate and hash, then the hashed text: comments, header, one row each time."""
        certificate = self.certificate
        ways = ", ".join(f"{way} {digits:.0f}" for way, digits in certificate.ways.items())
        confirmed = f"confirmed to {certificate.digits:.0f} digits ({ways or certificate.note}), {certificate.required} required"
        head = f"# gnomon {VERSION}\n# certificate: {confirmed}\n# sha256 of the lines below: {self.sha256}\n"
        return head + self.hashed

    def as_json(self) -> str:
        """One JSON object. Times and states are strings, because a JSON number may be read as a double."""
        case, certificate, numbers = self.case, self.certificate, self.numbers
        document = {
            "schema_version": SCHEMA_VERSION,
            "gnomon": VERSION,
            "case": case.id,
            "digits": self.digits,
            "parameters": {parameter.name: numbers[parameter.name] for parameter in case.parameter_list},
            "initial_state": {coordinate.name: numbers[coordinate.name] for coordinate in case.state},
            "units": {coordinate.name: coordinate.unit for coordinate in case.state},
            "states": [
                {"t": time, **{coordinate.name: value for coordinate, value in zip(case.state, state, strict=True)}}
                for time, state in zip(self.times, self.states, strict=True)
            ],
            "certificate": {
                "passed": certificate.passed,
                "digits": round(certificate.digits, 1),
                "required": certificate.required,
                "ways": {way: round(digits, 1) for way, digits in certificate.ways.items()},
                "note": certificate.note,
            },
            "sha256": self.sha256,
        }
        return json.dumps(document, indent=1, ensure_ascii=False) + "\n"


def exact_states(case: Case, times: Sequence[str], digits: int) -> ExactStates:
    """Exact states of `case` at `times`, with numbers rounded to binary64, and the certificate of its motion.

    If a time is later than the span, the motion and its certificate extend to it. Raises ValueError for a time or a
    number of digits outside the limits, and for a motion that is out of reach.
    """
    if not 1 <= digits <= MOST_DIGITS:
        raise ValueError(f"--digits {digits}: give a number of digits from 1 to {MOST_DIGITS}")
    moments = [moment(text) for text in times]
    rounded = case.rounded()
    latest = max(rounded.span, MOST_SCALES * exact(rounded.time_scale))
    if max(moments) > latest:
        raise ValueError(
            f"--times: t = {show(max(moments))} s; give times up to {float(latest):g} s, {MOST_SCALES:,} time scales"
        )
    if max(moments) > rounded.span:
        rounded, variant = rounded.with_span(max(moments)), rounded.variant
        rounded.variant = variant
    states = tuple(tuple(to_str(x._mpf_, digits) for x in rounded.exact(t, digits)) for t in moments)
    return ExactStates(rounded, digits, tuple(times), states, _certificate(rounded))


def times_of(source: str | None, case: Case) -> tuple[str, ...]:
    """The times as written, from a file or a list separated by commas or white space; see `_column` for a file.

    None gives the case's 64 sample times, as hexadecimal doubles.
    """
    if source is None:
        return tuple(t.hex() for t in case.rounded().times.tolist())
    text = _column(source, read_text(Path(source))) if is_file(source) else source
    times = tuple(text.replace(",", " ").split())
    if not times:
        raise ValueError(f"--times {shortened(source)}: no times; give numbers of seconds, as 0.5,1,1.5")
    if len(times) > MOST_TIMES:
        raise ValueError(f"--times: {len(times)} times; give at most {MOST_TIMES}")
    for each in times:
        try:
            moment(each)
        except ValueError as error:
            hint = "" if is_file(source) or "," in source else "; no file has this name either"
            raise ValueError(f"{error}{hint}") from None
    return times


def _column(source: str, text: str) -> str:
    """The times of a file: without a header all its numbers, else the only column, or the column t or time."""
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    mark = next((mark for mark in ";,\t" if mark in "".join(lines[:1])), None)
    rows = [[field.strip().strip('"') for field in line.split(mark)] for line in lines]
    if not rows or any(map(_is_number, rows[0])):
        return " ".join(field for row in rows for field in row)
    places = (
        [k for k, name in enumerate(rows[0]) if re.match(r"(t|time)\b", name, re.IGNORECASE)] if rows[0][1:] else [0]
    )
    if len(places) != 1:
        raise ValueError(f"--times {shortened(source)}: call one column t or time; it has {', '.join(rows[0])}")
    return " ".join(row[places[0]] for row in rows[1:] if len(row) > places[0])


def _is_number(text: str) -> bool:
    try:
        moment(text)
    except ValueError:
        return text.strip("+-")[:1].isdigit()  # a wrong number is not a header
    return True


def is_file(name: str) -> bool:
    try:
        return Path(name).is_file()
    except (OSError, ValueError):  # no file can have this name
        return False


def moment(text: str) -> Fraction:
    """A time: an exact decimal number or fraction, or a double in hexadecimal digits (0x1.8p+1)."""
    if "x" in text.lower():
        try:
            value: Any = float.fromhex(text)
        except (ValueError, OverflowError):
            raise ValueError(
                f"--times: t = {shortened(text)} is not a double in hexadecimal digits, as 0x1.8p+1"
            ) from None
    else:
        value = text
    time = exact(value, "--times: t")
    if not 0 <= time <= LARGEST:
        raise ValueError(f"--times: t = {show(time)} s; give times from 0 to 1e300 s: the motion starts at 0")
    return time


def _certificate(case: Case) -> Certificate:
    try:
        return certify(case)
    except (ArithmeticError, ValueError) as failure:
        return Certificate(case.name, case.variant or "default", {}, note=f"{type(failure).__name__}: {failure}")
