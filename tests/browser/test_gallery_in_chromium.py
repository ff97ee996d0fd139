"""The gallery as a reader sees it: opened from disk in Chromium, in light and in dark, every figure
drawn, nothing run that a name says.
"""

import pytest

from refdem.gallery.gallery import figure
from refdem.report import write_gallery
from tests.browser.test_report_in_chromium import PATIENCE, read_through
from tests.report.test_gallery import FIGURE


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    folder = tmp_path_factory.mktemp("gallery") / "100% #1"
    figures = [figure("1.15"), figure("1.20"), FIGURE]
    write_gallery(folder, figures, version="9.9")
    return folder / "gallery.html"


@pytest.mark.parametrize("width", [420, 1280])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_every_figure_is_drawn_and_nothing_is_wider_than_the_screen(browser, page, scheme, width):
    context = browser.new_context(color_scheme=scheme, viewport={"width": width, "height": 900})
    shown = context.new_page()
    wrong = []
    shown.on("console", lambda message: wrong.append(message.text))
    shown.on("pageerror", lambda error: wrong.append(str(error)))
    shown.on("dialog", lambda dialog: (wrong.append(dialog.message), dialog.dismiss()))
    shown.on("requestfailed", lambda request: wrong.append(request.url))
    shown.set_default_timeout(PATIENCE)
    shown.goto(page.as_uri())
    read_through(shown)
    assert shown.locator(".plot svg").count() >= 3
    assert shown.evaluate("document.documentElement.scrollWidth") <= width
    assert wrong == []
    context.close()
