"""The charts, each defined once in Altair: interactive in pages and drawn as SVG for Markdown."""

from typing import Any

import altair as alt

from refdem.report.chart_data import ChartData

WIDTH, HEIGHT = 460, 320


def specification(data: ChartData) -> dict[str, Any]:
    """The Vega-Lite specification of a chart."""
    chart = {"errors": _errors, "costs": _costs, "drifts": _drifts, "overview": _overview}[data.kind](data)
    spec: dict[str, Any] = chart.properties(background="transparent").to_dict(validate=False)
    return spec


def _values(data: ChartData, **types: str) -> alt.InlineData:
    return alt.InlineData(values=data.csv, format=alt.CsvDataFormat(type="csv", parse=types))


def _log(name: str, title: str, data: ChartData) -> alt.Y:
    """A logarithmic axis from the chart's floor up."""
    scale = alt.Scale(type="log", domainMin=data.numbers[0], nice=False)
    return alt.Y(f"{name}:Q", title=title, scale=scale, axis=alt.Axis(format=".0e", tickCount=8))


def _encodings(data: ChartData) -> dict[str, Any]:
    """Colour and shape of a series, joined in one legend."""
    names, colours, shapes = (list(column) for column in zip(*data.styles, strict=True))
    return {
        "color": alt.Color("series:N", title="engine, method", scale=alt.Scale(domain=names, range=colours)),
        "shape": alt.Shape("series:N", title="engine, method", scale=alt.Scale(domain=names, range=shapes)),
    }


def _picked(data: ChartData, name: str) -> alt.Parameter:
    """The selector of a chart."""
    return alt.param(name="pick", value=data.choices[0], bind=alt.binding_select(options=list(data.choices), name=f"{name} "))


def _errors(data: ChartData) -> Any:
    pick = _picked(data, "quantity")
    base = alt.Chart(_values(data, level="number", shown_error="number", shown_bound="number")).transform_filter("datum.quantity == pick")
    style = _encodings(data)
    tips = [alt.Tooltip(f"{name}:N") for name in ("series", "quantity", "level", "error", "bound")]
    y = _log("shown_error", "largest error / scale", data)

    def panel(control: str, title: str, width: int) -> alt.LayerChart:
        chosen = base.transform_filter(f"datum.control == '{control}'")
        x = alt.X("level:Q", title=title, scale=alt.Scale(type="log", padding=12), axis=alt.Axis(format="~e", tickCount=6))
        lines = chosen.mark_line(opacity=0.85).encode(x=x, y=y, color=style["color"])
        points = chosen.mark_point(filled=True, size=55, opacity=1).encode(x=x, y=y, tooltip=tips, **style)
        bounds = chosen.mark_line(strokeDash=[5, 4], opacity=0.6).encode(x=x, y=alt.Y("shown_bound:Q"), color=style["color"])
        return alt.layer(bounds, lines, points).properties(width=width, height=HEIGHT)

    panels = []
    if ",step," in data.csv:
        panels.append(panel("step", "step [s]; dashed: the bound", WIDTH))
    if ",tolerance," in data.csv:
        panels.append(panel("tolerance", "tolerance; dashed: the bound", WIDTH if not panels else 200))
    if ",exact," in data.csv:
        exact = base.transform_filter("datum.control == 'exact'").encode(x=alt.X("series:N", title="exact methods", axis=alt.Axis(labels=False)))
        ticks = exact.mark_tick(strokeDash=[5, 4], opacity=0.6).encode(y=alt.Y("shown_bound:Q"), color=style["color"])
        panels.append(alt.layer(ticks, exact.mark_point(filled=True, size=70, opacity=1).encode(y=y, tooltip=tips, **style)).properties(height=HEIGHT))
    return alt.hconcat(*panels).resolve_scale(y="shared").add_params(pick)


def _costs(data: ChartData) -> Any:
    pick = _picked(data, "quantity")
    style = _encodings(data)
    base = alt.Chart(_values(data, seconds="number", shown_error="number")).transform_filter("datum.quantity == pick")
    x = alt.X("seconds:Q", title="seconds in the engine's loop", scale=alt.Scale(type="log", padding=12), axis=alt.Axis(format="~e", tickCount=6))
    y = _log("shown_error", "largest error / scale", data)
    tips = [alt.Tooltip(f"{name}:N") for name in ("series", "quantity", "seconds", "error")]
    lines = base.mark_line(opacity=0.6).encode(x=x, y=y, color=style["color"])
    points = base.mark_point(filled=True, size=55, opacity=1).encode(x=x, y=y, tooltip=tips, **style)
    return alt.layer(lines, points).properties(width=WIDTH, height=HEIGHT).add_params(pick)


def _drifts(data: ChartData) -> Any:
    pick = _picked(data, "check")
    style = _encodings(data)
    base = alt.Chart(_values(data, t="number", shown_value="number", shown_bound="number")).transform_filter("datum.what == pick")
    x = alt.X("t:Q", title="t [s]; dashed: the bound")
    y = _log("shown_value", "value", data)
    tips = [alt.Tooltip(f"{name}:N") for name in ("series", "what", "t", "value", "bound")]
    bounds = base.mark_line(strokeDash=[5, 4], opacity=0.6).encode(x=x, y=alt.Y("shown_bound:Q"), color=style["color"])
    lines = base.mark_line(strokeWidth=1, opacity=0.85).encode(x=x, y=y, color=style["color"])
    points = base.mark_point(filled=True, size=22, opacity=1).encode(x=x, y=y, tooltip=tips, **style)
    return alt.layer(bounds, lines, points).properties(width=WIDTH, height=HEIGHT).add_params(pick)


def _overview(data: ChartData) -> Any:
    names, colours, _ = (list(column) for column in zip(*data.styles, strict=True))
    base = alt.Chart(_values(data, halvings="number", error="number"))
    x = alt.X("halvings:Q", title="halvings of the step", axis=alt.Axis(tickMinStep=1, tickCount=5))
    y = alt.Y("error:Q", title="error / scale", scale=alt.Scale(type="log", domainMin=data.numbers[0], nice=False), axis=alt.Axis(format=".0e", tickCount=5))
    colour = alt.Color("engine:N", title="engine", scale=alt.Scale(domain=names, range=colours), legend=alt.Legend(orient="top"))
    tips = [alt.Tooltip(f"{name}:N") for name in ("case", "series", "error")]
    drawn = base.mark_line(point=alt.OverlayMarkDef(filled=True, size=22), strokeWidth=1.5).encode(x=x, y=y, color=colour, detail="series:N", tooltip=tips)
    header = alt.Header(title=None, labelFontWeight="bold", labelLimit=200)
    return drawn.properties(width=170, height=120).facet(facet=alt.Facet("case:N", header=header), columns=4)
