"""`gnomon ensemble`: the distribution of an integrator's error over many starts of a case."""

from __future__ import annotations

import json
from contextlib import ExitStack
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from gnomon.harness.commands import options
from gnomon.harness.commands.cluster_options import Dask
from gnomon.harness.commands.options import out, problems
from gnomon.harness.registry.completion import complete_case, complete_integrator
from gnomon.harness.results.visible import shorten
from rich.markup import escape
from rich.table import Table

if TYPE_CHECKING:
    from gnomon.harness.ensembles.distribution import Distribution, Start
    from gnomon.harness.ensembles.ensemble_run import Cost, Job
    from gnomon.harness.ensembles.samples import Ensemble

MOST_TIMES, MOST_KEPT = 10_000, 1000
IMPORT = "from gnomon.harness.ensembles.samples import Ensemble, Varied"


def ensemble(
    case: Annotated[str, typer.Option(help=f"{options.CASE}; one.", autocompletion=complete_case)],
    integrator: Annotated[str, typer.Option(help=f"{options.INTEGRATOR}; one.", autocompletion=complete_integrator)],
    samples: Annotated[str, typer.Option(help="The number of starts, as 2**20 or 1e6.")],
    setting: Annotated[
        float | None,
        typer.Option(
            help="The tolerance or step size (then shortened to divide the time); by default 1e-9, or a 64th of the time scale."
        ),
    ] = None,
    vary: Annotated[
        list[str] | None,
        typer.Option(help="NAME or NAME=LOW:HIGH, a number that varies; repeatable. By default all of the start."),
    ] = None,
    seed: Annotated[int, typer.Option(help="The same seed gives the same samples.")] = 1,
    times: Annotated[int, typer.Option(help="The error is the largest at this many times; 1: at the end.")] = 1,
    worst: Annotated[int, typer.Option(help="How many of the worst starts to print.")] = 10,
    sides: Annotated[
        tuple[str, str] | None, typer.Option("--map", help="The two numbers of the map; by default the first two.")
    ] = None,
    out_path: Annotated[Path | None, options.path_option("A JSON file; the map goes beside it.", "--out")] = None,
    parquet: Annotated[Path | None, options.path_option("An empty folder for all samples.")] = None,
    workers: Annotated[int, typer.Option(help="Processes at a time.")] = 2,
    dask: Dask = None,
    parameters: options.Parameters = None,
) -> None:
    """Measure an integrator from many starts of a case. Exit code 1 if all samples failed, or a cluster was lost."""
    # Imported here and not above: `gnomon --help` starts without numpy, pandas and numba.
    from gnomon.harness.cluster.connection import Lost
    from gnomon.harness.ensembles import ensemble_run

    options.validate_workers(workers)
    _validate(seed, times, worst)
    chosen = _ensemble(case, integrator, setting, vary or [], seed, times, parameters)
    job = ensemble_run.Job(
        chosen, _samples(samples), worst, _sides(chosen, sides), None if parquet is None else str(parquet.resolve())
    )
    _ensure_places(out_path, parquet, sides is not None)
    _announce(job, ensemble_run.probe_apart(chosen), workers)
    try:
        distribution = _measure(job, workers, dask)
    except Lost as error:
        problems.print(escape(str(error)), highlight=False)
        raise typer.Exit(1) from None
    except KeyboardInterrupt:
        problems.print("interrupted; nothing is kept of an ensemble that is not complete")
        raise typer.Exit(130) from None
    _print(job, distribution)
    if out_path is not None:
        _write(job, distribution, out_path)
    if parquet is not None:
        out.print(f"samples: {parquet}, read by gnomon.load_ensemble", highlight=False)
    if not distribution.scored:
        problems.print("all samples failed")
        raise typer.Exit(1)


def _measure(job: Job, workers: int, dask: str | None) -> Distribution:
    from gnomon.harness.cluster.ensemble_on_dask import on_cluster
    from gnomon.harness.ensembles import ensemble_run
    from gnomon.harness.system.progress import Progress

    with ExitStack() as stack:
        mapper = ensemble_run.in_processes(workers)
        if dask is not None:
            mapper = stack.enter_context(on_cluster(dask, workers, job.ensemble))
        return ensemble_run.run(job, mapper, stack.enter_context(Progress()))


def _validate(seed: int, times: int, worst: int) -> None:
    from gnomon.harness.ensembles.draws import MOST_SEED

    for option, value, least, most in (
        ("--seed", seed, 0, MOST_SEED), ("--times", times, 1, MOST_TIMES), ("--worst", worst, 0, MOST_KEPT),
    ):  # fmt: skip
        if not least <= value <= most:
            raise ValueError(f"{option} {shorten(str(value))}: give a number from {least} to {most}")


def _samples(text: str) -> int:
    from gnomon.harness.ensembles.draws import MOST_SAMPLES
    from gnomon.harness.ensembles.ensemble_run import samples_of

    count = samples_of(text)
    if not 1 <= count <= MOST_SAMPLES:
        raise ValueError(f"--samples {shorten(text)}: give a whole number from 1 to 2**30, as 2**20 or 1e6")
    if count & (count - 1):
        problems.print(f"{count} samples: Sobol points are spread most evenly where their number is a power of two")
    return count


def _ensemble(
    case: str, integrator: str, setting: float | None, vary: list[str], seed: int, times: int, set_: list[str] | None
) -> Ensemble:
    from gnomon.harness.ensembles import draws
    from gnomon.harness.ensembles.samples import Ensemble, setting_for
    from gnomon.harness.registry import lookup

    chosen = options.choose_one(case, set_)
    method = lookup.find_one(integrator)
    setting = setting_for(chosen, method, times, setting)
    varied = draws.choose_varied(chosen, vary)
    for name in {number.name for number in varied} & set(options.read_parameters(set_)):
        raise ValueError(f"--set {name}: it varies; give --set or --vary")
    own = tuple(options.read_parameters(set_).items())
    # A user's name may be short; an id names one of gnomon's integrators in every process.
    return Ensemble(case, integrator if ":" in integrator else method.id, setting, varied, seed, times, own)


def _sides(chosen: Ensemble, pair: tuple[str, str] | None) -> tuple[int, int]:
    """The columns of the two numbers of the map."""
    from gnomon.cases.core.numbers import nearest

    names = [number.name for number in chosen.vary]
    if pair is None:
        return 0, min(1, len(names) - 1)
    for name in pair:
        if name not in names:
            raise ValueError(f"--map {name}: it does not vary; {nearest(name, names)}")
    if pair[0] == pair[1]:
        raise ValueError(f"--map {pair[0]} {pair[1]}: name two numbers")
    return names.index(pair[0]), names.index(pair[1])


def _ensure_places(out_path: Path | None, parquet: Path | None, mapped: bool) -> None:
    """Make the folders of the results. Raises ValueError if a result could not be written there."""
    from gnomon.harness.system import extras

    if mapped:
        if out_path is None:
            raise ValueError("--map: the map is a picture beside --out; name that file")
        extras.require("report", "--map")
    if out_path is not None:
        if out_path.suffix == ".png":
            raise ValueError(f"--out {out_path}: the map goes to a file of this name; end it in .json")
        options.ensure_writable(out_path, "--out")
        options.ensure_writable(out_path.with_suffix(".png"), "--out")
    if parquet is not None:
        extras.require("report", "--parquet")
        options.ensure_folder(parquet, "--parquet")
        if any(parquet.iterdir()):
            raise ValueError(f"--parquet {parquet}: holds files already; name a new folder")


def _announce(job: Job, cost: Cost, workers: int) -> None:
    """Print the ensemble that will be measured, and the time that it takes."""
    chosen = job.ensemble
    ranges = ", ".join(f"{number.name} from {number.low:g} to {number.high:g}" for number in chosen.vary)
    out.print(f"{chosen.case}, {chosen.integrator} at {chosen.setting:g}: {ranges}", highlight=False, markup=False)
    by = "a formula for many motions" if cost.by_formula else "the exact motion of each case"
    each = ", prepared for each sample, because parameters vary" if cost.prepares_each else ""
    out.print(
        f"a sample takes {cost.integration * 1e6:.3g} us for the integration{each}, and {cost.exact * 1e6:.3g} us for the "
        f"exact state by {by}; {job.samples} samples about {_duration(cost.seconds(job.samples, workers))}",
        highlight=False,
    )


def _duration(seconds: float) -> str:
    if seconds < 100:
        return f"{seconds:.2g} s"
    return f"{seconds / 60:.0f} minutes" if seconds < 6000 else f"{seconds / 3600:.1f} hours"


def _print(job: Job, distribution: Distribution) -> None:
    statuses = ", ".join(
        f"{count} {name} ({count / job.samples:.3g})" for name, count in sorted(distribution.statuses.items())
    )
    out.print(f"{job.samples} samples: {statuses}", highlight=False)
    table = Table("share of samples", "error at most", "95 % confidence", title="Quantiles of the error")
    for row in distribution.quantiles():
        low, middle, high = (_number(row[name]) for name in ("low", "error", "high"))
        table.add_row(f"{row['level']:g}", middle, f"{low} to {high}")
    out.print(table)
    table = Table("error at least", "samples", "share", title="Tail")
    for limit, count in distribution.tail():
        table.add_row(f"{limit:.0e}", str(count), f"{count / distribution.inside:.3g}")
    out.print(table)
    listed = {"worst starts": distribution.worst} | {f"first {n}": s for n, s in sorted(distribution.failed.items())}
    for title, starts in listed.items():
        if starts:
            out.print(f"{title}, as Python:", highlight=False)
            for line in (IMPORT, f"ensemble = {job.ensemble!r}", *(_line(job.ensemble, start) for start in starts)):
                out.print(f"    {line}", highlight=False, markup=False)


def _number(value: float | None) -> str:
    return "failed" if value is None else f"{value:.3g}"


def _line(chosen: Ensemble, start: Start) -> str:
    """The call that computes the error of one start alone, with its error in its block."""
    numbers = dict(zip((number.name for number in chosen.vary), start.numbers, strict=True))
    return f"ensemble.error({numbers!r})  # sample {start.index}: {start.error:.6g}"


def _write(job: Job, distribution: Distribution, path: Path) -> None:
    from gnomon.harness.ensembles.distribution import as_data
    from gnomon.harness.registry import environment
    from gnomon.harness.system import extras
    from gnomon.reference.storage import diskcache

    chosen = job.ensemble
    lines = [IMPORT, f"ensemble = {chosen!r}"]
    content: dict[str, Any] = {"ensemble": asdict(chosen), "samples": job.samples, "python": lines}
    content |= as_data(distribution) | {"map": [chosen.vary[k].name for k in job.sides]}
    content["worst"] = [{"sample": s.index, "error": s.error, "python": _line(chosen, s)} for s in distribution.worst]
    content["failed"] = {
        n: [{"sample": s.index, "python": _line(chosen, s)} for s in starts]
        for n, starts in distribution.failed.items()
    }
    content["environment"] = environment.describe()
    diskcache.replace(path, (json.dumps(content, indent=1) + "\n").encode())
    out.print(f"distribution: {escape(str(path))}", highlight=False)
    lacking = extras.lacking("report")
    if job.sides[0] != job.sides[1] and lacking is not None:
        out.print(escape(f"no map: {lacking} is not installed; {extras.install('report')}"), highlight=False)
    elif job.sides[0] != job.sides[1]:
        from gnomon.harness.reporting.pictures import ensemble_picture

        first, other = (chosen.vary[k] for k in job.sides)
        units = chosen.prepared.unit(first.name), chosen.prepared.unit(other.name)
        title = f"{chosen.case}, {chosen.integrator} at {chosen.setting:g}"
        drawing = path.with_suffix(".png")
        ensemble_picture.write(ensemble_picture.error_map(distribution, (first, other), units, title), drawing)
        out.print(f"map: {escape(str(drawing))}", highlight=False)
