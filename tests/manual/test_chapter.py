"""Every equation, figure, table and exercise of the source chapter has a case that runs it, and a
check that is seen to kill what the table of the manual says that it kills.
"""

import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from refdem.core import discovery
from refdem.core.selection import Selection
from refdem.faults.catalogue import chosen
from refdem.faults.settings import SETTINGS
from refdem.gallery import gallery
from refdem.kills.trials import FaultTrial
from refdem.manual.chapter import SPOILED, cited, engines, items, lines, named
from refdem.planning.in_process import record_of, task_of, truth_of
from refdem.report.manual import chapter_markdown

ITEMS = items()
FAULTS = sorted({item.kills for item in ITEMS if item.kills})
WHOLE = {
    *(f"(1.{number})" for number in range(1, 145)),
    *(f"figure 1.{number}" for number in range(1, 39)),
    *("Table 1.1", "Table 1.2"),
    *(f"exercise 1.1 {part}" for part in "ab"),
    *(f"exercise 1.2 {part}" for part in "abcde"),
    "exercise 1.3",
}
"""All that has a number in the chapter."""
BLAMED = ("fail", "error")
PAGES = Path(__file__).parents[2] / "reports" / "manual"


@cache
def table():
    """The lines of the table; what every engine supports is asked once."""
    return list(lines(gallery.names()))


def name_of(item):
    return f"{item.where}: {item.case}"


@cache
def findings_of(case, given, check, method=""):
    """The findings of one check on a method of the reference, the best one unless it is named."""
    instance = discovery.case(case).at(**dict(given))
    reference = discovery.engine("reference")
    chosen_method = method or reference.best(instance.problem).name
    task = task_of(reference, chosen_method, instance, truth_of(instance), 3, [check])
    return record_of(task).findings


def judged(item):
    return findings_of(item.case, tuple(item.set.items()), item.check, item.method)


def of_any_method(item):
    """The findings of the check of an item, on the best method of the reference first: others may
    have a quantity that an exact one has not.
    """
    yield from judged(item)
    instance = item.instance
    reference = discovery.engine("reference")
    for method in reference.methods:
        answers = method.answers == instance.problem.kind
        if answers and reference.unsupported(instance.problem, method) is None:
            yield from findings_of(item.case, tuple(item.set.items()), item.check, method.name)


def test_nothing_that_has_a_number_in_the_chapter_is_left_out() -> None:
    assert named() == WHOLE


def test_a_place_is_read_one_by_one() -> None:
    assert cited("(1.9)-(1.11), (1.20), figure 1.4, exercise 1.2 b, section 1.6.4, Table 1.1") == {
        "(1.9)",
        "(1.10)",
        "(1.11)",
        "(1.20)",
        "figure 1.4",
        "exercise 1.2 b",
        "Table 1.1",
    }


def cited_as_source(source):
    """What a case cites: "(1.44) to (1.91)" is of a wide range its ends, "figs. 1.18-1.20 and
    1.22" four figures.
    """
    found = cited(source)
    for listed in re.findall(r"figs?\. ((?:1\.\d+[a-d]?(?:-1\.\d+)?(?:, | and )?)+)", source):
        for first, last in re.findall(r"1\.(\d+)[a-d]?(?:-1\.(\d+))?", listed):
            found |= {f"figure 1.{n}" for n in range(int(first), int(last or first) + 1)}
    return found


def test_figures_of_a_source_are_read_one_by_one() -> None:
    assert cited_as_source("(1.112), figs. 1.3a, 1.18-1.20 and 1.22; k = 1.5, fig. 1.34") == {
        "(1.112)",
        *(f"figure 1.{n}" for n in (3, 18, 19, 20, 22, 34)),
    }


def test_what_a_case_cites_as_its_source_is_an_item_of_that_case() -> None:
    """The two say the same, so that neither can grow old alone."""
    lacking = {}
    for name in discovery.names("cases"):
        case = discovery.case(name)
        if isinstance(case, Selection) or "Matuttis" not in case.source:
            continue
        known = set().union(*(cited(item.where) for item in ITEMS if item.case == name))
        # An exercise without a part is the whole of it.
        known |= {place[: -len(" a")] for place in known if place.startswith("exercise")}
        lacking[name] = sorted(cited_as_source(case.source) - known)
    assert {name: found for name, found in lacking.items() if found} == {}


@pytest.mark.parametrize("item", ITEMS, ids=name_of)
def test_the_reference_runs_each_item_and_its_check_judges_it(item) -> None:
    assert "reference" in list(engines(item))
    findings = judged(item)
    outcomes = [finding.outcome for finding in findings]
    assert "pass" in outcomes, [finding.sentence for finding in findings]
    assert not set(outcomes) & set(BLAMED)


@pytest.mark.parametrize("item", [item for item in ITEMS if item.kills], ids=name_of)
def test_a_fault_of_an_item_acts_on_its_case_in_a_quantity_that_is_judged_there(item) -> None:
    assert item.case in {SETTINGS[name].case for name in item.fault.on}
    _, quantity = item.fault.sees
    assert any(quantity == finding.quantity for finding in of_any_method(item))


def on_several_settings(name):
    """True for a fault of which the matrix of tests/attacks, which plants every fault at one seed,
    sees one setting of several.
    """
    (planted,) = chosen([name])
    return len(planted.on) > 1


@pytest.mark.parametrize("fault", [fault for fault in FAULTS if on_several_settings(fault)])
def test_the_check_of_an_item_kills_its_fault_on_the_setting_that_comes_first(fault) -> None:
    (planted,) = chosen([fault])
    kill = FaultTrial(seeds=1, whole=False).kill(planted, 0)
    assert kill.killed, kill.sentence


@pytest.mark.parametrize("item", [item for item in ITEMS if not item.kills], ids=name_of)
def test_each_number_of_an_item_that_is_off_is_seen(item, monkeypatch) -> None:
    instance = item.instance
    quantities = item.quantities
    assert all(item.quantities_of(number) for number in item.numbers)
    observe = type(instance.case).observe

    def off(self, p, trajectory):
        seen = observe(self, p, trajectory)
        changed = {
            name: np.asarray(seen[name]) + SPOILED * instance.quantities[name].scale
            for name in quantities
        }
        return {**seen, **changed}

    monkeypatch.setattr(type(instance.case), "observe", off)
    blamed = findings_of.__wrapped__(item.case, tuple(item.set.items()), item.check, item.method)
    seen = {finding.quantity for finding in blamed if finding.outcome in BLAMED}
    assert seen == set(quantities)


def test_a_line_names_engines_check_kill_and_picture() -> None:
    by_place = {(line.where, line.case): line for line in table()}
    line = by_place[
        "(1.97), (1.99), (1.100), figure 1.14, figure 1.15, figure 1.16", "coulomb-oscillator"
    ]
    assert "reference" in line.engines
    assert line.check == "stop"
    assert line.kills.startswith("friction-sticky: ")
    assert line.pictures == ("1.15", "1.16"), "figure 1.14 shows no numbers"
    assert by_place["(1.75)", "quaternions"].kills.endswith("orthogonal, anticommute")


def test_an_item_about_a_method_names_it_and_the_engines_that_have_it() -> None:
    about = [item for item in ITEMS if item.method]
    assert {item.method for item in about} >= {"gear-5-free-body", "euler-angles"}
    for item in about:
        assert list(engines(item)) == ["reference"]
    by_place = {(line.where, line.parameters): line for line in table()}
    assert ("section 1.3.9, (1.68)", "--method gear-5-free-body") in by_place


def test_every_picture_of_the_gallery_that_the_chapter_has_is_beside_an_item() -> None:
    shown = {picture for line in table() for picture in line.pictures}
    of_chapter = {name for name in gallery.names() if name[0].isdigit()}
    assert shown == of_chapter | {item.picture for item in ITEMS if item.picture}


def test_an_engine_is_named_with_as_many_numbers_as_it_answers() -> None:
    """pymunk turns vectors of the plane, and has neither determinants nor reflections."""
    pytest.importorskip("pymunk")
    (item,) = (item for item in ITEMS if "mirror" in item.numbers)
    assert "pymunk (1 of 4)" in list(engines(item))
    assert "reference" in list(engines(item))


@pytest.mark.skipif(
    any(discovery.engine(name).missing() for name in discovery.own_names("engines")),
    reason="the committed table was made with every engine",
)
def test_the_committed_table_is_up_to_date() -> None:
    committed = (PAGES / "chapter.md").read_text()
    assert committed == chapter_markdown(table()), (
        "run `refdem manual reports` and commit reports/manual"
    )
