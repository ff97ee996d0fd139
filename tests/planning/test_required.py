"""Lists of the findings that a campaign must make: which files are read."""

import os
from pathlib import Path

import pytest

from refdem.errors import UsageError
from refdem.planning import required


def test_a_required_list_by_a_link_or_a_pipe_is_not_read(tmp_path: Path) -> None:
    (tmp_path / "elsewhere.txt").write_bytes(b"")
    (tmp_path / "link.txt").symlink_to("elsewhere.txt")
    os.mkfifo(tmp_path / "pipe.txt")
    for name in ("link.txt", "pipe.txt"):
        with pytest.raises(UsageError, match="restore it from version control"):
            required.read(tmp_path / name)
