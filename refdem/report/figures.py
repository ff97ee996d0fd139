"""Specifications of charts as JSON, and their pictures, which the store keeps under the digest of
what they are made from.
"""

import hashlib
import json
import re
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

from refdem.core.kept_file import kept_file
from refdem.core.store import Store
from refdem.report import charts
from refdem.report.chart_data import ChartData
from refdem.report.files import written

SNIPPET = "window.vegaEmbed = vegaEmbed;"
"""What the shared script leaves for report.js."""

ASSETS = Path(__file__).with_name("assets")

PAPER = {
    "background": "white",
    "font": "DejaVu Sans, Arial, sans-serif",
    "view": {"stroke": "#d0d4d9"},
    "text": {"color": "#30363d"},
    "axis": {
        "gridColor": "#eceef1",
        "labelColor": "#30363d",
        "titleColor": "#30363d",
        "titleFontWeight": "normal",
    },
    "legend": {"labelColor": "#30363d", "titleColor": "#30363d", "labelLimit": 260},
}
"""How a chart looks on paper; pages have a light and a dark configuration of their own in
report.js.
"""


def equip(folder: Path, store: Store | None) -> None:
    """Writes what pages with charts need into folder/assets: the style and the scripts."""
    for name in ("report.css", "report.js", "replay.js"):
        written(folder / "assets" / name, (ASSETS / name).read_bytes())
    written(folder / "assets" / "vega.js", script(store))


def specification(data: ChartData) -> str:
    """The Vega-Lite specification of a chart as JSON."""
    return json.dumps(charts.specification(data), separators=(",", ":"), sort_keys=True)


def picture(spec: str, store: Store | None) -> bytes:
    """The SVG that a specification of Vega-Lite is drawn as."""
    return _kept(store, "chart", [_renderer(), PAPER, spec], lambda: _picture(spec))


def _picture(spec: str) -> bytes:
    """The SVG of a Vega-Lite specification on paper, the same bytes in every run."""
    import vl_convert

    chart: dict[str, Any] = json.loads(spec)
    chart["background"] = PAPER["background"]
    svg = vl_convert.vegalite_to_svg(chart, config=PAPER)
    return _normalised(svg).encode()


def _normalised(svg: str) -> str:
    """The picture with its ids numbered in their own order, as Vega counts them through the life of
    a process.

    Descriptions of single marks are left out: half of the bytes, and nothing reads them in an
    image.
    """
    svg = re.sub(r"<[^>]+>", lambda tag: re.sub(r'\s(aria-[a-z]+|role)="[^"]*"', "", tag[0]), svg)
    for index, name in enumerate(dict.fromkeys(re.findall(r'\bid="([A-Za-z_]+\d+)"', svg))):
        svg = re.sub(
            rf'(\bid="|url\(#|href="#){re.escape(name)}(?=["\)])', rf"\g<1>part-{index}", svg
        )
    return svg + "\n"


def script(store: Store | None) -> bytes:
    """Vega, Vega-Lite and Vega-Embed in one script that needs no network."""
    return _kept(store, "script", [_renderer(), SNIPPET], _script)


@cache
def _script() -> bytes:
    """The same for every store: made once on a machine."""
    snippet = hashlib.sha256(SNIPPET.encode()).hexdigest()
    return kept_file(f"vega-{_renderer()}-{snippet}.js", _bundle)


def _bundle() -> bytes:
    import vl_convert

    return bytes(vl_convert.javascript_bundle(SNIPPET).encode())


def _kept(store: Store | None, kind: str, parts: list[Any], drawn: Callable[[], bytes]) -> bytes:
    """What the store has under the digest of `parts`; made and put there if it has nothing."""
    key = hashlib.sha256(json.dumps(parts, sort_keys=True).encode("utf-8", "replace")).hexdigest()
    if store:
        kept = store.get(kind, key)
    else:
        kept = None
    if kept is None:
        kept = drawn()
        if store:
            store.put(kind, key, kept)
    return kept


@cache
def _renderer() -> str:
    """The version of the library that draws, which keys the store."""
    from importlib.metadata import version

    return version("vl-convert-python")
