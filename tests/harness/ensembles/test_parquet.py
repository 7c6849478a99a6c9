"""Samples in Parquet files: read back as they were, and refused unless they belong to one ensemble."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from gnomon.harness.ensembles import ensemble_run
from gnomon.harness.ensembles.draws import Varied
from gnomon.harness.ensembles.ensemble_run import Job
from gnomon.harness.ensembles.samples import Ensemble

from gnomon import load_ensemble

FAILS = Ensemble(
    "pendulum_simple", "planted_ensembles:Fails", 1e-9, (Varied("theta", -7.0, 7.0), Varied("omega", -8.0, 8.0))
)


def written(folder: Path, ensemble: Ensemble = FAILS) -> Path:
    folder.mkdir()
    ensemble_run.run(Job(ensemble, 600, folder=str(folder)))
    return folder


def test_samples_are_read_as_they_were(tmp_path: Path) -> None:
    frame = load_ensemble(written(tmp_path / "a"))
    right = FAILS.prepared.measured(0, 600)
    assert frame["index"].tolist() == list(range(600))
    assert frame["status"].tolist() == [str(status) for status in right.statuses]
    assert np.array_equal(frame["error"], right.errors, equal_nan=True)
    assert np.array_equal(frame[["number theta", "number omega"]], right.numbers)
    assert frame.attrs["units"] == {
        "index": "1", "status": "1", "error": "1", "number theta": "rad", "number omega": "rad/s",
    }  # fmt: skip
    assert frame.attrs["integrator"] == FAILS.integrator
    assert len(list((tmp_path / "a").iterdir())) == 3


def test_what_is_not_one_whole_ensemble_is_refused(tmp_path: Path) -> None:
    folder = written(tmp_path / "a")
    other = written(tmp_path / "b", replace(FAILS, seed=2))
    last = sorted(folder.iterdir())[-1]
    kept = last.read_bytes()
    cases = [
        (lambda: shutil.copy(sorted(other.iterdir())[-1], last), "of another ensemble"),
        (lambda: last.write_bytes(kept[: len(kept) // 2]), "cannot be read as Parquet"),
        (lambda: pd.DataFrame({"x": [1]}).to_parquet(last), "not written by gnomon ensemble"),
        (lambda: last.unlink(), "holds 512 of 600 samples"),
        (lambda: sorted(folder.iterdir())[0].unlink(), "begins with sample 0 is missing"),
    ]
    for damage, message in cases:
        damage()
        with pytest.raises(ValueError, match=message):
            load_ensemble(folder)


def test_a_folder_without_samples_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="holds no part"):
        load_ensemble(tmp_path)
