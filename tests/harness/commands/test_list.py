"""`gnomon list` leaves nothing out, finds parts of names, and says what a method is for."""

import re

import pytest
from command_line import gnomon
from gnomon.cases.core.forms import Hybrid
from gnomon.harness.commands.list import purposes
from gnomon.harness.registry import lookup, selection
from gnomon.harness.stability import stiffness


def test_list_names_every_case_and_integrator_and_what_to_type_next(capfd: pytest.CaptureFixture[str]) -> None:
    from gnomon import cases

    assert gnomon("list") == 0
    text = capfd.readouterr().out
    words = re.sub(r"\s+", "", "".join(text.split("Integrators")[-1]))
    for name in cases.names():
        assert name in text
    for name in map(str.split, lookup.everything()):
        assert all(word in words for word in name)  # a long id has two lines
    (following,) = re.findall(r"^Next: (.*)", text, re.M)
    first = following.split(", ")[0].split()
    assert gnomon(*first[1:]) == 0, "what is named can be typed"


@pytest.mark.parametrize("what", ["integrators", "cases", "checks", "needs"])
def test_a_table_fits_its_width(what: str, capfd: pytest.CaptureFixture[str]) -> None:
    assert gnomon("list", what) == 0
    table, _ = capfd.readouterr().out.split("\nNext: ")
    assert max(map(len, table.splitlines())) <= 100


def test_narrow_tables_leave_no_letter_out(capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    from gnomon.cases.core.registry import entry, names

    monkeypatch.setenv("COLUMNS", "80")
    assert gnomon("list", "cases") == 0
    text = capfd.readouterr().out
    words = set(re.split(r"[\s,]+", text))
    for each in map(entry, names()):
        assert {each.name, *each.title.replace(",", " ").split(), *each.variants} <= words


def test_the_needs_are_the_subjects_of_recommend(capfd: pytest.CaptureFixture[str]) -> None:
    from gnomon.harness.results.advice import recommendations

    assert gnomon("list", "needs") == 0
    text = capfd.readouterr().out
    assert set(recommendations.subjects()) <= {line.split()[0] for line in text.splitlines() if line.strip()}
    (following,) = re.findall(r"^Next: gnomon (.*)", text, re.M)
    assert gnomon(*following.split()) == 0


@pytest.mark.parametrize(
    ("what", "part", "some", "other"),
    [
        ("cases", "KEPLER", "kepler_orbit", "pendulum_simple"),
        ("cases", "kepler_orbit/*", "kepler_orbit/e09", "Kepler orbit "),
        ("cases", "kepler_orbit/e09", "kepler_orbit/e0999", "hyperbolic"),
        ("checks", "moment", "moment_equipollent", "kepler"),
        ("integrators", "gauss", "gnomon:Gauss 2-stage", "RK4"),
        ("integrators", "scipy:*", "scipy:RK45", "gnomon:"),
    ],
)
def test_a_part_of_a_name_finds_it(
    what: str, part: str, some: str, other: str, capfd: pytest.CaptureFixture[str]
) -> None:
    assert gnomon("list", what, part) == 0
    text = capfd.readouterr().out
    assert some in text
    assert other not in text


def test_a_pattern_with_a_slash_is_all_variants_and_a_part_of_a_name_is_no_name() -> None:
    from gnomon import cases

    found = [case.id for case, _ in selection.choose(["kepler_orbit/*", "kepler_orbit"], variants=False)]
    variants = [variant.name for variant in cases.case_class("kepler_orbit").variants]
    assert found == ["kepler_orbit", *(f"kepler_orbit/{name}" for name in variants)]
    assert set(selection.expand(["moment*", "kepler*"], checks=True)) > {"moment_equipollent", "kepler_orbit"}
    with pytest.raises(ValueError, match="kepler_orbit"):
        selection.choose(["kepler"], variants=False)


def test_what_a_method_is_for_is_what_it_declares() -> None:
    for one in lookup.own().values():
        words = purposes(one)
        assert ("symplectic" in words) == ("symplectic" in one.conserves)
        assert ("events" in words) == any(issubclass(kind, Hybrid) for kind in one.accepts)
    assert set(lookup.own()) >= lookup.STIFF


def test_methods_for_stiff_equations_take_few_calls_where_stability_limits_the_others() -> None:
    """At a rate of 4000 the stability of an explicit method takes at least a call a unit of rate times time."""
    rate = 4000.0
    some = [one for one in lookup.find("scipy") if stiffness.first_order_reason(one) is None and one.counts_rhs]
    for one in (*some, *map(lookup.find_one, ("gnomon:Radau IIA 5", "gnomon:DOP853"))):
        calls = stiffness.row(one, rate, 1e-4)["calls"]
        assert (calls < rate * stiffness.SPAN / 4) == (one.id in lookup.STIFF), (one.id, calls)
