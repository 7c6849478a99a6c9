"""A picture of a motion has an orbit where the case has a plane, with equal scales."""

from typing import Any

import pytest
from gnomon.harness.measuring.drawn_motion import planes
from gnomon.harness.reporting.pictures.motion_picture import chart

from gnomon import cases


@pytest.mark.parametrize(
    ("name", "bodies"),
    [
        ("kepler_orbit", {"": ("x", "y")}),
        ("two_body", {"1": ("x1", "y1"), "2": ("x2", "y2")}),
        ("charge_in_E_and_B", {"": ("x", "y")}),
        ("small_vibrations_3dof_chain", {}),  # x1 and x2 are places on one line
        ("projectile_parabolic_coordinates", {}),
        ("pendulum_simple", {}),
    ],
)
def test_a_plane_has_two_cartesian_coordinates_of_a_body(name: str, bodies: dict[str, tuple[str, str]]) -> None:
    case = cases.get(name)
    found = {body: tuple(case.state[k].name for k in pair) for body, pair in planes(case).items()}
    assert found == bodies


@pytest.mark.parametrize("name", ["kepler_orbit", "two_body", "projectile_parabola"])
def test_an_orbit_has_equal_scales_and_every_point_inside(name: str) -> None:
    case: Any = cases.get(name)
    drawn = chart(case).to_dict(validate=False)
    orbit, *panels = drawn["vconcat"]
    assert len(panels) == len({coordinate.group for coordinate in case.state})
    across, up = (orbit["layer"][0]["encoding"][axis] for axis in ("x", "y"))
    lengths = [axis["scale"]["domain"][1] - axis["scale"]["domain"][0] for axis in (across, up)]
    assert lengths[0] / orbit["width"] == pytest.approx(lengths[1] / orbit["height"])
    for axis in (across, up):
        low, high = axis["scale"]["domain"]
        assert all(low < row[axis["field"]] < high for row in drawn["datasets"]["motion"])
