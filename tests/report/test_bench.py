"""The page and the Markdown of a bench."""

import json
import re

from refdem.report.bench import Section, chart, markdown, page

SECTION = Section(
    "pendulum[theta0=2]",
    [
        ("reference", "exact", True, 1e-5, 0.0),
        ("mujoco", "rk4", False, 1e-3, 3.3e-7),
        ("mujoco", "<b>", False, 2e-3, 1e-3),
    ],
    [("Time", ("method", "to 1e-3"), [("mujoco <b>", "1 ms | 2 ms")])],
)


def test_what_engines_are_called_is_escaped_in_a_page() -> None:
    text = page("Title", "words", [], [SECTION])
    assert "<b>" not in text
    assert "mujoco &lt;b&gt;" in text


def test_the_chart_has_every_point_and_draws_an_error_of_zero_at_its_floor() -> None:
    data = chart(SECTION)
    assert data is not None
    rows = [line.split(",") for line in data.csv.splitlines()[1:]]
    assert len(rows) == 3
    assert float(rows[0][4]) == data.extents["error"][0] > 0
    assert data.extents["seconds"][0] < 1e-5 < 2e-3 < data.extents["seconds"][1]
    specs = re.findall(r'id="spec-scene-chart-1">(.*?)</script>', page("Title", "", [], [SECTION]))
    assert "mujoco rk4" in json.dumps(json.loads(specs[0]))


def test_markdown_has_a_table_whose_cells_stay_apart() -> None:
    text = markdown("Title", "words", [], [SECTION], "figures")
    assert "| mujoco &lt;b&gt; | 1 ms \\| 2 ms |" in text
    assert "![error against seconds](figures/bench-1.svg)" in text


def test_the_reference_is_grey_and_methods_of_an_engine_differ_in_shape() -> None:
    data = chart(SECTION)
    assert data is not None
    colours = [style[1] for style in data.styles]
    shapes = [style[2] for style in data.styles]
    assert colours[0] not in colours[1:]
    assert colours[1] == colours[2]
    assert shapes[1] != shapes[2]
