"""The charts, each defined once in Altair: interactive in pages and drawn as SVG for Markdown."""

import math
from typing import Any

import altair as alt
from altair.utils.schemapi import debug_mode

from refdem.report.chart_data import ChartData

WIDTH = 460
"""Pixels of a chart: two stand beside each other on an ordinary screen."""
HEIGHT = 300
"""Pixels of a chart."""
SIDE = 100
"""Pixels of a chart that a further kind of curve takes."""
PICKED = {"errors": "quantity", "costs": "quantity", "drifts": "check"}
"""What is chosen in a chart, by its kind."""


def specification(data: ChartData) -> dict[str, Any]:
    """The Vega-Lite specification of a chart.

    Altair's validation, half of the time, is left to the tests.
    """
    drawers = {
        "errors": _errors,
        "costs": _costs,
        "drifts": _drifts,
        "overview": _overview,
        "ladders": _ladders,
    }
    with debug_mode(False):
        chart = drawers[data.kind](data)
        if isinstance(chart, list):
            spec = _beside(chart)
        else:
            spec = chart.to_dict(validate=False)
        if data.kind in PICKED:  # Altair would copy the whole chart several times over for it
            spec["params"] = [_picked(data, PICKED[data.kind])]
    return spec


def _beside(panels: list[Any]) -> dict[str, Any]:
    """The specification of charts of the same rows beside each other, with one axis of errors.

    What `altair.hconcat` gives, which copies every part of every chart several times over.
    """
    specs: list[dict[str, Any]] = [panel.to_dict(validate=False) for panel in panels]
    shared = ("$schema", "config", "data", "datasets")
    whole = {name: specs[0][name] for name in shared}
    for spec in specs:
        for name in shared:
            del spec[name]
    return {**whole, "hconcat": specs, "resolve": {"scale": {"y": "shared"}}, "spacing": 8}


def _chart(data: ChartData, **types: str) -> Any:
    """A chart of the rows, without marks."""
    columns = alt.CsvDataFormat(type="csv", parse=types)
    return alt.Chart(alt.InlineData(values=data.csv, format=columns))


def _powers(ends: tuple[float, float], most: int) -> list[float]:
    """At most `most` powers of ten between two ends, evenly apart; with 2 and 5 times these where
    there are less than two.
    """
    # 1e-9: an end that is a power of ten counts, whatever its logarithm is rounded to.
    first = math.ceil(math.log10(ends[0]) - 1e-9)
    last = math.floor(math.log10(ends[1]) + 1e-9)
    if last > first:
        # The number of powers over `most`, rounded up.
        stride = -(-(last - first + 1) // most)
        return [float(f"1e{k}") for k in range(first, last + 1, stride)]
    values = []
    for power in range(first - 1, last + 2):
        values += [float(f"{m}e{power}") for m in (1, 2, 5)]
    return [x for x in values if ends[0] <= x <= ends[1]]


def _log(name: str, title: str, data: ChartData, ticks: int = 9, *, labels: bool = True) -> alt.Y:
    """A logarithmic axis from the chart's floor up."""
    axis = alt.Axis(
        format=".0e", values=_powers(data.extents["error"], ticks), labels=labels, ticks=labels
    )
    return alt.Y(
        f"{name}:Q",
        title=title,
        scale=alt.Scale(type="log", domain=data.extents["error"], nice=False),
        axis=axis,
    )


def _log_x(name: str, title: str, ends: tuple[float, float]) -> alt.X:
    """A logarithmic axis with room on both sides."""
    axis = alt.Axis(format="~e", values=_powers(ends, 5), labelOverlap=True)
    return alt.X(
        f"{name}:Q",
        title=title,
        scale=alt.Scale(type="log", nice=False, padding=14, domain=ends),
        axis=axis,
    )


def _style(data: ChartData) -> tuple[alt.Color, alt.Shape]:
    """Colour and shape of a series, joined in one legend."""
    names, colours, shapes = (list(column) for column in zip(*data.styles, strict=True))
    legend = alt.Legend(orient="bottom", columns=3, symbolOpacity=1)
    inks = alt.Scale(domain=names, range=colours)
    marks = alt.Scale(domain=names, range=shapes)
    colour = alt.Color("series:N", title=None, scale=inks, legend=legend)
    shape = alt.Shape("series:N", title=None, scale=marks, legend=legend)
    return colour, shape


def _tips(*names: str) -> list[alt.Tooltip]:
    return [alt.Tooltip(f"{name}:N") for name in names]


def _picked(data: ChartData, name: str) -> dict[str, Any]:
    """The selector of a chart, as a parameter of Vega-Lite."""
    bind = {"input": "select", "options": list(data.choices), "name": f"{name} "}
    return {"name": "pick", "value": data.choices[0], "bind": bind}


def _curves(
    base: Any,
    data: ChartData,
    x: alt.X,
    y: alt.Y,
    tips: list[alt.Tooltip],
    *,
    bound: str = "",
    size: int = 50,
    **more: Any,
) -> Any:
    """Lines with points, and dashed lines for bounds; `more` are properties of the whole."""
    colour, shape = _style(data)
    lines = base.mark_line(opacity=0.8, strokeWidth=1.5).encode(x=x, y=y, color=colour)
    points = base.mark_point(filled=True, size=size, opacity=1).encode(
        x=x, y=y, color=colour, shape=shape, tooltip=tips
    )
    if not bound:
        return alt.layer(lines, points, **more)
    bounds = base.mark_line(strokeDash=[5, 4], opacity=0.85, strokeWidth=1.2).encode(
        x=x, y=alt.Y(f"{bound}:Q"), color=colour
    )
    return alt.layer(bounds, lines, points, **more)


def _errors(data: ChartData) -> list[Any]:
    """Panels for step, tolerance and exact methods, to stand beside each other."""
    base = _chart(
        data, level="number", shown_error="number", shown_bound="number"
    ).transform_filter("datum.quantity == pick")
    tips = _tips("series", "quantity", "level", "error", "bound")
    kinds = [kind for kind in ("step", "tolerance", "exact") if kind in data.extents]
    panels: list[Any] = []
    for kind in kinds:
        # Only the first panel names the axis that all share.
        if panels:
            y = _log("shown_error", "", data, labels=False)
        else:
            y = _log("shown_error", "largest error / scale", data)
        chosen = base.transform_filter(f"datum.control == '{kind}'")
        if kind == "exact":
            panels.append(_exact(chosen, data, y, tips))
            continue
        control = {"step": "step [s]", "tolerance": "tolerance"}[kind]
        x = _log_x("level", f"{control}; dashed: bound", data.extents[kind])
        # The first panel takes the width that the narrow ones beside it leave.
        if kind == kinds[0]:
            width = WIDTH - SIDE * (len(kinds) - 1)
        else:
            width = 3 * SIDE // 2
        curves = _curves(chosen, data, x, y, tips, bound="shown_bound", width=width, height=HEIGHT)
        panels.append(curves)
    return panels


def _exact(chosen: Any, data: ChartData, y: alt.Y, tips: list[alt.Tooltip]) -> Any:
    """Methods without a step, side by side; a bar for the bound."""
    colour, shape = _style(data)
    x = alt.X("series:N", title="exact", axis=alt.Axis(labels=False, ticks=False))
    bars = chosen.mark_tick(thickness=1.5, opacity=0.7).encode(
        x=x, y=alt.Y("shown_bound:Q"), color=colour
    )
    points = chosen.mark_point(filled=True, size=60, opacity=1).encode(
        x=x, y=y, color=colour, shape=shape, tooltip=tips
    )
    return alt.layer(bars, points, width=alt.Step(28), height=HEIGHT)


def _costs(data: ChartData) -> Any:
    base = _chart(data, seconds="number", shown_error="number").transform_filter(
        "datum.quantity == pick"
    )
    x = _log_x("seconds", "seconds in the engine's loop", data.extents["seconds"])
    y = _log("shown_error", "largest error / scale", data)
    return _curves(
        base,
        data,
        x,
        y,
        _tips("series", "quantity", "seconds", "error"),
        width=WIDTH,
        height=HEIGHT,
    )


def _drifts(data: ChartData) -> Any:
    base = _chart(data, t="number", shown_value="number", shown_bound="number").transform_filter(
        "datum.what == pick"
    )
    x = alt.X("t:Q", title="t [s]; dashed: bound", scale=alt.Scale(nice=False))
    y = _log("shown_value", "value", data)
    tips = _tips("series", "what", "t", "value", "bound")
    return _curves(base, data, x, y, tips, bound="shown_bound", size=16, width=WIDTH, height=HEIGHT)


def _overview(data: ChartData) -> Any:
    """A small picture a case, on common axes."""
    names, colours, _ = (list(column) for column in zip(*data.styles, strict=True))
    base = _chart(data, halvings="number", error="number")
    x = alt.X("halvings:Q", title="halvings of the step", axis=alt.Axis(tickMinStep=1, tickCount=5))
    legend = alt.Legend(orient="top", symbolOpacity=1)
    colour = alt.Color(
        "engine:N", title=None, scale=alt.Scale(domain=names, range=colours), legend=legend
    )
    lines = base.mark_line(point=alt.OverlayMarkDef(filled=True, size=22), strokeWidth=1.5)
    tips = _tips("case", "series", "error")
    drawn = lines.encode(
        x=x,
        y=_log("error", "error / scale", data, 4),
        color=colour,
        detail="series:N",
        tooltip=tips,
    )
    header = alt.Header(title=None, labelFontWeight="bold", labelLimit=200)
    return drawn.properties(width=190, height=110).facet(
        facet=alt.Facet("case:N", header=header), columns=4, spacing=14
    )


def _ladders(data: ChartData) -> Any:
    """A small picture a ladder: values over bounds against rungs in their order."""
    panels = []
    for number, name in enumerate(data.choices):
        title, _, along = name.partition("\n")
        base = _chart(data, ladder="number", shown="number", ratio="number").transform_filter(
            f"datum.ladder == {number}"
        )
        rungs = [
            label.partition("\t")[2] for label in data.labels if label.partition("\t")[0] == name
        ]
        axis = alt.Axis(labelAngle=-40, labelOverlap=True)
        x = alt.X("rung:N", title=along, scale=alt.Scale(domain=rungs), axis=axis)
        y = _log("shown", "value / bound", data, 5)
        ran = base.transform_filter("datum.verdict == 'pass' || datum.verdict == 'fail'")
        curves = _curves(ran, data, x, y, _tips("series", "rung", "ratio", "verdict"), size=36)
        colour, _ = _style(data)
        marks = base.transform_filter(
            "datum.verdict == 'error' || datum.verdict == 'undecided'"
        ).mark_text(fontSize=13, fontWeight="bold")
        sign = alt.condition("datum.verdict == 'error'", alt.value("x"), alt.value("?"))
        signs = marks.encode(x=x, y=y, color=colour, text=sign)
        # The bound: a value over its bound of 1. The axis says so; it is not read out.
        rule = base.mark_rule(strokeDash=[5, 4], color="#888888", aria=False)
        rule = rule.encode(y=alt.datum(1.0))
        heading = alt.Title(title, fontSize=11, limit=260)
        panel = alt.layer(rule, curves, signs, title=heading)
        panels.append(panel.properties(width=230, height=130))
    return alt.concat(*panels, columns=3, spacing=16).resolve_scale(x="independent")
