"""The report of a run: one self-contained page, a summary for CI, and the figures as files."""

import re
from collections.abc import Mapping, Sequence
from importlib.resources import files
from pathlib import Path
from typing import Any

from gnomon.cases.core.case import Case
from gnomon.harness.reporting import sidecars, style
from gnomon.harness.reporting.page.case_tables import Tables
from gnomon.harness.reporting.page.later import Later
from gnomon.harness.reporting.report_charts import (
    page_charts,
    panel_charts,
    remove_figures,
    run_charts,
    work_problems,
    write_figures,
)
from gnomon.harness.reporting.report_pack import pack_html, pack_json, pack_vega
from gnomon.harness.reporting.report_run import Run
from gnomon.harness.reporting.report_words import page_words
from gnomon.harness.results import contenders, number_text, opening, store
from gnomon.harness.results.visible import Verbatim, code, markdown
from gnomon.reference.storage import diskcache
from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup, escape

SUMMARY = "summary.md"
DATA = (SUMMARY, "raw.json", "requirements.txt")
"""Files beside a published page, with those of `sidecars.NAMES`."""
DOCUMENTS = {
    "repository": "README.md",
    "documentation": "docs/index.md",
    "every case with its source": "docs/cases.md",
    "the settings of every adapter": "docs/libraries.md",
    "a method of your own": "docs/integrator.md",
}
"""Pages of the repository, by the text of their links."""
ABOUT = ("title", "section", "stresses", "unrun", "lacking", "limit")
"""What the page's script knows of a case."""


def write_report(
    database: Path,
    folder: Path,
    cases: Mapping[str, type[Case]] | None = None,
    beside: Sequence[Path] | None = None,
    figures: bool = False,
) -> Path:
    """Write index.html and summary.md into `folder`, with `figures` also figures/, and return the page's path.

    The page draws its figures itself; their files take most of the time.

    `database` is a results file, or a folder that has one. Certificates, checks, claims of speed, orders and growth
    laws are read from JSON files in the first of the folders `beside` that has them; by default the folder of the
    results, `folder`, and the one above (reports/local/ is in the published reports/). `cases`: classes that are not
    installed, by the name under which they ran; code that the file names is not imported. Raises ValueError for a file
    without results.
    """
    database = store.results_file(database)
    with opening.one_state(database):
        run = Run.read(database, cases)
        folder.mkdir(parents=True, exist_ok=True)
        work = work_problems(run)
        charts = run_charts(run)
        words = page_words(run, beside or (run.path.parent, folder, folder.parent), work)
        up = _up(folder)
        words |= {"up": up, "links": _links(folder, up)}
        charts |= panel_charts(words["stability"])
    page = folder / "index.html"
    with diskcache.whole(page) as part:
        part.write_text(_page(words, page_charts(run, work, charts)), encoding="utf-8")
    plain = Environment(undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True, finalize=markdown)
    plain.filters |= {
        "counted": number_text.count_text,
        "code": code,
        "joined": lambda words: Verbatim(number_text.join_words(words)),
    }
    with diskcache.whole(folder / SUMMARY) as part:
        part.write_text(plain.from_string(_source("summary.md.j2")).render(words), encoding="utf-8")
    if figures:
        write_figures(run, work, charts, folder / "figures")
    else:
        remove_figures(folder / "figures")  # figures of an earlier report would contradict this page
    return page


def _page(words: dict[str, Any], charts: dict[str, Any]) -> str:
    """The page. Data of single cases are compressed, and shown when their case is chosen."""
    templates = PackageLoader("gnomon.harness.reporting", "templates")
    environment = Environment(
        loader=templates, undefined=StrictUndefined, autoescape=True, trim_blocks=True, lstrip_blocks=True
    )
    environment.filters |= {
        "breakable": _breakable,
        "counted": number_text.count_text,
        "division": lambda name: contenders.division(name.partition(":")[0]),
        "figures": number_text.figures_text,
        "grouped": number_text.group_digits,
        "hue": lambda name: Markup(style.apply_theme(style.hue(name.partition(":")[0]))),
        "joined": _join_declared,
        "lower_first": number_text.lower_first,
        "site": lambda address: address.split("/")[2] if "//" in address else address,
    }
    panel = environment.get_template("report_case.html.j2").module
    stability = {case["name"]: str(panel.stability(case)) for case in words["cases"] if case["stability"]}  # type: ignore[attr-defined]
    later = Later()
    environment.globals["later"] = later
    carried = {
        "times": pack_html(_of_problems(words["times"])),
        "families": pack_html(_of_problems(words["families"])),
        "stability": pack_html(stability),
        "about": {case["name"]: {key: case[key] for key in ABOUT} for case in words["cases"]},
        "first": words["opened"],
        "kinds": _carry_kinds(words["first"]["kinds"]),
    }
    plain = Environment(undefined=StrictUndefined)
    css = plain.from_string(_source("report.css")).render(
        page=style.PAGE, dark=style.DARK, own_grey=style.OWN_GREY, colours=style.STATUS_COLOURS
    )
    return environment.get_template("report.html.j2").render(
        words,
        titles={case["name"]: case["title"] for case in words["cases"]},
        sections={case["name"]: case["section"] for case in words["cases"]},
        chart_names=list(charts["others"]),
        css=css,
        script=_source("report.js"),
        data=lambda: pack_json(style.apply_theme_to_values(charts | carried) | {"parts": pack_html(later.parts)}),
        vega=pack_vega(),
    )


def _carry_kinds(kinds: Mapping[str, Any] | None) -> dict[str, Any] | None:
    """All that the table of kinds can show, packed."""
    if kinds is None:
        return None
    carried: dict[str, Any] = kinds["carried"]
    return carried | {name: pack_html(carried[name]) for name in ("tables", "said")}


def _of_problems(tables: Tables) -> dict[str, str]:
    return {f"{case}/{problem}": table for case, of in tables.items() for problem, table in of.items()}


def _links(folder: Path, up: str | None) -> list[tuple[str, str]]:
    """The files beside the page, and the documentation, if it can be reached: text and address."""
    beside = (*DATA, *sidecars.NAMES)
    links = [(name, name) for name in beside if name == SUMMARY or (folder / name).is_file()]  # it is written last
    return links + [(text, up + path) for text, path in DOCUMENTS.items() if up is not None]


def _up(folder: Path) -> str | None:
    """The way from the page to the root of the repository; None if it is not in a copy of the repository."""
    own = folder.resolve()
    root = next((parent for parent in own.parents if (parent / "docs" / "libraries.md").is_file()), None)
    return None if root is None else "../" * len(own.relative_to(root).parts)


def _breakable(name: str) -> Markup:
    """A name with line breaks allowed after its separators, for narrow pages."""
    text = str(escape(name))
    for separator in (":", "_", "/"):
        text = text.replace(separator, separator + "<wbr>")
    return Markup(text)


def _join_declared(words: Sequence[str]) -> Markup:
    """The words of declarations as a sentence lists them; words between backticks are emphasised."""
    text = str(escape(number_text.join_words(words).replace("'", "’")))
    return Markup(re.sub(r"`(.+?)`", r"<em>\1</em>", text))


def _source(name: str) -> str:
    return (files("gnomon.harness.reporting") / "templates" / name).read_text(encoding="utf-8")
