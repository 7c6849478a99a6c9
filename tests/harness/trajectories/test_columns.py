"""Columns become coordinates only by what is stated or by their own names; every convention gives the same motion."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from gnomon.cases.core import registry
from gnomon.harness.contract.problem import initial_state
from gnomon.harness.trajectories.columns import coordinate_sets, read_columns
from gnomon.harness.trajectories.reading import Table, read_frame
from gnomon.harness.trajectories.units import factor_to, parse_unit
from scipy.spatial.transform import Rotation

import gnomon

PENDULUM = gnomon.case("pendulum_simple").case
TOP = gnomon.case("euler_top").case
TIMES = np.linspace(0.1, 8, 12)
STATES = TOP.sample(TIMES)
MATRICES = STATES[:, 3:].reshape(-1, 3, 3)
QUATERNIONS = Rotation.from_matrix(MATRICES).as_quat()  # x, y, z, w


def table(**columns: Any) -> Table:
    return read_frame({"t": TIMES, **columns})


UNITS = {"deg": np.pi / 180, "deg/s": np.pi / 180, "rpm": np.pi / 30, "km": 1e3, "ft": 0.3048, "ms": 1e-3, "g": 9.80665,
         "km/h": 1 / 3.6, "m s^-1": 1.0, "rev/min": np.pi / 30, "m^(1/2)/s": 1.0, "au/d": 149597870700 / 86400}  # fmt: skip


@pytest.mark.parametrize("unit", UNITS)
def test_a_unit_has_its_size(unit: str) -> None:
    assert parse_unit(unit).factor == pytest.approx(UNITS[unit], rel=1e-15)


@pytest.mark.parametrize(
    ("unit", "wanted"), [("ms", "rad"), ("g", "rad"), ("m", "m/s"), ("deg", "m"), ("rad/s", "rad")]
)
def test_a_unit_of_another_dimension_is_refused(unit: str, wanted: str) -> None:
    with pytest.raises(ValueError, match=f"phi: {unit} is not a unit of a number in {wanted}"):
        factor_to(unit, wanted, "phi")


def test_names_of_coordinates_need_no_mapping_and_others_are_not_guessed() -> None:
    states = PENDULUM.sample(TIMES)
    found = read_columns(table(theta=states[:, 0], Omega=states[:, 1]), PENDULUM)
    assert found.states.tolist() == states.tolist()
    assert len(found.mapping) == 3
    with pytest.raises(ValueError, match=r"no column for theta .* the file has t, angle, omega"):
        read_columns(table(angle=states[:, 0], omega=states[:, 1]), PENDULUM)


def test_the_unit_of_the_file_counts_and_is_told() -> None:
    states = PENDULUM.sample(TIMES)
    read = table(theta=np.degrees(states[:, 0]), omega=states[:, 1])
    read.units["theta"] = "deg"
    found = read_columns(read, PENDULUM)
    assert np.allclose(found.states, states, rtol=1e-15)
    assert "theta is theta (deg, by the file)" in found.mapping


def test_a_mapping_states_columns_units_and_signs() -> None:
    states = PENDULUM.sample(TIMES)
    read = read_frame({"clock": 1e3 * TIMES, "sim.phi": -np.degrees(states[:, 0]), "w": states[:, 1] * 30 / np.pi})
    found = read_columns(read, PENDULUM, "clock=t:ms,phi=theta:deg:negative,w=omega:rpm")
    assert np.allclose(found.times, TIMES, rtol=1e-15)
    assert np.allclose(found.states, states, rtol=1e-14)
    assert np.allclose(
        read_columns(read, PENDULUM, {"#1": "t:ms", "#2": "theta:deg:negative", "w": "omega:rpm"}).states, states
    )


WRONG = {
    "phi=theta": "no column is called 'phi'",
    "a=thet": "has no coordinate 'thet'; it has t, theta, omega",
    "a=theta:furlong": "no unit is called 'furlong'",
    "a=theta:deg:rad": "two units",
    "a=theta:wxyz": "wxyz",
    "a=theta,a=theta": "theta is given twice",
    "a": "write COLUMN=COORDINATE",
    "a=theta,,": "an empty part",
    "a=theta+omega": "1 columns for 2 numbers",
    "a+b=theta+omega": "theta, omega have several units",
    "a=attitude:wxyz": "has no attitude",
    "#9=theta": "has 3 columns",
    "a+b=theta": "2 columns for 1 numbers",
}


@pytest.mark.parametrize("text", WRONG)
def test_a_wrong_mapping_is_refused_and_names_the_part(text: str) -> None:
    with pytest.raises(ValueError, match=WRONG[text].replace("+", r"\+")):
        read_columns(table(a=TIMES, b=TIMES), PENDULUM, text)


def test_columns_of_an_array_keep_commas_in_their_names() -> None:
    read = table(R=MATRICES, w=STATES[:, :3])
    assert "R[0,1]" in read.columns
    found = read_columns(read, TOP, "R=attitude:matrix,w=rates:body")
    assert found.states.tolist() == STATES.tolist()
    one_by_one = ",".join(f"R[{i},{j}]=R{i + 1}{j + 1}" for i in range(3) for j in range(3))
    assert read_columns(read, TOP, f"{one_by_one},w=w1+w2+w3").states.tolist() == STATES.tolist()


Y_UP = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]])
"""To a frame with y up."""
IN_SPACE = np.einsum("nij,nj->ni", MATRICES, STATES[:, :3])
CONVENTIONS = {
    "q=attitude:xyzw,w=rates:body": (QUATERNIONS, STATES[:, :3]),
    "q=attitude:wxyz,w=rates:body": (QUATERNIONS[:, [3, 0, 1, 2]], STATES[:, :3]),
    "q=attitude:xyzw:conjugate,w=rates:body": (QUATERNIONS * [-1, -1, -1, 1], STATES[:, :3]),
    "q=attitude:xyzw,w=rates:space": (QUATERNIONS, IN_SPACE),
    "q=attitude:ZYX:deg,w=rates:body:deg/s": (
        Rotation.from_matrix(MATRICES).as_euler("ZYX", degrees=True), np.degrees(STATES[:, :3]),
    ),
    "q=attitude:xyz,w=rates:body": (Rotation.from_matrix(MATRICES).as_euler("xyz"), STATES[:, :3]),
    "q=attitude:matrix:transposed,w=rates:body": (np.swapaxes(MATRICES, 1, 2), STATES[:, :3]),
    "q=attitude:matrix:y-up,w=rates:body:y-up": (Y_UP @ MATRICES @ Y_UP.T, STATES[:, :3] @ Y_UP.T),
    "q=attitude:matrix:y-up-space,w=rates:space:y-up-space": (Y_UP @ MATRICES, IN_SPACE @ Y_UP.T),
}  # fmt: skip


@pytest.mark.parametrize("text", CONVENTIONS)
def test_each_convention_of_attitudes_and_rates_gives_the_same_motion(text: str) -> None:
    attitude, rates = CONVENTIONS[text]
    found = read_columns(table(q=attitude, w=rates), TOP, text)
    assert np.allclose(found.states, STATES, atol=1e-14)


@pytest.mark.parametrize("text", ["q=attitude:wxyz,w=rates:body", "q=attitude:xyzw:conjugate,w=rates:body"])
def test_a_wrong_convention_gives_another_motion(text: str) -> None:
    """Or else the test above would see nothing."""
    found = read_columns(table(q=QUATERNIONS, w=STATES[:, :3]), TOP, text)
    assert np.max(np.abs(found.states - STATES)) > 0.1


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("q=attitude,w=rates:body", "how is the attitude written"),
        ("q=attitude:xyzw,w=rates", "along which axes"),
        ("w=rates:space", "map the attitude too"),
        ("q=attitude:ZYX,w=rates:body", "4 columns, ZYX has 3"),
        ("w=attitude:xyz:m,w=rates:body", "m is not a unit"),
    ],
)
def test_an_attitude_without_its_convention_is_refused(text: str, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        read_columns(table(q=QUATERNIONS, w=STATES[:, :3]), TOP, text)


def test_numbers_far_from_an_attitude_are_refused() -> None:
    with pytest.raises(ValueError, match="norm of a quaternion is 2"):
        read_columns(table(q=2 * QUATERNIONS, w=STATES[:, :3]), TOP, "q=attitude:xyzw,w=rates:body")


@pytest.mark.parametrize(
    "name", ["double_pendulum", "spherical_pendulum", "stiff_spring_pendulum", "cycloidal_pendulum"]
)
def test_the_columns_of_each_formulation_are_accepted(name: str) -> None:
    """By their names; the file decodes to the start of the case, which the formulation encodes in high precision."""
    case = registry.case_class(name)()
    (chart,) = [each for each in coordinate_sets(case) if each.formulation is not None]
    assert chart.names[0] != "y1", "the file of names has this formulation"
    start = initial_state(case, chart.formulation)
    assert len(start) == len(chart.names)
    columns = dict(zip(chart.names, np.tile(start, (len(TIMES), 1)).T, strict=True))
    found = read_columns(read_frame({"t": TIMES, **columns}), case)
    own = np.array([float(x) for x in case.initial_state])
    assert np.allclose(found.states, own, atol=1e-14)


def test_a_position_in_a_frame_with_y_up_is_turned() -> None:
    case = gnomon.case("spherical_pendulum").case
    names = list(coordinate_sets(case)[1].names)
    start = initial_state(case, coordinate_sets(case)[1].formulation)
    x, v = start[:3] @ Y_UP.T, start[3:] @ Y_UP.T
    read = table(x=np.tile(x, (12, 1)), v=np.tile(v, (12, 1)))
    found = read_columns(read, case, f"x={'+'.join(names[:3])}:y-up,v={'+'.join(names[3:])}:y-up")
    assert np.allclose(found.states[0], [float(each) for each in case.initial_state])


def test_a_wrapped_angle_is_unwrapped_on_request() -> None:
    angles = np.linspace(0, 20, 12)
    read = table(theta=np.remainder(angles, 2 * np.pi), omega=angles)
    assert np.allclose(read_columns(read, PENDULUM, "theta=theta:wrapped").states[:, 0], angles)
    assert not np.allclose(read_columns(read, PENDULUM).states[:, 0], angles)


def test_times_that_are_rounded_are_told_from_times_that_are_exact(tmp_path: Path) -> None:
    """0.05, 0.10, 0.15 are exact; 0.033, 0.067, 0.100 are thirds of a tenth that were rounded."""
    from gnomon.harness.trajectories.reading import read_table

    for step, half in ((0.05, 0), (1 / 30, 5e-4)):
        times = step * np.arange(20)
        np.savetxt(
            tmp_path / "a.csv",
            np.column_stack([times, PENDULUM.sample(times)]),
            "%.3f,%.17g,%.17g",
            header="t,theta,omega",
            comments="",
        )
        assert read_columns(read_table(tmp_path / "a.csv"), PENDULUM).half_time == pytest.approx(half)
