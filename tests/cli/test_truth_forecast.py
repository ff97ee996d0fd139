"""What a proof will cost is said on stderr before it is worked for, and only where it is dear."""

import pytest

from refdem.cli import truth
from refdem.errors import UsageError


@pytest.mark.parametrize(
    ("seconds", "said"), [(9.0, ""), (42.3, "the proof will take about 42 s of CPU")]
)
def test_dear_proofs_are_announced(seconds, said, capsys):
    truth.warn(seconds)
    told = capsys.readouterr()
    assert told.out == ""
    assert told.err.startswith(said)
    assert bool(told.err) == bool(said)


def test_a_proof_that_nobody_can_wait_for_is_refused():
    with pytest.raises(UsageError, match="about 12 days of CPU"):
        truth.warn(1e6)


@pytest.mark.parametrize(
    "case", ["double-pendulum", "kapitza-pendulum", "van-der-pol", "driven-duffing", "heavy-top"]
)
def test_a_time_without_end_is_refused_before_it_is_followed(command_line, case):
    done = command_line("truth", case, "--at", "1e99")
    assert done.returncode == 2, done.stdout
    assert "days of CPU" in done.stderr
