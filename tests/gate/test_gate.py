"""The gate opens for what was accepted, and closes for what is wrong, worse, lost or absent."""

import json
import re
import xml.etree.ElementTree as ElementTree

import pytest

from refdem.gate import baseline


def test_without_a_baseline_the_gate_is_closed_and_says_how_to_bless(program):
    done = program.gate()
    assert done.returncode == 1
    assert "refdem gate --bless --why" in done.stdout


def test_a_blessed_program_passes_and_a_comment_changes_nothing(program):
    program.bless()
    program.spoil('"""usage: spring.py REQUEST TRAJECTORY"""', "# the same program")
    done = program.gate("--junit", "gate.xml", "--markdown", "gate.md")
    assert done.returncode == 0, done.stdout
    assert done.stdout.splitlines()[-1] == "the gate of spring is open"
    assert "is open" in (program.folder / "gate.md").read_text()
    suite = ElementTree.parse(program.folder / "gate.xml").getroot()
    assert len(list(suite.iter("testcase"))) > 5
    assert not list(suite.iter("failure"))


def test_a_flipped_sign_closes_the_gate_although_the_version_stays(program):
    program.bless()
    program.spoil("x += h * v", "x -= h * v")
    done = program.gate("--junit", "gate.xml", "--markdown", "gate.md")
    assert done.returncode == 1
    assert "FAIL" in done.stdout
    assert "/spring/leapfrog/error/x" in done.stdout
    text = (program.folder / "gate.md").read_text()
    assert "is closed" in text
    assert "refdem run harmonic-oscillator" in text
    assert len(text.splitlines()) < 60
    assert list(ElementTree.parse(program.folder / "gate.xml").getroot().iter("failure"))


def test_what_closes_a_gate_is_told_to_a_code_host_at_the_claims_of_the_program(program):
    program.bless()
    assert program.gate("--sarif", "gate.sarif").returncode == 0
    assert sarif_run(program)["results"] == []
    program.spoil("x += h * v", "x -= h * v")
    assert program.gate("--sarif", "gate.sarif").returncode == 1
    run = sarif_run(program)
    rules = [rule["id"] for rule in run["tool"]["driver"]["rules"]]
    results = run["results"]
    assert "error" in rules
    names = [result["message"]["text"].split(": ")[0] for result in results]
    assert "harmonic-oscillator/spring/leapfrog/error/x" in names
    for result in results:
        assert rules[result["ruleIndex"]] == result["ruleId"]
        (place,) = result["locations"]
        assert (program.folder / place["physicalLocation"]["artifactLocation"]["uri"]).is_file()
    fingerprints = {result["partialFingerprints"]["finding/v1"] for result in results}
    assert len(fingerprints) == len(results)


def sarif_run(program):
    """The one run of the SARIF file that the gate wrote."""
    document = json.loads((program.folder / "gate.sarif").read_text())
    assert document["version"] == "2.1.0"
    (run,) = document["runs"]
    return run


def test_an_error_constant_that_doubles_is_worse_although_it_holds_its_bound(program):
    program.bless()
    program.spoil(
        "                x += h * v\n", "                x += h * v * (1 + 0.1 * h * h)\n"
    )
    done = program.gate()
    assert done.returncode == 1
    assert "WORSE" in done.stdout
    assert "more than the factor 1.5" in done.stdout


def test_a_method_that_can_no_longer_be_judged_is_lost(program):
    program.bless()
    program.spoil("import json, sys\n", "import json, sys\nsys.exit(77)\n")
    done = program.gate()
    assert done.returncode == 1
    assert done.stdout.count("LOST") == 1
    assert "ABSENT" not in done.stdout
    assert "not supported (exit status 77)" in done.stdout


def test_an_accepted_finding_that_is_gone_is_absent(program):
    program.bless()
    text = (program.folder / "refdem.toml").read_text()
    (program.folder / "refdem.toml").write_text(text.replace("symplectic = true\n", ""))
    done = program.gate()
    assert done.returncode == 1
    assert "ABSENT" in done.stdout
    assert "energy/drift" in done.stdout


def test_blessing_needs_a_reason_and_shows_what_it_changes(program):
    assert program.gate("--bless").returncode == 2
    assert not (program.folder / "refdem-baseline.jsonl").exists()
    first = program.gate("--bless", "--why", "it was looked at").stdout.splitlines()
    assert first[0].endswith(" findings accepted")
    assert "fail" not in first[1]
    program.spoil(
        "                x += h * v\n", "                x += h * v * (1 + 0.1 * h * h)\n"
    )
    done = program.gate("--bless", "--why", "the scheme was changed")
    assert "~ harmonic-oscillator/spring/leapfrog/error/x: pass" in done.stdout
    header = json.loads((program.folder / "refdem-baseline.jsonl").read_text().splitlines()[0])
    assert header["why"] == "the scheme was changed"


def test_a_blessing_says_in_one_line_that_failures_do_not_open_the_gate(program):
    program.bless()
    program.spoil("x += h * v", "x -= h * v")
    done = program.gate("--bless", "--why", "the scheme was changed")
    assert done.returncode == 1
    (said,) = [line for line in done.stdout.splitlines() if "of them fail" in line]
    assert int(said.split()[0]) == done.stdout.count("\nFAIL")
    assert "which no baseline can accept" in said


def test_of_many_changes_of_a_kind_some_are_shown_and_the_others_counted():
    before = {
        name: baseline.Accepted(id=name, outcome="pass", value=1.0)
        for name in (f"a/b/c/d/{number:02}" for number in range(23))
    }
    *shown, last = baseline.differences(before, [])
    assert shown == [f"- {name}: pass" for name in list(before)[:20]]
    assert last == "- and 3 more that are gone"
    assert baseline.differences({}, []) == []


@pytest.mark.parametrize("character", ["\n", "\r", "\x1b", "\u2028", "\x85", "\u202e"])
def test_an_id_that_does_not_print_is_no_id_of_a_baseline(program, character):
    program.bless()
    path = program.folder / "refdem-baseline.jsonl"
    name = f"harmonic-oscillator/spring/leapfrog/order/x{character}::error::y"
    with path.open("a") as file:
        file.write(json.dumps({"id": name, "outcome": "pass"}) + "\n")
    for words in ([], ["--bless", "--why", "because"]):
        done = program.gate(*words)
        assert done.returncode == 2
        assert "characters that do not print" in done.stderr
        assert character not in (done.stdout + done.stderr).removesuffix("\n")


def test_what_a_blessing_shows_is_no_command_of_a_workflow(program):
    program.bless()
    path = program.folder / "refdem-baseline.jsonl"
    header, *accepted = path.read_bytes().splitlines()
    accepted.append(json.dumps({"id": "##[error]/a/b/c/d", "outcome": "pass"}).encode())
    fits = {"findings": len(accepted), "sha256": baseline.digest(accepted)}
    first = json.dumps(json.loads(header) | fits).encode()
    path.write_bytes(b"\n".join([first, *accepted]) + b"\n")
    done = program.gate("--bless", "--why", "because")
    assert "- # #[error]/a/b/c/d: pass" in done.stdout


def test_a_crash_is_an_error_and_exit_3_while_nothing_failed(program):
    program.bless()
    program.spoil("import json, sys\n", "import json, sys\nimport os\nos.abort()\n")
    done = program.gate("--markdown", "gate.md")
    assert done.returncode == 3  # what the baseline has is gone, and follows from the crash
    first, second, *_ = done.stdout.splitlines()
    assert first.startswith("ERROR")
    assert "signal 6" in second
    assert "findings of the baseline could not be made" in second
    assert "ABSENT" not in done.stdout
    table = [
        line
        for line in (program.folder / "gate.md").read_text().splitlines()
        if line.startswith("| ")
    ]
    assert len(table) == 2
    assert table[1].startswith("| error |")


def test_what_fails_beside_a_crash_is_shown_after_the_crash(program):
    program.bless()
    program.spoil("x += h * v", "x -= h * v")
    program.spoil("if times[1] < times[0]:\n", "if times[1] < times[0]:\n    sys.exit(5)\n")
    done = program.gate()
    assert done.returncode == 1
    assert done.stdout.startswith("ERROR")
    assert "FAIL" in done.stdout


def test_a_program_that_answers_77_in_part_is_an_error(program):
    program.bless()
    program.spoil(
        "import json, sys\nrequest = json.load(open(sys.argv[1]))\n",
        "import json, sys\nrequest = json.load(open(sys.argv[1]))\n"
        "if request['step'] < 0.05:\n    sys.exit(print('too fine', file=sys.stderr) or 77)\n",
    )
    done = program.gate()
    assert done.returncode == 3, done.stdout
    assert "too fine" in done.stdout
    assert "at every step and in every variant" in done.stdout


def test_a_program_may_refuse_the_pictures_that_it_names_and_no_others(program):
    text = (program.folder / "refdem.toml").read_text()
    assert 'may_refuse = ["shifted"]' in text
    done = program.gate("--out", "report")
    assert (
        "harmonic-oscillator/spring/leapfrog/symmetry/shifted"
        in (program.folder / "report" / "junit.xml").read_text()
    )
    (program.folder / "refdem.toml").write_text(text.replace('["shifted"]', '["rotated"]'))
    done = program.gate()
    assert "springs hang at the origin only" in done.stdout
    assert done.stdout.startswith("ERROR")


def test_what_crashes_cannot_be_accepted_and_leaves_the_baseline_alone(program):
    program.bless()
    before = (program.folder / "refdem-baseline.jsonl").read_bytes()
    program.spoil("import json, sys\n", "import json, sys\nsys.exit(1)\n")
    done = program.gate("--bless", "--why", "it must be right")
    assert done.returncode == 2
    assert "nothing was decided" in done.stderr
    assert (program.folder / "refdem-baseline.jsonl").read_bytes() == before


def test_the_gate_says_what_it_would_have_noticed_and_a_misreading_of_that_size_closes_it(program):
    program.bless()
    done = program.gate("--resolution")
    assert done.returncode == 0, done.stdout
    (said,) = [line for line in done.stdout.splitlines() if "Would have noticed" in line]
    assert said.startswith("harmonic-oscillator, leapfrog: ")
    size = float(re.search(r"stiffness of the spring ([0-9.e-]+)", said)[1])
    assert 0 < size < 1e-6
    program.spoil('spring["stiffness"] /', f'spring["stiffness"] * (1 + {2 * size!r}) /')
    assert program.gate().returncode == 1
