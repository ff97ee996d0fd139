"""Rebuilding the certified store: sets and samples that are missing or stale are proved in worker
processes, the others are kept.

A *set* holds the certified values of one case at one parameter set and some times; *samples* are
the certified values at all sample times of an instance that campaigns judge by. A *job* is the
proof of one of either; its digest covers what was asked and all code that had a part in it.
"""

import hashlib
import json
import tomllib
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

import msgspec

from refdem.core import discovery
from refdem.core.case import Instance
from refdem.core.problem import Motion
from refdem.core.reading import content
from refdem.core.run import Failure
from refdem.core.selection import Selection
from refdem.core.store import Store
from refdem.errors import UNREADABLE, NotCertifiedError, StoreError, UsageError
from refdem.execution.schedule import Job, Progress, Schedule, counted
from refdem.planning import plan
from refdem.planning.kept_truth import samples_key
from refdem.planning.specification import named
from refdem.truth.certified import samples
from refdem.truth.certified.reader import LIST, sets_of, text_of
from refdem.truth.certified.sources import ROOT, closure, digest_of, digest_of_files
from refdem.truth.certified.writing import blocks_in

LONGEST = 1800.0
"""CPU seconds that one set may take to be proved."""
SAMPLED = "samples-of"
"""Key of sets.toml: the cases whose sampled truths are kept for judging, because they take long to
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
    sets = []
    for unknown in only - set(document):
        raise UsageError(f"{path} has no sets of case {unknown!r}; it has {', '.join(document)}")
    for case, groups in document.items():
        if only and case not in only:
            continue
        for group in groups:
            texts = [text.strip() for text in group["times"].split(",")]
            times = tuple(Fraction(text) for text in texts if text)
            for parameters in group["sets"]:
                sets.append(Wanted(discovery.case(case).at(**parameters), times))
    _refuse_twins(sets, path)
    return sets


def default_sets(named: set[str]) -> dict[str, list[dict[str, Any]]]:
    """One set at the defaults of each case in refdem/cases that is not `named`, in the form of
    sets.toml.

    The times of a motion are its first sample, the middle one and the last.
    """
    sets = {}
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
        sets[name] = [{"times": times, "sets": [{}]}]
    return sets


def document_of(path: Path) -> dict[str, Any]:
    """The content of sets.toml; raises UsageError."""
    data = content(path, "a list of sets to certify")
    try:
        return tomllib.loads(data.decode("utf-8"))
    except UNREADABLE as error:
        raise UsageError(f"{path}: {error}") from None


def _refuse_twins(sets: list[Wanted], path: Path) -> None:
    """Raises UsageError for two sets of one case at the same parameters."""
    labels = [wanted.instance.label for wanted in sets]
    for label in labels:
        if labels.count(label) > 1:
            raise UsageError(f"{path}: {label} is there twice; put its times together")


def judged_instances(folder: Path, cases: Iterable[str] = ()) -> list[Instance]:
    """The instances whose sampled truths are kept: of the campaigns main, gate and shipped, and at
    the defaults of cases.

    They are those of the cases under `samples-of` in sets.toml, or, of these, only of `cases`.
    """
    only = set(cases)
    kept_cases = document_of(folder / "sets.toml").get(SAMPLED, [])
    chosen_cases = {case for case in kept_cases if not only or case in only}
    planned = [
        instance
        for campaign in ("main", "gate", "shipped")
        for instance, _ in plan.instances(named(campaign))
    ]
    planned += [discovery.case(case).at() for case in chosen_cases]
    by_label = {instance.label: instance for instance in planned}
    return [instance for instance in by_label.values() if instance.case.id in chosen_cases]


def proved_set(case: str, given: dict[str, str], times: tuple[str, ...], job: str = "") -> bytes:
    """The lines of one set, proved and witnessed, as JSON {"lines", "reason"}.

    There are no lines, and a reason, if nothing can be certified or the witness contradicts it.
    `given` are the parameters as text, `times` exact numbers as text, `job` the digest that the
    lines carry.
    """
    from refdem.truth.certified.writing import DIGITS, block, rows
    from refdem.truth.witnesses.cross_check import cross_checked

    instance = discovery.case(case).at(**given)
    try:
        truth = instance.truth().refined(DIGITS)
        values, missing = rows(truth, [Fraction(text) for text in times])
    except NotCertifiedError as error:
        return _result([], str(error))
    if not values:
        return _result([], f"nothing is certified: {missing}")
    statement = cross_checked(case, instance.case.meant(instance.p), values)
    if statement is not None and statement["denied"]:
        denied = ", ".join(statement["denied"][:5])
        return _result([], f"the witness ({statement['by']}) does not confirm {denied}")
    if statement:
        witnessed = {name: statement[name] for name in ("by", "values", "digits")}
    else:
        witnessed = None
    provenance = {
        "source": digest_of(case),
        "job": job,
        "witnessed": witnessed,
        "not_certified": missing,
    }
    return _result(block(instance.label, instance.p.texts(), truth, values, **provenance), "")


def _result(lines: list[str], reason: str) -> bytes:
    """The outcome of a proof as JSON: the lines of a set, or the reason why there are none."""
    return json.dumps({"lines": lines, "reason": reason}).encode()


def proved_samples(case: str, given: dict[str, str], job: str = "") -> bytes:
    """The line of samples/ for one instance; where nothing is certified, the line has the
    reason.
    """
    from refdem.core.truth import SampledTruth
    from refdem.execution.worker import sampled_truth

    instance = discovery.case(case).at(**given)
    truth = msgspec.msgpack.decode(sampled_truth(case, given), type=SampledTruth)
    return samples.line_of(instance.label, samples_key(instance), digest_of(case), truth, job)


Key = tuple[str, str]
"""A job: "set" or "samples", and the label of the instance."""


@dataclass(frozen=True, kw_only=True)
class Certified:
    """The outcome of a rebuilding: a line for every proof that failed or was contradicted, and the
    number of proofs that were made.
    """

    problems: tuple[str, ...]
    made: int


@dataclass(frozen=True, kw_only=True)
class _Results:
    """Results of jobs by key, kept and new ones; the failures in words; how many are new."""

    by_key: Mapping[Key, bytes]
    problems: tuple[str, ...]
    made: int


@dataclass(frozen=True)
class Certification:
    """A rebuilding of the certified store in `folder`: what is missing or stale is proved.

    A line in the folder is kept while its job has the same digest; else a result is taken from the
    store of finished work, so that a killed run resumes; the rest is proved in `jobs` processes.
    `anew` proves everything.
    """

    folder: Path
    store: Store
    jobs: int = 2
    anew: bool = False
    progress: Progress = lambda stage, done, total: None

    def run(self, cases: Iterable[str] = ()) -> Certified:
        """Proves what is missing or stale and writes the files of these cases, or of all."""
        sets = wanted_sets(self.folder, cases)
        instances = judged_instances(self.folder, cases)
        jobs = [job_of("set", wanted.instance.label, proved_set, wanted.job) for wanted in sets]
        for instance in instances:
            arguments = (instance.case.id, instance.p.given)
            jobs.append(job_of("samples", instance.label, proved_samples, arguments))
        results = self._results(jobs)
        problems = list(results.problems)
        blocks: dict[str, list[list[str]]] = {wanted.instance.case.id: [] for wanted in sets}
        for wanted in sets:
            label = wanted.instance.label
            # A proof that failed has no result; its problem is already there.
            data = results.by_key.get(("set", label), _result([], ""))
            proof = json.loads(data)
            if proof["reason"]:
                problems.append(f"{label}: {proof['reason']}")
            if proof["lines"]:
                blocks[wanted.instance.case.id].append(proof["lines"])
        lines: dict[str, list[bytes]] = {instance.case.id: [] for instance in instances}
        for instance in instances:
            line = results.by_key.get(("samples", instance.label), b"")
            lines[instance.case.id].append(line)
        self._write(blocks, lines, is_complete=not cases)
        return Certified(problems=tuple(problems), made=results.made)

    def _results(self, jobs: list[Job]) -> _Results:
        """The results of all jobs that ended well, kept or proved now, and how the others
        failed.
        """
        digests = {job.key: job.arguments[-1] for job in jobs}
        results: dict[Key, bytes] = {}
        if not self.anew:
            results |= self._kept(digests)
        missing = [job for job in jobs if job.key not in results]
        problems = []
        proved = 0
        with Schedule(self.jobs, LONGEST) as schedule:
            proofs = schedule.results(missing)
            for job, result in counted(proofs, "certify", len(missing), self.progress):
                if isinstance(result, Failure):
                    problems.append(f"{job.key[1]}: {result.sentence}")
                else:
                    self.store.put("certified", digests[job.key], result)
                    results[job.key] = result
                    proved += 1
        return _Results(by_key=results, problems=tuple(problems), made=proved)

    def _kept(self, digests: Mapping[Key, str]) -> dict[Key, bytes]:
        """The results that need no new proof: from the files of the folder first, then from the
        store of finished work.
        """
        in_folder = committed(self.folder)
        results = {}
        for key, digest in digests.items():
            data = in_folder.get((*key, digest)) or self.store.get("certified", digest)
            if data is not None:
                results[key] = data
        return results

    def _write(
        self,
        blocks: Mapping[str, list[list[str]]],
        lines: Mapping[str, list[bytes]],
        *,
        is_complete: bool,
    ) -> None:
        """Writes the files of certified/ and samples/ and their lists of hashes.

        `blocks` are the lines of the sets by case, `lines` those of the samples; where these are
        of all cases, files of others are deleted.
        """
        from refdem.truth.certified.listing import listing
        from refdem.truth.certified.writing import file_text

        certified = self.folder / "certified"
        sampled = self.folder / "samples"
        for home in (certified, sampled):
            home.mkdir(parents=True, exist_ok=True)
        for case, sets in blocks.items():
            (certified / f"{case}.jsonl").write_text(file_text(case, sets), encoding="utf-8")
        for case, entries in lines.items():
            path = sampled / f"{case}.jsonl"
            if any(entries):
                path.write_bytes(b"".join(entries))
            else:
                path.unlink(missing_ok=True)
        if is_complete:
            _delete_others(certified, blocks)
            _delete_others(sampled, lines)
        for home in (certified, sampled):
            texts = {path.name: path.read_text(encoding="utf-8") for path in home.glob("*.jsonl")}
            (home / LIST).write_text(listing(texts))


def _delete_others(folder: Path, cases: Iterable[str]) -> None:
    """Deletes the files of all but these cases from a folder of the store."""
    names = set(cases)
    for path in list(folder.glob("*.jsonl")):
        if path.stem not in names:
            path.unlink()


def job_of(
    kind: str, label: str, function: Callable[..., bytes], arguments: tuple[Any, ...]
) -> Job:
    """The proof of one set or of the samples of one instance.

    Its last argument is the digest of the job, which the lines that it makes carry.
    """
    digest = job_digest(kind, label, arguments)
    return Job((kind, label), function, (*arguments, digest), computes=True)


def job_digest(kind: str, label: str, arguments: tuple[Any, ...]) -> str:
    """sha256 of a job and of the code behind it: of the case's truth, of the writers of the lines,
    and, for a set, of its witness.
    """
    from refdem.truth.witnesses.cross_check import witness_files

    case = arguments[0]
    if kind == "set":
        witness = closure(witness_files(case))
    else:
        witness = set()
    code = digest_of_files({*WRITERS, *witness})
    content = [kind, label, arguments, digest_of(case), code]
    return hashlib.sha256(msgspec.json.encode(content)).hexdigest()


def committed(folder: Path) -> dict[tuple[str, str, str], bytes]:
    """The results in the files of the folder, by kind, label and digest of the job.

    A damaged file counts as empty, so that its content is proved again.
    """
    results: dict[tuple[str, str, str], bytes] = {}
    for path in sorted((folder / "certified").glob("*.jsonl")):
        with suppress(ValueError):
            text = text_of(path)
            sets = sets_of(text, path.name)
            for certified_set, lines in zip(sets, blocks_in(text), strict=True):
                results["set", certified_set.label, certified_set.job] = _result(lines, "")
    for path in sorted((folder / "samples").glob("*.jsonl")):
        with suppress(StoreError):
            entries = samples.kept(path.parent, path.stem)
            lines_of_file = path.read_bytes().splitlines(keepends=True)
            for entry, line in zip(entries, lines_of_file, strict=True):
                results["samples", entry.label, entry.job] = line
    return results


def stale(folder: Path) -> list[str]:
    """Labels of sets, and of samples, whose stored job is not the one that is wanted now.

    They were proved with other code than there is now, or are missing, or are not wanted any more.
    """
    from refdem.truth.certified.reader import load

    stored_sets = {entry.label: entry.job for entry in load(folder=folder / "certified")}
    wanted_jobs = {}
    for wanted in wanted_sets(folder):
        label = wanted.instance.label
        wanted_jobs[label] = job_digest("set", label, wanted.job)
    stored_samples: dict[str, str] = {}
    for path in sorted((folder / "samples").glob("*.jsonl")):
        entries = samples.kept(path.parent, path.stem)
        stored_samples |= {entry.label: entry.job for entry in entries}
    wanted_samples = {}
    for instance in judged_instances(folder):
        arguments = (instance.case.id, instance.p.given)
        wanted_samples[instance.label] = job_digest("samples", instance.label, arguments)
    of_samples = _differing(stored_samples, wanted_samples)
    return _differing(stored_sets, wanted_jobs) + [f"samples of {label}" for label in of_samples]


def _differing(stored: Mapping[str, str], wanted: Mapping[str, str]) -> list[str]:
    """Labels whose stored digest is another than the wanted one, then those in only one of both."""
    changed = [label for label, job in stored.items() if wanted.get(label, job) != job]
    return changed + sorted(set(wanted) ^ set(stored))
