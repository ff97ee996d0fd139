"""Reads and checks certified values. The standard library alone, so that this one file can be taken
elsewhere: python reader.py FOLDER.

A file is JSON Lines. The first line has the format, the case, the number of sets and the columns.
Each set is a line with its exact parameters and how it was proved, and then its values, one a line:
[t, quantity, mid, radius, binary64]. t [s] is an exact number as text, null for what does not
depend on time. The exact value lies in [mid - radius, mid + radius]; binary64 (C's %a) is there
where both ends round to that double.

sha256 is the last member of its line. That of a set is of its lines, each with its newline, with
the text of sha256 itself left empty; that of the first line is of the whole file, with its own text
left empty. sha256sums.txt, beside the files, begins with their number, as a comment, and lists each
of them and no other.
"""

import hashlib
import json
import re
import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

FORMAT = 2
"""Version of the format of files of certified values."""
COLUMNS = ("t", "quantity", "mid", "radius", "binary64")
LARGEST_RADIUS = Fraction(1, 10**30)
LIST = "sha256sums.txt"
TIME = re.compile(r"[0-9]{1,80}(/[1-9][0-9]{0,80})?")
DECIMAL = re.compile(r"-?[0-9]{1,300}(\.[0-9]{1,400})?")
RADIUS = re.compile(r"0|[0-9]\.[0-9]{2}e-?[0-9]{1,3}")
DOUBLE = re.compile(r"-?0x[01]\.[0-9a-f]{1,13}p[+-][0-9]{1,4}")
SEALED = re.compile(r'(\{.*"sha256":")([0-9a-f]{64})("\}\n)')
COUNTED = re.compile(r"# ([0-9]{1,6}) files")
LISTED = re.compile(r"([0-9a-f]{64})  ([A-Za-z0-9_-]+\.jsonl)")
TEXT = {
    "set": str,
    "parameters": dict,
    "method": str,
    "witness": str,
    "digits": int,
    "versions": dict,
    "source": str,
    "job": str,
}
MEMBERS: dict[str, Any] = {
    **TEXT,
    "witnessed": (dict, type(None)),
    "not_certified": dict,
    "values": int,
    "sha256": str,
}
HEAD: dict[str, Any] = {"format": int, "case": str, "sets": int, "columns": list, "sha256": str}


@dataclass(frozen=True)
class Value:
    """One value: decimal midpoint and radius as they stand, the time [s] (None: it does not depend
    on time), the double if it is sure.
    """

    t: Fraction | None
    quantity: str
    mid: str
    radius: str
    binary64: float | None

    @property
    def interval(self) -> tuple[Fraction, Fraction]:
        """The exact ends of the ball, midpoint minus and plus radius."""
        mid = Fraction(self.mid)
        radius = Fraction(self.radius)
        return mid - radius, mid + radius

    def overlaps(self, other: "Value") -> bool:
        """Whether the two can be the same number: how stores are compared."""
        (low, high) = self.interval
        (other_low, other_high) = other.interval
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

    `source` is the digest of the code that proved them, `job` that of the request and of all code
    on which the lines depend, `versions` that of the packages; `witnessed` has the witness, the
    number of values that it confirmed and to how many digits, None without a witness;
    `not_certified` has the times at which nothing could be proved, and why.
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
    job: str
    versions: dict[str, str]
    values: tuple[Value, ...]

    def value(self, quantity: str, t: Fraction | str | None = None) -> Value:
        """One value; raises KeyError that lists the existing ones."""
        if t is None:
            when = None
        else:
            when = Fraction(t)
        for value in self.values:
            if value.quantity == quantity and value.t == when:
                return value
        raise KeyError(
            f"{self.label} has no {quantity} at {t}; it has"
            f" {', '.join(sorted({v.quantity for v in self.values}))}"
        )


def default_folder() -> Path:
    """The folder that comes with refdem: inside the installed package, or beside the source."""
    package = Path(__file__).resolve().parents[2]
    inside = package / "validation" / "truth" / "certified"
    if inside.is_dir():
        return inside
    return package.parent / "validation" / "truth" / "certified"


def load(case: str = "", *, folder: Path | str | None = None) -> list[CertifiedSet]:
    """The sets of one case, or of all; raises ValueError for the first thing that does not hold."""
    if folder is not None:
        home = Path(folder)
    else:
        home = default_folder()
    if case and not (home / f"{case}.jsonl").is_file():
        there = ", ".join(path.stem for path in sorted(home.glob("*.jsonl"))) or "none"
        raise ValueError(f"no certified values at {home / case}.jsonl; there are {there}")
    for problem in problems_of_list(home, f"{case}.jsonl" if case else ""):
        raise ValueError(problem)
    if case:
        paths = [home / f"{case}.jsonl"]
    else:
        paths = sorted(home.glob("*.jsonl"))
    return [one for path in paths for one in sets_of(text_of(path), path.name)]


def text_of(path: Path) -> str:
    """The text of a file; raises ValueError with name and line where it is not UTF-8."""
    content = path.read_bytes()
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise ValueError(f"{path.name}, line {line}: not UTF-8") from None


def problems_of_list(
    home: Path, only: str = "", inside: Callable[[Path], str] | None = None
) -> Iterator[str]:
    """What does not agree between the list of files and the files, both ways: of all, or of one
    file.

    `inside` returns the error within a file, or an empty text.
    """
    problem = inside or inner_problem
    try:
        count, listed = listed_in(home)
    except ValueError as error:
        yield str(error)
        return
    if len(listed) != count:
        yield f"{LIST}: {len(listed)} files are listed, and its first line counts {count}"
    entries = list(home.glob(only or "*.jsonl"))
    there = {
        entry.name: hashlib.sha256(entry.read_bytes()).hexdigest()
        for entry in entries
        if entry.is_file()
    }
    no_files = {entry.name for entry in entries} - there.keys()
    for name in sorted({only} if only else {*listed, *there, *no_files}):
        if name in no_files:
            yield f"{name}: not a file; expected a file of certified values"
        elif name not in there:
            yield f"{name}: missing, though {LIST} has it"
        elif name not in listed:
            yield f"{name}: there, though {LIST} does not have it"
        elif listed[name] != there[name]:
            # A fault within the file is reported by its own message, if there is one.
            yield problem(home / name) or f"{name}: not as {LIST} has it"


def listed_in(home: Path) -> tuple[int, dict[str, str]]:
    """The number of files that the list of a folder counts, and their digests by name; raises
    ValueError for what is not such a list.
    """
    path = home / LIST
    if not path.is_file():
        raise ValueError(f"{LIST}: missing in {home}")
    head, *lines = text_of(path).split("\n")[:-1] or [""]
    count = COUNTED.fullmatch(head)
    if count is None:
        raise ValueError(
            f"{LIST}, line 1: got {head[:40]!r}, expected the number of files, as `# 46 files`"
        )
    listed: dict[str, str] = {}
    for number, line in enumerate(lines, 2):
        entry = LISTED.fullmatch(line)
        if entry is None or entry[2] in listed:
            raise ValueError(
                f"{LIST}, line {number}: not a digest and the name of a file, or one that was there"
                " before"
            )
        listed[entry[2]] = entry[1]
    return int(count[1]), listed


def inner_problem(path: Path) -> str:
    """What is wrong with a file in itself, or nothing."""
    try:
        for _ in sets_of(text_of(path), path.name):
            pass
    except ValueError as error:
        return str(error)
    return ""


def sets_of(text: str, name: str) -> Iterator[CertifiedSet]:
    """The sets of one file; raises ValueError with name, line and what is wrong."""
    lines = lines_of(text, name)
    head = member_of(lines[0], HEAD, f"{name}, line 1")
    if head["format"] != FORMAT or tuple(head["columns"]) != COLUMNS:
        raise ValueError(f"{name}, line 1: not a file of certified values of format {FORMAT}")
    at = 1
    sets = []
    while at < len(lines):
        where = f"{name}, line {at + 1}"
        about = member_of(lines[at], MEMBERS, where)
        block = lines[at : at + 1 + about["values"]]
        if about["values"] < 1 or len(block) != 1 + about["values"]:
            raise ValueError(
                f"{where}: {about['set']} says {about['values']} values; {len(block) - 1} lines"
                " follow"
            )
        rows = [row_of(line, f"{name}, line {at + 2 + k}") for k, line in enumerate(block[1:])]
        if sha256_of(block) != about["sha256"]:
            raise ValueError(
                f"{where}: the sha256 of {about['set']} is not that of its lines; take the file"
                " anew"
            )
        sets.append(_certified_set(head["case"], about, rows, where))
        at += len(block)
    if len(sets) != head["sets"]:
        raise ValueError(f"{name}, line 1: {len(sets)} sets; its first line says {head['sets']}")
    if sha256_of(lines) != head["sha256"]:
        raise ValueError(
            f"{name}, line 1: the sha256 of the file is not that of its lines; take the file anew"
        )
    if head["case"] != name.removesuffix(".jsonl"):
        raise ValueError(f"{name}, line 1: it has the values of {head['case']}")
    yield from sets


def lines_of(text: str, name: str) -> list[str]:
    """The lines with their newlines; raises ValueError if there are none, or the last one has no
    end.
    """
    lines = [line + "\n" for line in text.split("\n")]
    if lines.pop() != "\n" or not lines:
        raise ValueError(f"{name}, line {len(lines) + 1}: the file ends within a line")
    return lines


def json_of(line: str, where: str) -> Any:
    """The value of a line; raises ValueError that says where."""
    try:
        return json.loads(line)
    except (ValueError, RecursionError) as error:
        raise ValueError(f"{where}: not JSON ({error})") from None


def member_of(line: str, members: dict[str, Any], where: str) -> dict[str, Any]:
    """The object of a line with exactly these members, sha256 the last; raises ValueError with the
    place of an error.
    """
    member = json_of(line, where)
    if not isinstance(member, dict) or SEALED.fullmatch(line) is None:
        raise ValueError(f"{where}: expected an object that ends with its sha256")
    if lacking := [name for name in members if name not in member]:
        raise ValueError(f"{where}: says nothing of {', '.join(lacking)}")
    if more := [name for name in member if name not in members]:
        raise ValueError(f"{where}: {', '.join(more)} is not known")
    for name, kind in members.items():
        if not isinstance(member[name], kind) or isinstance(member[name], bool):
            raise ValueError(f"{where}: {name} is {member[name]!r}")
    return member


def row_of(line: str, where: str) -> Value:
    """The value of a line; raises ValueError that says where."""
    row = json_of(line, where)
    if not isinstance(row, list) or len(row) != len(COLUMNS):
        raise ValueError(f"{where}: expected [t, quantity, mid, radius, binary64]")
    t, quantity, mid, radius, binary64 = row
    forms = (
        ("t", t, TIME, True),
        ("mid", mid, DECIMAL, False),
        ("radius", radius, RADIUS, False),
        ("binary64", binary64, DOUBLE, True),
    )
    for name, text, form, may_lack in forms:
        is_lacking = may_lack and text is None
        if not is_lacking and not (isinstance(text, str) and form.fullmatch(text)):
            raise ValueError(f"{where}: {name} is {text!r}")
    if not isinstance(quantity, str):
        raise ValueError(f"{where}: quantity is {quantity!r}")
    if t is None:
        when = None
    else:
        when = Fraction(t)
    if binary64 is None:
        sure = None
    else:
        sure = double_of(binary64, where)
    value = Value(when, quantity, mid, radius, sure)
    if problem := value.problem():
        raise ValueError(f"{where}: {quantity} at {t}: {problem}")
    return value


def double_of(text: str, where: str) -> float:
    """The double of C's %a; raises ValueError where it is none."""
    try:
        return float.fromhex(text)
    except OverflowError:
        raise ValueError(f"{where}: binary64 {text} is beyond all doubles") from None


def sha256_of(block: Iterable[str]) -> str:
    """The digest of lines, the text of the sha256 that ends the first of them left empty."""
    first, *rest = block
    return hashlib.sha256("".join([SEALED.sub(r"\1\3", first), *rest]).encode()).hexdigest()


def _certified_set(
    case: str, about: dict[str, Any], values: list[Value], where: str
) -> CertifiedSet:
    for name in ("parameters", "not_certified", "versions"):
        if not all(isinstance(text, str) for text in about[name].values()):
            raise ValueError(f"{where}: {name} has something that is not a text")
    if len({(value.t, value.quantity) for value in values}) < len(values):
        raise ValueError(f"{where}: {about['set']} has a value twice")
    kept = {name: about[name] for name in MEMBERS if name not in ("set", "values", "sha256")}
    return CertifiedSet(label=about["set"], case=case, values=tuple(values), **kept)


def main(arguments: list[str]) -> int:
    """Checks every file of a folder and prints how much it contains; returns 1 if there is an
    error.
    """
    try:
        loaded = load(folder=arguments[0] if arguments else None)
    except (ValueError, OSError) as error:
        print(f"PROBLEM: {error}")
        return 1
    print(
        f"{len(loaded)} sets of {len({s.case for s in loaded})} cases,"
        f" {sum(len(s.values) for s in loaded)} values: all hold"
    )
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
