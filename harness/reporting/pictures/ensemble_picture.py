"""The map of the error over two varied numbers, as a picture."""

from __future__ import annotations

import math
from functools import partial
from pathlib import Path
from typing import Any

import altair as alt
import numpy as np
import vl_convert
from gnomon.harness.ensembles.distribution import CELLS, LOWEST, PER_DECADE, Distribution
from gnomon.harness.ensembles.draws import Varied
from gnomon.harness.reporting.images import smaller
from gnomon.harness.reporting.style import QUIET, dress
from gnomon.reference.storage import diskcache

SIZE = 480
"""Pixels of a side of the map."""


def error_map(errors: Distribution, sides: tuple[Varied, Varied], units: tuple[str, str], title: str) -> alt.LayerChart:
    """The geometric mean of the error in each cell; cells with failed samples are framed, empty cells are left out."""
    count, total, failed = errors.cells
    rows = []
    for i, j in np.argwhere(count + failed).tolist():
        place: dict[str, Any] = {}
        for axis, k, side in (("x", i, sides[0]), ("y", j, sides[1])):
            step = (side.high - side.low) / CELLS
            place |= {axis: side.low + k * step, f"{axis}2": side.low + (k + 1) * step}
        mean = (float(total[i, j]) / float(count[i, j]) - 0.5) / PER_DECADE + LOWEST if count[i, j] else math.nan
        rows.append(place | {"decade": None if math.isnan(mean) else round(mean, 2), "failed": int(failed[i, j])})
    x, y = (
        channel(title=f"{side.name} ({unit})", scale=alt.Scale(domain=[side.low, side.high], nice=False))
        for channel, side, unit in zip((partial(alt.X, "x:Q"), partial(alt.Y, "y:Q")), sides, units, strict=True)
    )
    base = alt.Chart(alt.Data(values=rows)).encode(x=x, y=y, x2="x2:Q", y2="y2:Q")
    colour = alt.Color("decade:Q", title="log10 of the error", scale=alt.Scale(scheme="viridis"))
    cells = base.transform_filter("isValid(datum.decade)").mark_rect().encode(color=colour)
    lost = base.transform_filter("datum.failed > 0").mark_rect(filled=False, stroke=QUIET, strokeWidth=1.5)
    return alt.layer(cells, lost).properties(title=title, width=SIZE, height=SIZE)


def write(chart: alt.LayerChart, path: Path) -> None:
    """Write a PNG."""
    svg = vl_convert.vegalite_to_svg(dress(chart).to_dict())
    diskcache.replace(path, smaller(vl_convert.svg_to_png(svg, scale=1.0)))
