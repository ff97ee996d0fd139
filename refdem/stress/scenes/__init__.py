"""Scenes of stress tests that are not in the catalogue; their truth is computed on the spot."""

from refdem.core import discovery
from refdem.core.case import Instance
from refdem.core.truth import SampledTruth


def truth_here(instance: Instance) -> SampledTruth | None:
    """The sampled truth of a scene of this folder; None for cases of the catalogue, whose truth
    workers prove and store.
    """
    from refdem.truth.sampled import sampled

    if instance.case.id in discovery.names("cases"):
        return None
    return sampled(instance.truth(), instance.times.tolist())
