"""Certificates of many cases and checks, in several processes; a motion that fails has a certificate without digits."""

import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from gnomon.harness.certification.certify import Certificate, certify
from gnomon.harness.certification.certify_checks import certify_check
from gnomon.harness.system.supervisor import calls, require

from gnomon import cases

Subject = tuple[str, str | None]
"""The name of a case (or `package.module:Case`) or of a check, and the name of its variant or None for the default."""


def subjects(named: Sequence[str], variants: bool) -> list[Subject]:
    """The cases and checks with these names: case, case/variant, check or check/variant; without names all.

    With `variants`, a name without a variant means all its variants too. Raises ValueError for an unknown name.
    """
    chosen: list[Subject] = []
    for name in named or (*cases.names(), *cases.check_names()):
        base, slash, variant = name.partition("/")
        kind = cases.check_class(base) if base in cases.check_names() else cases.case_class(base)
        if slash:
            chosen.append((base, None if variant == "default" else variant))
            kind._variant(chosen[-1][1])
            continue
        chosen.append((base, None))
        if variants:
            chosen += [(base, known.name) for known in kind.variants]
    return chosen


def certificates(chosen: Sequence[Subject], workers: int = 1) -> Iterator[Certificate]:
    """A certificate of each subject, in the sequence of the subjects."""
    if workers == 1 or len(chosen) == 1:
        yield from map(certificate, chosen)
        return
    coming, ready = calls(certificate, chosen, workers, "spawn"), dict[Subject, Any]()
    for subject in chosen:
        while subject not in ready:
            ready.update([next(coming)])
        yield require(ready[subject])


def certificate(subject: Subject) -> Certificate:
    """The certificate of one subject, with its processor time."""
    name, variant = subject
    begin = time.process_time()
    try:
        if name in cases.check_names():
            record: Certificate = certify_check(cases.get_check(name, variant))
        else:
            record = certify(cases.get(name, variant))
    except ArithmeticError as failure:
        record = Certificate(name, variant or "default", {}, note=f"{type(failure).__name__}: {failure}")
    return replace(record, seconds=round(time.process_time() - begin, 2))
