"""Rebuilding the certified store: what is wanted, what still holds, what is proved anew in worker processes."""

import hashlib
import json
import time
import tomllib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import Any

import msgspec

from refdem.campaign import plan
from refdem.campaign.kept_truth import samples_key
from refdem.campaign.schedule import Job, Schedule
from refdem.campaign.specification import named
from refdem.core import discovery
from refdem.core.case import Instance
from refdem.core.problem import Motion
from refdem.core.run import Failure
from refdem.core.store import Store
from refdem.errors import NotCertifiedError, UsageError
from refdem.truth.certified import samples
from refdem.truth.certified.sources import ROOT, closure, digest_of, digest_of_files

LONGEST = 1800.0
"""CPU seconds that one set may take to be proved."""
DEAR = 0.1
"""CPU seconds above which sampled truth is kept for judging; below, it is proved each time."""
WRITERS = tuple(ROOT / "truth" / "certified" / f"{name}.py" for name in ("reader", "writing", "samples"))
Progress = Callable[[str, int, int], None]


@dataclass(frozen=True)
class Wanted:
    """One set to be proved: a case, its parameters, and the times."""

    instance: Instance
    times: tuple[Fraction, ...]

    @property
    def job(self) -> tuple[str, dict[str, str], tuple[str, ...]]:
        """What a worker needs."""
        return self.instance.case.id, self.instance.p.given, tuple(str(t) for t in self.times)


def wanted_sets(folder: Path, cases: Iterable[str] = ()) -> list[Wanted]:
    """The sets that sets.toml names, of these cases or of all; raises UsageError."""
    path = folder / "sets.toml"
    try:
        document = tomllib.loads(path.read_text())
    except (OSError, tomllib.TOMLDecodeError) as error:
        raise UsageError(f"{path}: {error}") from None
    only, found = set(cases), []
    for unknown in only - set(document):
        raise UsageError(f"{path} has no sets of case {unknown!r}; it has {', '.join(document)}")
    for case, groups in document.items():
        for group in groups if not only or case in only else ():
            times = tuple(Fraction(text.strip()) for text in group["times"].split(",") if text.strip())
            found += [Wanted(discovery.case(case).at(**given), times) for given in group["sets"]]
    _refuse_twins(found, path)
    return found


def _refuse_twins(found: list[Wanted], path: Path) -> None:
    labels = [one.instance.label for one in found]
    for label in labels:
        if labels.count(label) > 1:
            raise UsageError(f"{path}: {label} is there twice; put its times together")


def judged_instances(cases: Iterable[str] = ()) -> list[Instance]:
    """The instances of the campaign main whose truth is sampled over time."""
    only = set(cases)
    every = {instance.label: instance for instance, _ in plan.instances(named("main"))}
    return [one for one in every.values() if (not only or one.case.id in only) and isinstance(one.problem, Motion)]


def proved_set(case: str, given: dict[str, str], times: tuple[str, ...]) -> bytes:
    """The lines of one set, proved and witnessed; no lines and a reason if nothing can be certified or the witness denies it. JSON."""
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
        return _result([], f"the witness ({said['by']}) does not confirm {', '.join(said['denied'][:5])}")
    witnessed = {name: said[name] for name in ("by", "values", "digits")} if said else None
    more = {"source": digest_of(case), "witnessed": witnessed, "not_certified": missing}
    return _result(block(instance.label, instance.p.texts(), truth, found, **more), "")


def _result(lines: list[str], reason: str) -> bytes:
    return json.dumps({"lines": lines, "reason": reason}).encode()


def proved_samples(case: str, given: dict[str, str]) -> bytes:
    """The line of samples/ of one instance, empty if it is cheap enough to be proved each time."""
    from refdem.campaign.worker import sampled_truth
    from refdem.core.truth import SampledTruth

    instance = discovery.case(case).at(**given)
    start = time.process_time()
    data = sampled_truth(case, given)
    if time.process_time() - start < DEAR:
        return b""
    truth = msgspec.msgpack.decode(data, type=SampledTruth)
    return samples.line_of(instance.label, samples_key(instance), digest_of(case), truth) if truth.until else b""


@dataclass
class Certification:
    """One rebuilding of the store. What was proved before is kept while the code behind it is the same, unless `anew`."""

    folder: Path
    store: Store
    jobs: int = 2
    anew: bool = False
    progress: Progress = lambda stage, done, total: None
    problems: list[str] = field(default_factory=list)
    made: int = 0

    def run(self, cases: Iterable[str] = ()) -> None:
        """Proves what is missing or stale and writes the files of these cases, or of all."""
        wanted, judged = wanted_sets(self.folder, cases), judged_instances(cases)
        jobs = [Job(("set", one.instance.label), proved_set, one.job, computes=True) for one in wanted]
        jobs += [Job(("samples", one.label), proved_samples, (one.case.id, one.p.given), computes=True) for one in judged]
        results = self._results(jobs)
        blocks: dict[str, list[list[str]]] = {one.instance.case.id: [] for one in wanted}
        lines: dict[str, list[bytes]] = {one.case.id: [] for one in judged}
        for one in wanted:
            found = json.loads(results.get(("set", one.instance.label), b'{"lines": [], "reason": ""}'))
            if found["reason"]:
                self.problems.append(f"{one.instance.label}: {found['reason']}")
            blocks[one.instance.case.id] += [found["lines"]] if found["lines"] else []
        for instance in judged:
            lines[instance.case.id].append(results.get(("samples", instance.label), b""))
        self._write(blocks, lines, whole=not cases)

    def _results(self, jobs: list[Job]) -> dict[tuple[str, str], bytes]:
        """The result of every job that ended well: kept ones from the store of finished work, so that a killed run resumes."""
        keys = {job.key: _key(job) for job in jobs}
        kept = {} if self.anew else {job.key: data for job in jobs if (data := self.store.get("certified", keys[job.key])) is not None}
        missing = [job for job in jobs if job.key not in kept]
        with Schedule(self.jobs, LONGEST) as schedule:
            for done, (job, result) in enumerate(schedule.results(missing), 1):
                self.progress("certify", done, len(missing))
                if isinstance(result, Failure):
                    self.problems.append(f"{job.key[1]}: {result.sentence}")
                else:
                    self.store.put("certified", keys[job.key], result)
                    kept[job.key] = result
                    self.made += 1
        return kept

    def _write(self, blocks: Mapping[str, list[list[str]]], lines: Mapping[str, list[bytes]], *, whole: bool) -> None:
        from refdem.truth.certified.writing import file_text, sums

        certified, kept = self.folder / "certified", self.folder / "samples"
        for home in (certified, kept):
            home.mkdir(parents=True, exist_ok=True)
        for case, found in blocks.items():
            (certified / f"{case}.jsonl").write_text(file_text(case, found), encoding="utf-8")
        for case, entries in lines.items():
            path = kept / f"{case}.jsonl"
            path.write_bytes(b"".join(entries)) if any(entries) else path.unlink(missing_ok=True)
        for path in [*certified.glob("*.jsonl"), *kept.glob("*.jsonl")] if whole else ():
            if path.stem not in (blocks if path.parent == certified else lines):
                path.unlink()
        texts = {path.name: path.read_text(encoding="utf-8") for path in certified.glob("*.jsonl")}
        (certified / "sha256sums.txt").write_text(sums(texts))


def _key(job: Job) -> str:
    """sha256 of a job and of the code behind it: that of the truth, of its witness, and of what writes the lines."""
    from refdem.truth.witnesses.testimony import witness_files

    code = digest_of_files({*WRITERS, *closure(witness_files(job.arguments[0]))})
    asked: list[Any] = [job.key, job.arguments, digest_of(job.arguments[0]), code, *([DEAR] if job.key[0] == "samples" else [])]
    return hashlib.sha256(msgspec.json.encode(asked)).hexdigest()


def stale(folder: Path) -> list[str]:
    """Labels of sets and samples that were proved with other code than there is now, are missing, or that nobody asks for any more."""
    from refdem.truth.certified.reader import load

    there = load(folder=folder / "certified")
    found = [one.label for one in there if digest_of(one.case) != one.source]
    found += sorted({one.instance.label for one in wanted_sets(folder)} ^ {one.label for one in there})
    for path in sorted((folder / "samples").glob("*.jsonl")):
        found += [f"samples of {one.label}" for one in samples.kept(path.parent, path.stem) if digest_of(path.stem) != one.source]
    return found
