"""Rebuilding the certified store: what is wanted, what still holds, what is proved anew in worker
processes.
"""

import hashlib
import json
import tomllib
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

import msgspec

from refdem.campaign import plan
from refdem.campaign.kept_truth import samples_key
from refdem.campaign.schedule import Job, Progress, Schedule, counted
from refdem.campaign.specification import named
from refdem.core import discovery
from refdem.core.case import Instance
from refdem.core.problem import Motion
from refdem.core.run import Failure
from refdem.core.selection import Selection
from refdem.core.store import Store
from refdem.errors import UNREADABLE, NotCertifiedError, StoreError, UsageError
from refdem.truth.certified import samples
from refdem.truth.certified.reader import LIST, sets_of, text_of
from refdem.truth.certified.sources import ROOT, closure, digest_of, digest_of_files
from refdem.truth.certified.writing import blocks_in

LONGEST = 1800.0
"""CPU seconds that one set may take to be proved."""
SAMPLED = "samples-of"
"""In sets.toml: the cases whose sampled truths are kept for judging, because they are dear to
prove. The others are proved each time.
"""
WRITERS = tuple(
    ROOT / "truth" / "certified" / f"{name}.py" for name in ("reader", "writing", "samples")
)
EVERY = "every-case"
"""In sets.toml: true if a case that has no sets there is proved at its defaults."""


@dataclass(frozen=True)
class Wanted:
    """One set to be proved: a case, its parameters, and the times."""

    instance: Instance
    times: tuple[Fraction, ...]

    @property
    def job(self) -> tuple[str, dict[str, str], tuple[str, ...]]:
        """The case, its parameters and its times, as a worker needs them."""
        return self.instance.case.id, self.instance.p.given, tuple(str(t) for t in self.times)


def wanted_sets(folder: Path, cases: Iterable[str] = ()) -> list[Wanted]:
    """The sets that sets.toml asks for, of these cases or of all; raises UsageError."""
    path = folder / "sets.toml"
    document = document_of(path)
    document.pop(SAMPLED, None)
    if document.pop(EVERY, False):
        document |= default_sets(set(document))
    only = set(cases)
    found = []
    for unknown in only - set(document):
        raise UsageError(f"{path} has no sets of case {unknown!r}; it has {', '.join(document)}")
    for case, groups in document.items():
        if only and case not in only:
            continue
        for group in groups:
            times = tuple(
                Fraction(text.strip()) for text in group["times"].split(",") if text.strip()
            )
            found += [Wanted(discovery.case(case).at(**given), times) for given in group["sets"]]
    _refuse_twins(found, path)
    return found


def default_sets(named: set[str]) -> dict[str, list[dict[str, Any]]]:
    """One set of each case in refdem/cases that is not named, in the form of sets.toml: a motion
    after one sample, in the middle and at its end.
    """
    found = {}
    for name in discovery.own_names("cases"):
        case = discovery.case(name)
        if name in named or isinstance(case, Selection):
            continue
        instance = case.at()
        times = ""
        if isinstance(instance.problem, Motion):
            count = len(instance.times)
            chosen = [instance.times[number] for number in (1, count // 2, count - 1)]
            times = ", ".join(str(Fraction(float(t))) for t in chosen)
        found[name] = [{"times": times, "sets": [{}]}]
    return found


def document_of(path: Path) -> dict[str, Any]:
    """What sets.toml says; raises UsageError."""
    try:
        return tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, *UNREADABLE) as error:
        raise UsageError(f"{path}: {error}") from None


def _refuse_twins(found: list[Wanted], path: Path) -> None:
    labels = [one.instance.label for one in found]
    for label in labels:
        if labels.count(label) > 1:
            raise UsageError(f"{path}: {label} is there twice; put its times together")


def judged_instances(folder: Path, cases: Iterable[str] = ()) -> list[Instance]:
    """The instances of the campaigns main and gate whose sampled truth is kept: of the cases that
    sets.toml names so (and of these cases only).
    """
    only = set(cases)
    kept = document_of(folder / "sets.toml").get(SAMPLED, [])
    wanted = {case for case in kept if not only or case in only}
    asked = [*plan.instances(named("main")), *plan.instances(named("gate"))]
    every = {instance.label: instance for instance, _ in asked}
    return [
        one for one in every.values() if one.case.id in wanted and isinstance(one.problem, Motion)
    ]


def proved_set(case: str, given: dict[str, str], times: tuple[str, ...], job: str = "") -> bytes:
    """The lines of one set, proved and witnessed; no lines and a reason if nothing can be certified
    or the witness denies it. JSON.
    """
    from refdem.truth.certified.writing import DIGITS, block, rows
    from refdem.truth.witnesses.testimony import testimony

    instance = discovery.case(case).at(**given)
    try:
        truth = instance.truth().refined(DIGITS)
        found, missing = rows(truth, [Fraction(text) for text in times])
    except NotCertifiedError as error:
        return _result([], str(error))
    if not found:
        return _result([], f"nothing is certified: {missing}")
    said = testimony(case, instance.case.meant(instance.p), found)
    if said is not None and said["denied"]:
        return _result(
            [], f"the witness ({said['by']}) does not confirm {', '.join(said['denied'][:5])}"
        )
    if said:
        witnessed = {name: said[name] for name in ("by", "values", "digits")}
    else:
        witnessed = None
    more = {"source": digest_of(case), "job": job, "witnessed": witnessed, "not_certified": missing}
    return _result(block(instance.label, instance.p.texts(), truth, found, **more), "")


def _result(lines: list[str], reason: str) -> bytes:
    return json.dumps({"lines": lines, "reason": reason}).encode()


def proved_samples(case: str, given: dict[str, str], job: str = "") -> bytes:
    """The line of samples/ of one instance, also of one that is certified at no time, which says
    why.
    """
    from refdem.campaign.worker import sampled_truth
    from refdem.core.truth import SampledTruth

    instance = discovery.case(case).at(**given)
    truth = msgspec.msgpack.decode(sampled_truth(case, given), type=SampledTruth)
    return samples.line_of(instance.label, samples_key(instance), digest_of(case), truth, job)


@dataclass
class Certification:
    """One rebuilding of the certified store: what is stale is proved again.

    A line that is there is kept while what it was asked, and all code that had a part in it, are
    the same (its `job`); then the store of finished work is asked, so that a killed run resumes;
    what is left is proved. `anew` proves everything.
    """

    folder: Path
    store: Store
    jobs: int = 2
    anew: bool = False
    progress: Progress = lambda stage, done, total: None
    problems: list[str] = field(default_factory=list)
    made: int = 0

    def run(self, cases: Iterable[str] = ()) -> None:
        """Proves what is missing or stale and writes the files of these cases, or of all."""
        wanted = wanted_sets(self.folder, cases)
        judged = judged_instances(self.folder, cases)
        jobs = [job_of("set", one.instance.label, proved_set, one.job) for one in wanted]
        jobs += [
            job_of("samples", one.label, proved_samples, (one.case.id, one.p.given))
            for one in judged
        ]
        results = self._results(jobs)
        blocks: dict[str, list[list[str]]] = {one.instance.case.id: [] for one in wanted}
        lines: dict[str, list[bytes]] = {one.case.id: [] for one in judged}
        for one in wanted:
            found = json.loads(
                results.get(("set", one.instance.label), b'{"lines": [], "reason": ""}')
            )
            if found["reason"]:
                self.problems.append(f"{one.instance.label}: {found['reason']}")
            if found["lines"]:
                blocks[one.instance.case.id].append(found["lines"])
        for instance in judged:
            lines[instance.case.id].append(results.get(("samples", instance.label), b""))
        self._write(blocks, lines, whole=not cases)

    def _results(self, jobs: list[Job]) -> dict[tuple[str, str], bytes]:
        """The result of every job that ended well: kept ones from the store of finished work, so
        that a killed run resumes.
        """
        keys = {job.key: job.arguments[-1] for job in jobs}
        if self.anew:
            kept: dict[tuple[str, str], bytes] = {}
        else:
            kept = self._kept(keys)
        missing = [job for job in jobs if job.key not in kept]
        with Schedule(self.jobs, LONGEST) as schedule:
            results = schedule.results(missing)
            for job, result in counted(results, "certify", len(missing), self.progress):
                if isinstance(result, Failure):
                    self.problems.append(f"{job.key[1]}: {result.sentence}")
                else:
                    self.store.put("certified", keys[job.key], result)
                    kept[job.key] = result
                    self.made += 1
        return kept

    def _kept(self, keys: Mapping[tuple[str, str], str]) -> dict[tuple[str, str], bytes]:
        """What is not to be proved again: from the files of the folder first, then from the store
        of finished work.
        """
        there = committed(self.folder)
        found = {}
        for key, job in keys.items():
            data = there.get((*key, job)) or self.store.get("certified", job)
            if data is not None:
                found[key] = data
        return found

    def _write(
        self,
        blocks: Mapping[str, list[list[str]]],
        lines: Mapping[str, list[bytes]],
        *,
        whole: bool,
    ) -> None:
        from refdem.truth.certified.writing import file_text, sums

        certified = self.folder / "certified"
        kept = self.folder / "samples"
        for home in (certified, kept):
            home.mkdir(parents=True, exist_ok=True)
        for case, found in blocks.items():
            (certified / f"{case}.jsonl").write_text(file_text(case, found), encoding="utf-8")
        for case, entries in lines.items():
            path = kept / f"{case}.jsonl"
            if any(entries):
                path.write_bytes(b"".join(entries))
            else:
                path.unlink(missing_ok=True)
        if whole:
            _delete_others(certified, blocks)
            _delete_others(kept, lines)
        for home in (certified, kept):
            texts = {path.name: path.read_text(encoding="utf-8") for path in home.glob("*.jsonl")}
            (home / LIST).write_text(sums(texts))


def _delete_others(folder: Path, cases: Iterable[str]) -> None:
    """Deletes the files of all but these cases from a folder of the store."""
    names = set(cases)
    for path in list(folder.glob("*.jsonl")):
        if path.stem not in names:
            path.unlink()


def job_of(
    kind: str, label: str, function: Callable[..., bytes], arguments: tuple[Any, ...]
) -> Job:
    """The work for one line, or lines; its last argument is the digest that these carry."""
    return Job(
        (kind, label), function, (*arguments, job_digest(kind, label, arguments)), computes=True
    )


def job_digest(kind: str, label: str, arguments: tuple[Any, ...]) -> str:
    """sha256 of a job and of the code behind it: that of the truth, of what writes the lines, and
    of the witness of a set.
    """
    from refdem.truth.witnesses.testimony import witness_files

    case = arguments[0]
    if kind == "set":
        witness = closure(witness_files(case))
    else:
        witness = set()
    asked = [kind, label, arguments, digest_of(case), digest_of_files({*WRITERS, *witness})]
    return hashlib.sha256(msgspec.json.encode(asked)).hexdigest()


def committed(folder: Path) -> dict[tuple[str, str, str], bytes]:
    """What the files of the folder hold, by kind, label and digest of the job; a damaged file holds
    nothing, and is proved again.
    """
    found: dict[tuple[str, str, str], bytes] = {}
    for path in sorted((folder / "certified").glob("*.jsonl")):
        with suppress(ValueError):
            text = text_of(path)
            labels = [(one.label, one.job) for one in sets_of(text, path.name)]
            for (label, job), lines in zip(labels, blocks_in(text), strict=True):
                found["set", label, job] = _result(lines, "")
    for path in sorted((folder / "samples").glob("*.jsonl")):
        with suppress(StoreError):
            entries = samples.kept(path.parent, path.stem)
            for one, line in zip(entries, path.read_bytes().splitlines(keepends=True), strict=True):
                found["samples", one.label, one.job] = line
    return found


def stale(folder: Path) -> list[str]:
    """Labels of sets and samples that were proved with other code than there is now, are missing,
    or that nobody asks for any more.
    """
    from refdem.truth.certified.reader import load

    there = {one.label: one for one in load(folder=folder / "certified")}
    wanted = {one.instance.label: one for one in wanted_sets(folder)}
    jobs = {label: job_digest("set", label, one.job) for label, one in wanted.items()}
    found = [label for label, one in there.items() if label in jobs and one.job != jobs[label]]
    found += sorted(set(wanted) ^ set(there))
    asked = {
        one.label: job_digest("samples", one.label, (one.case.id, one.p.given))
        for one in judged_instances(folder)
    }
    kept: dict[str, str] = {}
    for path in sorted((folder / "samples").glob("*.jsonl")):
        kept |= {one.label: one.job for one in samples.kept(path.parent, path.stem)}
    found += [
        f"samples of {label}"
        for label, job in kept.items()
        if label in asked and job != asked[label]
    ]
    return found + [f"samples of {label}" for label in sorted(set(asked) ^ set(kept))]
