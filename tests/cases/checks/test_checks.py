"""Every check: its closed form agrees with its independent computation over its domain; bad numbers are refused."""

from fractions import Fraction

import pytest
from breadth import tenth
from gnomon.cases import check_class, check_names, get_check
from gnomon.cases.core.check import Check
from gnomon.cases.core.numbers import Range
from gnomon.harness.certification.certify_checks import REQUIRED, certify_check
from hypothesis import assume, given, settings
from hypothesis import strategies as st

VARIANTS = [(name, variant.name) for name in check_names() for variant in check_class(name).variants]


@pytest.mark.parametrize(("name", "variant"), [*((name, None) for name in check_names()), *tenth(VARIANTS)])
def test_closed_form_agrees_with_its_independent_computation(name: str, variant: str | None) -> None:
    """Every check on its defaults, and a tenth of the variants in `make test`: other numbers are drawn below."""
    certificate = certify_check(get_check(name, variant))
    assert certificate.passed, certificate
    assert certificate.digits >= REQUIRED


@pytest.mark.parametrize("name", check_names())
def test_closed_form_holds_over_the_domain(name: str) -> None:
    kind = check_class(name)

    @settings(max_examples=2)
    @given(st.data())
    def holds(data: st.DataObject) -> None:
        numbers = {}
        for parameter in kind.parameter_list:
            low, high = kind.domain.ranges.get(parameter.name, Range()).typical
            # Multiples of 1e-3 of the range, so that numbers are zero or far from it, but not 1e-300.
            numbers[parameter.name] = low + (high - low) * data.draw(st.integers(1, 999)) / 1000
        assume(kind.domain.admits({name: Fraction(value) for name, value in numbers.items()}))
        certificate = certify_check(kind(**numbers))
        assert certificate.passed, certificate

    holds()


@pytest.mark.parametrize(
    ("name", "numbers", "message"),
    [
        ("inertia_tensor_special_bodies", {"m": -1}, "m = -1 is outside"),
        ("inertia_tensor_special_bodies", {"r": float("nan")}, "not finite"),
        ("inertia_tensor_special_bodies", {"radius": 1}, "has no parameter 'radius'"),
        ("inertia_tensor_special_bodies", {"r": 2}, "r <= R"),
        ("inertia_composite_parallel_axis", {"r": "0.2"}, "the hole lies in the box"),
        ("inertia_transformation_principal", {"Izz": 9}, "triangle inequality"),
        ("inertia_transformation_principal", {"nx": 0, "ny": 0, "nz": 0}, r"\(nx, ny, nz\) is not zero"),
        ("moment_equipollent", {"Fx": 0, "Fy": 0, "Fz": 0}, "a couple has no axis"),
        ("gravity_field_particle_body", {"r": "6.4e6"}, "the shell's field jumps"),
        ("com_rigid_body", {"m1": "-0.4"}, "m1 \\+ m2 \\+ m3 is not zero"),
        ("conservative_force_test", {"X": "1.1", "Y": 0}, "does not pass through the origin"),
        ("hamilton_action", {"mode": "0.5"}, "mode = 0.5 is outside"),
        ("hamilton_action", {"mode": "1.5"}, "mode is a whole number"),
        ("work_energy_rigid_body", {"I3": 9}, "triangle inequality"),
        ("work_energy_rigid_body", {"p_phi": "-4.5"}, "differs from p_psi and -p_psi"),
    ],
)
def test_bad_numbers_are_named(name: str, numbers: dict[str, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        get_check(name, **numbers)


def test_an_unknown_name_is_answered_with_the_nearest() -> None:
    with pytest.raises(ValueError, match="did you mean com_rigid_body"):
        get_check("com_rigid_bodies")
    with pytest.raises(ValueError, match="has no variant 'exact_doubel'; did you mean exact_double"):
        get_check("inertia_transformation_principal", "exact_doubel")


def test_one_double_beyond_the_triangle_inequality_is_refused() -> None:
    flat = {"Ixx": 1, "Iyy": 2, "Izz": 3, "Ixy": 0, "Ixz": 0, "Iyz": 0}
    assert get_check("inertia_transformation_principal", **flat).exact(20)["principal.largest"] == 3
    with pytest.raises(ValueError, match="triangle inequality"):
        get_check("inertia_transformation_principal", **flat | {"Izz": 3 + 2**-51})


def test_multiplicity_is_decided_exactly() -> None:
    coinciding = {
        variant: int(get_check("inertia_transformation_principal", variant).exact()["coinciding"])
        for variant in ("near_double", "near_double_1e_15", "exact_double", "exact_double_least", "exact_triple")
    }
    assert list(coinciding.values()) == [1, 1, 2, 2, 3]


def test_numbers_that_the_book_gives() -> None:
    # A body dropped from 158.5 m at latitude 51 degrees lands 27.5 mm to the east.
    drop = get_check("projectile_coriolis_first_order", "drop", lat="0.8901179185171081")
    assert float(drop.exact()["coriolis.x"]) == pytest.approx(0.0275, abs=1e-4)
    hanging = get_check("generalized_impulse", "percussion").exact(30)
    assert abs(hanging["first_rate"]) < 1e-25
    loop = get_check("rod_tension_circular", "loop").exact(30)
    assert loop["extreme.top"] == 0
    assert loop["extreme.bottom"] == 60


def ratio(check: str, variant: str, part: str, whole: str) -> float:
    found = get_check(check, variant).exact(30)
    return abs(float(found[part] / found[whole]))


def test_variants_do_what_they_say() -> None:
    """The numbers in `stresses`, which have one or two digits."""
    assert ratio("rotor_dynamic_balance", "one_bearing_free", "bearing.A", "bearing.B") == pytest.approx(1e-6, rel=0.2)
    assert ratio("work_energy_rigid_body", "slow_turn", "rotational", "kinetic") == pytest.approx(2e-22, rel=0.2)
    assert ratio("work_energy_rigid_body", "fast_top", "top_work", "top_kinetic") == pytest.approx(4e-12, rel=0.2)
    assert ratio("inertia_transformation_principal", "aspect_1e8", "principal.least", "principal.largest") < 1e-15
    fallen = 20 - get_check("falling_target", "fast").exact(30)["height"]
    assert float(fallen) == pytest.approx(6e-15, rel=0.1)
    for variant, gap in (("near_double", 1.8e-15), ("near_double_1e_15", 1e-15), ("near_triple", 1.8e-15)):
        found = get_check("inertia_transformation_principal", variant).exact(40)
        apart = (found["principal.middle"] - found["principal.least"]) / found["principal.least"]
        assert float(apart) == pytest.approx(gap, rel=0.05)
    south = get_check("falkland_gunnery", "equator").exact(20)
    level = get_check("falkland_gunnery", "equator", vz=0, g="1e-20").exact(20)
    assert south["coriolis.x"] != 0
    assert abs(level["coriolis.x"]) < 1e-15


class Wrong(Check):
    """A check whose two computations differ in the thirtieth digit."""

    name = "wrong"
    title = section = ""
    parameter_list = ()
    domain = check_class("com_rigid_body").domain.__class__({})

    def formulas(self, p: object) -> dict[str, object]:
        from gnomon.reference.numerics.balls import ball

        return {"x": ball(1 + Fraction(1, 10**30))}

    def otherwise(self, mp: object, p: object) -> dict[str, object]:
        return {"x": 1}


def test_an_error_in_the_thirtieth_digit_shows() -> None:
    certificate = certify_check(Wrong())
    assert not certificate.passed
    assert 29 < certificate.ways["independent"] < 31
