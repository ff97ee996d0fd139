"""What the committed pages were made from: a digest a case, so that a page that is out of date is
seen without making it.
"""

import hashlib
from pathlib import Path

from refdem.core import discovery
from refdem.core.selection import Selection
from refdem.truth.certified.sources import ROOT, closure, digest_of, digest_of_files
from refdem.truth.witnesses.testimony import witness_files, witnesses

NAME = "inputs.txt"
"""Beside the pages: a line a case, `digest  case`."""
WRITERS = (
    "manual/pages.py",
    "manual/slips.py",
    "report/manual.py",
    "core/manual.py",
    "campaign/certified_list.py",
)


def digests(folder: Path) -> dict[str, str]:
    """sha256 by case of the code behind its truth and its witness, its certified values, what
    checks say of themselves, and the writers.
    """
    said = [
        (check.name, check.title, check.kills)
        for check in map(discovery.check, discovery.names("checks"))
    ]
    common = f"{digest_of_files({ROOT / name for name in WRITERS})}{said}"
    cases = [
        name for name in discovery.names("cases") if not isinstance(discovery.case(name), Selection)
    ]
    return {
        name: hashlib.sha256(f"{common}{_own(name, folder)}".encode()).hexdigest() for name in cases
    }


def _own(case: str, folder: Path) -> str:
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


def text_of(found: dict[str, str]) -> str:
    """The file."""
    return "".join(f"{digest}  {case}\n" for case, digest in sorted(found.items()))


def out_of_date(pages: Path, folder: Path) -> list[str]:
    """Cases whose page was made from something else than there is now, is missing, or is of no case
    any more.
    """
    path = pages / NAME
    if path.is_file():
        lines = [line.split("  ") for line in path.read_text().splitlines()]
    else:
        lines = []
    made = {case: digest for digest, case in lines}
    now = digests(folder)
    there = {page.stem for page in pages.glob("*.md")} - {"index"}
    return sorted(
        {
            case
            for case in {*made, *now, *there}
            if case not in there or case not in now or made.get(case) != now[case]
        }
    )
