"""`refdem request` prints what a program is asked."""

import pytest
from typer.testing import CliRunner

from refdem import __version__
from refdem.cli.app import app
from refdem.core import discovery
from refdem.core.problem import Request
from refdem.core.request_text import request_text
from refdem.core.selection import Selection
from refdem.errors import UsageError

CASES = [
    name for name in discovery.names("cases") if not isinstance(discovery.case(name), Selection)
]


def printed(*arguments: str) -> str:
    """What the command prints; raises what it raises."""
    done = CliRunner().invoke(app, list(arguments), catch_exceptions=False)
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    return done.output


@pytest.mark.parametrize("case", CASES)
def test_without_its_comments_it_is_the_text_that_a_program_reads(case):
    commented = printed("request", case)
    lines = [line for line in commented.splitlines() if not line.startswith("#")]
    plain = printed("request", case, "--text")
    assert lines == plain.splitlines()
    assert len(commented) > len(plain)
    assert max(len(line) for line in commented.splitlines() if line.startswith("#")) <= 98


def test_a_request_is_that_of_the_case_at_these_parameters():
    problem = discovery.case("pendulum").at(theta0="2").problem
    request = Request(problem=problem, method="verlet", step=problem.interval / 4)
    asked = ("request", "pendulum", "--set", "theta0=2", "--method", "verlet", "--stride", "4")
    assert printed(*asked, "--text") == request_text(request)
    assert printed(*asked, "--json") == request.to_json().decode() + "\n"


def test_every_element_is_explained_where_it_begins():
    lines = printed("request", "coupled-pendulums").splitlines()
    begins = [
        number for number, line in enumerate(lines) if ".kind " in line and "elements" in line
    ]
    assert len(begins) == 4
    assert all(lines[number - 1].startswith("# ") for number in begins)


def test_a_selection_and_two_formats_are_refused():
    with pytest.raises(UsageError, match="selection"):
        printed("request", "time-reversal")
    with pytest.raises(UsageError, match="got both"):
        printed("request", "pendulum", "--json", "--text")


def test_the_version_is_told():
    assert printed("--version") == f"refdem {__version__}\n"


@pytest.mark.parametrize("command", ["run", "gate", "truth", "request"])
def test_a_short_option_helps(command):
    assert printed(command, "-h") == printed(command, "--help")
