"""The second stage of a campaign, the sampled truths of instances: from the store of finished
work, from what comes with refdem, or made anew in workers.
"""

import hashlib
import os
import tempfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from importlib.metadata import version as installed
from typing import BinaryIO

import msgspec

from refdem.campaign import worker
from refdem.campaign.kept_truth import kept_truth
from refdem.campaign.schedule import InProcess, Job, Progress, Schedule, counted
from refdem.core import discovery, fingerprint
from refdem.core.case import Instance
from refdem.core.run import Failure
from refdem.core.store import Store
from refdem.core.truth import SampledTruth
from refdem.truth.certified.sources import digest_of

Asked = tuple[Instance, tuple[float, ...]]
"""An instance, and delays [s] before its samples at which truth is asked for as well."""
UNASKED = "no installed engine supports the case, so its truth was not computed"
PATIENCE = 3.0
"""Times the limit on a proof that the same work may take when it is made again: that of a proof
which came to its last sample just before its end takes all of the limit, and CPU time is not alike
from run to run on a busy machine.
"""
FAILED = "the proof ended in a "
"""How the reason begins where a proof crashed or hung: it may end otherwise next time."""


def is_lasting(truth: SampledTruth) -> bool:
    """False for a truth whose proof may end otherwise next time."""
    return not truth.reason.startswith(FAILED)


def sampled_truths(
    schedule: Schedule | InProcess,
    store: Store,
    instances: Sequence[Asked],
    progress: Progress,
    is_judged: Callable[[Instance], bool] = lambda _: True,
) -> list[SampledTruth]:
    """The sampled truth of every instance, in order; what nobody is judged by is not proved."""
    keys = [truth_key(instance, delays) for instance, delays in instances]
    found: dict[str, SampledTruth] = {}
    missing: dict[str, Asked] = {}
    for key, (instance, delays) in zip(keys, instances, strict=True):
        known = store.truth(key)
        # Kept truths have the samples of the case itself, none that are late.
        if known is None and not delays:
            known = kept_truth(instance)
        if known is None and not is_judged(instance):
            known = worker.no_truth(UNASKED)
        if known is None:
            missing[key] = (instance, delays)
        else:
            found[key] = known
    with tempfile.TemporaryFile() as told:
        os.ftruncate(told.fileno(), worker.COUNT_BYTES * len(missing))
        place = f"/proc/{os.getpid()}/fd/{told.fileno()}"
        jobs = [
            _job(key, *asked, told=(place, row)) for row, (key, asked) in enumerate(missing.items())
        ]
        for job, result in counted(schedule.results(jobs), "truths", len(jobs), progress):
            if isinstance(result, Failure):
                found[job.key] = worker.no_truth(f"{FAILED}{result.kind}: {result.sentence}")
            else:
                found[job.key] = msgspec.msgpack.decode(result, type=SampledTruth)
                store.put_truth(job.key, found[job.key])
        certified = _counts(told, missing)
    found |= _parts(schedule, missing, certified, found)
    return [found[key] for key in keys]


def _counts(told: BinaryIO, keys: Iterable[str]) -> dict[str, int]:
    """How many times each proof has certified; those that certified none are left out."""
    found = {}
    for row, key in enumerate(keys):
        written = os.pread(told.fileno(), worker.COUNT_BYTES, worker.COUNT_BYTES * row)
        count = int.from_bytes(written, "little")
        if count > 0:
            found[key] = count
    return found


def _job(
    key: str,
    instance: Instance,
    delays: tuple[float, ...],
    most: int | None = None,
    told: tuple[str, int] | None = None,
) -> Job:
    """The proof of an instance, or of its first samples."""
    arguments = (instance.case.id, instance.p.given, delays, most, told)
    return Job(key, worker.sampled_truth, arguments, computes=True)


def _parts(
    schedule: Schedule | InProcess,
    missing: Mapping[str, Asked],
    certified: Mapping[str, int],
    found: Mapping[str, SampledTruth],
) -> dict[str, SampledTruth]:
    """What was certified of proofs that ended in a crash or were not done in their time: they are
    made again up to there, in a process of their own, and no farther.
    """
    jobs = [
        replace(_job(key, *missing[key], most=most), patience=PATIENCE)
        for key, most in certified.items()
        if not is_lasting(found[key])
    ]
    parts = {}
    for job, result in schedule.results(jobs):
        if isinstance(result, Failure):
            continue
        part = msgspec.msgpack.decode(result, type=SampledTruth)
        reason = f"{found[job.key].reason}; what comes before is certified"
        parts[job.key] = msgspec.structs.replace(part, reason=reason)
    return parts


def truth_key(instance: Instance, delays: tuple[float, ...] = ()) -> str:
    """sha256 of all that can change a sampled truth: case, parameters, samples, its code,
    python-flint.
    """
    asked = [instance.case.id, instance.p.texts(), instance.times.tolist(), *delays]
    digest = hashlib.sha256(msgspec.json.encode(asked))
    source = fingerprint.of_source("truth", "core/truth.py", "core/case.py")
    digest.update(f"{source}\0{_of_case(instance)}\0{installed('python-flint')}".encode())
    return digest.hexdigest()


def _of_case(instance: Instance) -> str:
    """Digest of a case's code: all files of refdem that its truth can reach, or the package of
    one's own that brings it.
    """
    own = digest_of(instance.case.id)
    if own:
        return own
    module = type(instance.case).__module__
    package = discovery.package_of("cases", instance.case.id)
    digest = fingerprint.of_module(module)
    if package:
        digest += fingerprint.of_package(package)
    return digest
