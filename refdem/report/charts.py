"""The charts, each defined once in Altair: interactive in pages and drawn as SVG for Markdown."""

import math
from collections.abc import Iterator
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
SMALL_WIDTH = 208
"""Pixels of a picture of the overview: five beside each other fill a page."""
COLUMNS = 5
"""Pictures of the overview beside each other, where the page is wide enough."""
FADED = 0.08
"""Opacity of a curve while its reader has chosen others in the legend."""
CURVES = "curves"
"""Begins the names of the marks whose legend is clicked."""
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
        if data.kind == "errors" and data.defaults:
            # The panel of steps is the first.
            spec["hconcat"][0]["layer"][:0] = _default_steps(data)
        # Altair would copy the whole chart several times over for a parameter.
        spec["params"] = [_chosen(data, spec)]
        if data.kind in PICKED:
            spec["params"].append(_picked(data, PICKED[data.kind]))
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


def _chosen(data: ChartData, spec: dict[str, Any]) -> dict[str, Any]:
    """What clicks in the legend choose, as a parameter of Vega-Lite: each adds a name or takes it
    back, and without a name everything is shown.
    """
    if data.kind == "overview":
        legend = "engine"
    else:
        legend = "series"
    select = {"type": "point", "fields": [legend], "toggle": "true"}
    return {"name": "chosen", "select": select, "bind": "legend", "views": list(_clicked(spec))}


def _clicked(spec: dict[str, Any]) -> Iterator[str]:
    """The names of all marks of a specification whose legend is clicked, as Altair made them."""
    if spec.get("name", "").startswith(CURVES):
        yield spec["name"]
    parts = [*spec.get("hconcat", ()), *spec.get("concat", ()), *spec.get("layer", ())]
    if "spec" in spec:
        parts.append(spec["spec"])
    for part in parts:
        yield from _clicked(part)


def _wider(usual: float, each: float) -> dict[str, str]:
    """A width, or an area of a point: the usual one, and more for each curve that lies on this."""
    return {"expr": f"{usual} + {each} * (datum.under || 0)"}


def _opacity(shown: float) -> dict[str, Any]:
    """The opacity of a mark, half where another curve lies on it, and little where its reader has
    chosen others.
    """
    halved = {"expr": f"datum.under > 0 ? {shown / 2} : {shown}"}
    return {"condition": {"param": "chosen", "value": halved}, "value": FADED}


def _points(base: Any, size: float) -> Any:
    """Points that are larger where others lie on them."""
    points = base.mark_point(filled=True)
    return points.encode(size={"value": _wider(size, 2 * size)}, opacity=_opacity(1.0))


def _lines(base: Any, name: str, **more: Any) -> Any:
    """Lines that are wider where others lie on them; their legend is clicked."""
    lines = base.mark_line(**more).properties(name=f"{CURVES}-{name}")
    return lines.encode(strokeWidth={"value": _wider(1.5, 4.5)}, opacity=_opacity(0.8))


def _curves(
    base: Any,
    data: ChartData,
    x: alt.X,
    y: alt.Y,
    tips: list[alt.Tooltip],
    *,
    name: str,
    bound: str = "",
    size: int = 50,
    **more: Any,
) -> Any:
    """Lines with points, and dashed lines for bounds; `more` are properties of the whole."""
    colour, shape = _style(data)
    lines = _lines(base, name).encode(x=x, y=y, color=colour)
    points = _points(base, size).encode(x=x, y=y, color=colour, shape=shape, tooltip=tips)
    if not bound:
        return alt.layer(lines, points, **more)
    bounds = base.mark_line(strokeDash=[5, 4], strokeWidth=1.2).encode(
        x=x, y=alt.Y(f"{bound}:Q"), color=colour, opacity=_opacity(0.85)
    )
    return alt.layer(bounds, lines, points, **more)


def _default_steps(data: ChartData) -> list[dict[str, Any]]:
    """A dotted line at the default step of each engine, and its name at the foot, as layers of
    Vega-Lite with rows of their own.
    """
    x = alt.X("at:Q")
    tips = [alt.Tooltip("name:N"), alt.Tooltip("at:Q", title="step [s]")]
    layers: list[dict[str, Any]] = []
    for engine, colour, step in data.defaults:
        row = {"name": f"{engine}'s default", "at": step}
        base = alt.Chart(alt.InlineData(values=[row]))
        rule = base.mark_rule(strokeDash=[1, 3], strokeWidth=2, color=colour)
        words = base.mark_text(angle=270, align="left", dx=5, dy=-6, fontSize=10)
        marked = (
            rule.encode(x=x, tooltip=tips),
            words.encode(x=x, y=alt.value(HEIGHT), text="name:N"),
        )
        for layer in marked:
            drawn = layer.to_dict(validate=False)
            parts = {name: drawn[name] for name in ("mark", "encoding")}
            layers.append({"data": {"values": [row]}, **parts})
    return layers


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
        curves = _curves(
            chosen,
            data,
            x,
            y,
            tips,
            name=kind,
            bound="shown_bound",
            width=width,
            height=HEIGHT,
        )
        panels.append(curves)
    return panels


def _exact(chosen: Any, data: ChartData, y: alt.Y, tips: list[alt.Tooltip]) -> Any:
    """Methods without a step, side by side; a bar for the bound."""
    colour, shape = _style(data)
    x = alt.X("series:N", title="exact", axis=alt.Axis(labels=False, ticks=False))
    bars = chosen.mark_tick(thickness=1.5).encode(
        x=x, y=alt.Y("shown_bound:Q"), color=colour, opacity=_opacity(0.7)
    )
    points = chosen.mark_point(filled=True, size=60).properties(name=f"{CURVES}-exact")
    points = points.encode(x=x, y=y, color=colour, shape=shape, tooltip=tips, opacity=_opacity(1.0))
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
        name=data.kind,
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
    return _curves(
        base,
        data,
        x,
        y,
        tips,
        name=data.kind,
        bound="shown_bound",
        size=16,
        width=WIDTH,
        height=HEIGHT,
    )


def _overview(data: ChartData) -> Any:
    """A small picture a case, on common axes."""
    names, colours, _ = (list(column) for column in zip(*data.styles, strict=True))
    base = _chart(data, halvings="number", shown_error="number")
    x = alt.X("halvings:Q", title="halvings of the step", axis=alt.Axis(tickMinStep=1, tickCount=5))
    legend = alt.Legend(orient="top", symbolOpacity=1)
    colour = alt.Color(
        "engine:N", title=None, scale=alt.Scale(domain=names, range=colours), legend=legend
    )
    tips = _tips("case", "series", "error")
    places = {"x": x, "y": _log("shown_error", "error / scale", data, 4), "color": colour}
    lines = base.mark_line().properties(name=CURVES)
    lines = lines.encode(
        **places,
        detail="series:N",
        strokeWidth={"value": _wider(1.5, 3.0)},
        opacity=_opacity(0.9),
    )
    points = _points(base, 22).encode(**places, tooltip=tips)
    header = alt.Header(title=None, labelFontWeight="bold", labelLimit=SMALL_WIDTH)
    layers = alt.layer(lines, points).properties(width=SMALL_WIDTH, height=110)
    facet = alt.Facet("case:N", header=header)
    return layers.facet(facet=facet, columns=COLUMNS, spacing=14)


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
        tips = _tips("series", "rung", "ratio", "verdict")
        curves = _curves(ran, data, x, y, tips, name=str(number), size=36)
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
