"""The charts, each defined once as a specification of Vega-Lite: interactive in pages and drawn as
SVG for Markdown.

A specification is a dict of the same structure as its JSON. Altair, which builds such dicts from
objects, takes two hundred times as long, more than all the rest of a report. The tests validate
every specification against Altair's schema.
"""

import json
import math
from collections.abc import Iterator
from typing import Any

from refdem.report.chart_data import ChartData

Spec = dict[str, Any]
"""A part of a specification of Vega-Lite."""
SCHEMA = "https://vega.github.io/schema/vega-lite/v6.json"
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
CELL = 26
"""Pixels of a cell of a heat map, where there are few of them."""
SIDES_OF_MAP = (150, 360)
"""Least and most pixels of a side of a heat map."""
SIGN = 13.0
"""Pixels of the sign of a cell of a heat map, where cells are not smaller."""
ROWS = "rows"
"""The name of the rows of a chart, which all of its marks share."""
PICKED = {"errors": "quantity", "costs": "quantity", "drifts": "check"}
"""What is chosen in a chart, by its kind."""


def specification(data: ChartData) -> Spec:
    """The Vega-Lite specification of a chart."""
    drawers = {
        "errors": _errors,
        "costs": _costs,
        "drifts": _drifts,
        "overview": _overview,
        "sweeps": _sweeps,
        "heat_maps": _heat_maps,
    }
    spec = drawers[data.kind](data)
    params = []
    # A heat map has no series whose legend could be clicked.
    if data.kind != "heat_maps":
        params.append(_chosen(data, spec))
    if data.kind in PICKED:
        params.append(_picked(data, PICKED[data.kind]))
    view = {"continuousWidth": 300, "continuousHeight": 300}
    whole = {"$schema": SCHEMA, "config": {"view": view}, "datasets": {ROWS: data.csv}}
    return {**whole, **spec, "params": params}


def _rows(*numbers: str) -> Spec:
    """The rows of a chart, of which these columns are numbers and all others are text."""
    parse = dict.fromkeys(numbers, "number")
    return {"name": ROWS, "format": {"type": "csv", "parse": parse}}


def _layer(mark: Spec, encoding: Spec, filters: list[str], name: str = "") -> Spec:
    """One kind of mark, for the rows that pass all filters."""
    layer: Spec = {"mark": mark, "encoding": encoding}
    if name:
        layer["name"] = name
    if filters:
        layer["transform"] = [{"filter": condition} for condition in filters]
    return layer


def _quantity(field: str, **more: Any) -> Spec:
    """A channel that shows a column of numbers."""
    return {"field": field, "type": "quantitative", **more}


def _name(field: str, **more: Any) -> Spec:
    """A channel that shows a column of names."""
    return {"field": field, "type": "nominal", **more}


def _powers(ends: tuple[float, float], most: int) -> list[float]:
    """At most `most` powers of ten between two ends, evenly spaced; if there are fewer than two,
    also their multiples by 2 and 5.
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


def _log(name: str, title: str, data: ChartData, ticks: int = 9, *, labels: bool = True) -> Spec:
    """A logarithmic axis from the chart's floor up."""
    ends = data.extents["error"]
    values = _powers(ends, ticks)
    axis = {"format": ".0e", "values": values, "labels": labels, "ticks": labels}
    scale = {"type": "log", "domain": list(ends), "nice": False}
    return _quantity(name, title=title, scale=scale, axis=axis)


def _log_x(name: str, title: str, ends: tuple[float, float]) -> Spec:
    """A logarithmic axis with room on both sides."""
    axis = {"format": "~e", "values": _powers(ends, 5), "labelOverlap": True}
    scale = {"type": "log", "nice": False, "padding": 14, "domain": list(ends)}
    return _quantity(name, title=title, scale=scale, axis=axis)


def _style(data: ChartData) -> tuple[Spec, Spec]:
    """Colour and shape of a series, joined in one legend."""
    names, colours, shapes = (list(column) for column in zip(*data.styles, strict=True))
    legend = {"orient": "bottom", "columns": 3, "symbolOpacity": 1}
    inks = {"domain": names, "range": colours}
    marks = {"domain": names, "range": shapes}
    colour = _name("series", title=None, scale=inks, legend=legend)
    shape = _name("series", title=None, scale=marks, legend=legend)
    return colour, shape


def _tips(*names: str) -> list[Spec]:
    return [_name(name) for name in names]


def _picked(data: ChartData, name: str) -> Spec:
    """The selector of a chart, as a parameter of Vega-Lite."""
    bind = {"input": "select", "options": list(data.choices), "name": f"{name} "}
    return {"name": "pick", "value": data.choices[0], "bind": bind}


def _chosen(data: ChartData, spec: Spec) -> Spec:
    """The selection made by clicks in the legend, as a parameter of Vega-Lite.

    Each click adds a name to the selection or removes it. Everything is shown while it is empty.
    """
    if data.kind == "overview":
        legend = "engine"
    else:
        legend = "series"
    select = {"type": "point", "fields": [legend], "toggle": "true"}
    return {"name": "chosen", "select": select, "bind": "legend", "views": list(_clicked(spec))}


def _clicked(spec: Spec) -> Iterator[str]:
    """The names of all marks of a specification whose legend is clicked."""
    if spec.get("name", "").startswith(CURVES):
        yield spec["name"]
    parts = [*spec.get("hconcat", ()), *spec.get("concat", ()), *spec.get("layer", ())]
    if "spec" in spec:
        parts.append(spec["spec"])
    for part in parts:
        yield from _clicked(part)


def _wider(usual: float, each: float) -> Spec:
    """A line width or a point area: `usual`, and `each` more per curve drawn on top of this one."""
    return {"value": {"expr": f"{usual} + {each} * (datum.under || 0)"}}


def _opacity(shown: float) -> Spec:
    """The opacity of a mark: halved where another curve lies on it, and low while the legend
    selects others.
    """
    halved = {"expr": f"datum.under > 0 ? {shown / 2} : {shown}"}
    return {"condition": {"param": "chosen", "value": halved}, "value": FADED}


def _points(encoding: Spec, size: float, filters: list[str]) -> Spec:
    """Points that are larger where others lie on them."""
    areas = {"size": _wider(size, 2 * size), "opacity": _opacity(1.0)}
    return _layer({"type": "point", "filled": True}, {**encoding, **areas}, filters)


def _lines(encoding: Spec, width: Spec, opacity: float, filters: list[str], name: str) -> Spec:
    """Lines that are wider where others lie on them; their legend is clicked."""
    strokes = {"strokeWidth": width, "opacity": _opacity(opacity)}
    return _layer({"type": "line"}, {**encoding, **strokes}, filters, name)


def _curves(
    data: ChartData,
    x: Spec,
    y: Spec,
    tips: list[Spec],
    filters: list[str],
    *,
    name: str,
    bound: str = "",
    size: int = 50,
) -> list[Spec]:
    """Lines with points, and dashed lines for bounds."""
    colour, shape = _style(data)
    places = {"x": x, "y": y, "color": colour}
    lines = _lines(places, _wider(1.5, 4.5), 0.8, filters, f"{CURVES}-{name}")
    points = _points({**places, "shape": shape, "tooltip": tips}, size, filters)
    if not bound:
        return [lines, points]
    dashes = {"type": "line", "strokeDash": [5, 4], "strokeWidth": 1.2}
    heights = {"y": _quantity(bound), "opacity": _opacity(0.85)}
    return [_layer(dashes, {**places, **heights}, filters), lines, points]


def _default_steps(data: ChartData) -> list[Spec]:
    """A dotted line at the default step of each engine, with the engine's name at its foot.

    They have their own data rows.
    """
    x = _quantity("at")
    tips = [_name("name"), _quantity("at", title="step [s]")]
    words = {"type": "text", "angle": 270, "align": "left", "dx": 5, "dy": -6, "fontSize": 10}
    foot = {"value": HEIGHT}
    layers = []
    for engine, colour, step in data.defaults:
        rows = {"values": [{"name": f"{engine}'s default", "at": step}]}
        rule = {"type": "rule", "strokeDash": [1, 3], "strokeWidth": 2, "color": colour}
        text = {"x": x, "y": foot, "text": _name("name")}
        layers.append({"data": rows, "mark": rule, "encoding": {"x": x, "tooltip": tips}})
        layers.append({"data": rows, "mark": words, "encoding": text})
    return layers


def _errors(data: ChartData) -> Spec:
    """Panels for step, tolerance and exact methods beside each other, with one axis of errors."""
    kinds = [kind for kind in ("step", "tolerance", "exact") if kind in data.extents]
    panels: list[Spec] = []
    for kind in kinds:
        # Only the first panel names the axis that all share.
        if panels:
            y = _log("shown_error", "", data, labels=False)
        else:
            y = _log("shown_error", "largest error / scale", data)
        filters = ["datum.quantity == pick", f"datum.control == '{kind}'"]
        if kind == "exact":
            panels.append(_exact(data, y, filters))
        else:
            # The first panel takes the width that the narrow ones beside it leave.
            if kind == kinds[0]:
                width = WIDTH - SIDE * (len(kinds) - 1)
            else:
                width = 3 * SIDE // 2
            panels.append(_of_control(data, kind, y, filters, width))
    # The panel of steps is the first.
    if data.defaults:
        panels[0]["layer"][:0] = _default_steps(data)
    return {
        "data": _rows("level", "shown_error", "shown_bound"),
        "hconcat": panels,
        "resolve": {"scale": {"y": "shared"}},
        "spacing": 8,
    }


ERROR_TIPS = ("series", "quantity", "level", "error", "bound")
"""What is shown of a point of an error, by the columns of its row."""


def _of_control(data: ChartData, kind: str, y: Spec, filters: list[str], width: int) -> Spec:
    """The panel of methods with a step, or with a tolerance; `width` [pixels]."""
    control = {"step": "step [s]", "tolerance": "tolerance"}[kind]
    x = _log_x("level", f"{control}; dashed: bound", data.extents[kind])
    tips = _tips(*ERROR_TIPS)
    layers = _curves(data, x, y, tips, filters, name=kind, bound="shown_bound")
    return {"layer": layers, "width": width, "height": HEIGHT}


def _exact(data: ChartData, y: Spec, filters: list[str]) -> Spec:
    """Methods without a step, side by side; a bar for the bound."""
    colour, shape = _style(data)
    x = _name("series", title="exact", axis={"labels": False, "ticks": False})
    bars = {"x": x, "y": _quantity("shown_bound"), "color": colour, "opacity": _opacity(0.7)}
    points = {
        "x": x,
        "y": y,
        "color": colour,
        "shape": shape,
        "tooltip": _tips(*ERROR_TIPS),
        "opacity": _opacity(1.0),
    }
    dots = {"type": "point", "filled": True, "size": 60}
    layers = [
        _layer({"type": "tick", "thickness": 1.5}, bars, filters),
        _layer(dots, points, filters, f"{CURVES}-exact"),
    ]
    return {"layer": layers, "width": {"step": 28}, "height": HEIGHT}


def _costs(data: ChartData) -> Spec:
    x = _log_x("seconds", "seconds in the engine's loop", data.extents["seconds"])
    y = _log("shown_error", "largest error / scale", data)
    tips = _tips("series", "quantity", "seconds", "error")
    layers = _curves(data, x, y, tips, ["datum.quantity == pick"], name=data.kind)
    rows = _rows("seconds", "shown_error")
    return {"data": rows, "layer": layers, "width": WIDTH, "height": HEIGHT}


def _drifts(data: ChartData) -> Spec:
    x = _quantity("t", title="t [s]; dashed: bound", scale={"nice": False})
    y = _log("shown_value", "value", data)
    tips = _tips("series", "what", "t", "value", "bound")
    filters = ["datum.what == pick"]
    layers = _curves(data, x, y, tips, filters, name=data.kind, bound="shown_bound", size=16)
    rows = _rows("t", "shown_value", "shown_bound")
    return {"data": rows, "layer": layers, "width": WIDTH, "height": HEIGHT}


def _overview(data: ChartData) -> Spec:
    """A small picture a case, on common axes."""
    names, colours, _ = (list(column) for column in zip(*data.styles, strict=True))
    axis = {"tickMinStep": 1, "tickCount": 5}
    places = {
        "x": _quantity("halvings", title="halvings of the step", axis=axis),
        "y": _log("shown_error", "error / scale", data, 4),
        "color": _name(
            "engine",
            title=None,
            scale={"domain": names, "range": colours},
            legend={"orient": "top", "symbolOpacity": 1},
        ),
    }
    series = {**places, "detail": _name("series")}
    lines = _lines(series, _wider(1.5, 3.0), 0.9, [], CURVES)
    points = _points({**places, "tooltip": _tips("case", "series", "error")}, 22, [])
    header = {"title": None, "labelFontWeight": "bold", "labelLimit": SMALL_WIDTH}
    return {
        "data": _rows("halvings", "shown_error"),
        "facet": _name("case", header=header),
        "spec": {"layer": [lines, points], "width": SMALL_WIDTH, "height": 110},
        "columns": COLUMNS,
        "spacing": 14,
    }


def _sweeps(data: ChartData) -> Spec:
    """A small picture a sweep: values over bounds against points in their order."""
    return {
        "data": _rows("sweep", "shown", "ratio"),
        "concat": [_sweep(data, number, name) for number, name in enumerate(data.choices)],
        "columns": 3,
        "spacing": 16,
        "resolve": {"scale": {"x": "independent"}},
    }


def _sweep(data: ChartData, number: int, name: str) -> Spec:
    """The picture of one sweep: its title and what its points change are in `name`."""
    title, _, along = name.partition("\n")
    labels = [label.partition("\t") for label in data.labels]
    points = [point for sweep, _, point in labels if sweep == name]
    axis = {"labelAngle": -40, "labelOverlap": True}
    x = _name("point", title=along, scale={"domain": points}, axis=axis)
    y = _log("shown", "value / bound", data, 5)
    tips = _tips("series", "point", "ratio", "verdict")
    on_sweep = f"datum.sweep == {number}"
    ran = [on_sweep, "datum.verdict == 'pass' || datum.verdict == 'fail'"]
    curves = {"layer": _curves(data, x, y, tips, ran, name=str(number), size=36)}
    colour, _ = _style(data)
    sign = {"condition": {"test": "datum.verdict == 'error'", "value": "x"}, "value": "?"}
    signs = _layer(
        {"type": "text", "fontSize": 13, "fontWeight": "bold"},
        {"x": x, "y": y, "color": colour, "text": sign},
        [on_sweep, "datum.verdict == 'error' || datum.verdict == 'undecided'"],
    )
    # The bound: a value over its bound of 1. The axis says so; it is not read out.
    dashes = {"type": "rule", "strokeDash": [5, 4], "color": "#888888", "aria": False}
    rule = _layer(dashes, {"y": {"datum": 1.0}}, [on_sweep])
    return {
        "title": {"text": title, "fontSize": 11, "limit": 260},
        "layer": [rule, curves, signs],
        "width": 230,
        "height": 130,
    }


def _heat_maps(data: ChartData) -> Spec:
    """A heat map a method, with one scale of colours and one of dashes."""
    return {
        "data": _rows("map", "x", "y", "digits", "contour", "at"),
        "concat": [_heat_map(data, number, name) for number, name in enumerate(data.choices)],
        "columns": 2,
        "spacing": 24,
        "resolve": {"scale": {"color": "shared", "strokeDash": "shared"}},
    }


def _heat_map(data: ChartData, number: int, name: str) -> Spec:
    """The heat map of one method: cells, contours over them, and signs of verdicts."""
    x, y = (_values_of_axis(*axis, place) for axis, place in zip(data.axes, "xy", strict=True))
    places = {"x": x, "y": y}
    width, height = (_side_of_map(len(values)) for _, values in data.axes)
    sides = [
        side / len(values) for side, (_, values) in zip((width, height), data.axes, strict=True)
    ]
    layers = [_cells(places), *_contours(places), *_signs(places, min(sides))]
    for layer in layers:
        layer["transform"].insert(0, {"filter": f"datum.map == {number}"})
    title = {"text": name, "fontSize": 11, "limit": 300}
    return {"title": title, "layer": layers, "width": width, "height": height}


def _side_of_map(values: int) -> int:
    """Pixels of a side of a heat map with so many values."""
    least, most = SIDES_OF_MAP
    return min(max(CELL * values, least), most)


def _values_of_axis(name: str, values: tuple[str, ...], place: str) -> Spec:
    """The axis of a parameter: its values stand at 0, 1, 2 and so on, as they are written."""
    axis = {
        "values": list(range(len(values))),
        "labelExpr": f"{json.dumps(values)}[datum.value]",
        "labelOverlap": True,
        "grid": False,
    }
    scale = {"domain": [-0.5, len(values) - 0.5], "nice": False, "zero": False}
    return _quantity(place, title=name, scale=scale, axis=axis)


def _cells(places: dict[str, Spec]) -> Spec:
    """A square of unit sides around each place, coloured by its digits."""
    edges = {"left": "x - 0.5", "right": "x + 0.5", "bottom": "y - 0.5", "top": "y + 0.5"}
    encoding = {
        "x": {**places["x"], "field": "left"},
        "y": {**places["y"], "field": "bottom"},
        "x2": {"field": "right"},
        "y2": {"field": "top"},
        "color": _quantity(
            "digits", title="digits", scale={"scheme": "viridis", "domain": [0, 16]}
        ),
        "tooltip": _tips(*CELL_TIPS),
    }
    # Tables below the chart have the cells for those who hear the page.
    cells = _layer({"type": "rect", "aria": False}, encoding, ["isValid(datum.digits)"])
    sides = [{"calculate": f"datum.{where}", "as": edge} for edge, where in edges.items()]
    cells["transform"] += sides
    return cells


CELL_TIPS = ("digits", "error", "step", "verdict")
"""What is shown of a cell of a heat map, by the columns of its row."""


def _contours(places: dict[str, Spec]) -> list[Spec]:
    """Contours in black over white, as cells are dark and light; dashed by their digits."""
    path = {**places, "detail": _name("piece"), "order": _quantity("at")}
    dashes = {"domain": [3, 6, 9], "range": [[1, 3], [6, 4], [1, 0]]}
    # Gray stands out against a page that is light and one that is dark.
    legend = {"symbolStrokeColor": "#808080"}
    title = "contour [digits]"
    dashed = {**path, "strokeDash": _name("contour", title=title, scale=dashes, legend=legend)}
    on_contour = ["isValid(datum.contour)"]
    return [
        _layer({"type": "line", "stroke": "white", "strokeWidth": 2.5}, path, on_contour),
        _layer({"type": "line", "stroke": "black", "strokeWidth": 1.2}, dashed, on_contour),
    ]


def _signs(places: dict[str, Spec], side: float) -> list[Spec]:
    """The signs of verdicts that are no pass, in black over white for the same reason; no larger
    than the smaller `side` of a cell [pixel].
    """
    encoding = {**places, "text": _name("sign"), "tooltip": _tips(*CELL_TIPS)}
    size = min(SIGN, round(side, 1))
    outline = round(3 * size / SIGN, 1)
    text = {"type": "text", "fontSize": size, "fontWeight": "bold"}
    has_sign = ["isValid(datum.sign) && datum.sign != ''"]
    return [
        _layer({**text, "stroke": "white", "strokeWidth": outline}, encoding, has_sign),
        _layer({**text, "fill": "black"}, encoding, has_sign),
    ]
