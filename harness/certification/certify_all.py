"""Many certificates, in as many processes as asked for; one that cannot be made is a certificate without digits."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import replace

from gnomon.harness.certification.certify import Certificate, certify
from gnomon.harness.certification.certify_checks import certify_check
from gnomon.harness.system.child_process import interrupts_ignored, process_pool

from gnomon import cases

Setting = tuple[str, str | None]
"""The name of a case (or `package.module:Case`) or of a check, and of its variant."""


def settings(named: Sequence[str], variants: bool) -> list[Setting]:
    """What the names stand for: case, case/variant, check, check/variant; all variants too where asked.

    Raises ValueError for an unknown name.
    """
    found: list[Setting] = []
    for name in named or (*cases.names(), *cases.check_names()):
        base, slash, variant = name.partition("/")
        kind = cases.check_class(base) if base in cases.check_names() else cases.case_class(base)
        if slash:
            found.append((base, None if variant == "default" else variant))
            kind._variant(found[-1][1])
            continue
        found.append((base, None))
        if variants:
            found += [(base, setting.name) for setting in kind.variants]
    return found


def certificates(chosen: Sequence[Setting], workers: int = 1) -> Iterator[Certificate]:
    """A certificate of each setting, in order, as they are made."""
    if workers == 1 or len(chosen) == 1:
        yield from map(certificate, chosen)
        return
    with process_pool(workers, "spawn") as pool:
        with interrupts_ignored():
            made = pool.map(certificate, chosen)
        yield from made


def certificate(setting: Setting) -> Certificate:
    """The certificate of one setting, with the time that it took."""
    name, variant = setting
    begin = time.process_time()
    try:
        if name in cases.check_names():
            made: Certificate = certify_check(cases.get_check(name, variant))
        else:
            made = certify(cases.get(name, variant))
    except ArithmeticError as failure:
        made = Certificate(name, variant or "default", {}, note=f"{type(failure).__name__}: {failure}")
    return replace(made, seconds=round(time.process_time() - begin, 2))
