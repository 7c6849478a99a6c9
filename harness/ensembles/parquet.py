"""Write the samples of an ensemble as Parquet files, one a part, and read them (`gnomon.load_ensemble`)."""

from __future__ import annotations

import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
from gnomon.harness.contract.status import Status
from gnomon.harness.ensembles.exact_formulas import NO_EXACT_STATE, OUTSIDE
from gnomon.harness.ensembles.samples import Ensemble, Samples
from gnomon.harness.system import extras
from gnomon.reference.storage import diskcache

KEY, VERSION = b"gnomon.ensemble", 1
STATUSES = (*Status, OUTSIDE, NO_EXACT_STATE)


def write(folder: Path, ensemble: Ensemble, samples: int, part: Samples) -> None:
    """Write a part: columns index, status, error and the varied numbers, with units in the fields' metadata."""
    import pyarrow as pa  # slow to load, and needed only if samples are kept
    import pyarrow.parquet as pq

    schema = _schema(pa, ensemble, samples)
    columns = [
        pa.array(np.arange(part.first, part.first + len(part.errors))),
        pa.array([str(status) for status in part.statuses]).dictionary_encode(),
        pa.array(part.errors, mask=np.isnan(part.errors)),
        *(pa.array(column) for column in part.numbers.T),
    ]
    with diskcache.whole(folder / f"part-{part.first:010d}.parquet") as file:
        pq.write_table(pa.Table.from_arrays(columns, schema=schema), file)


def _schema(pa: Any, ensemble: Ensemble, samples: int) -> Any:
    unit = ensemble.prepared.unit
    about = {"version": VERSION, "samples": samples, **asdict(ensemble)}

    def field(name: str, kind: Any, unit_: str) -> Any:
        return pa.field(name, kind, metadata={"unit": unit_})

    return pa.schema(
        [
            field("index", pa.int64(), "1"),
            field("status", pa.dictionary(pa.int32(), pa.string()), "1"),
            field("error", pa.float64(), "1"),
            *(field(f"number {number.name}", pa.float64(), unit(number.name)) for number in ensemble.vary),
        ],
        metadata={KEY: json.dumps(about).encode()},
    )


def load_ensemble(path: str | Path, dask: bool = False) -> Any:
    """Read the samples that `gnomon ensemble --parquet` wrote into a folder.

    Parameters
    ----------
    path : str or Path
        The folder.
    dask : bool
        Whether to return a Dask dataframe, for samples that do not fit into memory.

    Returns
    -------
    pandas.DataFrame or dask.dataframe.DataFrame
        A row for each sample, sorted by index. Columns: index; status; error, relative to the size of the motion, nan
        unless the status is ok; and `number NAME` for each number that varies, in the unit of the case. The `attrs` of
        a pandas DataFrame hold the ensemble and the units of the columns.

    Raises
    ------
    ValueError
        For a file that gnomon did not write, for parts of two ensembles, for missing parts, and without the extra that
        reads them.

    Examples
    --------
    After `gnomon ensemble --case pendulum_simple --integrator gnomon:DOP853 --samples 1024 --parquet samples`:

    >>> load_ensemble("samples")["error"].describe()  # doctest: +SKIP
    """
    extras.require("report", "load_ensemble")
    if dask:
        extras.require("cluster", "load_ensemble(dask=True)")
    import pandas as pd  # slow to load, like the next ones
    import pyarrow as pa
    import pyarrow.parquet as pq

    files = sorted(Path(path).glob("part-*.parquet"))
    if not files:
        raise ValueError(f"{path}: holds no part-*.parquet; give the folder of gnomon ensemble --parquet")
    first: Any = None
    rows = 0
    for file in files:
        try:
            opened = pq.ParquetFile(file)
            schema, count = opened.schema_arrow, opened.metadata.num_rows
            opened.close()
        except (pa.ArrowException, OSError) as error:
            raise ValueError(f"{file}: cannot be read as Parquet ({str(error)[:100]})") from None
        first = schema if first is None else first
        _verify(file, schema, first)
        if file.name != f"part-{rows:010d}.parquet":
            raise ValueError(f"{path}: the part that begins with sample {rows} is missing; run the ensemble again")
        rows += count
    about = json.loads(first.metadata[KEY])
    if rows != about["samples"]:
        raise ValueError(f"{path}: holds {rows} of {about['samples']} samples; run the ensemble again")
    if dask:
        from dask import dataframe

        return dataframe.read_parquet([str(file) for file in files])
    frame = pd.concat([pq.read_table(file).to_pandas().astype({"status": str}) for file in files], ignore_index=True)
    if not np.array_equal(frame["index"], np.arange(rows)) or not frame["status"].isin(STATUSES).all():
        raise ValueError(f"{path}: gnomon writes other indices or statuses; run the ensemble again")
    frame.attrs = about | {"units": {f.name: f.metadata[b"unit"].decode() for f in first}}
    return frame


def _verify(file: Path, schema: Any, first: Any) -> None:
    """Raise ValueError unless gnomon wrote the schema and it equals the first schema."""
    metadata = schema.metadata or {}
    try:
        about = json.loads(metadata[KEY])
        names = [f"number {number['name']}" for number in about["vary"]]
        ours = about["version"] == VERSION and isinstance(about["samples"], int)
        ours = ours and schema.names == ["index", "status", "error", *names]
        ours = ours and all(b"unit" in (field.metadata or {}) for field in schema)
    except (KeyError, TypeError, ValueError):
        ours = False
    if not ours:
        raise ValueError(f"{file}: not written by gnomon ensemble, or by another version; run the ensemble again")
    if not schema.equals(first, check_metadata=True):
        raise ValueError(f"{file}: of another ensemble than the first part; keep each ensemble in a folder of its own")
