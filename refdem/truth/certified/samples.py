"""Stored sampled truths whose proof takes long, for judging: doubles with radii at the default
samples of a campaign's instances.

An entry is valid as long as its key (case, parameters, times, scales) and the digest of the code
behind it (sources.py) are unchanged. Its line ends with a sha256, which is that of the line with an
empty text of sha256; sha256sums.txt lists every file of the folder.
"""

import hashlib
import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import msgspec

from refdem.core.truth import SampledTruth
from refdem.errors import StoreError
from refdem.truth.certified.reader import SEALED, sha256_of
from refdem.truth.certified.writing import sealed


class KeptSamples(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """One line of samples/<case>.jsonl.

    `job` is the digest of the request and of all code on which the line depends.
    """

    label: str
    key: str
    source: str
    job: str
    truth: SampledTruth
    sha256: str


def key_of(
    case: str, parameters: Mapping[str, str], times: Sequence[float], scales: Mapping[str, float]
) -> str:
    """sha256 of all arguments of a truth."""
    return hashlib.sha256(
        msgspec.json.encode([case, dict(parameters), list(times), dict(scales)])
    ).hexdigest()


def line_of(label: str, key: str, source: str, truth: SampledTruth, job: str = "") -> bytes:
    """The entry of one instance; radii and S are rounded up to three digits."""
    radii = {
        name: [rounded_up(radius) for radius in column] for name, column in truth.radii.items()
    }
    scalars = {name: (value, rounded_up(radius)) for name, (value, radius) in truth.scalars.items()}
    sensitivity = [rounded_up(value) for value in truth.sensitivity]
    short = msgspec.structs.replace(
        truth, radii=radii, scalars=scalars, sensitivity=sensitivity, earlier={}
    )
    entry = msgspec.json.encode(KeptSamples(label, key, source, job, short, "")).decode()
    return sealed([entry + "\n"])[0].encode()


def rounded_up(value: float) -> float:
    """The value, or a little more, in three digits."""
    if value == 0 or not math.isfinite(value):
        return value
    mantissa, _, exponent = f"{value:.2e}".partition("e")
    return next(
        short
        for more in (0, 0.01)
        if (short := float(f"{float(mantissa) + more:.2f}e{exponent}")) >= value
    )


def kept(folder: Path, case: str) -> list[KeptSamples]:
    """The entries of a case; raises StoreError, with file and line, for what is damaged."""
    path = folder / f"{case}.jsonl"
    if not path.is_file():
        return []
    lines = path.read_bytes().split(b"\n")
    if lines.pop():
        raise damaged(path, len(lines) + 1, "the file ends within a line")
    return [entry_of(line, path, number) for number, line in enumerate(lines, 1)]


def entry_of(line: bytes, path: Path, number: int) -> KeptSamples:
    """The entry of a line; raises StoreError if it is not one, or not that of its sha256."""
    try:
        text = line.decode("utf-8") + "\n"
        entry = msgspec.json.decode(line, type=KeptSamples)
    except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError) as error:
        raise damaged(path, number, str(error)) from None
    if SEALED.fullmatch(text) is None or sha256_of([text]) != entry.sha256:
        raise damaged(path, number, f"the sha256 of {entry.label} is not that of its samples")
    return entry


def damaged(path: Path, number: int, what: str) -> StoreError:
    """The error for a file of samples."""
    return StoreError(
        f"{path}, line {number}: {what}. Run `make certify`, or install refdem again."
    )
