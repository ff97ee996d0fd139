"""What the billiard tables need of their parameters: exact pairs, and starts that are inside."""

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
    a, b = exact(p, "size")
    x, y = exact(p, "start")
    stadium = p["geometry"] == "stadium"
    if not any(exact(p, "direction")):
        raise UsageError("parameter direction: got 0,0; expected a vector that is not zero")
    if stadium and a < b:
        raise UsageError(
            f"parameter size: got {a},{b}; expected a stadium at least as long as it is wide"
        )
    if stadium:
        beyond = max(abs(x) - (a - b) / 2, Fraction(0))
    else:
        beyond = Fraction(0)
    if not (2 * abs(x) < a and 4 * (beyond * beyond + y * y) < b * b):
        raise UsageError(f"parameter start: got {x},{y}; expected a place inside the table")
