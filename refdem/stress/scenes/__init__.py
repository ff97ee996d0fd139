"""Scenes that only a stress test has: contacts that the catalogue does not ask for.

Their truth is made here, at once.
"""

from refdem.core import discovery
from refdem.core.case import Instance
from refdem.core.truth import SampledTruth


def truth_here(instance: Instance) -> SampledTruth | None:
    """The sampled truth of a scene of this folder.

    None for cases of the catalogue, whose truth is proved in workers and kept.
    """
    from refdem.truth.sampled import sampled

    if instance.case.id in discovery.names("cases"):
        return None
    return sampled(instance.truth(), instance.times.tolist())
