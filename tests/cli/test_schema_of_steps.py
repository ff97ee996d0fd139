"""The schemas tell the author of a program that steps are counted."""

import pytest


@pytest.mark.parametrize("what", ["request", "trajectory", "toml"])
def test_the_schemas_say_that_steps_are_counted_and_times_never_compared(command_line, what):
    told = command_line("schema", what)
    assert told.returncode == 0
    said = told.stdout
    assert "stride" in said
    assert "never compare" in said
