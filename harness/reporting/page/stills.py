"""Drawings that stand in the page itself, so that they are there at once, in print and without a script."""

import hashlib
import json
import re
from collections.abc import Mapping, Sequence
from typing import Any

import vl_convert
from gnomon.harness.reporting import images
from gnomon.harness.reporting.kept_parts import keep_result
from gnomon.harness.reporting.style import apply_theme
from markupsafe import Markup, escape

WIDE, NARROW = "wide", "narrow"
"""The two drawings of a figure; the style sheet shows the one that the width of the page has room for."""


def stills(specifications: Sequence[dict[str, Any]]) -> list[str]:
    """The drawings as SVG with the colours of the page; kept on disk, because drawing takes a tenth of a second each."""
    drawings: list[str] = keep_result(
        (__name__,), json.dumps(specifications), lambda: [_draw(specification) for specification in specifications]
    )
    return drawings


def _draw(specification: Mapping[str, Any]) -> str:
    schema = "https://vega.github.io/schema/vega-lite/v6.json"
    text = json.dumps({**specification, "background": None, "$schema": schema})
    own = f"d{hashlib.sha256(text.encode()).hexdigest()[:8]}"  # several drawings in one page must not share an id
    svg = images.leaner(vl_convert.vegalite_to_svg(text))
    return apply_theme(re.sub(r'( id="|url\(#|href="#)', rf"\1{own}", svg))


def figure(drawings: Mapping[str, Mapping[str, str]], label: str) -> dict[str, Markup]:
    """The drawings of a figure by axis (`time`, `calls`), each for two widths; the style sheet shows one of them."""
    return {
        axis: Markup("").join(
            Markup(f'<div class="still {width}" data-axis="{axis}">{_add_label(svg, label)}</div>')
            for width, svg in widths.items()
        )
        for axis, widths in drawings.items()
    }


def _add_label(svg: str, label: str) -> str:
    return svg.replace("<svg ", f'<svg role="img" aria-label="{escape(label)}" ', 1)
