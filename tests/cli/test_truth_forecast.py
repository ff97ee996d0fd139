"""What a proof will cost is said on stderr before it is worked for, and only where it is dear."""

import pytest

from refdem.cli import truth


@pytest.mark.parametrize(("seconds", "said"), [(9.0, ""), (42.3, "the proof will take about 42 s of CPU")])
def test_dear_proofs_are_announced(seconds, said, capsys):
    truth.warn(seconds)
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.startswith(said)
    assert bool(told.err) == bool(said)
