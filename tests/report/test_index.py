"""The first page of a report as large as that of campaign main: small, whatever the campaign."""

import msgspec
import pytest

from refdem.report import html, index
from refdem.report.contents import contents_of
from refdem.report.tolerance import rows_of
from tests.report.synthetic import case_sheet, engine_sheet, error, record, said

MOST = 300_000
"""Bytes of index.html, at most: what opens in half a second on a slow computer."""
ENGINES = ("reference", "mujoco", "pymunk", "rebound")
METHODS = ("leapfrog", "velocity-verlet", "rk4", "adaptive")
QUANTITIES = ("x", "y", "v", "w", "energy")
SETTINGS = 160
"""Instances, a third more than campaign main has."""
REFUSAL = "The engine has no element of this kind; it cannot say the scene without it."


def sheets(outcome):
    """Instances of 40 cases in all engines and methods; a method in eight refuses, and one in eight
    has this outcome, each for a reason of its own.
    """
    found = [engine_sheet(name) for name in ENGINES]
    for number in range(SETTINGS):
        case = f"a-case-with-a-name-{number % 40}"
        label = f"{case}[restitution=0.5 friction=0.25 setting={number}]"
        sheet = case_sheet(case, label, f"A case with a title, number {number % 40}", "")
        motion = ("spinning", "swinging", "impacts", "contact")[number % 4]
        found.append(msgspec.structs.replace(sheet, motion=motion))
        for engine in ENGINES:
            for kind, method in enumerate(METHODS):
                if (number + kind) % 8 == 0:
                    findings = (said("support", "unsupported", REFUSAL),)
                elif (number + kind) % 8 == 1:
                    reason = f"Something about setting {number} that takes a whole sentence."
                    findings = (said("order", outcome, reason),)
                else:
                    findings = tuple(error(name, 1e-3, 2) for name in QUANTITIES)
                found.append(record(case, label, engine, method, *findings))
    return found


@pytest.mark.parametrize("outcome", ["undecided", "error"])
def test_the_index_is_small_and_its_parts_have_the_rest(outcome):
    contents = contents_of(sheets(outcome))
    rows = {sheet.label: rows_of(contents, sheet.label) for sheet in contents.cases}
    templates = html.environment()
    shared = html.shared_by_all(contents)
    beside = {"has_gallery": False, "has_site": False}
    made = dict(index.files(contents, rows, "{}", templates, shared | beside))
    assert len(made["index.html"].encode()) <= MOST
    assert {name.removeprefix("assets/index-").removesuffix(".js") for name in made} == {
        "digits",
        "overview",
        "tolerance",
        f"reasons-{outcome}",
        "reasons-unsupported",
        "index.html",
    }
    measured = sum(len(own) for own in rows.values())
    assert made["assets/index-tolerance.js"].count('<tr class=\\"') == measured + SETTINGS
    for number in (1, SETTINGS - 7):
        assert f"about setting {number} " in made[f"assets/index-reasons-{outcome}.js"]
        assert f"about setting {number} " not in made["index.html"]


def test_a_part_of_an_earlier_report_is_known_by_its_name():
    assert index.is_part("index-reasons-fail.js")
    assert not index.is_part("report.js")
    assert not index.is_part("index.html")
