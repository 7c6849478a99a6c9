"""Files of motions for `gnomon check`: right motions by several methods, and the formats of other people's writers."""

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Floats = NDArray[np.float64]
Rates = Callable[[float, Floats], Floats]


def pendulum(t: float, y: Floats) -> Floats:
    return np.array([y[1], -9.81 * np.sin(y[0])])


def orbit(t: float, y: Floats) -> Floats:
    r3 = np.hypot(y[0], y[1]) ** 3
    return np.array([y[2], y[3], -y[0] / r3, -y[1] / r3])


def accurate(rates: Rates, start: list[float], times: Floats) -> Floats:
    """The motion to some 1e-11, by another library than gnomon."""
    found = solve_ivp(rates, (0, times[-1]), start, "DOP853", times, rtol=1e-13, atol=1e-13)
    return np.asarray(found.y.T)


def euler(rates: Rates, t: float, y: Floats, h: float) -> Floats:
    return y + h * rates(t, y)


def midpoint(rates: Rates, t: float, y: Floats, h: float) -> Floats:
    return y + h * rates(t + h / 2, y + h / 2 * rates(t, y))


def rk4(rates: Rates, t: float, y: Floats, h: float) -> Floats:
    k1 = rates(t, y)
    k2 = rates(t + h / 2, y + h / 2 * k1)
    k3 = rates(t + h / 2, y + h / 2 * k2)
    return y + h / 6 * (k1 + 2 * k2 + 2 * k3 + rates(t + h, y + h * k3))


def leapfrog(rates: Rates, t: float, y: Floats, h: float) -> Floats:
    n = len(y) // 2
    half = y[n:] + h / 2 * rates(t, y)[n:]
    q = y[:n] + h * half
    return np.concatenate([q, half + h / 2 * rates(t + h, np.concatenate([q, half]))[n:]])


def integrated(step: Callable[..., Floats], rates: Rates, start: list[float], h: float, rows: int, every: int) -> Any:
    """Times (rows + 1,) and states of a method with fixed steps, every so many steps."""
    y, states = np.array(start), [np.array(start)]
    for k in range(rows * every):
        y = step(rates, k * h, y, h)
        if (k + 1) % every == 0:
            states.append(y)
    return np.arange(rows + 1) * every * h, np.array(states)


Columns = Mapping[str, Floats]


def _table(columns: Columns) -> Floats:
    return np.column_stack(list(columns.values()))


def as_csv(path: Path, columns: Columns) -> None:
    np.savetxt(path, _table(columns), delimiter=",", header=",".join(columns), comments="", fmt="%.17g")


def as_pandas(path: Path, columns: Columns) -> None:
    import pandas  # as those below: a test that lacks it is skipped

    pandas.DataFrame(dict(columns)).to_csv(path, index=False)


def as_spreadsheet(path: Path, columns: Columns) -> None:
    """As a spreadsheet in German saves: semicolons, decimal commas, a mark of the byte order."""
    lines = [
        ";".join(columns),
        *(";".join(f"{x:.17g}".replace(".", ",") for x in row) for row in _table(columns).tolist()),
    ]
    path.write_text("\r\n".join(lines), encoding="utf-8-sig")


def as_fortran(path: Path, columns: Columns) -> None:
    """White space, exponents with D, names in a comment."""
    rows = ["  ".join(f"{x:24.16E}".replace("E", "D") for x in row) for row in _table(columns).tolist()]
    path.write_text("\n".join(["! " + "  ".join(columns), *rows]))


def as_tabs(path: Path, columns: Columns) -> None:
    np.savetxt(path, _table(columns), delimiter="\t", header="\t".join(columns), fmt="%.17g")


def as_json_lines(path: Path, columns: Columns) -> None:
    rows = [json.dumps(dict(zip(columns, row, strict=True))) for row in _table(columns).tolist()]
    path.write_text("\n".join(rows))


def as_json(path: Path, columns: Columns) -> None:
    path.write_text(json.dumps({name: values.tolist() for name, values in columns.items()}))


def as_npz(path: Path, columns: Columns) -> None:
    np.savez(path, **dict(columns))


def as_record(path: Path, columns: Columns) -> None:
    """One array of records."""
    found = np.zeros(len(next(iter(columns.values()))), dtype=[(name, "f8") for name in columns])
    for name, values in columns.items():
        found[name] = values
    np.savez(path, found)


def as_fmu_result(path: Path, columns: Columns) -> None:
    """As fmpy writes the result of a simulation."""
    from fmpy.util import write_csv

    found = np.zeros(len(next(iter(columns.values()))), dtype=[(name, "f8") for name in columns])
    for name, values in columns.items():
        found[name] = values
    write_csv(path, found)


def as_mat(path: Path, columns: Columns) -> None:
    from scipy.io import savemat

    savemat(path, dict(columns))


def as_mat_struct(path: Path, columns: Columns) -> None:
    from scipy.io import savemat

    savemat(path, {"L": 2.0, "out": dict(columns)}, oned_as="column")


def as_hdf5(path: Path, columns: Columns) -> None:
    import h5py

    with h5py.File(path, "w") as file:
        for name, values in columns.items():
            file[f"run/{name}"] = values
        file["run/label"] = "a text"


def as_parquet(path: Path, columns: Columns) -> None:
    import pyarrow
    from pyarrow import parquet

    parquet.write_table(pyarrow.table(dict(columns)), path)


WRITERS: Mapping[str, tuple[str, Callable[[Path, Columns], None], str]] = {
    "csv": (".csv", as_csv, "numpy"),
    "pandas": (".csv", as_pandas, "pandas"),
    "spreadsheet": (".csv", as_spreadsheet, "numpy"),
    "fortran": (".dat", as_fortran, "numpy"),
    "tabs": (".txt", as_tabs, "numpy"),
    "json lines": (".jsonl", as_json_lines, "numpy"),
    "json": (".json", as_json, "numpy"),
    "npz": (".npz", as_npz, "numpy"),
    "record": (".npz", as_record, "numpy"),
    "result of an FMU": (".csv", as_fmu_result, "fmpy"),
    "mat": (".mat", as_mat, "scipy"),
    "mat struct": (".mat", as_mat_struct, "scipy"),
    "hdf5": (".h5", as_hdf5, "h5py"),
    "parquet": (".parquet", as_parquet, "pyarrow"),
}
"""For each format: the ending, the writer, the module that it needs."""
