"""Checking the certified store: every hash, and a stratified sample of sets that is proved and
witnessed again. A new ball must overlap the stored one; bytes are not compared.
"""

import hashlib
import json
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

from refdem.certification.proofs import proved_set
from refdem.core import discovery
from refdem.core.run import Failure
from refdem.errors import StoreError
from refdem.execution.schedule import Job, Progress, Schedule, counted
from refdem.truth.certified.reader import CertifiedSet, Value, load, problems_of_list
from refdem.truth.certified.samples import kept

EARLIEST = 2
"""Times of a set that are proved again: validated integration costs as much as the time it covers.
"""
LONGEST = 100.0
"""Seconds for one set of the sample."""


def damaged(folder: Path) -> list[str]:
    """The faults of the files themselves, in words: of hashes, decimals, doubles, and the lists of
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
            listed = listing_problems(home, inside)
            problems += [problem for problem in listed if problem not in problems]
    return problems


def listing_problems(home: Path, inside: Callable[[Path], str] | None) -> list[str]:
    """The disagreements between sha256sums.txt and the files of a folder, in words."""
    try:
        return list(problems_of_list(home, inside=inside))
    except ValueError as error:
        return [str(error)]


def problem_of_samples(path: Path) -> str:
    """The fault of a file of samples in words, or an empty text."""
    try:
        kept(path.parent, path.stem)
    except StoreError as error:
        return str(error)
    return ""


def sample(sets: Iterable[CertifiedSet], *, each: int, seed: str) -> list[CertifiedSet]:
    """At most `each` sets of every case and method, drawn at random by the seed."""
    strata: dict[tuple[str, str], list[CertifiedSet]] = {}
    for certified_set in sets:
        stratum = (certified_set.case, certified_set.method)
        strata.setdefault(stratum, []).append(certified_set)
    chosen: list[CertifiedSet] = []
    for group in strata.values():
        chosen += sorted(group, key=lambda member: _random_rank(member, seed))[:each]
    return chosen


def _random_rank(certified_set: CertifiedSet, seed: str) -> str:
    """A hash of the seed and the label: sorted by it, the sets are in random order."""
    return hashlib.sha256(f"{seed}\0{certified_set.label}".encode()).hexdigest()


def contradictions(sets: list[CertifiedSet], *, jobs: int, progress: Progress) -> Iterator[str]:
    """The contradictions between the store and new proofs, or their witnesses, in words.

    Each set is proved again at its EARLIEST times, in `jobs` processes.
    """
    by_label = {certified_set.label: certified_set for certified_set in sets}
    work = []
    for label, certified_set in by_label.items():
        times = sorted({value.t for value in certified_set.values if value.t is not None})
        earliest = tuple(map(str, times[:EARLIEST]))
        arguments = (certified_set.case, given_of(certified_set), earliest)
        work.append(Job(label, proved_set, arguments, computes=True))
    with Schedule(jobs, LONGEST) as schedule:
        results = schedule.results(work)
        for job, result in counted(results, "prove again", len(work), progress):
            yield from _differences(by_label[job.key], result)


def given_of(certified_set: CertifiedSet) -> dict[str, str]:
    """The parameters of a set that differ from the defaults.

    Only these are given again, because a member of a family refuses the parameters of others even
    at their defaults.
    """
    declared = discovery.case(certified_set.case).at().p.declared
    changed = {}
    for name, text in certified_set.parameters.items():
        parameter = declared.get(name)
        if parameter is None:
            continue
        if parameter.parsed(text) != parameter.parsed(parameter.default):
            changed[name] = text
    return changed


def _differences(certified_set: CertifiedSet, result: bytes | Failure) -> Iterator[str]:
    """The contradictions between a stored set and its new proof, `proved_set` as JSON, in words."""
    label = certified_set.label
    if isinstance(result, Failure):
        proof = {"lines": [], "reason": result.sentence}
    else:
        proof = json.loads(result)
    if proof["reason"]:
        yield f"{label}: {proof['reason']}"
        return
    # The first line describes the set; each other one is a value.
    values = [json.loads(line) for line in proof["lines"][1:]]
    if not values:
        yield f"{label}: nothing was proved again"
    for t, quantity, mid, radius, _ in values:
        stored = certified_set.value(quantity, t)
        if not stored.overlaps(Value(stored.t, quantity, mid, radius, None)):
            yield (
                f"{label}: {quantity} at {t} is {stored.mid} +- {stored.radius} in the store, {mid}"
                f" +- {radius} proved again"
            )


def catalogue() -> list[str]:
    """Ids of the cases that have a truth of their own."""
    from refdem.core.selection import Selection

    return [
        name for name in discovery.names("cases") if not isinstance(discovery.case(name), Selection)
    ]
