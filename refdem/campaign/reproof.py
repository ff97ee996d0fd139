"""Checking the certified store: every hash, and a stratified sample proved and witnessed again,
compared by overlap, never by bytes.
"""

import hashlib
import json
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from refdem.campaign.certification import proved_set
from refdem.campaign.schedule import Job, Progress, Schedule, counted
from refdem.core import discovery
from refdem.core.run import Failure
from refdem.errors import StoreError
from refdem.truth.certified.reader import CertifiedSet, Value, load, problems_of_list
from refdem.truth.certified.samples import kept

EARLIEST = 2
"""Times of a set that are proved again: validated integration costs as much as the time it covers.
"""
LONGEST = 100.0
"""Seconds for one set of the sample."""


def damaged(folder: Path) -> list[str]:
    """What does not hold in the files themselves: hashes, decimals, doubles, and the list of
    files.
    """
    problems = []
    try:
        load(folder=folder / "certified")
        for path in sorted((folder / "samples").glob("*.jsonl")):
            kept(path.parent, path.stem)
    except (ValueError, StoreError) as error:
        problems.append(str(error))
    for home in (folder / "certified", folder / "samples"):
        if home.is_dir() and any(home.iterdir()):
            if home.name == "certified":
                inside = None
            else:
                inside = problem_of_samples
            problems += [
                problem for problem in listing_problems(home, inside) if problem not in problems
            ]
    return problems


def listing_problems(home: Path, inside: Callable[[Path], str] | None) -> list[str]:
    """What does not agree between sha256sums.txt and the files of a folder."""
    try:
        return list(problems_of_list(home, inside=inside))
    except ValueError as error:
        return [str(error)]


def problem_of_samples(path: Path) -> str:
    """What is wrong with a file of samples, or nothing."""
    try:
        kept(path.parent, path.stem)
    except StoreError as error:
        return str(error)
    return ""


def sample(sets: Iterable[CertifiedSet], *, each: int, seed: str) -> list[CertifiedSet]:
    """`each` sets of every case and method, chosen by the seed."""
    strata: dict[tuple[str, str], list[CertifiedSet]] = {}
    for one in sets:
        strata.setdefault((one.case, one.method), []).append(one)
    chosen: list[CertifiedSet] = []
    for group in strata.values():
        chosen += sorted(group, key=lambda one: _lot(one, seed))[:each]
    return chosen


def _lot(one: CertifiedSet, seed: str) -> str:
    """The place of a set in the draw, which the seed and its label decide."""
    return hashlib.sha256(f"{seed}\0{one.label}".encode()).hexdigest()


def contradictions(sets: list[CertifiedSet], *, jobs: int, progress: Progress) -> Iterator[str]:
    """What a new proof, or the witness, says otherwise than the store; each set at its earliest
    times.
    """
    known = {one.label: one for one in sets}
    work = []
    for label, one in known.items():
        times = sorted({value.t for value in one.values if value.t is not None})
        asked = (one.case, given_of(one), tuple(map(str, times[:EARLIEST])))
        work.append(Job(label, proved_set, asked, computes=True))
    with Schedule(jobs, LONGEST) as schedule:
        results = schedule.results(work)
        for job, result in counted(results, "prove again", len(work), progress):
            yield from _differences(known[job.key], result)


def given_of(one: CertifiedSet) -> dict[str, str]:
    """The parameters that differ from the defaults: a member of a family refuses those that are not
    its own, even at their defaults.
    """
    declared = discovery.case(one.case).at().p.declared
    found = {}
    for name, text in one.parameters.items():
        parameter = declared.get(name)
        if parameter is None:
            continue
        if parameter.parsed(text) != parameter.parsed(parameter.default):
            found[name] = text
    return found


def _differences(one: CertifiedSet, result: bytes | Failure) -> Iterator[str]:
    if isinstance(result, Failure):
        found = {"lines": [], "reason": result.sentence}
    else:
        found = json.loads(result)
    if found["reason"]:
        yield f"{one.label}: {found['reason']}"
        return
    again = [json.loads(line) for line in found["lines"][1:]]
    if not again:
        yield f"{one.label}: nothing was proved again"
    for t, quantity, mid, radius, _ in again:
        kept = one.value(quantity, t)
        if not kept.overlaps(Value(kept.t, quantity, mid, radius, None)):
            yield (
                f"{one.label}: {quantity} at {t} is {kept.mid} +- {kept.radius} in the store, {mid}"
                f" +- {radius} proved again"
            )


def catalogue() -> list[str]:
    """Ids of the cases that have a truth of their own."""
    from refdem.core.selection import Selection

    return [
        name for name in discovery.names("cases") if not isinstance(discovery.case(name), Selection)
    ]
