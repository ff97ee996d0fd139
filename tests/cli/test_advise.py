"""`refdem advise` and `refdem compare`: an answer in one command."""

import json

import pytest
from typer.testing import CliRunner

from refdem.cli.advise import MOST_ROWS, labels_found, table
from refdem.cli.app import app
from refdem.core import discovery
from refdem.core.case import Canonical
from refdem.core.finding import Record
from refdem.errors import UsageError
from refdem.report.advice import Choice, recommendations


@pytest.fixture(autouse=True)
def _own_store(tmp_path, monkeypatch):
    monkeypatch.setenv("REFDEM_STORE", str(tmp_path / "store.sqlite"))


def called(*arguments: str):
    """The result of the command; raises what it raises."""
    done = CliRunner().invoke(app, list(arguments), catch_exceptions=False)
    if done.exception is not None and not isinstance(done.exception, SystemExit):
        raise done.exception
    return done


PENDULUM = ("pendulum", "--set", "theta0=1/2", "--set", "duration=2", "--set", "samples=8")


def test_the_advised_step_is_one_that_holds_the_digits():
    asked = ("advise", *PENDULUM, "--engine", "reference", "--jobs", "1", "--digits", "3")
    done = called(*asked, "--json")
    answer = json.loads(done.stdout)
    assert done.exit_code == 0
    methods = {one["method"]: one for one in answer["methods"]}
    assert methods["exact-pendulum"]["holds"]
    for one in methods.values():
        for setting in one["settings"]:
            assert setting["level"] is None or setting["error"] <= 1e-3 * (1 + 1e-12)
    text = called(*asked).stdout
    assert text.startswith("3 digits: errors of at most 0.001 of each quantity's scale")
    assert "reference/exact-pendulum: exact at any step, in the only setting" in text


def test_digits_that_no_method_holds_are_exit_status_1():
    asked = ("advise", *PENDULUM, "--engine", "pymunk", "--jobs", "1", "--digits", "12")
    done = called(*asked)
    assert done.exit_code == 1
    assert "does not hold 12 digits in the only setting that it can run" in done.stdout


def test_an_engine_that_cannot_say_the_case_is_exit_status_2():
    done = called("advise", "heavy-top", "--engine", "pymunk", "--jobs", "1")
    assert done.exit_code == 2
    assert "pymunk: not measured in 1 of 1\n    The engine does not support" in done.stdout
    assert "(heavy-top)\n" in done.stdout


def test_a_word_that_is_no_case_asks_for_the_cases_that_it_finds():
    asked = ("advise", "gyroscopes", "--engine", "pymunk", "--jobs", "1")
    done = called(*asked)
    assert "pymunk: not measured in 3 of 3\n" in done.stdout
    for case in ("free-rigid-body", "heavy-top", "neglected-gyroscopic"):
        assert case in done.stdout


def test_words_of_one_thing_find_the_cases_that_have_all_of_them():
    assert labels_found(["bouncing", "ball"]) == ["bouncing-ball"]
    assert labels_found(["pendulum[theta0=1]", "gear"]) == [
        "pendulum[theta0=1]",
        "degrees-of-freedom",
        "pendulum-wheel-mass",
    ]


def test_words_of_several_things_find_the_cases_of_each_once():
    found = labels_found(["snooker", "pool"])
    assert found == ["billiard-break"]
    found = labels_found(["snooker", "kepler", "pool"])
    assert sorted(found) == ["billiard-break", "billiards", "two-body-orbit"]


def test_a_word_that_finds_nothing_is_refused():
    with pytest.raises(UsageError, match="no case 'teapot'"):
        called("advise", "teapot")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((), "got neither"),
        (("pendulum", "--motion", "swinging"), "got both"),
        (("--motion", "swiming"), "did you mean 'swinging'"),
        (("--motion", "formula"), "no motion is named"),
        (("--motion", "swinging", "--set", "theta0=1"), "set their own parameters"),
    ],
)
def test_a_question_that_makes_no_sense_is_refused(arguments, message):
    with pytest.raises(UsageError, match=message):
        called("advise", *arguments)


def test_every_case_says_what_happens_in_it():
    cases = [discovery.case(name) for name in discovery.own_names("cases")]
    silent = [case.id for case in cases if isinstance(case, Canonical) and case.motion == "other"]
    assert silent == []


def test_engines_are_compared_in_a_case_the_cheapest_method_first():
    case = "pendulum[theta0=0.5 duration=2 samples=8]"
    done = called("compare", "reference", "pymunk", "--case", case, "--jobs", "1")
    table, *_ = done.stdout.split("\n\n")
    lines = table.splitlines()
    assert done.exit_code == 0
    assert lines[0].startswith("pendulum[")
    assert lines[1].split()[:4] == ["method", "digits", "order", "step"]
    costs = [float(line[lines[1].index("cost") :].split()[0]) for line in lines[2:]]
    assert costs == sorted(costs)
    assert any(line.split()[0] == "pymunk/semi-implicit-euler" for line in lines[2:])
    assert all(line.split()[-1] == "holds" for line in lines[2:])


def test_who_cannot_say_a_case_is_told_with_the_reason():
    done = called("compare", "pymunk", "--case", "heavy-top", "--jobs", "1")
    assert done.exit_code == 2
    assert "pymunk: not measured in 1 of 1\n" in done.stdout
    assert "    The engine does not support motion or rotation in three" in done.stdout
    assert "(heavy-top)" in done.stdout


def test_a_comparison_ends_with_one_sentence_that_answers():
    case = "pendulum[theta0=0.5 duration=2 samples=8]"
    done = called("compare", "reference", "pymunk", "--case", case, "--jobs", "1")
    last = done.stdout.splitlines()[-1]
    assert last.startswith("For 3 digits in 1 setting: reference/")
    assert "costs least; pymunk/semi-implicit-euler takes " in last
    assert last.endswith(" times as long.")
    done = called("compare", "pymunk", "--case", case, "--digits", "12", "--jobs", "1")
    assert (
        done.stdout.splitlines()[-1] == "For 12 digits in 1 setting: no method holds them in any."
    )


def test_a_reason_that_refuses_several_settings_is_told_once():
    cases = ("heavy-top", "heavy-top[spin=2]")
    done = called("compare", "pymunk", *(f"--case={case}" for case in cases), "--jobs", "1")
    (line,) = [line for line in done.stdout.splitlines() if "does not support" in line]
    assert line.endswith("(heavy-top (2 settings))")


def test_a_run_tells_its_outcome_as_json(tmp_path):
    out = tmp_path / "report"
    asked = ("run", *PENDULUM, "--engine", "reference", "--method", "exact-pendulum")
    done = called(*asked, "--jobs", "1", "--out", str(out), "--json")
    answer = json.loads(done.stdout)
    assert answer["exit_status"] == done.exit_code == 0
    assert set(answer["outcomes"]) <= {"pass", "undecided"}
    assert answer["broken"] == []
    assert answer["report"] == str(out / "index.html")


def test_a_refusal_is_in_the_json_of_a_run_with_its_reason(tmp_path):
    asked = ("run", "heavy-top", "--engine", "pymunk", "--jobs", "1", "--out", str(tmp_path))
    done = called(*asked, "--json")
    answer = json.loads(done.stdout)
    assert answer["exit_status"] == done.exit_code == 2
    assert answer["unjudged"][0].startswith("heavy-top/pymunk")


def choice(case: str, number: int, step: float) -> Choice:
    """A choice of one method in one of the settings of a case."""
    record = Record(
        case=case,
        label=f"{case}[mass={number}]",
        parameters={},
        engine="e",
        version="1",
        method="m",
        is_reference=False,
        runs=(),
        findings=(),
    )
    return Choice(record=record, control="step", tau=1.0, level=step, error=1e-4, cost=1.0)


def test_of_more_settings_than_fit_a_screen_each_case_shows_the_one_that_asks_most():
    many = [choice("a", number, 1 / number) for number in range(1, MOST_ROWS + 1)]
    few = table(recommendations(many))
    assert len(few) == 1 + MOST_ROWS
    grouped = table(recommendations([*many, choice("b", 1, 0.5)]))
    assert [line.split()[0] for line in grouped[1:3]] == [f"a[mass={MOST_ROWS}]", "b[mass=1]"]
    assert grouped[3].startswith("one row per case")


@pytest.mark.parametrize("option", [("--digits", "3"), ("--engine", "mujoco"), ("--jobs", "1")])
def test_an_option_that_means_nothing_with_rules_is_refused(option):
    with pytest.raises(UsageError, match=f"got {option[0]} with --rules"):
        called("advise", "two-spheres", "--rules", *option)


def test_rules_list_settings_without_contacts_and_judge_the_others(tmp_path):
    asked = ("advise", "two-spheres", "hertz-spheres", "pendulum", "--rules", "--json")
    done = called(*asked, "--out", str(tmp_path / "steps"))
    assert done.stderr.startswith("pendulum: got a scene without spheres")
    rows = json.loads(done.stdout)
    assert {row["setting"] for row in rows} == {"two-spheres", "hertz-spheres"}
    page = (tmp_path / "steps" / "steps.md").read_text()
    assert page.count("| two-spheres |") + page.count("| hertz-spheres |") == len(rows)
