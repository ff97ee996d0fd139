"""Rows of a campaign with levels of their own, rows that ask the same twice, what is refused."""

import pytest
from msgspec import UNSET

from refdem.core import discovery
from refdem.errors import UsageError
from refdem.planning import plan
from refdem.planning.specification import Entry, Specification, named

BASE = """
levels = 3

[[case]]
id = "harmonic-oscillator"

[[case]]
id = "harmonic-oscillator"
set = { x0 = "2" }
levels = 2

[[case]]
id = "pendulum"
"""
ABOVE = """
include = ["base"]
levels = 4

[[case]]
id = "pendulum"
levels = 5
"""


def written(folder, **texts):
    """Campaigns in a folder, by name; returns the last one's specification."""
    for name, text in texts.items():
        (folder / f"{name}.toml").write_text(text)
    return named(str(folder / f"{name}.toml"))


def levels_by_label(specification):
    return {
        instance.label: specification.levels_of(instance)
        for instance, _ in plan.instances(specification)
    }


def test_a_row_has_the_levels_of_its_campaign_or_its_own(tmp_path):
    assert levels_by_label(written(tmp_path, base=BASE)) == {
        "harmonic-oscillator": 3,
        "harmonic-oscillator[x0=2]": 2,
        "pendulum": 3,
    }


def test_an_own_row_takes_the_place_of_an_included_one_that_asks_the_same(tmp_path):
    levels = levels_by_label(written(tmp_path, base=BASE, above=ABOVE))
    assert levels == {"harmonic-oscillator": 4, "harmonic-oscillator[x0=2]": 2, "pendulum": 5}
    assert list(levels)[-1] == "pendulum"


def test_runs_are_planned_with_the_levels_of_the_row(tmp_path):
    specification = written(tmp_path, base=BASE)
    reference = discovery.engine("reference")
    counts = {}
    for instance, _ in plan.instances(specification):
        subjects = plan.subjects(specification, instance, reference)
        counts[instance.label] = {
            len(subject.levels)
            for subject, unsupported in subjects
            if subject.method.name == "velocity-verlet" and unsupported is None
        }
    assert counts["harmonic-oscillator"] == {3}
    assert counts["harmonic-oscillator[x0=2]"] == {2}


def test_levels_hold_however_the_parameters_are_written():
    specification = Specification(
        name="test", levels=3, case=[Entry("harmonic-oscillator", {"x0": "4/2"}, levels=6)]
    )
    instance = discovery.case("harmonic-oscillator").at(x0="2")
    assert specification.levels_of(instance) == 6


@pytest.mark.parametrize(
    ("row", "said"),
    [
        ("levels = 0", "levels of pendulum is 0; expected a whole number from 1 to 10"),
        ("levels = 11", "levels of pendulum is 11; expected a whole number from 1 to 10"),
        ("levels = 2.5", "Expected `int`, got `float`"),
        ('levels = "4"', "Expected `int`, got `str`"),
        ("level = 4", "unknown field `level`"),
    ],
)
def test_levels_without_sense_are_refused_with_their_place(tmp_path, row, said):
    with pytest.raises(UsageError, match=r"case\[0\]|case\[\.\.\.\]") as refused:
        written(tmp_path, wrong=f'[[case]]\nid = "pendulum"\n{row}\n')
    assert said in str(refused.value)


def test_a_row_that_is_listed_twice_with_other_levels_is_refused(tmp_path):
    twice = '[[case]]\nid = "pendulum"\n\n[[case]]\nid = "pendulum"\nlevels = 5\n'
    with pytest.raises(UsageError, match="pendulum is listed twice"):
        written(tmp_path, wrong=twice)


def test_campaign_full_refines_breaks_further_than_the_rest():
    full = named("full").case
    main = named("main").case
    of_main = {entry.label for entry in main}
    its_own = [entry for entry in full if entry.label not in of_main]
    assert {entry.levels for entry in its_own if entry.id == "billiard-break"} == {9}
    # A few rows need bounds that are a half to a sixteenth of those at four levels.
    few = {UNSET, 5, 6, 8}
    assert {entry.levels for entry in full if entry.id != "billiard-break"} == few
    assert {entry.levels for entry in main} == few
