"""From a truth to the lines of a certified set (see reader.py for their format)."""

import hashlib
import json
from collections.abc import Mapping, Sequence
from fractions import Fraction
from importlib.metadata import version
from typing import Any

from refdem import __version__
from refdem.core.truth import Ball, Truth
from refdem.errors import NotCertifiedError
from refdem.truth.certified.reader import COLUMNS, FORMAT, LARGEST_RADIUS, sha256_of
from refdem.truth.sampled import certified_scalars

DIGITS = 36
"""Digits to which the balls are requested, two beyond PLACES: rounding then costs no place."""
PLACES = 34
"""Decimal places that are kept: the radius of the decimals is half a unit of the last place."""

Rows = list[tuple[str | None, str, str, str, str | None]]


def rows(truth: Truth, times: Sequence[Fraction]) -> tuple[Rows, dict[str, str]]:
    """Every value, scalars first, then the quantities at each time; and the times that cannot be
    certified, with reasons.
    """
    lines = [row(None, name, ball) for name, ball in certified_scalars(truth).items()]
    missing: dict[str, str] = {}
    for t in times:
        try:
            balls = truth.at(t)
            wide = [name for name, ball in balls.items() if ball.radius > LARGEST_RADIUS]
            missing |= {str(t): f"radius of {', '.join(wide)} above 1e-30"} if wide else {}
            lines += [row(t, name, ball) for name, ball in balls.items() if not wide]
        except NotCertifiedError as error:
            missing[str(t)] = str(error)
    return lines, missing


def row(
    t: Fraction | None, quantity: str, ball: Ball
) -> tuple[str | None, str, str, str, str | None]:
    """One row of the store: time, quantity, midpoint, radius, exact double."""
    mid, radius = ball.decimals(PLACES)
    if radius == "0" and "." in mid:
        mid = mid.rstrip("0").rstrip(".")
    low, high = (float(Fraction(mid) + sign * Fraction(radius)) for sign in (-1, 1))
    return None if t is None else str(t), quantity, mid, radius, low.hex() if low == high else None


def versions() -> dict[str, str]:
    """The packages that a proof rests on."""
    return {"refdem": __version__, "python-flint": version("python-flint")}


def block(
    label: str, parameters: Mapping[str, str], truth: Truth, values: Rows, **more: Any
) -> list[str]:
    """The lines of one set; `more` has source and job (digests), witnessed and not_certified."""
    proved = {
        "method": truth.method,
        "witness": truth.witness,
        "digits": DIGITS,
        "versions": versions(),
    }
    about = {
        "set": label,
        "parameters": dict(parameters),
        **proved,
        **more,
        "values": len(values),
        "sha256": "",
    }
    lines = [compact(about), *(compact(list(item)) for item in values)]
    return sealed(lines)


def sealed(lines: Sequence[str]) -> list[str]:
    """The same lines with their sha256 in the first one, whose last member it is."""
    first, *rest = lines
    before, mark, _ = first.rpartition('"sha256":"')
    open_first = f'{before}{mark}"}}\n'
    return [f'{before}{mark}{sha256_of([open_first, *rest])}"}}\n', *rest]


def file_text(case: str, blocks: Sequence[Sequence[str]]) -> str:
    """The text of a case's file, a header and one line per value."""
    head = {"format": FORMAT, "case": case, "sets": len(blocks), "columns": COLUMNS, "sha256": ""}
    return "".join(sealed([compact(head), *(line for lines in blocks for line in lines)]))


def blocks_in(text: str) -> list[list[str]]:
    """The lines of each set of a file that holds, as they stand."""
    lines = text.splitlines(keepends=True)
    at = 1
    blocks = []
    while at < len(lines):
        count = json.loads(lines[at])["values"]
        blocks.append(lines[at : at + 1 + count])
        at += 1 + count
    return blocks


def sums(files: Mapping[str, str]) -> str:
    """What `sha256sum -c` checks the files with."""
    return "".join(
        f"{hashlib.sha256(text.encode()).hexdigest()}  {name}\n"
        for name, text in sorted(files.items())
    )


def compact(value: Any) -> str:
    """A value as JSON on one line, without spaces."""
    return json.dumps(value, ensure_ascii=False, separators=(",", ":")) + "\n"
