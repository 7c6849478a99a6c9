"""`gnomon check --template`: a text with all that is needed to make a file, which a person reads and TOML parses."""

from __future__ import annotations

from gnomon.cases import Case
from gnomon.harness.trajectories.columns import coordinate_sets
from gnomon.harness.trajectories.comparison import count_periods, longest_gap

HEAD = """\
# What a file for `gnomon check` needs: integrate the case from its start, and write a row at each time.
# gnomon check FILE --case {case}{numbers} --within 1e-6{sparse}
# A row has the columns t, {columns}; CSV, NPZ, MAT, HDF5, Parquet or JSON lines.
# Other names, units and conventions: --columns COLUMN=COORDINATE:UNIT, as described in docs/check.md.
# Other times are as good; rows more than {gap:.4g} s apart need --sparse.{angles}
"""


def template(case: Case, numbers: tuple[str, ...] = ()) -> str:
    """The text, in TOML: parameters, start, times, columns and units of a case, numbers as they round to binary64."""
    case = case.rounded()
    names = [coordinate.name for coordinate in case.state]
    gap, times = longest_gap(case), case.times.tolist()
    sparse = " --sparse" * (times[-1] - times[-2] > gap)
    angles = " Angles are compared modulo 2 pi." * any(each.kind == "angle" for each in case.state)
    stated = "".join(f" --set {each}" for each in numbers)
    lines = [HEAD.format(case=case.id, numbers=stated, columns=", ".join(names), sparse=sparse, gap=gap, angles=angles)]
    lines += [f"case = {_text(case.id)}", f"title = {_text(case.title)}", f"conventions = {_text(case.conventions)}"]
    lines += ["", "[parameters]"]
    lines += [
        f"{each.name} = {float(case.parameters[each.name])!r}  # {each.unit}" + f", {each.meaning}" * bool(each.meaning)
        for each in case.parameter_list
    ]
    lines += ["", "[start]  # at t = 0"]
    lines += [
        f"{each.name} = {float(value)!r}  # {each.unit}"
        for each, value in zip(case.state, case.initial_state, strict=True)
    ]
    lines += ["", "[columns]  # with their units", 't = "s"']
    lines += [f"{each.name} = {_text(each.unit)}" for each in case.state]
    for each in coordinate_sets(case)[1:]:
        if each.formulation is not None:
            lines += ["", f"[formulations.{_text(each.formulation.name)}]  # columns that are accepted too"]
            lines += [f"{name} = {_text(unit)}" for name, unit in each.units.items()]
    lines += ["", "[times]", f"span = {float(case.span)!r}  # s{count_periods(case, float(case.span))}", "rows = ["]
    lines += [f"  {', '.join(map(repr, times[k : k + 4]))}," for k in range(0, len(times), 4)]
    return "\n".join([*lines, "]"]) + "\n"


def _text(text: str) -> str:
    """A basic string of TOML."""
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"').replace("\n", " ") + '"'
