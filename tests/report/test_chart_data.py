"""The rows of charts: their floor, curves that lie on each other, default steps and costs."""

import csv
import io

import msgspec
import pytest

from refdem.core.finding import Sheet
from refdem.report import chart_data, charts
from refdem.report.chart_data import FLOOR, ChartData, undisturbed
from refdem.report.contents import Contents, contents_of
from refdem.report.tolerance import rows_of
from tests.report.synthetic import case_sheet, engine_sheet, error, levels, record

LABEL = "pendulum"


def contents(*records: Sheet, default_step: float | None = None) -> Contents:
    """A report on one case in three engines, of which `alpha` has a default step."""
    alpha = msgspec.structs.replace(engine_sheet("alpha"), default_step=default_step)
    engines = (engine_sheet("reference"), alpha, engine_sheet("beta"))
    return contents_of([*engines, case_sheet(LABEL, LABEL, "Pendulum", ""), *records])


def run(engine: str, size: float, order: int = 2) -> Sheet:
    """A run with errors size (h/0.1)^order."""
    return record(LABEL, LABEL, engine, "verlet", error("x", size, order))


def errors_of(found: Contents) -> ChartData:
    """The chart of errors."""
    chart = chart_data.errors(found, rows_of(found, LABEL))
    assert chart is not None
    return chart


def rows(chart: ChartData, series: str) -> list[dict[str, str]]:
    """The rows of a series in a chart."""
    return [row for row in csv.DictReader(io.StringIO(chart.csv)) if row["series"] == series]


def test_an_error_far_below_round_off_is_drawn_at_the_floor_and_told_as_it_is() -> None:
    chart = errors_of(contents(run("alpha", 1e-2), run("beta", 1e-24)))
    assert chart.extents["error"][0] == FLOOR
    (first, *_) = rows(chart, "beta verlet")
    assert float(first["shown_error"]) == FLOOR
    assert float(first["error"]) == 1e-24


def test_a_chart_of_errors_that_all_lie_below_the_floor_has_an_axis() -> None:
    low, high = errors_of(contents(run("alpha", 1e-24))).extents["error"]
    assert FLOOR == low < high


def test_a_curve_on_which_another_lies_is_marked_and_no_other() -> None:
    found = contents(run("reference", 1e-2), run("alpha", 1.001e-2), run("beta", 1e-5))
    chart = errors_of(found)
    assert {row["under"] for row in rows(chart, "reference verlet")} == {"1"}
    assert {row["under"] for row in rows(chart, "alpha verlet")} == {"0"}
    assert {row["under"] for row in rows(chart, "beta verlet")} == {"0"}


def test_curves_that_cross_do_not_lie_on_each_other() -> None:
    chart = errors_of(contents(run("reference", 1e-2, 2), run("alpha", 1e-2, 4)))
    assert {row["under"] for row in rows(chart, "reference verlet")} == {"0"}


@pytest.mark.parametrize("step", [0.03, 0.5])
def test_a_default_step_is_marked_in_the_panel_of_steps(step: float) -> None:
    chart = errors_of(contents(run("alpha", 1e-2), default_step=step))
    low, high = chart.extents["step"]
    assert low <= step <= high
    first = charts.specification(chart)["hconcat"][0]["layer"][0]
    assert first["mark"]["type"] == "rule"
    assert first["data"]["values"] == [{"name": "alpha's default", "at": step}]


def test_a_default_step_far_from_all_that_ran_does_not_stretch_the_axis() -> None:
    assert errors_of(contents(run("alpha", 1e-2), default_step=1e4)).defaults == ()


def test_a_default_step_of_an_engine_without_curves_is_not_marked() -> None:
    assert errors_of(contents(run("beta", 1e-2), default_step=0.03)).defaults == ()


def test_a_level_that_took_longer_than_a_finer_one_is_left_out_of_the_costs() -> None:
    timed = [
        msgspec.structs.replace(level, seconds=seconds)
        for level, seconds in zip(levels(1e-2, 2), (9.0, 1.0, 3.0, 2.0), strict=True)
    ]
    assert [level.seconds for level in undisturbed(timed)] == [1.0, 2.0]


def test_a_click_in_the_legend_chooses_in_every_panel() -> None:
    chart = errors_of(contents(run("alpha", 1e-2), run("beta", 1e-15, 0)))
    spec = charts.specification(chart)
    (chosen,) = [item for item in spec["params"] if item.get("bind") == "legend"]
    names = {layer.get("name") for panel in spec["hconcat"] for layer in panel["layer"]} - {None}
    assert set(chosen["views"]) == names
    assert len(names) == len(spec["hconcat"]) == 2
