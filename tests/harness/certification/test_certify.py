"""Every exact motion is confirmed in independent ways, and a wrong one is not."""

import errno
import json
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import pytest
from breadth import cheap_and_tenth
from gnomon.cases import case_class, check_names, get, names
from gnomon.cases.core.forms import SecondOrder, Values
from gnomon.cases.flight.projectile_parabola import ProjectileParabola
from gnomon.cases.pendulums.pendulum_simple import PendulumSimple
from gnomon.harness.certification import certify_all, certify_long
from gnomon.harness.certification.certify import ball_digits, certify, write
from gnomon.reference.numerics.motion import Motion


@pytest.mark.parametrize("name", cheap_and_tenth(names()))
def test_default_case_is_certified(name: str) -> None:
    certificate = certify(get(name))
    assert certificate.digits >= certificate.required, certificate
    assert certificate.passed, certificate


BY_FLIGHTS = ("bouncing_ball", "block_incline_friction")
FEW_SECONDS = [
    *(("projectile_parabola", name, None) for name in (None, *(v.name for v in ProjectileParabola.variants))),
    *(("kepler_orbit", name, None) for name in ("hyperbolic", "parabolic", "plunge")),
    *(("kepler_orbit", f"near_parabolic_{name}", None) for name in ("bound", "unbound")),
    ("kepler_orbit", None, 4),  # past the apocentre
    *((name, None, 60) for name in ("foucault_pendulum_linear", "foucault_precession")),
    ("foucault_pendulum_linear", "turntable", 3),
    *(("euler_top", name, 2) for name in (None, "separatrix", "near_symmetric", "oblate", "sphere", "flips_1e12")),
    # a million events take seconds to list, and `elastic` has the same motion
    *((name, v.name, None) for name in BY_FLIGHTS for v in case_class(name).variants if v.name != "elastic_1e6"),
]
"""Variants, some over a short span, for `make test`; the others run in `make test-all`."""


@pytest.mark.parametrize(("name", "variant", "span"), FEW_SECONDS)
def test_a_variant_is_certified_in_every_way_that_it_has(name: str, variant: str | None, span: int | None) -> None:
    certificate = certify(get(name, variant, span=span))
    assert certificate.digits >= (48 if name == "projectile_parabola" else certificate.required)
    assert certificate.passed
    assert {"rounding", "residual", *(() if name in BY_FLIGHTS else ("invariants",))} < set(certificate.ways)
    assert {"taylor", "windows"} & set(certificate.ways)
    assert ("ball" in certificate.ways) == (name == "euler_top")


HARD = [subject for subject in certify_all.subjects([], True) if subject[1] is not None]


@pytest.mark.slow
@pytest.mark.parametrize("subject", HARD, ids=["/".join(map(str, subject)) for subject in HARD])
def test_hard_variant_is_certified(subject: certify_all.Subject) -> None:
    certificate = certify_all.certificate(subject)
    assert certificate.passed, certificate


def wrong_sign(t: Any, q: Values, parameters: Values) -> Values:
    (theta,) = q
    g, length = parameters
    return (g / length * theta,)


class WrongEquations(PendulumSimple):
    """The exact motion of one system with the equations of another."""

    @property
    def forms(self) -> tuple[Any, ...]:
        return (SecondOrder(wrong_sign),)


def wrong(state: Callable[[Motion, Any, Fraction], Sequence[Any]], span: int) -> PendulumSimple:
    """A pendulum whose exact motion is `state(its motion, mp, t)`."""

    class Wrong(PendulumSimple):
        def motion(self) -> Motion:
            right = super().motion()

            class Off(Motion):
                def _state(self, mp: Any, t: Fraction) -> Sequence[Any]:
                    return state(right, mp, t)

                def _guard(self, t: Fraction) -> float:
                    return right._guard(t)

            return Off()

    return Wrong(span=span)


def nearly_right(motion: Motion, mp: Any, t: Fraction) -> Sequence[Any]:
    theta, omega = motion._state(mp, t)
    return theta + mp.mpf(t) * mp.mpf(10) ** -20, omega


def test_wrong_equations_show_in_residual_and_integration() -> None:
    ways = certify(WrongEquations(span=2)).ways
    assert ways["residual"] < 2
    assert ways["taylor"] < 2


def test_an_error_in_the_twentieth_digit_shows_in_every_independent_way() -> None:
    certificate = certify(wrong(nearly_right, 2))
    assert not certificate.passed
    assert 18 < certificate.ways["residual"] < 22
    assert 18 < certificate.ways["taylor"] < 22
    assert 18 < certificate.ways["invariants"] < 22


def test_certificates_are_written_for_the_report(tmp_path: Path) -> None:
    certificate = certify(get("projectile_parabola"))
    write([certificate], tmp_path / "certificates.json")
    (row,) = json.loads((tmp_path / "certificates.json").read_text())["rows"]
    assert row["case"] == "projectile_parabola"
    assert row["passed"] is True


@pytest.mark.parametrize("name", ["pendulum_simple", "euler_top", "lagrange_top", "spherical_pendulum"])
def test_balls_prove_the_digits_of_elliptic_motions(name: str) -> None:
    case = get(name)
    assert (ball_digits(case, [case.span / 3, case.span]) or 0) >= 45


def test_long_spans_are_certified_by_windows_group_and_seams() -> None:
    certificate = certify(get("pendulum_simple", "long_1e6"))
    assert set(certificate.ways) == {"rounding", "residual", "windows", "group", "seams", "ball", "invariants"}
    assert certificate.passed


def jumping(motion: Motion, mp: Any, t: Fraction) -> Sequence[Any]:
    """A motion that jumps by 1e-30 where theta passes zero, late in a long span."""
    theta, omega = motion._state(mp, t)
    return theta + (mp.mpf(10) ** -30 if t > 2900 and theta > 0 else 0), omega


def running(motion: Motion, mp: Any, t: Fraction) -> Sequence[Any]:
    """At a time too large by 1e-30 t^2: right at short times, but not a flow."""
    return motion._state(mp, t + t * t / 10**30)


def test_a_jump_where_a_branch_changes_shows_in_seams() -> None:
    seams = certify_long.seams(wrong(jumping, 3000))
    assert seams is not None
    # a jump of 1e-30 over a difference step of 1e-40
    assert seams < 0


def test_an_error_that_grows_with_time_shows_in_the_group_property() -> None:
    # 1e-30 of half the span squared
    assert 23 < (certify_long.group(wrong(running, 3000)) or 0) < 26


def test_a_case_that_cannot_be_certified_has_a_certificate_with_the_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(case: object) -> None:
        raise ArithmeticError("no precision is enough")

    monkeypatch.setattr(certify_all, "certify", fails)
    made = certify_all.certificate(("projectile_parabola", None))
    assert not made.passed
    assert made.note == "ArithmeticError: no precision is enough"


def test_subjects_are_cases_and_checks_and_two_processes_agree_with_one() -> None:
    chosen = certify_all.subjects(["projectile_parabola/default", "moment_equipollent"], True)
    assert chosen[:2] == [("projectile_parabola", None), ("moment_equipollent", None)]
    assert len(chosen) > 2
    one, two = ([replace(c, seconds=0.0) for c in certify_all.certificates(chosen, n)] for n in (1, 2))
    assert one == two
    assert (
        len(certify_all.subjects([], True)) > len(certify_all.subjects([], False)) == len(names()) + len(check_names())
    )
    with pytest.raises(ValueError, match="no variant 'wrong'"):
        certify_all.subjects(["pendulum_simple/wrong"], False)


def test_if_the_disk_is_full_the_former_certificates_stay(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "certificates.json"
    path.write_text("[]\n")

    def full(self: Path, text: str, *_: object, **__: object) -> int:
        self.write_bytes(text.encode()[:10])
        raise OSError(errno.ENOSPC, "No space left on device", str(self))

    monkeypatch.setattr(Path, "write_text", full)
    with pytest.raises(OSError, match="No space"):
        write((), path)
    assert [one.name for one in tmp_path.iterdir()] == ["certificates.json"]
    assert path.read_bytes() == b"[]\n"
