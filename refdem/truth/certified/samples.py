"""Sampled truths that are dear to prove, kept for judging: doubles with radii at the default samples of a campaign's instances.

An entry holds as long as its key (case, parameters, times, scales) and the digest of the code behind it (sources.py) are the same.
"""

import hashlib
import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import msgspec

from refdem.core.truth import SampledTruth
from refdem.errors import StoreError


class KeptSamples(msgspec.Struct, frozen=True):
    """One line of samples/<case>.jsonl."""

    label: str
    key: str
    source: str
    sha256: str
    truth: msgspec.Raw


def key_of(case: str, parameters: Mapping[str, str], times: Sequence[float], scales: Mapping[str, float]) -> str:
    """sha256 of all that a truth is asked with."""
    return hashlib.sha256(msgspec.json.encode([case, dict(parameters), list(times), dict(scales)])).hexdigest()


def line_of(label: str, key: str, source: str, truth: SampledTruth) -> bytes:
    """The entry of one instance; radii and S are rounded up to three digits."""
    radii = {name: [rounded_up(radius) for radius in column] for name, column in truth.radii.items()}
    scalars = {name: (value, rounded_up(radius)) for name, (value, radius) in truth.scalars.items()}
    sensitivity = [rounded_up(value) for value in truth.sensitivity]
    short = msgspec.structs.replace(truth, radii=radii, scalars=scalars, sensitivity=sensitivity, earlier={})
    data = msgspec.json.encode(short)
    return msgspec.json.encode(KeptSamples(label, key, source, hashlib.sha256(data).hexdigest(), msgspec.Raw(data))) + b"\n"


def rounded_up(value: float) -> float:
    """The value, or a little more, in three digits."""
    if value == 0 or not math.isfinite(value):
        return value
    mantissa, _, exponent = f"{value:.2e}".partition("e")
    return next(short for more in (0, 0.01) if (short := float(f"{float(mantissa) + more:.2f}e{exponent}")) >= value)


def kept(folder: Path, case: str) -> list[KeptSamples]:
    """The entries of a case; raises StoreError for a file that is damaged."""
    path = folder / f"{case}.jsonl"
    try:
        return [msgspec.json.decode(line, type=KeptSamples) for line in path.read_bytes().splitlines()] if path.is_file() else []
    except msgspec.MsgspecError as error:
        raise StoreError(f"{path}: {error}. Run `make certify`, or install refdem again.") from None


def truth_of(entry: KeptSamples, where: Path) -> SampledTruth:
    """The sampled truth of an entry; raises StoreError if its hash is not that of its content."""
    if hashlib.sha256(bytes(entry.truth)).hexdigest() != entry.sha256:
        raise StoreError(f"{where}: the sha256 of {entry.label} is not that of its samples. Run `make certify`, or install refdem again.")
    return msgspec.json.decode(bytes(entry.truth), type=SampledTruth)
