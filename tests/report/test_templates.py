"""What holds for every template, whatever it is filled with."""

import re
from pathlib import Path

import pytest

import refdem.report

TEMPLATES = sorted((Path(refdem.report.__file__).parent / "templates").glob("*.html"))


@pytest.mark.parametrize("path", TEMPLATES, ids=lambda path: path.stem)
def test_what_scrolls_is_reached_by_keyboard_and_has_a_name(path):
    tags = re.findall(r'<[a-z]+ class="(?:scroll|equation)"[^>]*>', path.read_text())
    for tag in tags:
        assert 'tabindex="0"' in tag
        assert re.search(r' role="(?:region|group)"', tag), tag
        assert re.search(r' aria-label="[^"]+"', tag), tag


def test_templates_have_something_that_scrolls():
    assert sum(path.read_text().count('class="scroll"') for path in TEMPLATES) > 10
