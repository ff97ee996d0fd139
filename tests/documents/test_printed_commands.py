"""Every command that a committed page, or the help of a command, prints is one that works.

REFDEM_RANDOM_SETTINGS (at night) asks for certified derivatives of smooth motions at the times that
are printed; by day those times are shorter.
"""

import os
import re
import shlex
import subprocess
from collections.abc import Callable, Iterator
from fractions import Fraction
from math import ceil
from pathlib import Path
from typing import Any

import pytest
import typer

from refdem.cli.app import app
from refdem.cli.run import specification_of
from refdem.core import discovery
from refdem.gallery.gallery import names as figures
from refdem.planning import plan
from refdem.planning.specification import Specification
from refdem.stress.selection import names as batteries
from refdem.truth.sensitivities import HasEquation
from refdem.truth.validated_flow import ValidatedFlow
from tests.random_settings import SHORT

ROOT = Path(__file__).parents[2]
Answered = Callable[..., "subprocess.CompletedProcess[str]"]
COMMANDS: dict[str, Any] = typer.main.get_command(app).commands  # type: ignore[attr-defined]
CONTRIBUTED = "hop"
"""The engine that CONTRIBUTING writes; its own test puts it in place."""
PLACEHOLDER = re.compile(r"\b[A-Z]{3,}\b|\.toml\b|\.\.\.")
"""A word that stands for something of the reader's: DIR, mine.toml."""


def cleaned(text: str) -> str:
    """A command without its prompt, its folder, the comment behind it, and what is done if it
    fails.
    """
    alone = re.sub(r"\s+(# |\|\| ).*", "", text.strip())
    return re.sub(r"^(\$ )?(\.venv/bin/)?", "", alone)


def of_page(text: str) -> Iterator[str]:
    """Commands in code: lines of blocks, and code within a line."""
    is_block = False
    for line in text.splitlines():
        if line.lstrip().startswith("```"):
            is_block = not is_block
        else:
            yield from map(cleaned, [line] if is_block else re.findall(r"`([^`]+)`", line))


def printed() -> dict[str, str]:
    """Every command with a place where it is printed."""
    listed = subprocess.run(
        ["git", "ls-files", "*.md"], cwd=ROOT, check=True, capture_output=True, text=True
    )
    pages = {name: list(of_page((ROOT / name).read_text())) for name in listed.stdout.split()}
    examples = re.compile(r"Example: (refdem .*)")
    pages |= {
        f"refdem {name} --help": examples.findall(command.help or "")
        for name, command in COMMANDS.items()
    }
    return {
        command: name
        for name, found in pages.items()
        for command in found
        if re.match(r"(refdem|make) [a-z]", command)
    }


PRINTED = printed()


def words_of(name: str) -> list[list[str]]:
    """The words after `refdem NAME` of every such command, without those that hold a
    placeholder.
    """
    found = [shlex.split(command) for command in PRINTED if command.startswith(f"refdem {name} ")]
    return [words[2:] for words in found if not PLACEHOLDER.search(" ".join(words))]


def parsed(name: str, words: list[str]) -> dict[str, object]:
    """The options and arguments as the command itself reads them; it raises where it does not know
    one.
    """
    return COMMANDS[name].make_context(name, list(words)).params


def test_pages_print_commands_of_every_kind() -> None:
    names = {command.split()[1] for command in PRINTED if command.startswith("refdem ")}
    assert names == set(COMMANDS)


@pytest.mark.parametrize(
    "command", [command for command in PRINTED if command.startswith("refdem ")]
)
def test_a_printed_command_is_read_by_the_command_itself(command: str) -> None:
    _, name, *words = shlex.split(command)
    if words:  # alone, `refdem truth` is the name of a command
        parsed(name, words)


@pytest.mark.parametrize("command", [command for command in PRINTED if command.startswith("make ")])
def test_a_printed_target_is_one_of_the_makefile(command: str) -> None:
    targets = re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE)
    assert command.split()[1] in targets


ABOUT_CASES = [*words_of("run"), *(words for words in words_of("explain") if words[0][0] != "-")]
"""Of commands that name a case first."""


@pytest.mark.parametrize("words", ABOUT_CASES, ids=" ".join)
def test_what_a_page_says_to_run_is_run_by_every_engine_that_it_names(words: list[str]) -> None:
    found = parsed("run", words)
    case = found["case"]
    cases = [case] if isinstance(case, str) else [str(one) for one in case or ()]  # type: ignore[attr-defined]
    campaign = str(found.get("campaign") or "")
    specification = specification_of(cases, list(found["set"] or ()), campaign)  # type: ignore[call-overload]
    wanted = Specification(
        name="printed", case=specification.case, engines=list(found["engine"] or ["reference"])
    )  # type: ignore[call-overload]
    # By name, so that an engine that is missing fails.
    engines = [discovery.engine(name) for name in wanted.engines]
    assert engines
    assert not [engine.name for engine in engines if engine.missing()]
    for instance, only in plan.instances(wanted):
        for engine in engines:
            tasks = plan.tasks(wanted, instance, only, engine, None)
            assert any(task.unsupported is None for task in tasks), (
                f"{engine.name} runs no {instance.label}"
            )


AT_NIGHT = "REFDEM_RANDOM_SETTINGS" in os.environ


def is_integrated(words: list[str]) -> bool:
    """True if a question is for derivatives of a smooth motion: the whole motion up to the time is
    then integrated five times, which costs as much as the time is long.
    """
    found = parsed("truth", words)
    if not found["sensitivities"]:
        return False
    given = dict(str(text).split("=", 1) for text in found["set"] or ())  # type: ignore[call-overload]
    truth = discovery.case(str(found["case"])).at(**given).truth()
    return isinstance(truth, ValidatedFlow | HasEquation)


def asked_early(words: list[str]) -> list[str]:
    """A question with a SHORT part of its times: what a formula lacks, it lacks from the start."""
    place = words.index("--at") + 1
    times = [Fraction(text) * SHORT for text in words[place].split(",")]
    if discovery.case(words[0]).at().problem.kind == "iteration":
        times = [Fraction(ceil(n)) for n in times]
    return [*words[:place], ",".join(str(t) for t in times), *words[place + 1 :]]


def test_a_question_that_is_asked_early_is_the_same_but_for_its_times() -> None:
    words = ["duffing", "--sensitivities", "--at", "21,4.8", "--digits", "8"]
    assert asked_early(words) == ["duffing", "--sensitivities", "--at", "21/16,3/10", *words[4:]]
    iterates = ["lorenz", "--sensitivities", "--at", "21"]
    assert asked_early(iterates) == ["lorenz", "--sensitivities", "--at", "2"]


def test_motions_through_events_and_without_an_integration_are_asked_at_the_printed_time() -> None:
    early = {words[0] for words in words_of("truth") if is_integrated(words)}
    assert {"coupled-pendulums", "double-pendulum", "lorenz", "rigid-cluster"} <= early
    assert early.isdisjoint({"bouncing-ball", "coulomb-oscillator", "logistic", "stick-slip"})


@pytest.mark.parametrize("words", words_of("truth"), ids=" ".join)
def test_a_printed_question_for_the_truth_is_answered(
    words: list[str], command_line: Answered
) -> None:
    if is_integrated(words) and not AT_NIGHT:
        words = asked_early(words)
    done = command_line("truth", *words)
    assert done.returncode == 0, done.stderr
    assert done.stdout


@pytest.mark.parametrize("name", ["list", "schema", "doctor"])
def test_a_printed_command_that_only_tells_tells_something(
    name: str, command_line: Answered
) -> None:
    for words in words_of(name):
        done = command_line(name, *words)
        assert done.returncode == 0, done.stderr
        assert done.stdout


def test_printed_figures_batteries_cases_and_engines_exist() -> None:
    for words in words_of("gallery"):
        assert set(parsed("gallery", words)["figure"] or ()) <= set(figures())  # type: ignore[call-overload]
    for name in ("stress", "bench", "smoke"):
        for words in words_of(name):
            found = parsed(name, words)
            assert set(found.get("battery") or ()) <= set(batteries())  # type: ignore[call-overload]
            engines = found.get("engine") or ()
            for engine in [engines] if isinstance(engines, str) else engines:  # type: ignore[union-attr]
                assert engine in (*discovery.names("engines"), CONTRIBUTED)
            for case in found.get("case") or ():  # type: ignore[union-attr]
                assert str(case).partition("[")[0] in discovery.names("cases")
