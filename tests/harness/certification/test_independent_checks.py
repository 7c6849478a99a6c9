"""Independent computations of the checks: accurate where the method is, and inaccurate where it loses digits."""

import json
from pathlib import Path

import pytest
from gnomon.cases import check_names, get_check
from gnomon.harness.certification import independent_checks
from gnomon.harness.certification.independent import IndependentComputation
from gnomon.harness.contract.integrator import Unsupported


def errors(check: str, variant: str | None, name: str) -> dict[str, float]:
    chosen = [one for one in independent_checks.COMPUTATIONS if one.name == name and one.check == check]
    found = independent_checks.run_checks([get_check(check, variant)], chosen, repeats=1)
    return {row["quantity"]: row["error"] for row in found}


def test_every_check_has_an_independent_computation() -> None:
    assert {one.check for one in independent_checks.COMPUTATIONS} == set(check_names())


def test_quadrature_of_bodies_keeps_its_tolerance() -> None:
    found = errors("inertia_tensor_special_bodies", None, "cubature")
    assert set(found) == {"box", "cylinder", "cone", "torus"}
    # The requested tolerance.
    assert max(found.values()) < 1e-12


def test_the_inertia_of_pybullets_shapes_is_correct_to_rounding() -> None:
    pytest.importorskip("pybullet", reason="pybullet has wheels up to CPython 3.11 only")
    found = errors("inertia_tensor_special_bodies", None, "inertia from shapes")
    assert set(found) == {"box", "sphere", "cylinder"}
    # A few operations of half an ulp each; the shapes' margins have no effect.
    assert max(found.values()) < 1e-15


def test_the_cubic_loses_half_the_digits_where_eigh_does_not() -> None:
    assert errors("inertia_transformation_principal", "near_double", "eigh")["principal"] < 1e-15
    assert errors("inertia_transformation_principal", "rod", "trigonometric cubic")["principal"] > 1e-10


def test_transfer_over_1e8_sizes_cancels() -> None:
    found = errors("inertia_composite_parallel_axis", "far_1e8", "parallel axes there and back")
    assert found["about_origin"] < 1e-14
    assert found["about_centre"] > 1e-3


def test_paths_and_particles() -> None:
    """Quadratures and pair sums are correct to rounding, differences to the error of their steps; at a distance of 1e-10
    differences have no correct digits."""
    assert max(errors("work_constant_linear_coulomb", None, "quad").values()) < 1e-12
    assert max(errors("work_constant_linear_coulomb", "flat_ellipse", "ellipe, asinh").values()) < 1e-15
    assert max(errors("internal_potential_energy", "close_pair", "sum over pairs").values()) < 1e-15
    assert max(errors("internal_potential_energy", None, "approx_fprime").values()) < 1e-6  # sqrt of an ulp, 1.5e-8
    assert errors("internal_potential_energy", "close_pair", "approx_fprime")["force1"] > 0.1
    assert errors("rod_tension_circular", "whirl", "solve_ivp")["tension"] < 1e-9
    assert max(errors("moment_momentum_moving_point", None, "central differences").values()) < 1e-9


def test_frames_and_rides() -> None:
    """Correct to rounding or to the tolerance; wrong if a hole lies between nodes or the result is below an ulp."""
    assert max(errors("com_rigid_body", None, "average, quad").values()) < 1e-12
    assert errors("com_rigid_body", "pin_hole", "average, quad")["plate"] > 0.1
    assert max(errors("gravity_field_particle_body", None, "quad over round bodies").values()) < 1e-12
    assert max(errors("apparent_gravity_earth", None, "formulas in doubles").values()) < 1e-15
    # sqrt of an ulp, 1.5e-8, over a second derivative of a few units
    assert errors("frame_transformation", None, "Rotation, second differences")["acceleration"] < 1e-5
    assert max(errors("material_frame_indifference", None, "Rotation").values()) < 1e-15
    assert errors("projectile_coriolis_first_order", "a_day", "solve_ivp")["beyond"] < 1e-12
    assert errors("projectile_coriolis_first_order", "slow", "solve_ivp")["beyond"] > 1
    assert errors("stability_pendulum_linearisation", None, "eigvals, solve_ivp")["angle"] < 1e-10
    assert max(errors("amusement_rides", None, "brentq").values()) < 1e-14
    assert max(errors("falling_target", None, "formulas in doubles").values()) < 1e-14


def test_rotors_and_energies() -> None:
    """Correct to rounding, or to the integrator's tolerance of 1e-12; a difference of 1e-15 of its terms is wrong."""
    assert max(errors("rotor_dynamic_balance", None, "Rotation, solve").values()) < 1e-15
    assert errors("rotor_dynamic_balance", "nearly_isotropic", "Rotation, solve")["I_xz"] > 1e-2
    found = errors("work_energy_rigid_body", None, "solve_ivp, quad")
    assert len(found) == 9
    # 1e-12 in each of some 50 steps; the power of the top is a tenth of its size in between.
    assert max(found.values()) < 1e-9


def test_failures_are_rows_with_their_status(tmp_path: Path) -> None:
    def failing(what: str) -> IndependentComputation:
        def compute(numbers: object) -> dict[str, float]:
            if what == "refuses":
                raise Unsupported("no such shape")
            if what == "raises":
                raise RuntimeError("broken")
            return {"hemisphere": float("nan") if what == "nan" else 1e3}

        library = "no_such_library" if what == "missing" else "numpy"
        return IndependentComputation(what, library, "com_rigid_body", compute)

    kinds = ("refuses", "raises", "nan", "wrong", "missing")
    found = independent_checks.run_checks([get_check("com_rigid_body")], [failing(kind) for kind in kinds], repeats=1)
    assert [row["status"] for row in found] == ["refused", "crashed", "diverged", "inaccurate", "not_installed"]
    independent_checks.write(found, tmp_path / "checks.json")
    rows = json.loads((tmp_path / "checks.json").read_text())["rows"]
    assert [row["reason"] for row in rows][:2] == ["no such shape", "RuntimeError: broken"]
    assert rows[2]["error"] is None
