"""Files of other people's writers are read as they were written, and nothing else is: no pickle, no guess, no program."""

import os
import pickle
import zipfile
from pathlib import Path

import numpy as np
import pytest
from gnomon.harness.trajectories import reading
from gnomon.harness.trajectories.reading import read_frame, read_table
from motion_files import WRITERS

COLUMNS = {"t": np.linspace(0, 1, 9) ** 2, "theta": np.cos(np.arange(9.0)), "omega": -1e-7 * np.arange(9.0) - 1 / 3}


@pytest.mark.parametrize("form", WRITERS)
def test_a_file_gives_back_the_numbers_that_were_written(form: str, tmp_path: Path) -> None:
    """To the last bit: each writer keeps 17 digits, and a reader that rounded would limit every result."""
    ending, write, needs = WRITERS[form]
    pytest.importorskip(needs)
    write(tmp_path / f"motion{ending}", COLUMNS)
    found = read_table(tmp_path / f"motion{ending}")
    names = {name.rpartition(".")[2]: values for name, values in found.columns.items()}
    for name, values in COLUMNS.items():
        assert names[name].tolist() == values.tolist()
    assert not any(np.any(each) for each in found.resolution.values())


def text_file(folder: Path, text: str, name: str = "motion.csv", encoding: str = "utf-8") -> Path:
    (folder / name).write_text(text, encoding=encoding)
    return folder / name


@pytest.mark.parametrize(
    "text",
    [
        "t [s],theta [deg]\n0,1\n1,2\n",
        "t,theta\ns,deg\n0,1\n1,2\n",
        "# made by a program\n# t theta\n0 1\n1 2\n",
        "My simulation\nRun 7\n\nt;theta\n0;1\n1;2\n",
        "t|theta|\n0|1|\n1|2|\n",
        '"t","theta"\n"0","1"\n"1","2"\n',
        "t\ttheta\n0\t1\n1\t2\n// the end\n",
    ],
)
def test_headers_comments_and_separators(text: str, tmp_path: Path) -> None:
    found = read_table(text_file(tmp_path, text))
    assert {name: values.tolist() for name, values in found.columns.items()} == {"t": [0, 1], "theta": [1, 2]}
    if "deg" in text:
        assert found.units == {"t": "s", "theta": "deg"}


def test_a_degree_sign_of_a_spreadsheet_is_a_unit(tmp_path: Path) -> None:
    found = read_table(text_file(tmp_path, "t;phi [°]\n0;1,5\n1;2,5\n", encoding="latin-1"))
    assert found.units == {"phi": "°"}
    assert found.columns["phi"].tolist() == [1.5, 2.5]


def test_a_file_without_names_has_numbered_columns(tmp_path: Path) -> None:
    assert list(read_table(text_file(tmp_path, "0 1 2\n1 2 3\n")).columns) == ["#1", "#2", "#3"]


def test_the_digits_of_a_file_are_those_that_were_printed(tmp_path: Path) -> None:
    """Half a unit of the last digit, for fixed decimals and for significant digits without zeros at the end."""
    values = np.array([2.0, 1.23456789, 0.0123456789])
    for form, halves in (("%.4f", [5e-5] * 3), ("%.5g", [5e-5, 5e-5, 5e-7])):
        np.savetxt(tmp_path / "a.csv", np.column_stack([np.arange(3.0), values]), delimiter=",", fmt=["%.17g", form])
        assert read_table(tmp_path / "a.csv").resolution["#2"] == pytest.approx(halves)


def test_single_precision_has_its_own_digits() -> None:
    found = read_frame({"t": np.arange(3.0), "x": np.array([1, 2, 4], dtype=np.float32)})
    assert found.resolution["x"] == pytest.approx(2.0**-24 * np.array([1, 2, 4]))
    assert "t" not in found.resolution


def test_arrays_with_a_column_for_each_time_are_turned(tmp_path: Path) -> None:
    """A column-major program writes (dim, n); a vector of another length is a parameter, and is left out."""
    np.savez(tmp_path / "a.npz", t=np.arange(5.0), r=np.arange(10.0).reshape(2, 5), masses=np.ones(3))
    found = read_table(tmp_path / "a.npz")
    assert found.columns["r[1]"].tolist() == [5, 6, 7, 8, 9]
    assert set(found.columns) == {"t", "r[0]", "r[1]"}


def test_results_of_modelica_tools_are_read(tmp_path: Path) -> None:
    """Their matrices have a name in each column, and an alias with a sign for a variable that repeats another."""
    io = pytest.importorskip("scipy.io")

    def letters(texts: list[str]) -> np.ndarray:
        return np.array([list(each.ljust(16)) for each in texts])

    data = np.array([[0.0, 2.0], [0.5, 1.5], [1.0, 1.0]])
    io.savemat(
        tmp_path / "a.mat",
        {
            "Aclass": letters(["Atrajectory", "1.1", "", "binNormal"]),
            "name": letters(["time", "pendulum.phi", "minus"]),
            "description": letters(["", "", ""]),
            "dataInfo": np.array([[0, 1, 0, -1], [2, 2, 0, -1], [2, -2, 0, -1]]),
            "data_1": np.zeros((2, 1)),
            "data_2": data,
        },
    )
    found = read_table(tmp_path / "a.mat")
    assert {name: values.tolist() for name, values in found.columns.items()} == {
        "time": [0, 0.5, 1], "pendulum.phi": [2, 1.5, 1], "minus": [-2, -1.5, -1],
    }  # fmt: skip


REFUSED = {
    "t,x\n0,1\n1,abc\n2,3\n": "motion.csv:3: x = 'abc'",
    "t,x\n0,1\n1\n2,3\n": "motion.csv:3: 1 values",
    "t,x\n0,1,5\n1,2,5\n": "decimal commas with ;",
    "t,t\n0,1\n1,2\n": "two columns are called 't'",
    "t,x\n0,1_0\n1,2\n2,3\n": "1_0",
    "only words\nhere\n": "no rows of two or more numbers",
    "# a comment\n": "only comments",
    "": "an empty file",
}


@pytest.mark.parametrize("text", REFUSED)
def test_a_damaged_text_is_refused_with_its_place(text: str, tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=REFUSED[text].replace("(", r"\(")):
        read_table(text_file(tmp_path, text))


class Harm:
    """Makes a folder when it is unpickled."""

    def __init__(self, place: Path) -> None:
        self.place = place

    def __reduce__(self) -> tuple[object, ...]:
        return os.mkdir, (str(self.place),)


def test_no_object_is_unpickled(tmp_path: Path) -> None:
    harm = np.array([Harm(tmp_path / "harm")], dtype=object)
    np.savez(tmp_path / "a.npz", t=np.arange(3.0), x=harm)
    np.save(tmp_path / "a.npy", harm)
    (tmp_path / "a.pkl").write_bytes(pickle.dumps(harm))
    for name in ("a.npz", "a.npy", "a.pkl"):
        with pytest.raises(ValueError, match="would be executed"):
            read_table(tmp_path / name)
    assert not (tmp_path / "harm").exists()


def test_a_link_of_hdf5_to_another_file_is_not_followed(tmp_path: Path) -> None:
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "secret.h5", "w") as file:
        file["x"] = np.arange(4.0)
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["t"] = np.arange(4.0)
        file["link"] = h5py.ExternalLink("secret.h5", "/x")
    assert list(read_table(tmp_path / "a.h5").columns) == ["t"]


def test_a_packed_file_that_unpacks_to_too_much_is_refused_before_it_is_unpacked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A few kilobytes may hold gigabytes of zeros."""
    monkeypatch.setattr(reading, "MOST_BYTES", 2**22)
    with zipfile.ZipFile(tmp_path / "a.npz", "w", zipfile.ZIP_DEFLATED) as packed, packed.open("t.npy", "w") as file:
        file.write(bytes(2**23))
    assert (tmp_path / "a.npz").stat().st_size < 2**16
    with pytest.raises(ValueError, match="give at most"):
        read_table(tmp_path / "a.npz")


@pytest.mark.parametrize("ending", [".npz", ".mat", ".h5", ".parquet", ".json", ".jsonl", ".npy"])
def test_a_cut_or_foreign_file_is_refused_in_one_line(ending: str, tmp_path: Path) -> None:
    pytest.importorskip("h5py")
    pytest.importorskip("pyarrow")
    (tmp_path / f"a{ending}").write_bytes(b"PK\x03\x04 this is no such file {")
    with pytest.raises(ValueError, match=r"a\.") as caught:
        read_table(tmp_path / f"a{ending}")
    assert len(str(caught.value).splitlines()) == 1


@pytest.mark.parametrize("name", ["a.xlsx", "a.csv.gz", "folder", "nothing.csv"])
def test_other_things_are_refused_with_the_way_out(name: str, tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    if name.startswith("a."):
        (tmp_path / name).write_bytes(b"PK\x03\x04")
    with pytest.raises(ValueError, match=r"save its sheet as CSV|unpack it|give a file"):
        read_table(tmp_path / name)
