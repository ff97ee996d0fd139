"""Heat maps of studies of two parameters, from points made by hand."""

import csv
import io
import json
from pathlib import Path

import altair
import pytest

from refdem.core.finding import Outcome
from refdem.report import heat_map
from refdem.report.figures import specification
from refdem.report.sweep import Point

NAMES = ("theta0", "length")


def point(
    x: str,
    y: str,
    error: float | None = 1e-4,
    *,
    verdict: Outcome = "pass",
    level: float | None = 0.1,
    engine: str = "mydem",
) -> Point:
    """One step of leapfrog at theta0 = x, length = y."""
    return Point(
        setting={"theta0": x, "length": y},
        engine=engine,
        method="leapfrog",
        verdict=verdict,
        reason=f"It is {verdict}.",
        level=level,
        error=error,
        bound=1.0,
    )


def rows(found: list[Point]) -> list[dict[str, str]]:
    """The rows of the chart."""
    data = heat_map.chart(NAMES, found)
    assert data is not None
    return list(csv.DictReader(io.StringIO(data.csv)))


def contours(found: list[Point]) -> dict[str, set[tuple[float, float]]]:
    """The vertices of the contours of each number of digits."""
    vertices: dict[str, set[tuple[float, float]]] = {}
    for row in rows(found):
        if row["contour"]:
            vertices.setdefault(row["contour"], set()).add((float(row["x"]), float(row["y"])))
    return vertices


def test_a_cell_has_the_error_of_the_smallest_step() -> None:
    steps = [point("1", "2", 1e-2, level=0.2), point("1", "2", 1e-5, level=0.05), point("1", "2")]
    (cell,) = rows(steps)
    assert (cell["x"], cell["y"], cell["digits"], cell["step"]) == ("0", "0", "5.0", "0.05")


def test_a_step_without_an_error_does_not_hide_one_that_was_measured() -> None:
    (cell,) = rows([point("1", "2", 1e-3), point("1", "2", None, level=0.01)])
    assert cell["digits"] == "3.0"


def test_each_method_has_a_map_with_its_own_cells() -> None:
    found = rows([point("1", "2", 1e-3), point("1", "2", 1e-7, engine="other")])
    assert [(cell["map"], cell["digits"]) for cell in found] == [("0", "3.0"), ("1", "7.0")]


@pytest.mark.parametrize(
    ("error", "digits"), [(0.0, 16.0), (1e-30, 16.0), (1e-6, 6.0), (1.0, 0.0), (1e3, 0.0)]
)
def test_digits_lie_between_none_and_those_of_binary64(error: float, digits: float) -> None:
    assert heat_map.correct_digits(point("1", "2", error)) == digits


def test_contours_lie_where_digits_are_interpolated_to_three_six_and_nine() -> None:
    # Digits 2, 5, 10 from left to right in both rows: 3 lies a third of the way from 2 to 5, 6 a
    # fifth and 9 four fifths of the way from 5 to 10.
    found = [
        point(x, y, error)
        for x, error in (("1", 1e-2), ("2", 1e-5), ("5", 1e-10))
        for y in ("1", "2")
    ]
    upright = {level: {x for x, _ in places} for level, places in contours(found).items()}
    assert upright == {"3": {0.3333}, "6": {1.2}, "9": {1.8}}


def test_no_contour_leaves_a_cell_that_was_not_measured() -> None:
    found = [
        point(x, y, None if (x, y) == ("1", "1") else error)
        for x, error in (("1", 1e-2), ("2", 1e-4))
        for y in ("1", "2", "3")
    ]
    assert all(y >= 1.0 for _, y in contours(found)["3"])


def test_a_single_row_of_cells_has_no_contour() -> None:
    assert contours([point("1", "1", 1e-2), point("2", "1", 1e-8)]) == {}


@pytest.mark.parametrize(
    ("verdict", "sign"), [("pass", ""), ("fail", "x"), ("error", "!"), ("undecided", "?")]
)
def test_a_verdict_that_is_no_pass_has_its_sign(verdict: Outcome, sign: str) -> None:
    found = [point("1", "2", verdict=verdict)]
    assert rows(found)[0]["sign"] == sign
    (shown,) = heat_map.maps(NAMES, found)
    _, header, lines = heat_map.table(NAMES, found, shown)
    assert header == ["length \\ theta0", "1"]
    assert lines == [["2", f"4.0 {sign}".strip()]]


def test_the_chart_keeps_to_the_schema_and_its_axes_show_values_as_they_are_written() -> None:
    found = [point(x, y) for x in ("1,0,0", "0,1,0") for y in ("1/3", "2")]
    data = heat_map.chart(NAMES, found)
    assert data is not None
    spec = json.loads(specification(data))
    altair.Chart.from_dict(spec, validate=True)
    cells, *_ = spec["concat"][0]["layer"]
    axis = cells["encoding"]["x"]["axis"]
    assert (axis["values"], axis["labelExpr"]) == ([0, 1], '["1,0,0", "0,1,0"][datum.value]')


def test_the_page_has_the_map_the_table_and_the_reasons(tmp_path: Path) -> None:
    found = [point(x, y) for x in ("1", "2") for y in ("1", "2")]
    found.append(point("3", "1", verdict="fail", engine="<b>bad</b>"))
    assert heat_map.write(tmp_path, "Sweep", NAMES, found, None)
    page = (tmp_path / "sweep.html").read_text()
    assert "<b>bad</b>" not in page
    assert "fail, &lt;b&gt;bad&lt;/b&gt;/leapfrog: It is fail." in page
    assert (tmp_path / "sweep.svg").read_text().startswith("<svg")
    assert (tmp_path / "assets" / "report.js").exists()


def test_a_study_in_which_nothing_was_judged_has_no_map(tmp_path: Path) -> None:
    assert not heat_map.write(tmp_path, "Sweep", NAMES, [], None)
    assert list(tmp_path.iterdir()) == []


def test_a_method_that_supports_no_setting_has_no_map(tmp_path: Path) -> None:
    found = [point("1", y, None, verdict="unsupported", engine="other") for y in ("1", "2")]
    assert not heat_map.write(tmp_path, "Sweep", NAMES, found, None)
    (shown,) = heat_map.maps(NAMES, [point("1", "1"), *found])
    assert shown.series == "mydem leapfrog"


def test_a_method_that_supports_some_settings_has_the_sign_of_the_others() -> None:
    rest = point("1", "2", None, verdict="unsupported")
    assert [row["sign"] for row in rows([point("1", "1"), rest])] == ["", "-"]


def test_signs_are_no_larger_than_cells() -> None:
    def size(count: int) -> float:
        """Pixels of a sign on a map with so many columns."""
        data = heat_map.chart(NAMES, [point(str(x), "1") for x in range(count)])
        assert data is not None
        spec = json.loads(specification(data))
        return float(spec["concat"][0]["layer"][-1]["mark"]["fontSize"])

    assert size(2) == 13.0
    assert size(50) == 360 / 50
