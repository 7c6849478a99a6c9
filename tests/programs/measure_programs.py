"""Compile the programs of this folder, run them and some methods of SciPy on five cases, and write what was measured.

`make other-languages` is this file with `runs/programs` as the folder; it takes some minutes, and the same command resumes.
The programs need a C and a C++ compiler, GSL and Boost (Debian: apt-get install g++ libgsl-dev libboost-dev).
"""

import json
import shutil
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

import pandas as pd
from gnomon.harness.adapters import library_copies
from gnomon.harness.contract.status import Status
from gnomon.harness.results.store import load

HERE = Path(__file__).parent
OUT = HERE.parents[1] / "harness" / "adapters" / "other_languages.toml"
OPTIONS = ["-O2", "-ffp-contract=off"]
"""Without fused operations, so that processors with and without them give the same bits."""
PROGRAMS = {
    "gsl": ("cc", "gsl.c", ["-lgsl", "-lgslcblas", "-lm"], "gsl/gsl_odeiv2.h"),
    "odeint": ("c++", "odeint.cpp", [], "boost/numeric/odeint.hpp"),
}
"""The compiler, the source, the libraries, and the header that must be installed."""
METHODS = {
    "gsl": ["rkf45", "rk8pd", "msadams", "bsimp", "msbdf"],
    "odeint": ["dopri5", "fehlberg78", "bulirsch_stoer", "rosenbrock4"],
}
COMPARED = ["scipy:DOP853", "scipy:LSODA", "scipy:Radau"]
CASES = [
    *("pendulum_simple", "kepler_orbit", "damped_oscillator", "damped_oscillator/stiff_1e6", "duffing_unforced"),
    "forced_oscillator",
]
LIMIT_SECONDS = 5.0


def missing(name: str) -> str | None:
    """The compiler or the header that a program lacks here."""
    compiler, _, _, header = PROGRAMS[name]
    if shutil.which(compiler) is None:
        return f"a compiler called {compiler}"
    asked = subprocess.run(
        [compiler, "-E", "-x", "c" if compiler == "cc" else "c++", "-"],
        input=f"#include <{header}>", capture_output=True, text=True, check=False,
    )  # fmt: skip
    return None if asked.returncode == 0 else f"the header {header}"


def build(name: str, folder: Path) -> Path:
    """Compile a program into a folder."""
    compiler, source, libraries, _ = PROGRAMS[name]
    program = folder / name
    subprocess.run([compiler, *OPTIONS, "-o", program, HERE / source, *libraries], check=True)
    return program


def tables(rows: pd.DataFrame) -> str:
    """The series as TOML, errors to three digits."""
    found = []
    rows = rows[rows["formulation"] == "standard"]
    for (case, variant, name), trials in rows.groupby(["case", "variant", "integrator_id"], sort=False):
        good = trials[trials["status"] == Status.OK].sort_values("setting", ascending=False)
        others = trials.loc[trials["status"] != Status.OK, "status"].value_counts()
        values = {
            "case": case if variant == "default" else f"{case}/{variant}",
            "integrator": name,
            "setting": [float(f"{x:.3g}") for x in good["setting"]],
            "error": [float(f"{x:.3g}") for x in good["error_max"]],
            "rhs_calls": [int(x) for x in good["rhs_calls"]],
        }
        lines = [f"{key} = {json.dumps(value)}\n" for key, value in values.items()]
        kept = ", ".join(f"{status} = {count}" for status, count in sorted(others.items()))
        found.append("\n[[series]]\n" + "".join(lines) + f"others = {{ {kept} }}\n")
    return "".join(found)


def main(folder: Path) -> None:
    lacking = [text for name in PROGRAMS if (text := missing(name))]
    if lacking:
        sys.exit(f"needs {' and '.join(lacking)}; Debian: apt-get install g++ libgsl-dev libboost-dev")
    folder.mkdir(parents=True, exist_ok=True)
    words, versions = [], {}
    for name, methods in METHODS.items():
        program = build(name, folder)
        words += [word for method in methods for word in ("--command", f"{program} {method}")]
        asked = json.dumps({"protocol": 1, "request": "describe"})
        told = subprocess.run([program, methods[0]], input=asked, capture_output=True, text=True, check=True)
        library, _, number = json.loads(told.stdout)["version"].partition(" ")
        versions[library] = number.replace("_", ".")
    compiled = subprocess.run(["c++", "-dumpfullversion"], capture_output=True, text=True, check=True)
    versions |= {"C and C++ compiler": compiled.stdout.strip(), "SciPy": version("scipy")}
    words += [word for one in COMPARED for word in ("--integrator", one)]
    words += [word for case in CASES for word in ("--case", case)]
    results = folder / "results.sqlite"
    options = ["--suite", "quick", "--timing", "none", "--limit", str(LIMIT_SECONDS), "--out", str(results)]
    subprocess.run([Path(sys.executable).parent / "gnomon", "run", *words, *options], check=True)
    head = "# `make other-languages` writes this file.\n\n"
    head += f"limit_seconds = {LIMIT_SECONDS}\n\n[versions]\n"
    head += "".join(f"{json.dumps(name)} = {json.dumps(number)}\n" for name, number in versions.items())
    OUT.write_text(head + tables(load(results)), encoding="utf-8")
    library_copies.write()


if __name__ == "__main__":
    main(Path(sys.argv[1]))
