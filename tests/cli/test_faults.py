"""`refdem faults`: the matrix in words and as JSON, its exit status, and what it says of bad
input.
"""

import json

from typer.testing import CliRunner

from refdem.cli.app import app
from refdem.cli.faults import lines
from refdem.errors import UsageError
from refdem.kills.trials import Alarm, Matrix


def command(*arguments):
    return CliRunner().invoke(app, ["faults", *arguments])


def test_it_prints_a_row_a_fault_with_what_killed_it_and_what_else_saw_it():
    done = command("--seeds", "1", "--fault", "rod-too-long", "--fault", "not-a-number")
    assert done.exit_code == 0, done.output
    row = next(line for line in done.output.splitlines() if line.strip().startswith("rod-too-long"))
    assert row.split()[1:2] == ["1/1"]
    killer, _, others = row.partition("; ")
    assert killer.endswith("constraint/length")
    assert "error" in others.split(", ")
    assert "2 faults at 1 seeds: 2 of 2 killed, 0 alarms" in done.output
    assert "checks that detect none of the faults: " in done.output


def test_programs_read_it_as_json():
    done = command("--seeds", "1", "--fault", "rod-too-long", "--json")
    (kill,) = json.loads(done.stdout)["kills"]
    assert kill["killed"] is True
    assert (kill["check"], kill["quantity"]) == ("constraint", "length")
    assert kill["beyond"] > 1


def test_bad_input_is_named():
    for arguments, word in (
        (("--seeds", "0"), "--seeds is 0"),
        (("--fault", "rod-too-lang"), "rod-too-long"),
        (("--engine", "nobody"), "nobody"),
    ):
        done = command(*arguments)
        assert isinstance(done.exception, UsageError)
        assert word in str(done.exception)


def test_survivors_and_alarms_are_said_in_full():
    alarm = Alarm(
        id="pendulum/transparent/verlet/error/x", setting="swing", seed=3, sentence="It is off."
    )
    said = lines(Matrix(engine="transparent", seeds=1, kills=(), alarms=(alarm,)))
    assert "ALARM pendulum/transparent/verlet/error/x (seed 3): It is off." in said
