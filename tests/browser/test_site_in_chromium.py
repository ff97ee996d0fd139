"""Pages of the site that Sphinx builds, wide, narrow, light and dark, by the rules of axe-core."""

import subprocess
import sys
from importlib import resources
from pathlib import Path

import pytest

from tests.browser.test_accessibility_in_chromium import BROKEN_RULES, WIDTHS
from tests.browser.test_report_in_chromium import PATIENCE, SCHEMES

ROOT = Path(__file__).parents[2]
PAGES = ("docs/index", "docs/tutorial", "docs/installation", "docs/explanation/bounds")
"""With a picture, code and output, a table, and formulas."""


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    """A site of these pages alone, with the settings of the whole one."""
    folder = tmp_path_factory.mktemp("site")
    included = ",".join(f"{page}.md" for page in PAGES)
    command = [Path(sys.executable).with_name("sphinx-build"), "-q", "-b", "html"]
    command += ["-c", ROOT / "docs", "-D", f"include_patterns={included}"]
    subprocess.run([*command, ROOT, folder / "html"], cwd=folder, check=True, timeout=600)
    return folder / "html"


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("name", [*PAGES, "search"])
def test_no_rule_is_broken_in_the_site(browser, site, name, scheme):
    rules = resources.files("axe_playwright_python").joinpath("axe.min.js").read_text("utf-8")
    context = browser.new_context(color_scheme=scheme, viewport={"width": 1440, "height": 900})
    shown = context.new_page()
    shown.set_default_timeout(PATIENCE)
    shown.goto((site / f"{name}.html").as_uri())
    shown.evaluate(rules)
    for width in WIDTHS:
        shown.set_viewport_size({"width": width, "height": 900})
        assert shown.evaluate(BROKEN_RULES) == [], width
    context.close()


def test_the_search_shows_an_excerpt_beside_each_hit(browser, site):
    shown = browser.new_page()
    shown.set_default_timeout(PATIENCE)
    shown.goto(f"{(site / 'search.html').as_uri()}?q=dashpot")
    shown.wait_for_selector("#search-results li .excerpt")
    hits = shown.locator("#search-results ul.search > li")
    assert hits.count() > 0
    for hit in hits.all():
        assert "dashpot" in hit.locator(".excerpt").first.inner_text().lower()
    shown.close()
