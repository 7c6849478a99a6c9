"""`gnomon scene`: exact files, only in the folder that is named; refusals that name the reason; point masses replaced exactly."""

import csv
import hashlib
import json
import re
import subprocess
import sys
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from command_line import gnomon
from gnomon.cases import get, names
from gnomon.cases.core.scene import TOKENS
from gnomon.harness.scene_files.tree import LEAST, STATED, Link, tree_of
from gnomon.harness.scene_files.written import FORMATS, list_unstated, write
from gnomon.harness.scene_files.xml import number
from on_cases import exact_states

ROOT = Path(__file__).parents[3]
SCENES = {name: each.needs for name in names() if (each := get(name).scene) is not None}
HALF_ULP = Fraction(1, 2**53)


def link_of(name: str, index: int = 0, **numbers: Any) -> Link:
    return tree_of(get(name, **numbers).rounded()).links[index]


def table(path: Path) -> list[dict[str, str]]:
    with path.open() as file:
        return list(csv.DictReader(file))


def test_numbers_are_the_shortest_that_give_the_same_double() -> None:
    for value in (0.1, 1 / 3, 2.0**-1074, 1.7976931348623157e308, 9.81, 1e22, 0.30000000000000004):
        assert float(number(value)) == value
        digits = len(Decimal(number(value)).normalize().as_tuple().digits)
        assert digits == 1 or float(f"{value:.{digits - 2}e}") != value
    assert number(-0.0) == "0.0"


@pytest.mark.parametrize("length", ["1", "0.7", "1.234567890123456"])
def test_a_point_mass_on_a_fixed_hinge_keeps_its_moments(length: str) -> None:
    """The first moment, to which gravity is proportional, exactly; the moment about the pivot within its roundings."""
    link = link_of("pendulum_simple", L=length)
    m, arm = Fraction(link.mass), [Fraction(x) for x in link.centre]
    full = Fraction(float(length))
    assert [m * x for x in arm] == [0, 0, -full]
    about = m * arm[2] ** 2 + Fraction(link.inertia[1])
    assert abs(about / full**2 - 1) <= 2 * HALF_ULP
    a, b, c = link.inertia
    assert a + b >= c > 0  # a rigid body has such moments


def test_a_point_mass_on_a_ball_joint_keeps_its_moments_and_has_no_spin_about_its_arm() -> None:
    link = link_of("spherical_pendulum")
    arm = [2 * Fraction(x) for x in link.centre]
    square = sum(x * x for x in arm)
    about = Fraction(link.mass) * square / 4 + Fraction(link.inertia[0])
    assert abs(about / square - 1) <= 4 * HALF_ULP
    assert len(set(link.inertia)) == 1
    along = sum(Fraction(w) * x for w, x in zip(link.spin, arm, strict=True))
    assert abs(along) <= 8 * HALF_ULP * max(map(abs, map(Fraction, link.spin)))


def test_a_point_mass_on_a_hinge_that_moves_says_that_it_is_not_exact() -> None:
    lower = link_of("double_pendulum", 1)
    assert lower.inertia == (LEAST,) * 3
    assert "not exact, 2e-15 of its moment" in lower.replaced
    assert lower.parent == "upper"
    assert lower.place == (0.0, 0.0, -1.0)


@pytest.mark.parametrize("form", FORMATS)
def test_a_scene_that_a_format_cannot_state_is_refused(form: str, tmp_path: Path) -> None:
    """Also forces, guides, ropes, torques and blows are in no file: a scene with one has a token that is refused."""
    assert set(TOKENS) >= STATED
    able = [name for name, needs in SCENES.items() if not list_unstated(needs, form)]
    assert 0 < len(able) < len(SCENES)
    for name in able:
        case = get(name).rounded()
        assert case.scene is not None
        scene = case.scene.build(tuple(map(float, case.initial_state)), tuple(map(float, case.parameter_values())))
        assert not [*scene.forces, *scene.guides, *scene.ropes, *scene.torques, *scene.impulses], name
        assert not any(hinge.friction for hinge in scene.hinges), name
        assert not any(slider.drive for slider in scene.sliders), name
        assert not any(any(contact.velocity) or contact.adhesive for contact in scene.contacts), name
        assert FORMATS[form].text(tree_of(case))
    for name in SCENES.keys() - able:
        with pytest.raises(ValueError, match=list_unstated(SCENES[name], form)[0]):
            write(get(name), form, tmp_path)
    assert not list(tmp_path.iterdir())


def test_a_law_that_the_tokens_do_not_name_is_not_left_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A case of a user's own may forget a token."""
    case = get("harmonic_oscillator")
    assert case.scene is not None
    monkeypatch.setattr(type(case), "scene", replace(case.scene, needs=frozenset({"slider"})))
    with pytest.raises(ValueError, match="has forces"):
        write(case, "mjcf", tmp_path)


def test_urdf_refuses_a_ball_joint_and_two_free_bodies() -> None:
    assert list_unstated(SCENES["lagrange_top"], "urdf") == ["ball_joint"]
    assert list_unstated(SCENES["newtons_cradle"], "urdf") == ["body_contact"]
    assert not list_unstated(SCENES["lagrange_top"], "sdf")


@pytest.mark.parametrize("name", ["lagrange_top", "bouncing_ball", "double_pendulum", "projectile_parabola"])
def test_the_manifest_has_the_hashes_the_start_and_the_exact_numbers(name: str, tmp_path: Path) -> None:
    case = get(name).rounded()
    files = write(case, "sdf", tmp_path)
    manifest = json.loads(files.manifest.read_text())
    for file, digest in manifest["sha256"].items():
        assert hashlib.sha256((tmp_path / file).read_bytes()).hexdigest() == digest
    assert set(manifest["sha256"]) == {files.scene.name, files.motion.name}
    for each, value in case.numbers.items():
        written = (manifest["parameters"] | manifest["initial_state"])[each]
        assert Fraction(float(written["decimal"])) == value == Fraction(float.fromhex(written["hexadecimal"]))
    first, *rows = table(files.motion)
    assert list(first) == list(manifest["columns"])
    assert [float(row["t"]) for row in rows] == case.times.tolist()
    for row, state in zip(rows, exact_states(case).tolist(), strict=True):
        assert [float(row[f"state.{coordinate.name}"]) for coordinate in case.state] == state
    for joint, start in manifest["start"]["joints"].items():
        assert [float(first[f"joint.{joint}.{key}"]) for key in ("position", "rate")] == list(start.values())
    for body, start in manifest["start"]["bodies"].items():
        assert [float(first[f"body.{body}.v{axis}"]) for axis in "xyz"] == start["velocity"]


def test_an_attitude_that_nothing_determines_is_left_out(tmp_path: Path) -> None:
    """A point has none; the billiard ball rolls, and its case has none; that of another case has one."""
    for name, has in (("projectile_parabola", False), ("billiard_ball", False), ("billiard_ball_attitude", True)):
        (first, *_) = table(write(get(name), "mjcf", tmp_path).motion)
        assert any(column.endswith(".qw") for column in first) == has
        assert any(column.endswith(".wz") for column in first) == (name != "projectile_parabola")


def test_each_format_says_what_its_contacts_lack(tmp_path: Path) -> None:
    missing = {form: " ".join(write(get("bouncing_ball"), form, tmp_path).missing) for form in FORMATS}
    assert "restitution" in missing["mjcf"]
    assert "restitution" in missing["urdf"]
    assert "gravity" in missing["urdf"]
    text = (tmp_path / "bouncing_ball_sdf.sdf").read_text()
    found = [float(each.text or "") for each in ElementTree.fromstring(text).iter("restitution_coefficient")]
    assert found == [0.8, 0.8]
    assert json.loads((tmp_path / "bouncing_ball_urdf.json").read_text())["contacts"][0]["restitution"] == 0.8
    assert write(get("pendulum_simple"), "mjcf", tmp_path).missing == ()


def test_files_are_written_to_the_named_folder_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert gnomon("scene", "pendulum_simple", "--variant", "upright", "--format", "urdf", "--out", "new/scenes") == 0
    found = sorted(path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*") if path.is_file())
    assert found == [f"new/scenes/pendulum_simple_upright_urdf.{end}" for end in ("csv", "json", "urdf")]
    before = [(tmp_path / each).read_bytes() for each in found]
    assert gnomon("scene", "pendulum_simple/upright", "--format", "urdf", "--out", "new/scenes") == 0
    assert [(tmp_path / each).read_bytes() for each in found] == before


@pytest.mark.parametrize(
    ("arguments", "word"),
    [
        (["pendulum_simpl", "--out", "x"], "did you mean pendulum_simple"),
        (["pendulum_simple"], "--out"),
        (["kepler_orbit", "--out", "x"], "position_force (forces that depend on position)"),
        (["rubber_tube_thin", "--out", "x"], "has no scene"),
        (["capstan_belt", "--out", "x"], "is a check"),
        (["pendulum_simple/upright", "--variant", "rotation", "--out", "x"], "names a variant already"),
        (["--list", "--out", "x"], "leave out"),
    ],
)
def test_wrong_usage_is_one_line(
    arguments: list[str], word: str, capfd: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    assert gnomon("scene", *arguments) == 2
    (line,) = capfd.readouterr().err.splitlines()
    assert word in line
    assert not [path for path in tmp_path.rglob("*") if path.is_file()]


def test_the_list_has_every_scene_with_what_keeps_it_out(capfd: pytest.CaptureFixture[str]) -> None:
    assert gnomon("scene", "--list", "--format", "urdf") == 0
    lines = {words[0]: words[1:] for line in capfd.readouterr().out.splitlines() if (words := line.split())}
    for name, needs in SCENES.items():
        assert " ".join(lines[name]) == ", ".join(list_unstated(needs, "urdf"))


def test_the_example_of_the_documentation_needs_no_gnomon(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    (example,) = re.findall(r"^```py\n(.*?)^```$", (ROOT / "docs" / "engine.md").read_text(), re.M | re.S)
    (tmp_path / "scenes").mkdir()
    write(get("pendulum_simple"), "mjcf", tmp_path / "scenes")
    command = [sys.executable, "-c", f"import sys; sys.modules['gnomon'] = None\n{example}"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert re.match(r"errors [\d.e-]+ and [\d.e-]+ rad", done.stdout)
    scene = tmp_path / "scenes" / "pendulum_simple_mjcf.xml"
    scene.write_text(scene.read_text().replace("9.81", "9.82"))
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert "pendulum_simple_mjcf.xml was changed" in done.stderr
