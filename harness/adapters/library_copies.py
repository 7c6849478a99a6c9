"""Copies the declarations of the libraries to where they are read by people and by tools.

These are docs/libraries.md, docs/other_languages.md, a line of README.md, and lines of pyproject.toml.

`make libraries` is `python -m gnomon.harness.adapters.library_copies`, in a working tree.
"""

import json
import re
from pathlib import Path

from gnomon.harness.adapters.absent import ABSENT, Series, measured
from gnomon.harness.adapters.libraries import LIBRARIES, Library

PAGE, PROJECT = Path("docs/libraries.md"), Path("pyproject.toml")
OTHER_PAGE, README = Path("docs/other_languages.md"), Path("README.md")
HEAD = """# Libraries

gnomon runs the integrators of these third-party libraries. `make libraries` writes this page from their declarations in
`harness/adapters/libraries.toml`; CONTRIBUTING.md says how to add one.

| library | ids begin with | requirement | installed | licence |
|---|---|---|---|---|
"""
DRIVEN_HEAD = """
## How they are driven

A user pays for the library, and not for gnomon's way to it: what can be compiled is. Costs were measured on Linux with Python
3.11, in processor time, before and after a change in turn in one process: medians of at least 25 pairs, with the same states to
rounding. A null call is a call over nearly no span, less its steps where the method has fixed steps. If a library's manual
advises another way, an issue that quotes the sentence is enough: the adapter is changed, or says here why not.
"""
ABSENT_HEAD = """
## Known integrators that do not take part

From `harness/adapters/absent.toml`. "No wheel" means that pip finds no compiled package for CPython 3.11 on Linux.

| integrators | reason |
|---|---|
"""
OTHER_HEAD = """# Other languages, measured

The programs in `tests/programs/` solve five cases with the GNU Scientific Library (C) and with Boost's odeint (C++), as
[Any language](any_language.md) describes. `make other-languages` compiles them, runs them with `gnomon run --command`, and
writes this page; on Debian it needs `apt-get install g++ libgsl-dev libboost-dev`. Three methods of SciPy ran beside them.

- Settings are from the manuals of the libraries. GSL: `gsl_odeiv2_driver_alloc_y_new` with a first step of 1e-6 s; the
  tolerance is the absolute error, and the relative error is 0. odeint: controlled steppers with a first step of 0.01 s; the
  tolerance is the relative error, and the absolute error is 1e-4 of it for dopri5 and fehlberg78, and equal to it for
  bulirsch_stoer and rosenbrock4. All shorten a step to end at each of the 64 samples.
- An equal tolerance has another meaning in each library, so the tables compare at an equal error: the largest of the 64
  samples, as in every report. They show the fewest evaluations of the right-hand side in a trial with at most that error.
- Evaluations in rejected steps count; evaluations of the Jacobian do not. bsimp, msbdf, rosenbrock4 and SciPy's Radau have it
  in closed form, and LSODA too.
- Tolerances are 1e-3 to 1e-13, one a decade; a trial may take {limit:g} s. A dash: no trial reached the error. For the stiff variant a
  program in C can afford more evaluations in that time than SciPy's methods in Python.
- Errors and counts do not include the start of the program or the exchange of lines. Times would; they are not published here.

Versions: {versions}. All numbers are in `harness/adapters/other_languages.toml`.

odeint's rosenbrock4 gains little from a smaller tolerance on `forced_oscillator`, the only one of these cases whose equations
depend on time. With constant steps its order is 4, but 1 on equations that depend on time: its coefficient `d4` is 0.0362,
where RODAS of Hairer and Wanner has -0.0362. With that coefficient the order is 4 (`tests/programs/rosenbrock_order.cpp`).
"""
TARGETS = (1e-3, 1e-6, 1e-9)
MARK = "# `make libraries` writes the next line.\n"
README_MARK = "<!-- `make libraries` writes the next line. -->\n"


def page() -> str:
    """The text of PAGE."""
    rows = [
        f"| {one.title} | `{one.name}:` | `{one.requirement}` | {_installed(one)} | {one.licence} |\n"
        for one in LIBRARIES.values()
    ]
    driven = [f"\n### {one.title}\n\n{one.driven.strip()}\n" for one in LIBRARIES.values() if one.driven]
    absent = [f"| {one.title} | {one.reason} |\n" for one in ABSENT]
    return "".join([HEAD, *rows, DRIVEN_HEAD, *driven, ABSENT_HEAD, *absent])


def other_page() -> str:
    """The text of OTHER_PAGE."""
    found = measured()
    versions = ", ".join(f"{name} {number}" for name, number in found.versions.items())
    text = OTHER_HEAD.format(limit=found.limit_seconds, versions=versions)
    for case in dict.fromkeys(one.case for one in found.series):
        targets = " | ".join(f"{target:.0e}".replace("e-0", "e-") for target in TARGETS)
        text += (
            f"\n## {case}\n\n| integrator | {targets} | least error | trials not ok |\n|---|---:|---:|---:|---:|---|\n"
        )
        text += "".join(_other_row(one) for one in found.series if one.case == case)
    return text


def _other_row(one: Series) -> str:
    calls = ["–" if n is None else f"{n:,}" for n in map(one.calls_within, TARGETS)]
    least = f"{one.least_error:.1e}" if one.error else "–"
    others = ", ".join(f"{count} {status}" for status, count in one.others.items())
    name = one.integrator.removeprefix("command:")
    return f"| {name} | {' | '.join(calls)} | {least} | {others} |\n"


def readme(text: str) -> str:
    """The text of README with the names of the best-known integrators that do not take part."""
    names = ", ".join(one.readme for one in ABSENT if one.readme)
    line = f"[docs/libraries.md](docs/libraries.md) says why known integrators do not take part: {names} and others."
    return re.sub(rf"(?<={README_MARK}).*", line, text)


def _installed(library: Library) -> str:
    if library.debian:
        return f"by the system; Debian: `{library.debian}`"
    wheels = "" if library.last_wheels is None else "; its wheels end with CPython {}.{}".format(*library.last_wheels)
    return (f"extra `{library.extra}`" if library.extra else "with gnomon") + wheels


def project(text: str) -> str:
    """The text of PROJECT with the extras of the libraries, and with their names where mypy ignores missing types."""
    lists = {"module": [f"{name}.*" for name, one in LIBRARIES.items() if not one.debian]}
    for library in LIBRARIES.values():
        if library.extra:
            lists.setdefault(library.extra, []).append(library.installs)
    for name, values in lists.items():
        line = f"{name} = {json.dumps(values)}"
        text = re.sub(rf"(?<={MARK}){name} = \[.*\]", line, text)
    return text


def write() -> None:
    """Write all copies, in a working tree."""
    PAGE.write_text(page(), encoding="utf-8")
    OTHER_PAGE.write_text(other_page(), encoding="utf-8")
    for path, change in ((PROJECT, project), (README, readme)):
        path.write_text(change(path.read_text(encoding="utf-8")), encoding="utf-8")


if __name__ == "__main__":
    write()
