"""The data that the page contains for its script, as columns and compressed, so that a hundred cases fit.

The browser decompresses them with DecompressionStream (in all browsers since 2023); nothing is fetched.
"""

import base64
import gzip
import json
from importlib.metadata import version
from typing import Any

from gnomon.harness.reporting.kept_parts import kept


def pack(text: str) -> str:
    """Text as base64 of its gzip; equal texts give equal bytes."""
    return base64.b64encode(gzip.compress(text.encode("utf-8"), 9, mtime=0)).decode("ascii")


def pack_vega() -> str:
    """The script that draws charts, packed and kept on disk: making it takes 5 s."""
    return str(kept((__name__,), version("vl-convert-python"), _vega))


def _vega() -> str:
    import vl_convert  # slow to load

    return pack(vl_convert.javascript_bundle("window.vegaEmbed = vegaEmbed;"))


def pack_json(value: Any) -> str:
    """JSON, packed. Raises ValueError for nan and infinity: JSON lacks them, and a browser would reject all of it."""
    return pack(json.dumps(value, separators=(",", ":"), ensure_ascii=False, allow_nan=False))


def columnar(spec: dict[str, Any]) -> dict[str, Any]:
    """A chart's specification with its data as columns."""
    data = {
        name: columns({key: [row[key] for row in rows] for key in (rows[0] if rows else ())})
        for name, rows in spec["datasets"].items()
    }
    return spec | {"datasets": data}


def columns(table: dict[str, list[Any]]) -> dict[str, Any]:
    """Columns in few characters: words as indices into a list, floats to four figures."""
    found: dict[str, Any] = {}
    for name, values in table.items():
        if any(isinstance(value, str) for value in values):
            places: dict[str, int] = {}
            codes = [places.setdefault(value, len(places)) if isinstance(value, str) else -1 for value in values]
            found[name] = {"words": list(places), "codes": codes}
        else:
            found[name] = [_short(value) for value in values]
    return found


def _short(value: Any) -> Any:
    if isinstance(value, bool):
        return int(value)
    return float(f"{value:.4g}") if isinstance(value, float) else value
