"""The JSON files beside a page: one of another shape gives one line that names the file and the place."""

import copy
import json
import random
from pathlib import Path
from typing import Any

import pytest
from gnomon.harness.reporting import report_benchmarks, report_checks, sidecars
from gnomon.harness.reporting.page import league
from gnomon.harness.results.advice import recommendations
from gnomon.harness.results.visible import markdown
from planted_sidecars import PAIR, files

SINGLE = {"group": "call", "first_name": "Gauss", "unit": "s", "median": 7.0, "low": 6.0, "high": 8.0, "launches": 5}
MISSED = PAIR | {"second": None, "median": None, "low": None, "high": None}
SOUND = files() | {"benchmarks.json": {"launches": 5, "environment": {"cpu": "x"}, "rows": [PAIR, MISSED, SINGLE]}}
del SOUND["stability.json"]  # shown by figures: test_report_stability.py
del SOUND["verification.json"]  # no text of it is on the page
AS_HTML = ("certificates.json", "checks.json")
"""Shown as HTML; the others as rows of texts, which the page's template escapes."""
EACH, ORDINARY = 200, 20
DEEP = "[" * 100_000 + "]" * 100_000
WRONG = (
    *(None, True, -1, 0, 10**400, 1.5, -1e308, float("nan"), float("inf"), "", "text", "1e100000000", "9" * 10_000),
    *([], {}, [[]], {"a": {}}, "\x1b[31m", "<script>", "\ud800"),
)
BROKEN = (
    *("", "{", "null", "[]", "{}", "7", "[7]", '{"rows": 7}', '{"rows": [7]}'),
    *(DEEP, '"\\u0000"', "[" + "9" * 5000 + "]"),
)


def shown(folder: Path, name: str) -> str:
    """All texts of the page that come from a file."""
    if name in AS_HTML:
        return str(report_checks.render_certificates(folder, folder)) + "".join(
            map(markdown, report_checks.list_certificates(folder, folder))  # as summary.md has them
        )
    if name == sidecars.LEAGUE:
        with pytest.MonkeyPatch.context() as patched:
            patched.setattr(league, "stills", lambda figures: [json.dumps(each) for each in figures])
            return str(league.league(folder))
    if name == "outside.json":
        return recommendations.outside_text(sidecars.first(name, folder))
    return str(getattr(report_benchmarks, name.removesuffix(".json"))(folder))


def told(folder: Path, name: str, content: str | bytes) -> str | None:
    """The error line for a file; None if it is shown."""
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode("utf-8", "surrogatepass"))
    try:
        text = shown(folder, name)
    except ValueError as error:
        line = str(error)
    else:
        line = "" if "\x1b" not in text and ("<script>" not in text or name not in AS_HTML) else "steers"
    return (
        (line if line.startswith(f"{path}: ") and line.isprintable() and len(line) < 500 else f"WRONG {line}")
        if line
        else None
    )


@pytest.mark.parametrize("name", SOUND)
def test_a_sound_file_is_shown(tmp_path: Path, name: str) -> None:
    assert told(tmp_path, name, json.dumps(SOUND[name])) is None
    assert len(shown(tmp_path, name)) > 100


@pytest.mark.parametrize("name", SOUND)
@pytest.mark.parametrize("content", BROKEN, ids=range(len(BROKEN)))
def test_a_file_that_holds_something_else_is_named(tmp_path: Path, name: str, content: str) -> None:
    line = told(tmp_path, name, content)
    if content == "[]" and name in sidecars.FORMERLY_LISTS:
        assert line is None
    else:
        assert not (line or "WRONG").startswith("WRONG")


@pytest.mark.parametrize("content", [b"\xff\xfe", b"\xef\xbb\xbf{}", bytes(100)], ids=["no text", "a mark", "zeros"])
def test_bytes_that_are_no_text_are_named(tmp_path: Path, content: bytes) -> None:
    assert not (told(tmp_path, "growth.json", content) or "WRONG").startswith("WRONG")


@pytest.mark.parametrize("name", SOUND)
@pytest.mark.parametrize(
    "seeds", [range(ORDINARY), pytest.param(range(ORDINARY, EACH), marks=pytest.mark.slow)], ids=["a tenth", "the rest"]
)
def test_one_value_of_another_kind_is_named_or_shown_as_it_is(tmp_path: Path, name: str, seeds: range) -> None:
    for seed in seeds:
        chance = random.Random(f"{name} {seed}")
        found = copy.deepcopy(SOUND[name])
        places = list(_places(found))
        holder, key = chance.choice(places)
        if isinstance(holder, dict) and chance.random() < 0.2:
            del holder[key]
        else:
            holder[key] = chance.choice(WRONG)
        line = told(tmp_path, name, json.dumps(found))
        assert not (line or "").startswith("WRONG"), f"seed {seed}: {key} = {str(holder)[:200]}: {line}"


def _places(value: Any) -> Any:
    members = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, member in members:
        yield value, key
        yield from _places(member)
