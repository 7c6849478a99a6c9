"""Certificates of checks: closed forms compared with an independent way, and with themselves in more digits."""

from dataclasses import dataclass
from typing import Any

from gnomon.cases.core.check import Check
from gnomon.harness.certification import agreement
from gnomon.harness.certification.agreement import DIGITS
from gnomon.harness.certification.certify import Certificate
from gnomon.reference.numerics.precision import working

REQUIRED = 40
"""Required digits of a closed form without motion."""


@dataclass(frozen=True)
class CheckCertificate(Certificate):
    """The confirmed digits of one check, the fewest of its quantities."""

    @property
    def passed(self) -> bool:
        """Whether both ways confirm at least the required digits."""
        return self.digits >= REQUIRED and set(self.ways) == {"independent", "rounding"}


def certify_check(check: Check) -> CheckCertificate:
    """Certify a check: `independent` is another way to the same quantities, `rounding` has three times the digits."""
    exact = check.exact(DIGITS)
    ways = {
        "independent": count_agreed_digits(check, exact, check.independent(DIGITS)),
        "rounding": count_agreed_digits(check, exact, check.exact(3 * DIGITS)),
    }
    return CheckCertificate(check.name, check.variant or "default", ways)


def count_agreed_digits(check: Check, first: dict[str, Any], second: dict[str, Any]) -> float:
    """The fewest decimal digits in which two sets of results agree, at most DIGITS; 0 if their names differ."""
    if first.keys() != second.keys():
        return 0.0
    sizes = check.sizes(first)
    with working(2 * DIGITS) as mp:
        return agreement.count_agreed_digits(
            (mp.mpf(first[name]) - mp.mpf(second[name]), mp.mpf(sizes[name])) for name in first
        )
