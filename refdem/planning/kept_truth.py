"""Sampled truths distributed with refdem, in validation/truth/samples/. That of an instance is used
if the code from which it was computed is unchanged.
"""

from pathlib import Path

from refdem.core.case import Instance
from refdem.core.truth import SampledTruth
from refdem.planning.specification import validation_folder
from refdem.truth.certified import samples
from refdem.truth.certified.sources import digest_of


def truth_folder() -> Path:
    """The folder of the store: sets.toml, certified/ and samples/."""
    return validation_folder() / "truth"


def samples_key(instance: Instance) -> str:
    """The key of an instance in samples/: case, parameters, times and scales."""
    scales = {name: quantity.scale for name, quantity in instance.quantities.items()}
    return samples.key_of(instance.case.id, instance.p.texts(), instance.times.tolist(), scales)


def kept_truth(instance: Instance, folder: Path | None = None) -> SampledTruth | None:
    """The sampled truth of an instance if it is kept and not stale; raises StoreError if it is
    damaged.
    """
    home = (folder or truth_folder()) / "samples"
    for entry in samples.kept(home, instance.case.id):
        if entry.label == instance.label:
            is_current = entry.source == digest_of(instance.case.id)
            if is_current and entry.key == samples_key(instance):
                return entry.truth
            return None
    return None
