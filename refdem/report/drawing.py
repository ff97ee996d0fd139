"""Drawing charts: specifications of Vega-Lite as SVG, many of them in processes of their own.

The drawing library runs JavaScript and draws one picture at a time, in about 0.1 s each. It takes
150 MB of memory. Each process reads a JSON list of specifications from its standard input and
writes a JSON list of pictures to its standard output.
"""

import json
import os
import re
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import msgspec

MANY = 8
"""Least number of pictures per process: starting one takes as long as drawing a few pictures."""

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


def drawn(spec: str) -> str:
    """The SVG of a Vega-Lite specification on paper, the same text in every run."""
    import vl_convert

    chart: dict[str, Any] = json.loads(spec)
    chart["background"] = PAPER["background"]
    return _normalised(vl_convert.vegalite_to_svg(chart, config=PAPER))


def all_drawn(specs: Sequence[str]) -> list[str]:
    """The SVG of each specification; in a process for each core where there are many."""
    processes = min(os.cpu_count() or 1, len(specs) // MANY)
    if processes < 1:
        return [drawn(spec) for spec in specs]
    # Charts of similar size are neighbours, so charts are dealt out in turn to balance the load.
    shares = [specs[first::processes] for first in range(processes)]
    pictures = [""] * len(specs)
    with ThreadPoolExecutor(processes) as threads:
        for first, share in enumerate(threads.map(_drawn_elsewhere, shares)):
            pictures[first::processes] = share
    return pictures


def _drawn_elsewhere(specs: Sequence[str]) -> list[str]:
    """The SVG of each specification from another process; from this one if that one fails."""
    # -P: a module of the working directory is not one of Python's.
    command = [sys.executable, "-P", "-m", "refdem.report.drawing"]
    try:
        done = subprocess.run(
            command, input=msgspec.json.encode(specs), capture_output=True, check=True
        )
    except (OSError, subprocess.CalledProcessError):
        return [drawn(spec) for spec in specs]
    return msgspec.json.decode(done.stdout, type=list[str])


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


def main() -> None:
    """Draws the specifications read from standard input; ends if the parent process ends."""
    parent = os.getppid()
    specs = msgspec.json.decode(sys.stdin.buffer.read(), type=list[str])
    pictures = []
    for spec in specs:
        if os.getppid() != parent:
            sys.exit(1)
        pictures.append(drawn(spec))
    sys.stdout.buffer.write(msgspec.json.encode(pictures))


if __name__ == "__main__":
    main()
