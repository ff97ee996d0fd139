"""The heat map of a study of two parameters: correct digits at each pair of values, with contours
of 3, 6 and 9 digits, one map for each method.
"""

import csv
import io
import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from contourpy import contour_generator
from numpy.typing import NDArray

from refdem.core.finding import Outcome
from refdem.core.store import Store
from refdem.report.chart_data import ChartData
from refdem.report.figures import equip, picture, specification
from refdem.report.files import written
from refdem.report.html import environment
from refdem.report.markdown import Cells
from refdem.report.numbers import two
from refdem.report.overview import MOST_DIGITS, shown_digits
from refdem.report.sweep import Point, reasons

Array = NDArray[np.float64]
Place = tuple[int, int]
"""Column and row of a cell."""
CONTOURS = (3, 6, 9)
"""Correct digits whose contours are drawn."""
SIGNS: dict[Outcome, str] = {"fail": "x", "error": "!", "undecided": "?", "unsupported": "-"}
"""The sign of a verdict that is no pass."""
CAPTION = (
    "correct digits at the smallest step; contours: 3, 6 and 9 digits; x: failed, ?: undecided,"
    " !: no run, -: unsupported"
)
FILES = ("sweep.html", "sweep.svg")
"""The page of a study, and its picture."""
COLUMNS = ("map", "x", "y", "digits", "sign", "error", "step", "verdict", "contour", "piece", "at")
"""Columns of the chart's rows: a row is a cell of a map, or a vertex of a contour."""


@dataclass(frozen=True)
class Map:
    """The cells of one method: the point of its smallest step by the places (column, row) of the
    two values.
    """

    series: str
    cells: dict[Place, Point]


def axes(names: Sequence[str], found: Sequence[Point]) -> tuple[tuple[str, tuple[str, ...]], ...]:
    """The name of each parameter with its values in the order of the study."""
    return tuple((name, tuple(dict.fromkeys(p.setting[name] for p in found))) for name in names)


def maps(names: Sequence[str], found: Sequence[Point]) -> list[Map]:
    """A map for each method of each engine that supports any setting, in the order of the study."""
    (x, columns), (y, rows) = axes(names, found)
    made: dict[str, Map] = {}
    for point in found:
        series = f"{point.engine} {point.method}"
        cells = made.setdefault(series, Map(series, {})).cells
        place = (columns.index(point.setting[x]), rows.index(point.setting[y]))
        if place not in cells or _is_finer(point, cells[place]):
            cells[place] = point
    return [one for one in made.values() if not _is_unsupported(one)]


def _is_unsupported(shown: Map) -> bool:
    """True if the engine supports no setting with this method."""
    return all(point.verdict == "unsupported" for point in shown.cells.values())


def _is_finer(point: Point, other: Point) -> bool:
    """True if `point` was measured at a smaller step or tolerance than `other`."""
    if point.error is None:
        return False
    return other.error is None or (point.level or 0.0) < (other.level or 0.0)


def correct_digits(point: Point) -> float | None:
    """-log10 of the error in units of the quantity's scale, between 0 and those of binary64; None
    where no error was measured.
    """
    if point.error is None:
        return None
    if point.error == 0.0:
        return MOST_DIGITS
    return min(max(-math.log10(point.error), 0.0), MOST_DIGITS)


def contours(columns: int, rows: int, cells: dict[Place, Point]) -> dict[int, list[Array]]:
    """The polygons along which the digits, interpolated linearly between neighbouring cells, are 3,
    6 and 9.

    A polygon is an array (vertices, 2) of places in units of cells. A cell without a measured error
    bounds no contour.
    """
    # Contours need a cell of the grid of centres: two columns and two rows.
    if columns < 2 or rows < 2:
        return {}
    digits = np.full((rows, columns), np.nan)
    for (column, row), point in cells.items():
        measured = correct_digits(point)
        if measured is not None:
            digits[row, column] = measured
    generator = contour_generator(z=np.ma.masked_invalid(digits), corner_mask=False)
    return {
        level: [np.asarray(polygon) for polygon in generator.lines(level)] for level in CONTOURS
    }


def chart(names: Sequence[str], found: Sequence[Point]) -> ChartData | None:
    """The maps of a study as the chart `heat_maps` takes them; None where nothing was judged."""
    drawn = maps(names, found)
    if not drawn:
        return None
    ends = axes(names, found)
    (_, columns), (_, rows) = ends
    out = io.StringIO()
    writer = csv.DictWriter(out, COLUMNS, lineterminator="\n")
    writer.writeheader()
    for number, shown in enumerate(drawn):
        for (column, row), point in shown.cells.items():
            writer.writerow({"map": number, "x": column, "y": row, **_cell(point)})
        for level, polygons in contours(len(columns), len(rows), shown.cells).items():
            for piece, polygon in enumerate(polygons):
                for at, (x, y) in enumerate(polygon.round(4).tolist()):
                    vertex = {"map": number, "x": x, "y": y, "at": at}
                    writer.writerow({**vertex, "contour": level, "piece": f"{level}-{piece}"})
    series = tuple(shown.series for shown in drawn)
    return ChartData("heat_maps", out.getvalue(), series, axes=ends)


def _cell(point: Point) -> dict[str, object]:
    """What a cell shows: colour, sign, and the words of its tooltip."""
    digits = correct_digits(point)
    texts: dict[str, object] = {
        "sign": SIGNS.get(point.verdict, ""),
        "error": two(point.error),
        "step": two(point.level),
        "verdict": point.verdict,
    }
    if digits is not None:
        texts["digits"] = round(digits, 2)
    return texts


def table(names: Sequence[str], found: Sequence[Point], shown: Map) -> Cells:
    """The map as a table: a line for each value of the second parameter, a column for each of the
    first.
    """
    (x, columns), (y, rows) = axes(names, found)
    lines = []
    for row, value in enumerate(rows):
        line = [_text(shown.cells.get((column, row))) for column in range(len(columns))]
        lines.append([value, *line])
    return shown.series, [f"{y} \\ {x}", *columns], lines


def _text(point: Point | None) -> str:
    """The digits of a cell, with the sign of a verdict that is no pass."""
    if point is None:
        return ""
    digits = correct_digits(point)
    words = [SIGNS.get(point.verdict, "")]
    if digits is not None:
        words.insert(0, shown_digits(digits))
    return " ".join(filter(None, words))


def write(
    folder: Path, title: str, names: Sequence[str], found: Sequence[Point], store: Store | None
) -> bool:
    """Writes sweep.html, sweep.svg and what the page needs into a folder.

    False for another number of parameters than two, or without a map; a page of an earlier study in
    that folder is then removed, as it does not show this one.
    """
    data = None
    if len(names) == 2:
        data = chart(names, found)
    if data is None:
        for stale in FILES:
            (folder / stale).unlink(missing_ok=True)
        return False
    spec = specification(data)
    written(folder / "sweep.svg", picture(spec, store))
    page = environment().get_template("sweep.html")
    sheet = page.render(
        root="",
        title=title,
        caption=CAPTION,
        spec=spec,
        tables=[table(names, found, shown) for shown in maps(names, found)],
        reasons=reasons(found),
    )
    written(folder / "sweep.html", sheet)
    equip(folder, store)
    return True
