"""Numbers formatted for people: two significant digits, or as many as requested."""

import math

ABSENT = "\N{EN DASH}"


def two(value: float | None) -> str:
    """A number with two significant digits: `0.012`, `3.4e-9`, `0`; a dash if it is absent."""
    return significant(value, 2)


def significant(value: float | None, digits: int) -> str:
    """A number with at most so many significant digits: of 1.6266 and 4 `1.627`, of 0.4 `0.4`; a
    dash if it is absent.
    """
    if value is None:
        return ABSENT
    if value == 0 or not math.isfinite(value):
        if value == 0:
            return "0"
        return str(value)
    mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
    if -3 <= int(exponent) < max(3, digits):
        # At least so many digits keep Python from writing a power of ten.
        return f"{rounded(value, digits):.{max(digits, 3)}g}"
    if "." in mantissa:
        mantissa = mantissa.rstrip("0").removesuffix(".")
    return f"{mantissa}e{int(exponent)}"


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
