"""Every kind of page, wide and narrow, light and dark, by the rules of axe-core; text of charts by
its contrast, which those rules do not measure.
"""

import shutil
from importlib import resources

import pytest

from refdem.core import discovery
from refdem.gallery.gallery import figure
from refdem.manual.pages import page
from refdem.report import bench, heat_map, stress, write_gallery, write_manual
from refdem.truth import load
from tests.browser.test_report_in_chromium import CONTRAST, PATIENCE, SCHEMES, read_through
from tests.report.test_bench import SECTION
from tests.report.test_gallery import FIGURE
from tests.report.test_heat_map import NAMES, point
from tests.report.test_manual import PAGE

WIDTHS = (1440, 390)
"""Pixels of an ordinary screen and of a telephone."""
KINDS = (
    "index.html",
    "engines.html",
    "cases/pendulum.html",
    "gallery/gallery.html",
    "manual/chapter.html",
    "manual/index.html",
    "manual/stick-slip.html",
    "manual/top.html",
    "bench/bench.html",
    "stress/stress.html",
    "sweep/sweep.html",
)
MARK = stress.Mark("mass", "mass ratio", 0, "10", "mujoco", "rk4", False, 0.5, "pass")
BROKEN_RULES = """
async () => {
  const found = await axe.run(document, { resultTypes: ["violations"] });
  return found.violations.map(rule => [rule.id, rule.help, rule.nodes.map(node => node.html)]);
}
"""


@pytest.fixture(scope="module")
def pages(folder, tmp_path_factory):
    """A page of every kind, beside a copy of the report."""
    folder = shutil.copytree(folder, tmp_path_factory.mktemp("kinds") / "report")
    write_gallery(folder / "gallery", [figure("1.20"), FIGURE], version="9.9")
    write_manual(
        folder, [page(discovery.case("stick-slip"), load("stick-slip")), PAGE], version="9"
    )
    tables = [("Time", ("method", "to 1e-3"), [("mujoco rk4", "1 ms")])]
    bench.write(folder / "bench", "Bench", "What a run takes.", tables, [SECTION])
    sections = [stress.Section("step-limit", "Step limit", "How long a step?", [MARK], tables)]
    stress.write(folder / "stress", "Stress", "What breaks.", [], sections)
    study = [point(x, y, float(f"1e-{x}{y}")) for x in "01" for y in "159"]
    study += [point("1", "1", None, verdict="fail", engine="</script><b>hostile</b>")]
    heat_map.write(folder / "sweep", "Sweep", NAMES, study, None)
    return folder


@pytest.fixture(scope="module")
def rules():
    """The script of axe-core, as the package that wraps it has it."""
    return resources.files("axe_playwright_python").joinpath("axe.min.js").read_text("utf-8")


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("kind", KINDS)
def test_no_rule_is_broken(browser, pages, rules, kind, scheme):
    context = browser.new_context(color_scheme=scheme, viewport={"width": 1440, "height": 900})
    shown = context.new_page()
    shown.set_default_timeout(PATIENCE)
    shown.goto((pages / kind).as_uri())
    read_through(shown)
    # What is folded away is read too.
    shown.evaluate("for (const part of document.querySelectorAll('details')) part.open = true")
    for replay in shown.locator("details[data-replay]").all():
        shown.wait_for_selector("details[data-replay][data-loaded]")
        assert replay.locator("canvas").is_visible()
    shown.evaluate(rules)
    for width in WIDTHS:
        shown.set_viewport_size({"width": width, "height": 900})
        assert shown.evaluate(BROKEN_RULES) == [], width
    seen = shown.evaluate(CONTRAST, ".role-axis text, .role-legend text, .role-title text")
    assert [(round(contrast, 2), text) for contrast, text in seen if contrast < 4.5] == []
    assert seen or not shown.locator(".plot").count()
    context.close()


@pytest.mark.parametrize(("width", "columns"), [(1440, 2), (390, 1)])
def test_heat_maps_stand_below_each_other_on_a_narrow_screen(browser, pages, width, columns):
    shown = browser.new_page(viewport={"width": width, "height": 900})
    shown.set_default_timeout(PATIENCE)
    shown.goto((pages / "sweep" / "sweep.html").as_uri())
    read_through(shown)
    titles = shown.locator(".plot .role-title-text")
    assert len({round(title.bounding_box()["y"]) for title in titles.all()}) == 2 // columns
    shown.close()
