"""The page of the field has every code's result on every case, or the reason why there is none."""

import shutil
import xml.etree.ElementTree as ET
from pathlib import Path

import field_page
import pytest
from field_results import Kept, Law, Result, Run, read, write
from msgspec.structs import replace

ROOT = Path(__file__).parents[3]
CODES = ROOT / "validation" / "codes"
OUT = ROOT / "reports" / "field"
PASSED = Result(
    label="pendulum",
    method="world-step",
    counts={"pass": 9},
    quantity="theta",
    error=1e-5,
    seconds=0.002,
    laws={
        "momentum": Law("kept", 0.0),
        "energy": Law("approximate", 3e-5),
        "angular-momentum": Law("lost", 0.5),
    },
)
DEVIATING = Result(
    label="block-on-slope[duration=0.5]",
    method="world-step",
    counts={"expected": 1, "pass": 1},
    deviations=("rest/speed",),
)
REFUSED = Result(
    label="hard-wall", method="world-step", counts={"unsupported": 1}, refused="no walls"
)
FAILED = Result(label="hard-spheres", method="world-step", counts={"fail": 2, "pass": 1})
WORSE = Result(label="hard-wall", method="world-step", counts={"worse": 2})
HELD = Result(label="rolling", method="world-step", counts={"pass": 3})


def kept(*results, state="open", code="ode"):
    """The results of a run of a code."""
    methods = {"world-step": "an exact solver"}
    run = Run(code=code, version="0.16.2", state=state, date="2026-11-29", methods=methods)
    return Kept(run, results)


@pytest.fixture
def page_of(tmp_path):
    """A function that makes the page of the results of ODE, beside YADE without any."""
    for name in ("ode", "yade"):
        shutil.copytree(CODES / name, tmp_path / "codes" / name)
    (tmp_path / "field").mkdir()

    def made(*results):
        write(tmp_path / "field" / "ode.jsonl", kept(*results))
        write(tmp_path / "field" / "yade.jsonl", kept(code="yade"))
        return field_page.page(tmp_path / "codes", tmp_path / "field")

    return made


def cells(page, case):
    """The cells of ODE and YADE on a case."""
    (line,) = [line for line in page.splitlines() if line.startswith(f"| {case}")]
    _, ode, yade = line.removesuffix(" |").split(" | ")
    return ode, yade


def test_a_cell_has_digits_what_is_conserved_and_time(page_of):
    ode, _ = cells(page_of(PASSED), "pendulum")
    assert ode == (
        '[5.0 digits](#ode "error 1e-5 in theta")<br>keeps p<br>E to 3e-5<br>loses L<br>2 ms'
    )


@pytest.mark.parametrize("said", ["right", "wrong"])
def test_a_cell_says_whether_derivatives_are_right(page_of, said):
    result = replace(HELD, derivatives=said)
    assert cells(page_of(result), "rolling")[0] == f"{said} derivatives"


@pytest.mark.parametrize("said", ["none", "undecided"])
def test_a_cell_without_judged_derivatives_says_nothing_of_them(page_of, said):
    assert cells(page_of(replace(HELD, derivatives=said)), "rolling")[0] == "held"


def test_a_case_without_numbers_held(page_of):
    assert cells(page_of(HELD), "rolling")[0] == "held"


def test_a_cell_says_what_failed(page_of):
    assert cells(page_of(FAILED), "hard-spheres")[0] == "2 fail"


def test_a_deviation_leads_to_its_reason_its_script_and_its_source(page_of):
    page = page_of(DEVIATING)
    assert cells(page, "block-on-slope")[0] == "deviates: [1](#ode-1)"
    told = page.partition("### ode 1")[2]
    assert "Contacts yield by CFM" in told
    assert "codes/ode/deviations/cfm.cpp)" in told
    assert "[source](https://sources.debian.org/src/ode/" in told
    assert "rest/speed: 1e-10 to 2e-8, version 0.16" in told


def test_a_cell_that_the_driver_refused_has_its_words(page_of):
    page = page_of(REFUSED)
    assert cells(page, "hard-wall")[0] == (
        '[no walls](#why-cells-are-empty "The driver refuses: no walls.")'
    )
    assert "- **no walls**: The driver refuses: no walls. (ode)" in page


def test_a_cell_that_the_adapter_refuses_names_the_features(page_of):
    page = page_of(PASSED)
    assert cells(page, "pendulum")[1] == (
        '[no rod](#why-cells-are-empty "The scene has rod, which the adapter does not support.")'
    )
    told = "The scene has rod, which the adapter does not support. (yade)"
    assert f"- **no rod**: {told}" in page


def test_a_cell_of_a_case_that_was_not_asked_says_so(page_of):
    free = Result(label="free-rigid-body", method="world-step", counts={"pass": 1})
    page = page_of(free)
    assert cells(page, "free-rigid-body")[1] == (
        '[not asked](#why-cells-are-empty "The gate did not ask for this case when it last ran.")'
    )


def test_methods_of_a_code_that_has_several_are_named(tmp_path):
    shutil.copytree(CODES / "lammps", tmp_path / "codes" / "lammps")
    results = [
        Result(label="two-spheres", method=method, counts={"pass": 1}, refused=refused)
        for method, refused in (("gran", ""), ("granular", "no walls"))
    ]
    (tmp_path / "field").mkdir()
    write(tmp_path / "field" / "lammps.jsonl", kept(*results, code="lammps"))
    page = field_page.page(tmp_path / "codes", tmp_path / "field")
    assert "| **gran**<br>held<br>**granular**<br>[no walls](#why" in page


@pytest.mark.parametrize(
    ("results", "state", "words", "colour"),
    [
        ([PASSED, REFUSED], "open", "1 of 1 cases hold", "#1a7f37"),
        ([PASSED, DEVIATING], "open", "1 of 2 cases hold, 1 deviate", "#9a6700"),
        ([PASSED, FAILED], "closed", "1 of 2 cases hold, 1 fail", "#cf222e"),
        ([WORSE], "closed", "1 of 1 cases hold", "#cf222e"),
    ],
)
def test_a_badge_counts_cases_and_is_coloured_by_the_gate(results, state, words, colour):
    picture = ET.fromstring(field_page.badge(kept(*results, state=state)))
    assert picture.attrib["aria-label"] == f"refdem: {words}"
    assert any(element.attrib.get("fill") == colour for element in picture.iter())
    assert words in [element.text for element in picture.iter()]


def test_a_script_without_a_title_is_told_of(tmp_path):
    script = tmp_path / "a.py"
    script.write_text("import b\n")
    with pytest.raises(ValueError, match="has no title"):
        field_page.title_of(script)


def test_the_committed_page_is_that_of_the_committed_results():
    """After a change of a description or of the page: `ci/field/field.py --page`."""
    assert (OUT / "index.md").read_text() == field_page.page(CODES, OUT)


@pytest.mark.parametrize("path", sorted(OUT.glob("*.jsonl")), ids=lambda path: path.stem)
def test_a_committed_badge_is_that_of_the_committed_results(path):
    found = read(path)
    assert found.run.code == path.stem
    assert path.with_suffix(".svg").read_text() == field_page.badge(found)
