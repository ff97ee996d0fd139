"""The version is the same wherever it stands, and what people fill in or cite is well formed."""

import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
import yaml

import refdem

ROOT = Path(__file__).parents[2]
FORMS = sorted((ROOT / ".github" / "ISSUE_TEMPLATE").glob("*.yml"))
KINDS = {"Added", "Changed", "Deprecated", "Removed", "Fixed", "Security"}
"""Of the lines of a change log (keepachangelog.com)."""
MOST_CHANGES = 60
"""Lines of a version that a user still reads; the history of the repository has the rest."""
LONGEST_CHANGE = 300
"""Characters of a change: what is gained or has to be changed, one or two sentences."""


def document(path: Path) -> dict[str, Any]:
    """A file of YAML."""
    found: dict[str, Any] = yaml.safe_load(path.read_text())
    return found


def test_the_version_is_the_same_everywhere() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    built = re.search(r"^  version: '(.*)',$", (ROOT / "meson.build").read_text(), re.MULTILINE)
    assert built
    cited = document(ROOT / "CITATION.cff")
    recipe = document(ROOT / "ci" / "packaging" / "conda" / "recipe.yaml")
    versions = {project["version"], built[1], cited["version"], recipe["context"]["version"]}
    assert versions == {refdem.__version__}
    assert cited["license"] == project["license"]


def test_the_date_of_a_release_is_the_same_where_it_is_cited() -> None:
    cited = document(ROOT / "CITATION.cff")
    heading = f"## {cited['version']} - {cited['date-released']}"
    assert heading in (ROOT / "CHANGELOG.md").read_text().splitlines()


def test_a_citation_has_what_its_format_asks_for() -> None:
    cited = document(ROOT / "CITATION.cff")
    assert {"cff-version", "message", "title", "authors"} <= set(cited)


def test_a_change_is_a_line_of_a_known_kind() -> None:
    kind = ""
    for line in (ROOT / "CHANGELOG.md").read_text().splitlines():
        if line.startswith("## "):
            assert re.fullmatch(r"## (Unreleased|\d+\.\d+\.\d+ - \d{4}-\d\d-\d\d)", line), line
            kind = ""
        elif line.startswith("### "):
            kind = line.removeprefix("### ")
            assert kind in KINDS
        elif kind:
            assert not line or line.startswith("- "), line


def changes() -> dict[str, list[str]]:
    """The lines of the change log by the heading of their version."""
    of_version: dict[str, list[str]] = {}
    version = ""
    for line in (ROOT / "CHANGELOG.md").read_text().splitlines():
        if line.startswith("## "):
            version = line.removeprefix("## ")
            of_version[version] = []
        elif line.startswith("- "):
            of_version[version].append(line)
    return of_version


def test_a_version_has_no_more_changes_than_a_user_reads() -> None:
    counts = {version: len(lines) for version, lines in changes().items()}
    assert counts
    assert not {version: count for version, count in counts.items() if count > MOST_CHANGES}


def test_a_change_is_as_short_as_a_sentence_or_two() -> None:
    lines = [line for of_version in changes().values() for line in of_version]
    assert not [line for line in lines if len(line) > LONGEST_CHANGE]


@pytest.mark.parametrize("form", FORMS, ids=lambda path: path.stem)
def test_a_form_of_an_issue_asks_for_something(form: Path) -> None:
    asked = document(form)
    if form.stem == "config":
        assert asked["blank_issues_enabled"] is True
        return
    assert asked["name"]
    assert asked["description"]
    names = [field["id"] for field in asked["body"]]
    assert len(names) == len(set(names)) > 0
    for field in asked["body"]:
        assert field["type"] in ("input", "textarea")
        assert field["attributes"]["label"]
