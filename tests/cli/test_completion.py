"""What a shell is offered after `refdem --install-completion`."""

import os
import subprocess
import sys

import pytest

from refdem.cli import completion
from refdem.core import discovery


def offered(words: str) -> list[str]:
    """The answer to bash where the cursor stands at the end of the last word."""
    asking = {
        "COMP_WORDS": words,
        "COMP_CWORD": str(len(words.split()) - 1),
        "_REFDEM_COMPLETE": "complete_bash",
    }
    # A command is completed by the name under which it was called.
    called = "import sys; sys.argv[0] = 'refdem'; from refdem.cli import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", called],
        env=os.environ | asking,
        capture_output=True,
        text=True,
        check=True,
    )
    return done.stdout.split()


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("refdem run pendulum-e", ["pendulum-equilibria"]),
        ("refdem run --engine mu", ["mujoco"]),
        ("refdem advise --motion sp", ["spinning"]),
    ],
)
def test_a_shell_is_offered_the_names_that_begin_so(words, expected):
    assert offered(words) == expected


def test_nothing_typed_offers_everything():
    assert completion.cases("") == list(discovery.names("cases"))
    assert set(completion.engines("")) >= {"reference", "mujoco", "pymunk", "rebound"}
    assert "formula" not in completion.motions("")
    assert completion.cases("no such case") == []
