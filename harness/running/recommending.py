"""Writes the table of `gnomon recommend` from a run: the answers of `needs` at every error, with the forms of the methods.

The first line of the table has the results of the trial on systems outside of the catalogue. Recommended tolerances are
multiplied by the margin of this trial.
"""

import json
import math
from collections.abc import Iterator, Mapping
from collections.abc import Set as AbstractSet
from pathlib import Path
from typing import Any, Protocol

import pandas as pd
from gnomon.harness.registry import lookup
from gnomon.harness.registry.environment import DISTRIBUTIONS
from gnomon.harness.results import reading, store, summary
from gnomon.harness.results.advice.needs import SUBJECTS, YOURS, Answer, Measurements, Reliable, Setting, kind_of, needs
from gnomon.harness.results.advice.recommendations import MOST_BYTES, SCHEMA
from gnomon.harness.results.equal_error import TARGETS
from gnomon.harness.results.outstanding import outstanding
from gnomon.harness.running import rounds
from gnomon.harness.running.own_equations import form_names
from gnomon.reference.storage import diskcache

FIGURES = 3


class Run(Protocol):
    """The parts of `report_run.Run` that the table is made from."""

    @property
    def path(self) -> Path: ...
    @property
    def equal(self) -> pd.DataFrame: ...
    @property
    def frame(self) -> pd.DataFrame: ...
    @property
    def forms(self) -> Mapping[str, AbstractSet[str]]: ...


def write_table(run: Run, to: Path, outside: Path | None = None) -> Path:
    """Write the table of a run and return its path. Equal measurements give equal files.

    `outside`: the file of the trial outside of the catalogue, whose margin the reliable tolerances have; without it 1.

    Raises ValueError if it is larger than MOST_BYTES, and for measurements from several sources or machines, which one head
    cannot name.
    """
    tried = None if outside is None else _trial(outside)
    margin = 1.0 if tried is None else float(tried["margin"])
    rows = answers(Measurements(run.equal, run.frame, kind_of(run.forms)), margin)
    named = dict.fromkeys(name for row in rows for name in (*row["methods"], *row.get("better", {}).get("methods", ())))
    known = lookup.own()
    parts = [{"method": name, "forms": form_names(known[name])} for name in named]
    launches = min((row["launches"] for row in rows if row["systems"]), default=0)
    head = {"schema": SCHEMA} | _head(run) | {"launches": launches, "margin": margin, "outside": tried}
    text = "".join(json.dumps(part, ensure_ascii=False, separators=(",", ":")) + "\n" for part in (head, *parts, *rows))
    if len(text.encode()) > MOST_BYTES:
        raise ValueError(f"{to}: the table takes {len(text.encode())} bytes, more than {MOST_BYTES}")
    with diskcache.whole(to) as part:
        part.write_text(text, encoding="utf-8")
    return to


def answers(measured: Measurements, margin: float = 1.0) -> list[dict[str, Any]]:
    """The rows of the table: for each subject, error and library an answer, whose reliable tolerances have a margin."""
    return [
        {"subject": need.subject.key, "error": need.error, **_row(answer)}
        for need in needs(measured, list(SUBJECTS.values()), TARGETS, margin)
        for answer in need.answers
        if answer.division != YOURS
    ]


def _trial(path: Path) -> dict[str, Any]:
    """The results of the trial on systems outside of the catalogue."""
    trial: dict[str, Any] = json.loads(path.read_text("utf-8"))
    margin = trial.get("margin")
    if not (isinstance(margin, int | float) and 0 < margin <= 1):
        raise ValueError(f"{path}: margin={margin!r}, where a factor above 0 and up to 1 belongs; run the trial again")
    return trial


def _head(run: Run) -> dict[str, Any]:
    """Whose measurements these are."""
    used = set(run.frame["run"])
    runs = [row for row in store.runs(run.path) if row["run"] in used]
    environments = [row["environment"] for row in runs]
    for name in ("sources", "machine"):
        several = dict.fromkeys(str(environment.get(name)) for environment in environments)
        if len(several) > 1:
            raise ValueError(
                f"{run.path}: its times are of several {name} ({', '.join(several)}), but a table names one;"
                " take a results file of one"
            )
    timed = run.frame[run.frame["seconds_median"].notna()]
    count, delayed, _ = summary.count_waits(zip(timed["seconds_median"], timed["delay_seconds"], strict=True))
    return {
        **{name: environments[-1].get(name) for name in ("revision", "sources", "machine", "cpu", "cores", "python")},
        "date": max(str(row["ended"] or row["started"]) for row in runs)[:10],
        "suites": list(dict.fromkeys(row["suite"] for row in runs)),
        "lacks": outstanding(run.path).text,
        "open": rounds.describe_open(reading.rows(run.path)),
        "timed": count,
        "delayed": delayed,
        "versions": {name: environments[-1][name] for name in DISTRIBUTIONS if name in environments[-1]},
    }


def _row(answer: Answer) -> dict[str, Any]:
    """An answer as a row of the table: numbers with FIGURES figures; values that are not known are left out."""
    row: dict[str, Any] = {
        "library": answer.library,
        "methods": list(answer.methods),
        "why": answer.why,
        "tried": answer.tried,
        "systems": answer.systems,
        "share_low": _round(answer.share[0]),
        "share_high": _round(answer.share[1]),
        "launches": answer.launches,
    }
    names = ("seconds", "low", "high", "evaluations", "loosest", "tightest", "best_error")
    row |= dict(_find_known({name: getattr(answer, name) for name in names}))
    if answer.setting is not None:
        setting = answer.setting
        row["setting"] = {
            "kind": setting.kind,
            "value": setting.value,
            "relative": _round(setting.relative),
            "problem": f"{setting.case}/{setting.variant or 'default'}",
            "method": setting.integrator,
            **_name_parameter(setting),
        }
    if answer.reliable:
        first, *others = map(_reliable, answer.reliable)
        row["reliable"] = first | ({"others": others} if others else {})
    if answer.rests_on is not None:
        of = answer.rests_on
        row["rests_on"] = {"spans": [_round(of.shortest), _round(of.longest)]}
        row["rests_on"] |= dict(_find_known({name: getattr(of, name) for name in ("conditioning", "eccentricity")}))
    if answer.better is not None:
        row["better"] = _row(answer.better) | {"among": answer.better.among, "how": answer.better.how}
    return row


def _reliable(reliable: Reliable) -> dict[str, Any]:
    value = {"relative": _floor_step(reliable.relative)} if reliable.kind == "step" else {"value": reliable.relative}
    row = {"method": reliable.integrator, "kind": reliable.kind, **value, **_name_parameter(reliable)}
    return row | {"systems": reliable.systems, "of": reliable.of, **dict(_find_known({"seconds": reliable.seconds}))}


def _name_parameter(setting: Setting | Reliable) -> dict[str, str]:
    """The name of a parameter that is not a tolerance."""
    return {} if setting.name == "rtol" else {"name": setting.name}


def _find_known(values: Mapping[str, float]) -> Iterator[tuple[str, float]]:
    return ((name, _round(value)) for name, value in values.items() if math.isfinite(value))


def _round(value: float) -> float:
    return float(f"{value:.{FIGURES}g}")


def _floor_step(step: float) -> float:
    """To FIGURES figures, and not above: a longer step would not be the one that was measured."""
    unit = 10.0 ** (math.floor(math.log10(step)) + 1 - FIGURES)
    return _round(math.floor(step / unit * (1 + 1e-12)) * unit)
