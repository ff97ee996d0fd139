"""The tools that plant errors: what they plant, whom they blame, and what they leave behind."""

import signal
from pathlib import Path

import mutant_sites
import pytest
import tree_copy
from executed_lines import Executed
from mutants import STARTED, Judge

ROOT = Path(__file__).parents[3]

MODULE = """
LIMIT = 2.0

def inside(x):
    return 0.0 < x and x < LIMIT
"""


@pytest.fixture
def copy(tmp_path):
    """A copy with nothing in it but what runs the tests, and a way to write one."""
    place = tmp_path / "copy"
    (place / "ci" / "mutants").mkdir(parents=True)
    plugin = "ci/mutants/current_test.py"
    (place / plugin).write_text((ROOT / plugin).read_text())

    def tested(text, seconds=None, tests=("test_own.py",)):
        (place / "test_own.py").write_text(text)
        return tree_copy.TreeCopy(place).tested(list(tests), 60.0, seconds=seconds)

    return tested


def test_every_operator_comparison_and_constant_is_a_site(tmp_path):
    (tmp_path / "module.py").write_text(MODULE)
    text = MODULE.encode()
    found = {
        (site.shown(text), site.is_inside) for site in mutant_sites.sites(tmp_path, "module.py")
    }
    assert found == {
        ("2.0 -> 3.0", False),
        ("0.0 -> 1.0", True),
        ("< -> <=", True),
        ("and -> or", True),
    }


def test_a_failure_has_the_name_of_its_test(copy):
    ended = copy("def test_good():\n    pass\n\ndef test_bad():\n    assert False\n")
    assert ended.status == 1
    assert ended.failed == ("test_own.py::test_bad",)


def test_a_test_that_is_no_longer_there_is_told_and_blames_nothing(copy, tmp_path):
    asked = ("test_own.py::test_good", "test_own.py::test_that_was[2-a]")
    ended = copy("def test_good():\n    pass\n", tests=asked)
    assert ended.status == tree_copy.NOT_FOUND
    assert ended.failed == ()
    there = tree_copy.TreeCopy(tmp_path / "copy").collected(["test_own.py"], 60.0)
    assert there == {"test_own.py::test_good"}


def test_a_crash_has_the_name_of_its_test(copy):
    ended = copy("import os\n\ndef test_crash():\n    os.abort()\n")
    assert ended.status == -signal.SIGABRT
    assert ended.failed == ("test_own.py::test_crash",)


def test_a_test_that_never_ends_is_ended_by_its_own_use_of_the_processor(copy):
    ended = copy(
        "def test_hang():\n    while True:\n        pass\n",
        seconds={"test_own.py::test_hang": -0.99},
    )
    assert ended.status == -signal.SIGPROF
    assert ended.failed == ("test_own.py::test_hang",)


def test_what_tests_pass_is_green(copy):
    assert not copy("def test_good():\n    pass\n").is_red


def test_no_process_is_left_even_of_those_that_left_their_group(copy, tmp_path):
    told = tmp_path / "child"
    lines = [
        "import subprocess",
        "def test_child():",
        "    child = subprocess.Popen(['sleep', '600'], start_new_session=True)",
        f"    open({str(told)!r}, 'w').write(str(child.pid))",
        "    assert False",
    ]
    assert copy("\n".join(lines)).is_red
    state = Path("/proc") / told.read_text() / "stat"
    # What is dead may still wait for the process that adopted it to look.
    assert not state.exists() or state.read_text().rpartition(")")[2].split()[0] == "Z"


def names(tmp_path, file, text):
    """The names of all sites of a text: what they are, without their places in the file."""
    (tmp_path / file).write_text(text)
    return {
        (site.scope, site.number, site.instead, site.shown(text.encode()))
        for site in mutant_sites.sites(tmp_path, file)
    }


PYTHON_PAIR = """
def first(x):
    '''The docstring of the first.'''
    return x + 1.0

def second(x):
    return x * x
"""
C_PAIR = """
static double first(double x) {
    /* The comment of the first. */
    return x + 1.0;
}
static double second(double x) {
    return x * x;
}
"""


@pytest.mark.parametrize(("file", "text"), [("pair.py", PYTHON_PAIR), ("pair.c", C_PAIR)])
def test_a_site_keeps_its_name_while_the_code_of_its_function_stays(tmp_path, file, text):
    before = names(tmp_path, file, text)
    assert len(before) == 3
    moved = "\n\n" + text.replace("of the first", "of another day")
    assert names(tmp_path, file, moved) == before
    after = names(tmp_path, file, text.replace("x * x", "x / x"))
    assert len(after & before) == 2


def test_what_an_assert_says_is_no_site(tmp_path):
    text = "static double f(double x)\n{\n    assert(x > 1.0 && x < 4.0);\n    return x + x;\n}\n"
    assert len(names(tmp_path, "asserted.c", text)) == 1


def test_functions_of_equal_code_do_not_share_their_sites(tmp_path):
    text = "def twin(x):\n    return x + x\n"
    assert len(names(tmp_path, "twins.py", text + text)) == 2


DECLARED = """
static double f(double x)
{
    double all[3], last[1], some[N + 1];
    all[2] = x;
    return all[2];
}
"""


def test_only_a_larger_array_is_room_that_nobody_uses(tmp_path):
    (tmp_path / "declared.c").write_text(DECLARED)
    found = {
        (site.kind, site.shown(DECLARED.encode()))
        for site in mutant_sites.sites(tmp_path, "declared.c")
    }
    assert found == {
        ("room", "3 -> 4"),
        ("constant", "1 -> 0"),
        ("operator", "+ -> -"),
        ("constant", "2 -> 3"),
        ("statement", "all[2] = x; -> ;"),
    }


def test_a_site_of_c_knows_the_end_of_its_function(tmp_path):
    (tmp_path / "declared.c").write_text(DECLARED)
    ends = {site.until for site in mutant_sites.sites(tmp_path, "declared.c")}
    assert ends == {len(DECLARED) - 1}


def executed(name, seconds, **lines):
    """A test that runs lines of files, named without their endings."""
    return Executed(name, seconds, {f"{file}.{end}": set(at) for file, (end, at) in lines.items()})


def shown(lots):
    """The names of the tests of all lots."""
    return [test.test for lot in lots for test in lot]


def test_a_declaration_is_shown_to_those_that_run_what_follows_it(tmp_path):
    (tmp_path / "declared.c").write_text(DECLARED)
    tests = [
        executed("a.py::follows", 1.0, declared=("c", [6])),
        executed("b.py::elsewhere", 1.0, declared=("c", [40])),
    ]
    sites = mutant_sites.sites(tmp_path, "declared.c")
    (site,) = (site for site in sites if site.kind == "operator")
    lots = Judge(tests, {}, 1).lots(site, DECLARED.encode())
    assert shown(lots) == ["a.py::follows"]


def test_what_runs_in_a_process_of_its_own_is_shown_to_those_that_start_it(tmp_path):
    ((path, starter),) = STARTED.items()
    tests = [
        Executed("a.py::starts", 2.0, {starter: {200}}),
        Executed("b.py::runs", 1.0, {path: {3}}),
        Executed("c.py::neither", 1.0, {path: {9}}),
    ]
    text = "def f(x):\n    if x:\n        return x + 1.5\n"
    (tmp_path / Path(path).parent).mkdir(parents=True)
    (tmp_path / path).write_text(text)
    site = mutant_sites.sites(tmp_path, path)[0]
    assert shown(Judge(tests, {}, 1).lots(site, text.encode())) == ["b.py::runs", "a.py::starts"]
