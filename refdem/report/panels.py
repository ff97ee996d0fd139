"""Panels of figures as Vega-Lite: curves simplified to the resolution of a screen, point clouds as
images of their density.
"""

import base64
import csv
import io
import struct
import zlib
from typing import Any

import altair as alt
import numpy as np
from altair.utils.schemapi import debug_mode
from numpy.typing import NDArray

from refdem.core.figure import Axis, Figure, Panel, Series
from refdem.report.palette import ENGINES, REFERENCE

Array = NDArray[np.float64]
FINE = 0.3
"""Largest deviation of a simplified curve, and grid of drawn points [pixels]."""
DOTS_PER_PIXEL = 2
"""Dots of a cloud's picture on each pixel."""
SYMBOL = 26
"""Pixels that a legend takes for a symbol with its margins."""
LETTER = 5.0
"""Pixels that a legend takes for a letter of its text."""
FAINTEST = 110
"""Opacity, of 255, of a single point of a cloud."""


def specification(figure: Figure) -> dict[str, Any]:
    """The Vega-Lite specification of a figure."""
    with debug_mode(False):
        drawn = [_panel(panel) for panel in figure.panels]
        if len(drawn) == 1:
            chart = drawn[0]
        else:
            # Each panel has colours and dashes of its own.
            beside = alt.concat(*drawn, columns=figure.columns, spacing=18)
            chart = beside.resolve_scale(color="independent", strokeDash="independent")
        spec: dict[str, Any] = chart.to_dict(validate=False)
    return spec


def colour(ink: int) -> str:
    """The colour of an ink, as #rrggbb; a negative ink is that of the reference."""
    if ink < 0:
        return REFERENCE
    return ENGINES[ink % len(ENGINES)]


def _panel(panel: Panel) -> Any:
    x = _scaled(panel, "x")
    y = _scaled(panel, "y")
    labels = {series.label: series for series in panel.series if series.label}
    layers = [_layer(series, panel, x, y, labels) for series in panel.series]
    if panel.title:
        named: dict[str, Any] = {"title": panel.title}
    else:
        named = {}
    return alt.layer(*layers).properties(width=panel.size[0], height=panel.size[1], **named)


def _scaled(panel: Panel, name: Any) -> Any:
    """The channel of an axis without its field."""
    axis: Axis = getattr(panel, name)
    kind: type[alt.X | alt.Y] = alt.Y
    if name == "x":
        kind = alt.X
    if axis.is_log:
        kept_zero: dict[str, Any] = {"type": "log"}
    else:
        kept_zero = {"zero": False}
    scale = alt.Scale(domain=panel.ends(name), nice=False, **kept_zero)
    width, height = panel.size
    # A tick label takes about 70 pixels across and 50 up.
    if name == "x":
        most_ticks = width // 70
    else:
        most_ticks = height // 50
    ticks = max(3, most_ticks)
    if axis.is_log:
        written: dict[str, Any] = {"format": "~e"}
    else:
        written = {}
    shown = None
    if not axis.is_hidden:
        shown = alt.Axis(tickCount=min(ticks, 9), labelOverlap=True, grid=True, **written)
    return kind(f"{name}:Q", title=axis.title or None, scale=scale, axis=shown)


def _layer(series: Series, panel: Panel, x: Any, y: Any, labels: dict[str, Series]) -> Any:
    """The chart of one series, with the axes of its panel."""
    if series.mark == "cloud":
        return _cloud(series, panel, x, y)
    base = alt.Chart(_rows(series, panel))
    paint = colour(series.ink)
    if series.mark == "text":
        return base.mark_text(color=paint, fontSize=12, align="center").encode(x=x, y=y, text="w:N")
    tips = []
    for name in ("x", "y"):
        title = getattr(panel, name).title or name
        tips.append(alt.Tooltip(f"{name}:Q", title=title, format=".5~g"))
    # Lines join their points in the order of the rows, not of x.
    in_order: dict[str, Any] = {"order": alt.Order("i:Q")}
    if series.mark == "points":
        drawn = base.mark_point(filled=True, size=26, opacity=0.9, clip=True)
        in_order = {}
    elif series.mark == "area":
        drawn = base.mark_line(
            filled=True,
            fillOpacity=0.4,
            stroke=paint,
            strokeWidth=1.2,
            clip=True,
            interpolate="linear-closed",
        )
    else:
        drawn = base.mark_line(strokeWidth=series.width, strokeDash=_dash(series), clip=True)
    encoded = drawn.encode(x=x, y=y, tooltip=tips, **in_order)
    if not series.label:
        return encoded.encode(color=alt.value(paint))
    return encoded.encode(**_legend(series, labels, panel.size[0]))


def _cloud(series: Series, panel: Panel, x: Any, y: Any) -> Any:
    """The picture of a cloud's density, laid over the whole panel."""
    width, height = panel.size
    blank = alt.Chart(alt.InlineData(values=[{}]))
    # The caption of the figure says what is seen; a picture of dots has nothing to read out.
    picture = blank.mark_image(
        url=density(series, panel), width=width, height=height, aspect=False, aria=False
    )
    centred = picture.encode(x=alt.value(width / 2), y=alt.value(height / 2))
    return centred + _frame(panel, x, y)


def _dash(series: Series) -> list[int]:
    """Lengths [px] of the dashes of a line and of the gaps between them."""
    if series.dashed:
        return [5, 4]
    return [1, 0]


def _legend(series: Series, labels: dict[str, Series], width: int) -> dict[str, Any]:
    """Colour and dash of a label, joined in one legend of as many columns as fit under the panel;
    of more than three labels two.
    """
    longest = max(map(len, labels))
    fit = max(1, int(width // (SYMBOL + LETTER * longest)))
    if len(labels) > 3:
        wanted = 2
    else:
        wanted = len(labels)
    columns = min(fit, wanted)
    legend = alt.Legend(orient="bottom", columns=columns, symbolOpacity=1, symbolType="stroke")
    inks = alt.Scale(domain=list(labels), range=[colour(s.ink) for s in labels.values()])
    channels: dict[str, Any] = {
        "color": alt.ColorDatum(series.label, type="nominal", title=None, scale=inks, legend=legend)
    }
    if any(s.dashed for s in labels.values()):
        dashes = alt.Scale(domain=list(labels), range=[_dash(s) for s in labels.values()])
        channels["strokeDash"] = alt.StrokeDashDatum(
            series.label, type="nominal", title=None, scale=dashes, legend=legend
        )
    return channels


def _frame(panel: Panel, x: Any, y: Any) -> Any:
    """An invisible chart that gives a panel its axes: points at two of its corners."""
    left, right = panel.ends("x")
    low, high = panel.ends("y")
    ends = alt.InlineData(values=[{"x": left, "y": low}, {"x": right, "y": high}])
    return alt.Chart(ends).mark_point(opacity=0).encode(x=x, y=y)


def _rows(series: Series, panel: Panel) -> Any:
    """The points that are drawn, as rows; an empty cell breaks a curve."""
    if series.mark == "text":
        pick = np.arange(len(series.x))
    else:
        pick = kept(series, panel)
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    head = ["i", "x", "y"]
    if series.words:
        head.append("w")
    writer.writerow(head)
    for i, k in enumerate(pick):
        row = [i, _coordinate(series.x[k]), _coordinate(series.y[k])]
        if series.words:
            row.append(series.words[k])
        writer.writerow(row)
    parse = {"i": "number", "x": "number", "y": "number"}
    columns = alt.CsvDataFormat(type="csv", parse=parse)
    return alt.InlineData(values=out.getvalue(), format=columns)


def _coordinate(value: float) -> str:
    """A coordinate with six digits; empty where it is not finite."""
    if np.isfinite(value):
        return format(value, ".6g")
    return ""


def pixels(series: Series, panel: Panel) -> Array:
    """Places (N, 2) on the panel in pixels from its lower left corner."""
    columns = []
    for name, size in zip(("x", "y"), panel.size, strict=True):
        low, high = panel.ends(name)  # type: ignore[arg-type]
        values = getattr(series, name)
        if getattr(panel, name).is_log:
            low = np.log(low)
            high = np.log(high)
            values = np.log(values)
        columns.append((values - low) / (high - low) * size)
    return np.stack(columns, axis=-1)


def kept(series: Series, panel: Panel) -> NDArray[np.int64]:
    """Indices of the points that are drawn.

    Of points, one in each dot is drawn; of a curve, those that keep it within FINE pixels.
    """
    place = pixels(series, panel)
    if series.mark == "points":
        _, first = np.unique(np.round(place), axis=0, return_index=True)
        return np.sort(first)
    finite: Any = np.isfinite(place).all(axis=1)
    breaks = np.flatnonzero(np.diff(finite.astype(int)) != 0) + 1
    pick: list[int] = []
    for run in np.split(np.arange(len(place)), breaks):
        if finite[run[0]]:
            pick += run[_corners(place[run])].tolist()
        else:
            # One point of a gap is enough to break the curve.
            pick.append(int(run[0]))
    return np.array(pick)


def _corners(place: Array) -> NDArray[np.int64]:
    """Indices of the points of a curve (N, 2) that are kept, by the algorithm of Douglas and
    Peucker (1973) with an explicit stack.
    """
    stay = np.zeros(len(place), bool)
    stay[[0, -1]] = True
    stack = [(0, len(place) - 1)]
    while stack:
        first, last = stack.pop()
        if last - first < 2:
            continue
        inner = place[first + 1 : last] - place[first]
        chord = place[last] - place[first]
        length = float(np.hypot(*chord))
        off: Any
        if length > FINE:
            # Distance from the line of the chord, |r x chord| / |chord|; beyond an end of the
            # chord, how far beyond it.
            off = np.abs(inner[:, 0] * chord[1] - inner[:, 1] * chord[0]) / length
            along = inner @ chord / length
            beyond = np.maximum(-along, along - length)
            off = np.maximum(off, beyond)
        else:
            # A chord without length, as of a closed curve: distance from its end.
            off = np.hypot(*inner.T)
        worst = int(np.argmax(off))
        if off[worst] > FINE:
            middle = first + 1 + worst
            stay[middle] = True
            stack += [(first, middle), (middle, last)]
    return np.flatnonzero(stay)


def density(series: Series, panel: Panel) -> str:
    """A cloud as an image (PNG in a data URL): opacity grows with the number of points in a dot."""
    place = pixels(series, panel)
    width = panel.size[0] * DOTS_PER_PIXEL
    height = panel.size[1] * DOTS_PER_PIXEL
    across, up = (np.floor(place * DOTS_PER_PIXEL)).astype(np.int64).T
    inside = (across >= 0) & (across < width) & (up >= 0) & (up < height)
    # Rows of a picture run from its top down.
    dot = (height - 1 - up[inside]) * width + across[inside]
    counts = np.bincount(dot, minlength=width * height).reshape(height, width)
    # A point is as wide as its series says.
    wide = round(series.width * DOTS_PER_PIXEL)
    grown = counts
    for axis in (0, 1):
        grown = np.maximum.reduce([np.roll(grown, shift, axis) for shift in range(wide)])
    typical = 1.0
    if counts.any():
        typical = max(1.0, float(np.quantile(counts[counts > 0], 0.9)))
    # Opacity of 255: FAINTEST for the emptiest dots, then as the square root of their number.
    opacity = FAINTEST + (255 - FAINTEST) * np.sqrt(grown / typical)
    alpha = np.where(grown > 0, np.clip(opacity, 0, 255), 0).astype(np.uint8)
    paint = colour(series.ink)
    ink = tuple(int(paint[k : k + 2], 16) for k in (1, 3, 5))
    levels = (alpha // 16).astype(np.uint8)
    return "data:image/png;base64," + base64.b64encode(_png(levels, ink)).decode()


def _png(levels: NDArray[np.uint8], ink: tuple[int, ...]) -> bytes:
    """An image (height, width) of one ink in 16 levels of opacity, 4 bits per dot, as PNG
    (ISO/IEC 15948).
    """
    height, width = levels.shape
    packed = (levels[:, ::2] << 4) | levels[:, 1::2]
    lines = np.hstack([np.zeros((height, 1), np.uint8), packed]).tobytes()
    head = struct.pack(">IIBBBBB", width, height, 4, 3, 0, 0, 0)
    opacity = bytes([0, *(round(255 * level / 15) for level in range(1, 16))])
    parts = [
        (b"IHDR", head),
        (b"PLTE", bytes(ink) * 16),
        (b"tRNS", opacity),
        (b"IDAT", zlib.compress(lines, 9)),
        (b"IEND", b""),
    ]
    picture = b"\x89PNG\r\n\x1a\n"
    for kind, data in parts:
        size = struct.pack(">I", len(data))
        checksum = struct.pack(">I", zlib.crc32(kind + data))
        picture += size + kind + data + checksum
    return picture
