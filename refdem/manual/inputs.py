"""What the committed pages were made from: a digest a case, so that a page that is out of date is
seen without making it.
"""

import hashlib
from pathlib import Path

from refdem.core import discovery
from refdem.core.selection import Selection
from refdem.manual.pages import checks
from refdem.truth.certified.sources import ROOT, closure, digest_of, digest_of_files
from refdem.truth.witnesses.cross_check import witness_files, witnesses

NAME = "inputs.txt"
"""Beside the pages: a line a case, `digest  case`."""
WRITERS = (
    "core/moved.py",
    "planning/moved.py",
    "report/moved.py",
    "manual/pages.py",
    "manual/slips.py",
    "report/manual.py",
    "core/manual.py",
    "certification/listing.py",
)


def digests(folder: Path) -> dict[str, str]:
    """sha256 by case of the code behind its truth and its witness, its certified values, what the
    checks that apply to it say of themselves, and the writers.
    """
    writers = digest_of_files({ROOT / name for name in WRITERS})
    by_case = {}
    for name in discovery.names("cases"):
        case = discovery.case(name)
        if not isinstance(case, Selection):
            described = list(checks(case.at()))
            sources = f"{writers}{described}{_own(name, folder)}"
            by_case[name] = hashlib.sha256(sources.encode()).hexdigest()
    return by_case


def _own(case: str, folder: Path) -> str:
    """Digests of a case's truth, of its witness, and of its certified values, one after the
    other.
    """
    values = folder / "certified" / f"{case}.jsonl"
    if values.is_file():
        kept = hashlib.sha256(values.read_bytes()).hexdigest()
    else:
        kept = ""
    if case in witnesses():
        witness = digest_of_files(closure(witness_files(case)))
    else:
        witness = ""
    return f"{digest_of(case)}{witness}{kept}"


def text_of(by_case: dict[str, str]) -> str:
    """The text of the file: a line a case, sorted by name."""
    return "".join(f"{digest}  {case}\n" for case, digest in sorted(by_case.items()))


def out_of_date(pages: Path, folder: Path) -> list[str]:
    """Cases whose page was made from something else than there is now, is missing, or is of no case
    any more.
    """
    path = pages / NAME
    recorded = {}
    if path.is_file():
        for line in path.read_text().splitlines():
            digest, case = line.split("  ")
            recorded[case] = digest
    now = digests(folder)
    there = {page.stem for page in pages.glob("*.md")} - {"index", "chapter"}
    every = sorted({*recorded, *now, *there})
    return [
        case
        for case in every
        if case not in there or case not in now or recorded.get(case) != now[case]
    ]
