"""What experiments measured, in files that say where each number comes from: drawn in figures,
never judged.
"""

from pathlib import Path

import msgspec
import numpy as np
from numpy.typing import NDArray

from refdem.errors import UNREADABLE, UsageError

FOLDER = Path(__file__).parent


class Reading(msgspec.Struct, frozen=True, forbid_unknown_fields=True):
    """Values of a quantity at impact angles [degrees from the normal]: `of` what figure, read `by`
    whom.
    """

    quantity: str
    of: str
    by: str
    angle: list[float]
    value: list[float]

    @property
    def places(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The angles and the measured values, each (N,)."""
        return np.array(self.angle), np.array(self.value)


class _File(msgspec.Struct, forbid_unknown_fields=True):
    reading: list[Reading]


def readings(name: str, folder: Path = FOLDER) -> list[Reading]:
    """What the file of that name holds; raises UsageError for one that is not of this kind, or with
    other than finite pairs.
    """
    path = folder / f"{name}.toml"
    try:
        reading = msgspec.toml.decode(path.read_bytes(), type=_File).reading
    except (OSError, *UNREADABLE) as error:
        raise UsageError(f"{path}: {error}") from None
    for one in reading:
        if len(one.angle) != len(one.value) or not np.isfinite([*one.angle, *one.value]).all():
            raise UsageError(
                f"{path}: {one.quantity}, {one.of}: expected as many finite values as angles"
            )
    return reading
