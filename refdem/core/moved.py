"""The effect of each number of a case on its quantities, for a report and a page of the manual."""

import msgspec


class MovedLine(msgspec.Struct, frozen=True, kw_only=True):
    """The effect of one number p of a case on the quantity q that it changes most, in units of the
    scale s of q.

    `slope` is dq/dp, and `share` is p dq/dp / s: a relative change a of p changes q by `share` a s
    (None if p is 0). `quantity` is empty if none depends on the number. `has_derivative` is False
    if the motions below and above the number are of different kinds.
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
    """The effects of all numbers of an instance at the time `at` [s]: a sheet of a report.

    `command` is the command that prints all derivatives; `reason` states why `numbers` is empty.
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
