"""What each number of a case moves, as a report and a page of the manual show it."""

import msgspec


class MovedLine(msgspec.Struct, frozen=True, kw_only=True):
    """What one number of a case moves: the quantity that it moves most, in units of its scale.

    `slope` is the derivative of this quantity by the number; a number larger by a small part a
    moves it by `share` times a of its scale (None for a number that is 0). No quantity is named
    where none depends on the number. `has_derivative` is False where motions are of another kind
    on either side of the number.
    """

    number: str
    value: float
    unit: str
    has_derivative: bool = True
    quantity: str = ""
    unit_of_quantity: str = ""
    slope: float = 0.0
    share: float | None = None


class Moved(msgspec.Struct, frozen=True, kw_only=True, tag="moved", tag_field="type"):
    """What each number of an instance moves at the time `at` [s]: a sheet of a report.

    `command` prints all derivatives; `reason` says why there are no lines, if there are none.
    """

    label: str
    at: str
    command: str
    numbers: tuple[MovedLine, ...] = ()
    reason: str = ""


def unit_of_derivative(unit: str, by: str) -> str:
    """The unit of a derivative as `N/kg` or `(m/s)/(kg/m)`; that of the quantity where the number
    has none.
    """
    if by == "1":
        return unit
    return f"{_bracketed(unit)}/{_bracketed(by)}"


def _bracketed(unit: str) -> str:
    """A unit as a part of a quotient, in parentheses where it is a product or quotient itself."""
    if any(sign in unit for sign in "/ *"):
        return f"({unit})"
    return unit
