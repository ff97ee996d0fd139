"""The verification manual as a reader sees it: opened from disk in Chromium, with nothing missing
and nothing cut off.
"""

import pytest

from refdem.core import discovery
from refdem.manual.pages import page
from refdem.report import write_manual
from refdem.truth import load
from tests.report.test_manual import PAGE


@pytest.fixture(scope="module")
def manual(tmp_path_factory):
    """Two true pages and a hostile one."""
    folder = tmp_path_factory.mktemp("manual") / "100% #1"
    true = [page(discovery.case(name), load(name)) for name in ("rotations", "stick-slip")]
    write_manual(folder, [*true, PAGE], version="9.9")
    return folder / "manual"


@pytest.mark.parametrize("width", [420, 1280])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_every_page_opens_in_style_and_nothing_is_wider_than_the_screen(
    browser, manual, scheme, width
):
    context = browser.new_context(color_scheme=scheme, viewport={"width": width, "height": 900})
    wrong = []
    for path in sorted(manual.glob("*.html")):
        shown = context.new_page()
        shown.on("console", lambda message: wrong.append(message.text))
        shown.on("dialog", lambda dialog: (wrong.append(dialog.message), dialog.dismiss()))
        shown.on("requestfailed", lambda request: wrong.append(request.url))
        shown.goto(path.as_uri())
        assert shown.evaluate("document.documentElement.scrollWidth") <= width, path.name
        assert shown.evaluate("document.styleSheets.length") == 1
        assert shown.locator("h1").count() == 1
        shown.close()
    context.close()
    assert wrong == []


def test_a_reader_goes_from_the_table_to_a_page_and_on(browser, manual):
    shown = browser.new_page()
    shown.goto((manual / "index.html").as_uri())
    assert shown.locator("tr.fail").count() == 1
    shown.get_by_role("link", name="stick-slip").click()
    assert shown.locator("h1").inner_text() == "Stick-slip oscillator"
    assert shown.locator("math").count() >= 1
    shown.locator("a[rel=prev]").click()
    assert shown.locator("#slips").count() == 1
    assert "120" in shown.locator("main").inner_text()
    shown.close()
