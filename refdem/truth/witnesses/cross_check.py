"""The comparison of a certified set of values with the values of a witness.

A witness is a second computation of a case that shares no code with its truth. It is in a file of
this folder whose WITNESSES maps case ids to `Witness`. It is not proved; a set that it does not
confirm is not stored.
"""

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
"""The working precision [bit] of a witness: 77 digits, more than are compared."""

Results = Iterator[tuple[Fraction | None, Mapping[str, arb]]]
Claimed = Mapping[str, Fraction]
"""Midpoints of the certified scalars, with which a witness selects the root to compute."""


@dataclass(frozen=True)
class Witness:
    """The computation of a witness, and a sentence `method` about it.

    `values` yields pairs (time, values by name) for some or all of the quantities at the times,
    which increase, and for scalars, with None as the time.
    """

    method: str
    values: Callable[[Mapping[str, Exact], Sequence[Fraction], Claimed], Results]


@cache
def witnesses() -> Mapping[str, Witness]:
    """Every witness by case id: found in the files of this folder."""
    by_case: dict[str, Witness] = {}
    for path in sorted(Path(__file__).parent.glob("*.py")):
        if path.stem != "__init__":
            module = import_module(f"{__package__}.{path.stem}")
            by_case |= getattr(module, "WITNESSES", {})
    return by_case


def witness_files(case: str) -> tuple[Path, ...]:
    """The file of a case's witness; none if it has none."""
    witness = witnesses().get(case)
    if witness is None:
        return ()
    # The file in which its function is written.
    module = witness.values.__globals__["__name__"].rpartition(".")[2]
    return (Path(__file__).with_name(f"{module}.py"),)


@exclusive
def cross_checked(
    case: str, p: Mapping[str, Exact], rows: Sequence[Sequence[Any]]
) -> dict[str, Any] | None:
    """The witness of a set, the number of values compared, and the digits to which they agree.

    `rows` are those of the store. `denied` lists the values that differ by more than 10^-AGREED.
    None if the case has no witness, or the witness has none of the values.
    """
    witness = witnesses().get(case)
    if witness is None:
        return None
    times = sorted({Fraction(row[0]) for row in rows if row[0] is not None})
    claimed = {row[1]: Fraction(row[2]) for row in rows if row[0] is None}
    with precision(BITS):
        results: dict[tuple[Fraction | None, str], arb] = {}
        for t, values in witness.values(p, times, claimed):
            for name, value in values.items():
                results[t, name] = value
        differences: dict[tuple[Fraction | None, str], Fraction] = {}
        for row in rows:
            key = (_time(row[0]), row[1])
            if key in results:
                differences[key] = _difference(results[key], row)
    if not differences:
        return None
    denied = set()
    for (t, name), difference in differences.items():
        if difference > Fraction(1, 10**AGREED):
            denied.add(f"{name} at {t}")
    return {
        "by": witness.method,
        "values": len(differences),
        "digits": _digits(max(differences.values())),
        "denied": sorted(denied),
    }


def _time(text: str | None) -> Fraction | None:
    """The time of a row of the store, None for a scalar."""
    if text is None:
        return None
    return Fraction(text)


def _difference(results: arb, row: Sequence[Any]) -> Fraction:
    """An upper bound of the difference between the witness and a row (t, name, mid, radius, ...).

    It is relative to |value| rounded up, where that is larger than 1; 10^6 if it is not finite.
    """
    mid = Fraction(row[2])
    radius = Fraction(row[3])
    size = max(Fraction(1), abs(mid)).__ceil__()
    difference = (abs(results - arb_of(mid)) + arb_of(radius)) / size
    if not difference.is_finite():
        return Fraction(10**6)
    mantissa, exponent = difference.abs_upper().man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


def _digits(difference: Fraction) -> int:
    """The number of decimal digits that agree: the largest n <= 40 with difference <= 10^-n."""
    return next((n for n in range(40, 0, -1) if difference * 10**n <= 1), 0)
