"""The second stage of a campaign, the sampled truths of instances: read from the store, or from
those distributed with refdem, or proved now in workers.
"""

import hashlib
import os
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from typing import BinaryIO

import msgspec

from refdem.core import discovery, fingerprint
from refdem.core.case import Instance
from refdem.core.run import Failure
from refdem.core.store import Store
from refdem.core.truth import SampledTruth
from refdem.execution import worker
from refdem.execution.schedule import Job, Progress, Scheduler, counted
from refdem.planning.kept_truth import kept_truth
from refdem.truth.certified.sources import digest_of

RequestedTruth = tuple[Instance, tuple[float, ...]]
"""An instance, and delays [s] before its samples at which truth is also needed."""
UNASKED = "no installed engine supports the case, so its truth was not computed"
PATIENCE = 3.0
"""Factor on the time limit of a proof that is repeated up to its last certified sample. If the
first proof reached that sample just before its limit, the repetition takes all of the limit, and
CPU time varies between runs on a busy machine.
"""
FAILED = "the proof ended in a "
"""The start of the reason of a proof that crashed or hung, which may not be reproducible."""


class BrokenProofError(Exception):
    """A proof raised an unexpected exception: refdem has a bug and can judge no engine.

    It is no RefdemError, so that the command ends with the exit status of an internal error.
    """


def is_lasting(truth: SampledTruth) -> bool:
    """False for a truth whose proof crashed or hung, which may not be reproducible."""
    return not truth.reason.startswith(FAILED)


def sampled_truths(
    schedule: Scheduler,
    store: Store,
    instances: Sequence[RequestedTruth],
    progress: Progress,
    is_judged: Callable[[Instance], bool] = lambda _: True,
) -> list[SampledTruth]:
    """The sampled truth of every instance, in order.

    Instances that no engine supports (`is_judged` is false) are not proved. A proof that crashed or
    ran out of time yields the samples that it had certified until then. If a proof raised an
    unexpected exception, BrokenProofError is raised after all others are proved and kept.
    """
    keys = [truth_key(instance, delays) for instance, delays in instances]
    truths: dict[str, SampledTruth] = {}
    missing: dict[str, RequestedTruth] = {}
    broken: dict[str, str] = {}
    for key, (instance, delays) in zip(keys, instances, strict=True):
        available = _available(store, key, instance, delays)
        if available is None and not is_judged(instance):
            available = worker.no_truth(UNASKED)
        if available is None:
            missing[key] = (instance, delays)
        else:
            truths[key] = available
    # Each proof writes the number of times that it has certified so far into its row of this file,
    # so that the number is available even if its process is killed.
    with tempfile.TemporaryFile() as counts_file:
        os.ftruncate(counts_file.fileno(), worker.COUNT_BYTES * len(missing))
        path = f"/proc/{os.getpid()}/fd/{counts_file.fileno()}"
        jobs = [
            _job(key, *requested, counter=(path, row))
            for row, (key, requested) in enumerate(missing.items())
        ]
        for job, result in counted(schedule.results(jobs), "truths", len(jobs), progress):
            if isinstance(result, Failure) and result.kind == "exception":
                broken[job.key] = result.sentence
            elif isinstance(result, Failure):
                truths[job.key] = worker.no_truth(f"{FAILED}{result.kind}: {result.sentence}")
            else:
                truths[job.key] = msgspec.msgpack.decode(result, type=SampledTruth)
                store.put_truth(job.key, truths[job.key])
        certified = _counts(counts_file, missing)
    _refuse_broken(missing, broken)
    truths |= _partial_truths(schedule, missing, certified, truths)
    return [truths[key] for key in keys]


def _refuse_broken(missing: Mapping[str, RequestedTruth], broken: Mapping[str, str]) -> None:
    """Raises BrokenProofError if there are proofs, by key, that raised an exception."""
    sentences = [f"{missing[key][0].label}: {sentence}" for key, sentence in broken.items()]
    if sentences:
        raise BrokenProofError(f"the proof of {'; of '.join(sentences)}")


def _available(
    store: Store, key: str, instance: Instance, delays: tuple[float, ...]
) -> SampledTruth | None:
    """The truth in the store of finished work, or else the one that comes with refdem, or None."""
    stored = store.truth(key)
    # The truths distributed with refdem are at the samples of the case only, not before them.
    if stored is None and not delays:
        return kept_truth(instance)
    return stored


def _counts(counts_file: BinaryIO, keys: Iterable[str]) -> dict[str, int]:
    """Number of times that each proof has certified, by key; proofs with none are left out."""
    counts = {}
    for row, key in enumerate(keys):
        written = os.pread(counts_file.fileno(), worker.COUNT_BYTES, worker.COUNT_BYTES * row)
        count = int.from_bytes(written, "little")
        if count > 0:
            counts[key] = count
    return counts


def _job(
    key: str,
    instance: Instance,
    delays: tuple[float, ...],
    most: int | None = None,
    counter: tuple[str, int] | None = None,
) -> Job:
    """The proof of an instance, or of its first `most` samples, which it counts in `counter`."""
    arguments = (instance.case.id, instance.p.given, delays, most, counter)
    return Job(key, worker.sampled_truth, arguments, computes=True)


def _partial_truths(
    schedule: Scheduler,
    missing: Mapping[str, RequestedTruth],
    certified: Mapping[str, int],
    truths: Mapping[str, SampledTruth],
) -> dict[str, SampledTruth]:
    """The certified samples of proofs that crashed or ran out of time, by key.

    Such a proof is repeated only up to the number of samples that it had `certified`.
    """
    jobs = [
        replace(_job(key, *missing[key], most=count), patience=PATIENCE)
        for key, count in certified.items()
        if not is_lasting(truths[key])
    ]
    partial = {}
    broken: dict[str, str] = {}
    for job, result in schedule.results(jobs):
        if isinstance(result, Failure):
            if result.kind == "exception":
                broken[job.key] = result.sentence
            continue
        truth = msgspec.msgpack.decode(result, type=SampledTruth)
        reason = f"{truths[job.key].reason}; what comes before is certified"
        partial[job.key] = msgspec.structs.replace(truth, reason=reason)
    _refuse_broken(missing, broken)
    return partial


def truth_key(instance: Instance, delays: tuple[float, ...] = ()) -> str:
    """sha256 of all that can change a sampled truth: case, parameters, samples, its code,
    python-flint.
    """
    requested = [instance.case.id, instance.p.texts(), instance.times.tolist(), *delays]
    digest = hashlib.sha256(msgspec.json.encode(requested))
    source = fingerprint.of_source("truth", "core/truth.py", "core/case.py")
    flint = fingerprint.version_of("python-flint")
    digest.update(f"{source}\0{_of_case(instance)}\0{flint}".encode())
    return digest.hexdigest()


def _of_case(instance: Instance) -> str:
    """Digest of a case's code: of all files of refdem that its truth can reach, or, for a case of
    another package, of that package.
    """
    of_refdem = digest_of(instance.case.id)
    if of_refdem:
        return of_refdem
    module = type(instance.case).__module__
    package = discovery.package_of("cases", instance.case.id)
    digest = fingerprint.of_module(module)
    if package:
        digest += fingerprint.of_package(package)
    return digest
