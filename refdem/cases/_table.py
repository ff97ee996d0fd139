"""The parameters of the billiard tables: exact pairs of them, and the refusal of starts outside."""

from fractions import Fraction

from refdem.core.parameters import Parameters
from refdem.errors import UsageError


def exact(p: Parameters, name: str) -> tuple[Fraction, Fraction]:
    """Two parameters of that name as exact fractions."""
    return p[name]  # type: ignore[return-value]


def refuse_outside(p: Parameters) -> None:
    """Raises UsageError for a start that is not inside, no direction, or a stadium that is wider
    than long.
    """
    length, width = exact(p, "size")
    x, y = exact(p, "start")
    is_stadium = p["geometry"] == "stadium"
    if not any(exact(p, "direction")):
        raise UsageError("parameter direction: got 0,0; expected a vector that is not zero")
    if is_stadium and length < width:
        raise UsageError(
            f"parameter size: got {length},{width}; expected a stadium at least as long as it is"
            " wide"
        )
    # The centres of a stadium's half circles, of radius width/2, are at x = +-(length - width)/2.
    # Beyond them a point lies inside if its distance from the centre is less than the radius.
    beyond = Fraction(0)
    if is_stadium:
        beyond = max(abs(x) - (length - width) / 2, Fraction(0))
    is_within_length = 2 * abs(x) < length
    is_within_width = 4 * (beyond * beyond + y * y) < width * width
    if not (is_within_length and is_within_width):
        raise UsageError(f"parameter start: got {x},{y}; expected a place inside the table")
