"""What each number of a case moves, as cells of a table: for reports and for pages of the manual,
in HTML and in Markdown.
"""

import re
from dataclasses import dataclass

from refdem.core.moved import Moved, MovedLine, unit_of_derivative
from refdem.core.outside import markdown_text

TITLE = "What each number moves"
HEAD = ("number", "value", "moves most", "derivative", "1 % more moves it by, of its scale")
NAME = re.compile(r"[\w.]+", re.ASCII)
"""Names of numbers and quantities of the cases that come with refdem."""
NO_DERIVATIVE = "no derivative: the motion is of another kind on one side"
NOTHING = "no quantity depends on it"


@dataclass(frozen=True)
class Cells:
    """One line of the table as plain text; `quantity` is empty where `reason` says why there is
    none.
    """

    number: str
    value: str
    quantity: str
    reason: str
    slope: str
    share: str


def words_of(moved: Moved, where: str) -> str:
    """The sentence above the table; `where` names the parameters."""
    return (
        f"Certified derivatives at {where}, at t = {moved.at} s: of the quantity that each number"
        " moves most, in units of its scale."
    )


def markdown_rows(moved: Moved) -> list[list[str]]:
    """The lines of the table with every cell escaped."""
    return [_escaped(cells) for cells in map(cells_of, moved.numbers)]


def _escaped(cells: Cells) -> list[str]:
    """The cells of one line in Markdown."""
    what = markdown_text(cells.reason)
    if cells.quantity:
        what = _code(cells.quantity)
    shown = [markdown_text(cells.value), what, markdown_text(cells.slope), cells.share]
    return [_code(cells.number), *shown]


def _code(name: str) -> str:
    """A name as code; text that is no name, which untrusted records may hold, is escaped."""
    if NAME.fullmatch(name):
        return f"`{name}`"
    return markdown_text(name)


def cells_of(line: MovedLine) -> Cells:
    """The cells of one number as plain text."""
    value = f"{line.value:.6g} {_unit(line.unit)}".rstrip()
    reason = ""
    if not line.has_derivative:
        reason = NO_DERIVATIVE
    elif not line.quantity:
        reason = NOTHING
    if reason:
        return Cells(line.number, value, "", reason, "", "")
    unit = _unit(unit_of_derivative(line.unit_of_quantity, line.unit))
    share = ""
    if line.share is not None:
        share = f"{line.share:.3g} %"
    slope = f"{line.slope:.4g} {unit}".rstrip()
    return Cells(line.number, value, line.quantity, "", slope, share)


def _unit(unit: str) -> str:
    """A unit; empty for a number without one."""
    if unit == "1":
        return ""
    return unit
