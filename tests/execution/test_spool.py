"""What a campaign holds in memory while it judges: the trajectories of one task, not of all."""

import errno
import weakref
from io import BytesIO
from pathlib import Path

import pytest

from refdem.core.finding import Record
from refdem.core.store import Store
from refdem.core.trajectory import Trajectory
from refdem.errors import StoreError
from refdem.execution.spool import IN_MEMORY, Spool, spool
from refdem.planning.campaign import Campaign
from refdem.planning.specification import Entry, Specification


def test_what_was_kept_is_read_in_any_order_also_from_a_file() -> None:
    large = bytes(IN_MEMORY)
    with spool() as kept:
        kept.keep("first", b"ab")
        kept.keep("large", large)
        kept.keep("last", b"c")
        kept.keep("empty", b"")
        assert [kept.read(key) for key in ("last", "first", "empty")] == [b"c", b"ab", b""]
        assert kept.read("large") == large


def test_a_key_under_which_nothing_was_kept_is_an_error() -> None:
    with spool() as kept, pytest.raises(KeyError, match="key"):
        kept.read("key")


def test_a_full_disk_is_told_with_the_folder_that_may_be_another() -> None:
    class Full(BytesIO):
        """A file on a disk without room."""

        def write(self, data: object) -> int:
            """Raises OSError."""
            raise OSError(errno.ENOSPC, "No space left on device")

    with pytest.raises(StoreError, match=r"No space left on device; .* set TMPDIR"):
        Spool(Full()).keep("key", b"a")


def test_a_campaign_holds_the_trajectories_of_one_task_at_once(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    held: weakref.WeakSet[Trajectory] = weakref.WeakSet()
    most = 0
    unpacked = Trajectory.from_bytes

    def counted(data: bytes) -> Trajectory:
        """The trajectory, which counts for as long as something holds it."""
        nonlocal most
        trajectory = unpacked(data)
        held.add(trajectory)
        most = max(most, len(held))
        return trajectory

    monkeypatch.setattr(Trajectory, "from_bytes", counted)
    specification = Specification(
        name="held",
        case=[
            Entry("harmonic-oscillator", {"samples": samples, "duration": "4"})
            for samples in ("16", "32", "64")
        ],
        engines=["reference"],
        levels=2,
    )
    sheets = Campaign(specification, Store(tmp_path / "store"), jobs=0).sheets()
    runs = [len(sheet.runs) for sheet in sheets if isinstance(sheet, Record)]
    assert most >= max(runs)
    assert most < sum(runs) / 3
