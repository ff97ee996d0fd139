"""Sampled truths of instances: from the store of finished work, from what comes with refdem, or
made anew in workers.
"""

import hashlib
from collections.abc import Callable, Sequence
from importlib.metadata import version as installed

import msgspec

from refdem.campaign import worker
from refdem.campaign.kept_truth import kept_truth
from refdem.campaign.schedule import InProcess, Job, Schedule
from refdem.core import discovery, fingerprint
from refdem.core.case import Instance
from refdem.core.run import Failure
from refdem.core.store import Store
from refdem.core.truth import SampledTruth
from refdem.truth.certified.sources import digest_of

Asked = tuple[Instance, tuple[float, ...]]
"""An instance, and delays [s] before its samples at which truth is asked for as well."""
FAILED = "the proof ended in a "
"""How the reason begins where a proof crashed or hung: it may end otherwise next time."""


def sampled_truths(
    schedule: Schedule | InProcess,
    store: Store,
    instances: Sequence[Asked],
    progress: Callable[[str, int, int], None],
) -> list[SampledTruth]:
    """The sampled truth of every instance, in order."""
    keys = [truth_key(instance, delays) for instance, delays in instances]
    found: dict[str, SampledTruth] = {}
    jobs: dict[str, Job] = {}
    for key, (instance, delays) in zip(keys, instances, strict=True):
        known = store.truth(key)
        # Kept truths have the samples of the case itself, none that are late.
        if known is None and not delays:
            known = kept_truth(instance)
        if known is not None:
            found[key] = known
            continue
        asked = (instance.case.id, instance.p.given, delays)
        jobs[key] = Job(key, worker.sampled_truth, asked, computes=True)
    for done, (job, result) in enumerate(schedule.results(list(jobs.values())), 1):
        if isinstance(result, Failure):
            found[job.key] = no_truth(f"{FAILED}{result.kind}: {result.sentence}")
        else:
            found[job.key] = msgspec.msgpack.decode(result, type=SampledTruth)
            store.put_truth(job.key, found[job.key])
        progress("truths", done, len(jobs))
    return [found[key] for key in keys]


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


def no_truth(reason: str) -> SampledTruth:
    """What stands in for a truth that could not be made."""
    return SampledTruth(
        t=[],
        values={},
        radii={},
        sensitivity=[],
        scalars={},
        method="not certified",
        witness="",
        until=0,
        reason=reason,
    )
