"""Specifications of charts as JSON, and their pictures, which the store keeps under the digest of
what they are made from.
"""

import hashlib
import json
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

from refdem.core.kept_file import kept_file
from refdem.core.store import Store
from refdem.report import charts, drawing
from refdem.report.chart_data import ChartData
from refdem.report.files import written

SNIPPET = "window.vegaEmbed = vegaEmbed;"
"""What the shared script provides to report.js."""

ASSETS = Path(__file__).with_name("assets")


def equip(folder: Path, store: Store | None) -> None:
    """Writes what pages with charts need into folder/assets: the style and the scripts."""
    for name in ("report.css", "report.js", "replay.js"):
        written(folder / "assets" / name, (ASSETS / name).read_bytes())
    written(folder / "assets" / "vega.js", script(store))


def specification(data: ChartData) -> str:
    """The Vega-Lite specification of a chart as JSON."""
    return json.dumps(charts.specification(data), separators=(",", ":"), sort_keys=True)


def pictures(specs: Sequence[str], store: Store | None) -> list[bytes]:
    """The SVG that each specification of Vega-Lite is drawn as; those that the store has are not
    drawn again.
    """
    keys = {spec: _key([_renderer(), drawing.PAPER, spec]) for spec in specs}
    found: dict[str, bytes] = {}
    if store:
        kept = {spec: store.get("chart", key) for spec, key in keys.items()}
        found = {spec: svg for spec, svg in kept.items() if svg is not None}
    missing = [spec for spec in keys if spec not in found]
    for spec, svg in zip(missing, drawing.all_drawn(missing), strict=True):
        found[spec] = svg.encode()
        if store:
            store.put("chart", keys[spec], found[spec])
    return [found[spec] for spec in specs]


def picture(spec: str, store: Store | None) -> bytes:
    """The SVG of one specification."""
    (svg,) = pictures([spec], store)
    return svg


def script(store: Store | None) -> bytes:
    """Vega, Vega-Lite and Vega-Embed in one script that needs no network."""
    if not store:
        return _script()
    key = _key([_renderer(), SNIPPET])
    kept = store.get("script", key)
    if kept is None:
        kept = _script()
        store.put("script", key, kept)
    return kept


@cache
def _script() -> bytes:
    """The script itself, which is the same for every store and is made once per machine."""
    snippet = hashlib.sha256(SNIPPET.encode()).hexdigest()
    return kept_file(f"vega-{_renderer()}-{snippet}.js", _bundle)


def _bundle() -> bytes:
    import vl_convert

    return bytes(vl_convert.javascript_bundle(SNIPPET).encode())


def _key(parts: list[Any]) -> str:
    """The digest of parts that JSON can say."""
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode("utf-8", "replace")).hexdigest()


@cache
def _renderer() -> str:
    """The version of the library that draws, which keys the store."""
    from importlib.metadata import version

    return version("vl-convert-python")
