"""Numbers as people read them: two significant digits."""

import math

ABSENT = "\N{EN DASH}"


def two(value: float | None) -> str:
    """A number with two significant digits: `0.012`, `3.4e-9`, `0`; a dash if it is absent."""
    if value is None:
        return ABSENT
    if value == 0 or not math.isfinite(value):
        if value == 0:
            return "0"
        return str(value)
    mantissa, _, exponent = f"{value:.1e}".partition("e")
    if -3 <= int(exponent) < 3:
        return f"{float(f'{value:.1e}'):g}"
    return f"{mantissa.removesuffix('.0')}e{int(exponent)}"


def rounded(value: float, digits: int = 2) -> float:
    """The number that has no more than `digits` significant digits."""
    return float(f"{value:.{digits - 1}e}")


def decades(margin: float | None) -> str:
    """A margin in decades with its sign."""
    if margin is None:
        return ABSENT
    if math.isinf(margin):
        return "exact"
    return f"{margin:+.1f}"
