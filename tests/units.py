"""What other units of mass, length and time make of a number: a unit as it is printed, read as
powers of these three.
"""

import re
from dataclasses import dataclass
from fractions import Fraction

NAMED = {
    "": (0, 0, 0),
    "1": (0, 0, 0),
    "rad": (0, 0, 0),
    "kg": (1, 0, 0),
    "m": (0, 1, 0),
    "s": (0, 0, 1),
    "Hz": (0, 0, -1),
    "N": (1, 1, -2),
    "J": (1, 2, -2),
}
"""Powers of mass, length and time."""
FACTOR = re.compile(r"([A-Za-z]+|1)(?:\^(\d+|\(\d+/\d+\)|n))?")

Powers = tuple[Fraction, ...]


def of_product(text: str, n: Fraction) -> Powers:
    """The powers in a product such as `m^2 s^2`."""
    total = [Fraction(0)] * 3
    for name, power in FACTOR.findall(text):
        if power == "n":
            exponent = n
        else:
            exponent = Fraction(power.strip("()") or 1)
        total = [
            sum_so_far + exponent * p for sum_so_far, p in zip(total, NAMED[name], strict=True)
        ]
    return tuple(total)


def powers(unit: str, n: Fraction) -> Powers:
    """The powers in a unit such as `s/(kg m^2)`; `n` is that of `N/m^n`."""
    above, _, below = unit.partition("/")
    both = zip(of_product(above, n), of_product(below, n), strict=True)
    return tuple(over - under for over, under in both)


@dataclass(frozen=True)
class Change:
    """Numbers in kg, m and s are multiplied by these powers of a whole number `base`."""

    base: int
    mass: int
    length: int
    time: int

    def factor(self, unit: str, n: Fraction = Fraction(1)) -> Fraction:
        """By what a number in this unit is multiplied; ValueError where that is a root."""
        mass, length, time = powers(unit, n)
        exponent = self.mass * mass + self.length * length + self.time * time
        if exponent.denominator != 1:
            raise ValueError(f"{unit} would be multiplied by {self.base}^({exponent})")
        return Fraction(self.base) ** int(exponent)
