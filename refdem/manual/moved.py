"""What each number of a case does to its quantities: the lines of a page of the manual, from
certified derivatives.
"""

from collections.abc import Iterator
from fractions import Fraction

from refdem.core.case import Instance
from refdem.core.manual import MovedLine
from refdem.errors import NotCertifiedError
from refdem.truth.sensitivities import Number, Sensitivities, numbers_of, sensitivities

DIGITS = 8
"""Decimal places to which derivatives are proved; a line shows four digits."""


def moved_at(instance: Instance) -> str:
    """The time [s] at which the derivatives of a motion are shown, a third of it, in three digits;
    empty for a case without time.
    """
    times = instance.times
    if len(times) < 2:
        return ""
    return f"{float(times[len(times) // 3]):.3g}"


def moved_lines(instance: Instance) -> tuple[MovedLine, ...]:
    """A line for each number of a motion at its defaults; none where derivatives are not
    certified.
    """
    time = moved_at(instance)
    if not time:
        return ()
    parameters = instance.case.written_out(instance.p)
    try:
        found = sensitivities(instance.case.truth, parameters, Fraction(time), DIGITS)
    except NotCertifiedError:
        return ()
    numbers = [(number, number.of(parameters)) for number in numbers_of(parameters)]
    return tuple(line(instance, found, number, value) for number, value in numbers)


def line(instance: Instance, found: Sensitivities, number: Number, value: Fraction) -> MovedLine:
    """The line of one number of this value: the quantity that it moves most, counted in scales."""
    name = number.name
    unit = instance.p.declared[number.parameter].unit
    if name in found.missing:
        return MovedLine(number=name, value=float(value), unit=unit, has_derivative=False)
    size, quantity, slope = max(moves(instance, found, name))
    if size == 0:
        return MovedLine(number=name, value=float(value), unit=unit)
    share = None
    if value:
        share = abs(float(value)) * size
    return MovedLine(
        number=name,
        value=float(value),
        unit=unit,
        quantity=quantity,
        unit_of_quantity=instance.quantities[quantity].unit,
        slope=slope,
        share=share,
    )


def moves(
    instance: Instance, found: Sensitivities, name: str
) -> Iterator[tuple[float, str, float]]:
    """|dq/dp|/scale, the quantity, and dq/dp, for every quantity and one number."""
    for quantity, by_number in found.of.items():
        if quantity in instance.quantities:
            slope = float(by_number[name].mid)
            yield abs(slope) / instance.quantities[quantity].scale, quantity, slope
