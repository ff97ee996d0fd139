"""What a witness says of a certified set, and whether it confirms it."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any

from flint import arb

from refdem.core.parameters import Exact
from refdem.truth.balls import arb_of, exclusive, precision

AGREED = 24
"""Digits, relative to a size of at least 1, to which a witness has to agree."""
BITS = 256

Said = Iterator[tuple[Fraction | None, Mapping[str, arb]]]
Claimed = Mapping[str, Fraction]
"""Midpoints of the scalars, for a witness that looks for the same one: which of the roots is meant.
"""


@dataclass(frozen=True)
class Witness:
    """What a witness computes; `method` says how.

    `values` gives what it knows of the scalars (None) and of the quantities at the times (rising).
    """

    method: str
    values: Callable[[Mapping[str, Exact], Sequence[Fraction], Claimed], Said]


@cache
def witnesses() -> Mapping[str, Witness]:
    """Every witness by case id: found in the files of this folder."""
    found: dict[str, Witness] = {}
    for path in sorted(Path(__file__).parent.glob("*.py")):
        found |= (
            getattr(import_module(f"{__package__}.{path.stem}"), "WITNESSES", {})
            if path.stem != "__init__"
            else {}
        )
    return found


def witness_files(case: str) -> tuple[Path, ...]:
    """The file of a case's witness; none if it has none."""
    witness = witnesses().get(case)
    if witness:
        name = witness.values.__globals__["__name__"].rpartition(".")[2]
    else:
        name = ""
    if witness:
        return (Path(__file__).with_name(f"{name}.py"),)
    return ()


@exclusive
def testimony(
    case: str, p: Mapping[str, Exact], rows: Sequence[Sequence[Any]]
) -> dict[str, Any] | None:
    """Who confirms how many of the values of a set (rows as the store has them), to how many
    digits; None if nobody can.

    `denied` lists values that the witness does not confirm.
    """
    witness = witnesses().get(case)
    if witness is None:
        return None
    times = sorted({Fraction(row[0]) for row in rows if row[0] is not None})
    claimed = {row[1]: Fraction(row[2]) for row in rows if row[0] is None}
    with precision(BITS):
        said = {
            (t, name): value
            for t, values in witness.values(p, times, claimed)
            for name, value in values.items()
        }
        apart = {
            key: _apart(said[key], row) for row in rows if (key := (_time(row[0]), row[1])) in said
        }
    if not apart:
        return None
    worst = max(apart.values())
    denied = sorted(
        {f"{name} at {t}" for (t, name), by in apart.items() if by > Fraction(1, 10**AGREED)}
    )
    return {"by": witness.method, "values": len(apart), "digits": _digits(worst), "denied": denied}


def _time(text: str | None) -> Fraction | None:
    if text is None:
        return None
    return Fraction(text)


def _apart(said: arb, row: Sequence[Any]) -> Fraction:
    """How far the two may be apart, in units of the value where that is larger than 1; an upper
    bound.
    """
    mid = Fraction(row[2])
    apart = (abs(said - arb_of(mid)) + arb_of(Fraction(row[3]))) / max(
        Fraction(1), abs(mid)
    ).__ceil__()
    if not apart.is_finite():
        return Fraction(10**6)
    mantissa, exponent = apart.abs_upper().man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


def _digits(apart: Fraction) -> int:
    """Whole decimal digits below 1; at most 40."""
    return next((n for n in range(40, 0, -1) if apart * 10**n <= 1), 0)
