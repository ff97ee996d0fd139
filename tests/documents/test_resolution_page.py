"""reports/resolution.md: it has every motion of campaign main, and what it says can be measured
again.
"""

import re
from pathlib import Path

import pytest
from msgspec.structs import replace

from refdem.core import discovery
from refdem.core.outside import markdown_text
from refdem.core.parameters import labelled
from refdem.core.problem import Motion
from refdem.planning import plan
from refdem.planning.in_process import truth_of
from refdem.planning.resolution import CLOSE, resolution
from refdem.planning.specification import named

PAGE = (Path(__file__).parents[2] / "reports" / "resolution.md").read_text()
SECTIONS = {
    head.strip(): body for head, body in (part.split("\n", 1) for part in PAGE.split("\n## ")[1:])
}
MEASURED = [
    ("harmonic-oscillator", "rebound", "leapfrog"),
    ("free-rigid-body", "mujoco", "rk4"),
    ("hard-spheres", "pymunk", "semi-implicit-euler"),
]


def cells(label, engine, method):
    """What the page says of each number: the smallest misreading, or None for nothing."""
    rows = [
        [cell.strip() for cell in re.split(r"(?<!\\)\|", line)[1:-1]]
        for line in SECTIONS[markdown_text(label)].splitlines()
        if line.startswith("|")
    ]
    place = rows[0].index(markdown_text(f"{engine} {method}"))
    return {row[0]: value_of(row[place]) for row in rows[2:]}


def value_of(cell):
    if cell == "nothing":
        return None
    number = cell.split(" (")[0]
    if number.endswith("%"):
        return float(number[:-1]) / 100
    return float(number)


def test_every_motion_of_campaign_main_has_its_table():
    labels = {
        markdown_text(instance.label)
        for instance, _ in plan.instances(named("main"))
        if isinstance(instance.problem, Motion)
    }
    assert labels == set(SECTIONS)


@pytest.mark.parametrize(("label", "engine", "method"), MEASURED)
def test_what_the_page_says_is_measured_again(label, engine, method):
    name, given = labelled(label)
    instance = discovery.case(name).at(**given)
    campaign = named("main")
    asked = replace(campaign, case=[], method=method)
    found = resolution(asked, discovery.engine(engine), instance, truth_of(instance)).numbers
    said = cells(instance.label, engine, method)
    assert {markdown_text(seen.number) for seen in found} <= set(said)
    for seen in found:
        before = said[markdown_text(seen.number)]
        if before is None or seen.smallest is None:
            assert before is seen.smallest is None
        else:
            # Each trial is within CLOSE of the threshold, and the page has two digits.
            assert max(before / seen.smallest, seen.smallest / before) < 1.1 * CLOSE
