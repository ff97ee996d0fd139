"""What a failed run leaves for its author: the newest stay, whatever the clock does."""

import time
from pathlib import Path

import pytest

from refdem.engines.external.kept import MOST_FOLDERS, kept


@pytest.mark.parametrize("tick", [-(10**9), 0, 1])
def test_the_newest_failed_runs_stay_on_any_clock(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, tick: int
) -> None:
    clock = [10**18]

    def now() -> int:
        clock[0] += tick
        return clock[0]

    monkeypatch.setattr(time, "time_ns", now)
    monkeypatch.setenv("REFDEM_STORE", str(tmp_path / "store.sqlite"))
    (tmp_path / "run").mkdir()
    places = []
    for number in range(MOST_FOLDERS + 3):
        (tmp_path / "run" / "stderr.txt").write_text(str(number))
        place = kept(tmp_path / "run", "small")
        assert place is not None
        assert (place / "stderr.txt").read_text() == str(number)
        places.append(place)
    left = sorted((tmp_path / "failed-runs").iterdir())
    assert left == sorted(places[-MOST_FOLDERS:])
