"""Truths by which tests judge are proved once in a session of pytest, for all of its workers.

Most tests of checks and engines ask for the truth of the same few instances, and a proof costs
more than what is judged by it. What `in_process.truth_of` has proved is kept in the folder of the
session under the key that the product's store has for it: case, parameters, samples, and all code
behind the truth. A test that changes code while it runs (`monkeypatch`) proves anew, and whoever
tests a truth itself asks the case for it.
"""

import fcntl
from pathlib import Path

import msgspec
import pytest

from refdem.core.case import Instance
from refdem.core.truth import SampledTruth
from refdem.execution import worker
from refdem.planning.kept_truth import kept_truth
from refdem.planning.truths import truth_key


def proved_once(folder: Path, instance: Instance) -> SampledTruth:
    """The truth of an instance: proved by the first who asks, who keeps it in the folder; others
    wait, and read it.
    """
    folder.mkdir(exist_ok=True)
    place = folder / truth_key(instance)
    with place.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if place.exists():
            data = place.read_bytes()
        else:
            data = worker.sampled_truth(instance.case.id, instance.p.given)
            # Whole or not at all: whoever proves may be killed.
            unfinished = place.with_suffix(".unfinished")
            unfinished.write_bytes(data)
            unfinished.replace(place)
    return msgspec.msgpack.decode(data, type=SampledTruth)


class SharedTruths:
    """Stands between `in_process.truth_of` and the proof; a plugin of pytest, which tells it what
    each test does.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        # Until it is known what the test at hand does.
        self.is_open = False

    def available(self, instance: Instance) -> SampledTruth | None:
        """The truth that comes with refdem, or that of the session; None, so that it is proved,
        where a test changes code.
        """
        kept = kept_truth(instance)
        if kept is not None or not self.is_open:
            return kept
        return proved_once(self.folder, instance)

    @pytest.hookimpl(tryfirst=True)
    def pytest_runtest_setup(self, item: pytest.Item) -> None:
        """Closed for a test that changes code."""
        self.is_open = "monkeypatch" not in getattr(item, "fixturenames", ())
