"""Reads and checks certified values. The standard library alone, so that this one file can be taken elsewhere: python reader.py FOLDER.

A file is JSON Lines. The first line says format, case, number of sets and columns. Each set is a line with its exact parameters and
how it was proved, and then its values, one a line: [t, quantity, mid, radius, binary64]. t [s] is an exact number as text, null for
what does not depend on time. The exact value lies in [mid - radius, mid + radius]; binary64 (C's %a) is there where both ends round
to that double. sha256 of a set is that of its lines, each with its newline, with the text of sha256 itself left empty.
"""

import hashlib
import json
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

FORMAT = 1
COLUMNS = ("t", "quantity", "mid", "radius", "binary64")
LARGEST_RADIUS = Fraction(1, 10**30)


@dataclass(frozen=True)
class Value:
    """One value: decimal midpoint and radius as they stand, the time [s] (None: it does not depend on time), the double if it is sure."""

    t: Fraction | None
    quantity: str
    mid: str
    radius: str
    binary64: float | None

    @property
    def interval(self) -> tuple[Fraction, Fraction]:
        """The ends, exactly."""
        mid, radius = Fraction(self.mid), Fraction(self.radius)
        return mid - radius, mid + radius

    def overlaps(self, other: "Value") -> bool:
        """Whether the two can be the same number: how stores are compared."""
        (low, high), (other_low, other_high) = self.interval, other.interval
        return low <= other_high and other_low <= high

    def problem(self) -> str:
        """What is wrong with it, or nothing."""
        low, high = self.interval
        if not 0 <= high - low <= 2 * LARGEST_RADIUS:
            return f"radius {self.radius} is not between 0 and {float(LARGEST_RADIUS):g}"
        if self.binary64 is not None and not float(low) == float(high) == self.binary64:
            return f"binary64 {self.binary64.hex()} is not what both ends round to"
        return ""


@dataclass(frozen=True)
class CertifiedSet:
    """A case at one set of exact parameters (as text), its values, and how they were proved.

    `source` is the digest of the code that proved them, `versions` that of the packages; `witnessed` says who confirmed how many of
    the values and to how many digits, None if nobody did; `not_certified` has the times at which nothing could be proved, and why.
    """

    label: str
    case: str
    parameters: dict[str, str]
    method: str
    witness: str
    witnessed: dict[str, Any] | None
    not_certified: dict[str, str]
    digits: int
    source: str
    versions: dict[str, str]
    values: tuple[Value, ...]

    def value(self, quantity: str, t: Fraction | str | None = None) -> Value:
        """One value; raises KeyError that says what there is."""
        when = None if t is None else Fraction(t)
        for value in self.values:
            if value.quantity == quantity and value.t == when:
                return value
        raise KeyError(f"{self.label} has no {quantity} at {t}; it has {', '.join(sorted({v.quantity for v in self.values}))}")


def default_folder() -> Path:
    """The folder that comes with refdem: inside the installed package, or beside the source."""
    package = Path(__file__).resolve().parents[2]
    inside = package / "validation" / "truth" / "certified"
    return inside if inside.is_dir() else package.parent / "validation" / "truth" / "certified"


def load(case: str = "", *, folder: Path | str | None = None) -> list[CertifiedSet]:
    """The sets of one case, or of all; raises ValueError for the first thing that does not hold."""
    home = Path(folder) if folder is not None else default_folder()
    paths = [home / f"{case}.jsonl"] if case else sorted(home.glob("*.jsonl"))
    found = []
    for path in paths:
        if not path.is_file():
            raise ValueError(
                f"no certified values at {path}; there are {', '.join(p.stem for p in sorted(home.glob('*.jsonl'))) or 'none'}"
            )
        found += list(sets_of(path.read_text(encoding="utf-8"), path.name))
    return found


def sets_of(text: str, name: str) -> Iterator[CertifiedSet]:
    """The sets of one file; raises ValueError with name, line and what is wrong."""
    lines = text.splitlines(keepends=True)
    head = json.loads(lines[0]) if lines else {}
    if head.get("format") != FORMAT or tuple(head.get("columns", ())) != COLUMNS:
        raise ValueError(f"{name}: not a file of certified values of format {FORMAT}")
    at, count = 1, 0
    while at < len(lines):
        about = json.loads(lines[at])
        block = lines[at : at + 1 + about["values"]]
        if sha256_of(block) != about["sha256"]:
            raise ValueError(f"{name}, line {at + 1}: the sha256 of {about['set']} is not that of its lines; take the file anew")
        yield _certified_set(head["case"], about, [json.loads(line) for line in block[1:]], f"{name}, line {at + 1}")
        at, count = at + len(block), count + 1
    if count != head["sets"]:
        raise ValueError(f"{name}: {count} sets; its first line says {head['sets']}")


def sha256_of(block: list[str]) -> str:
    """The digest of a set's lines, the text of its own sha256 left empty."""
    before, mark, _ = block[0].rpartition('"sha256":"')
    return hashlib.sha256("".join([before + mark + '"}\n', *block[1:]]).encode()).hexdigest()


def _certified_set(case: str, about: dict[str, Any], rows: list[list[Any]], where: str) -> CertifiedSet:
    values = []
    names = ("parameters", "method", "witness", "witnessed", "not_certified", "digits", "source", "versions")
    if lacking := [name for name in names if name not in about]:
        raise ValueError(f"{where}: {about['set']} says nothing of {', '.join(lacking)}")
    for t, quantity, mid, radius, binary64 in rows:
        sure = None if binary64 is None else float.fromhex(binary64)
        values.append(Value(None if t is None else Fraction(t), quantity, mid, radius, sure))
        if problem := values[-1].problem():
            raise ValueError(f"{where}: {about['set']}, {quantity} at {t}: {problem}")
    return CertifiedSet(label=about["set"], case=case, values=tuple(values), **{name: about[name] for name in names})


def main(arguments: list[str]) -> int:
    """Checks every file of a folder and says how much it holds; 1 if something is wrong."""
    try:
        found = load(folder=arguments[0] if arguments else None)
    except (ValueError, OSError) as error:
        print(f"PROBLEM: {error}")
        return 1
    print(f"{len(found)} sets of {len({s.case for s in found})} cases, {sum(len(s.values) for s in found)} values: all hold")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
