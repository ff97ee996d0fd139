"""The report as a reader sees it: opened from disk in Chromium, light and dark, wide and narrow."""

from contextlib import contextmanager
from urllib.parse import unquote, urlsplit

import msgspec
import numpy as np
import pytest

from refdem.core.replay import DrawnBody, Grid
from refdem.report import write_report
from refdem.report.replays import handed_over
from tests.report import synthetic

SCHEMES = ("light", "dark")
PATIENCE = 60_000
"""Milliseconds that anything in a page may take, whatever else the machine does."""

CONTRAST = """
selector => {
  const parts = text => text.match(/[\\d.]+/g).map(Number);
  const linear = x => x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4;
  const light = ([r, g, b]) => [r, g, b].map(x => linear(x / 255))
    .reduce((sum, x, k) => sum + x * [0.2126, 0.7152, 0.0722][k], 0);
  const contrast = element => {
    let behind = element, back = parts(getComputedStyle(behind).backgroundColor);
    while (back.length === 4 && back[3] === 0 && behind.parentElement) {
      behind = behind.parentElement;
      back = parts(getComputedStyle(behind).backgroundColor);
    }
    const style = getComputedStyle(element);
    const front = parts(element instanceof SVGElement ? style.fill : style.color);
    const [low, high] = [light(front), light(back)].sort((a, b) => a - b);
    return (high + 0.05) / (low + 0.05);
  };
  const words = element => (element.innerText ?? element.textContent).trim();
  const seen = [...document.querySelectorAll(selector)]
    .filter(element => element.checkVisibility() && words(element));
  return seen.map(element => [contrast(element), element.outerHTML.slice(0, 200)]);
}
"""
"""Contrast of the text of each visible element with what is behind it, after WCAG 2.2."""

SAID = (
    "main p, main td, main th, main h1, main h2, main h3, main a, main .quiet, main .outcome, main"
    " .tally, main .mark, main small, footer p"
)


def read_through(page):
    """Scrolls to every part and every chart of a page and waits until it is there."""
    for kind, there in ((".part", "loaded"), (".plot", "drawn")):
        for place in page.locator(kind).all():
            place.scroll_into_view_if_needed()
            page.wait_for_function(
                f"place => place.dataset.{there} === 'yes'", arg=place.element_handle()
            )
    page.evaluate("scrollTo(0, 0)")


@contextmanager
def opened(browser, path, *, scheme="light", width=1280):
    """The page with its charts drawn; fails on any message, dialog or request that is not of a
    file.
    """
    context = browser.new_context(color_scheme=scheme, viewport={"width": width, "height": 900})
    page = context.new_page()
    wrong = []
    page.on("console", lambda message: wrong.append(message.text))
    page.on("pageerror", lambda error: wrong.append(str(error)))
    page.on("dialog", lambda dialog: (wrong.append(dialog.message), dialog.dismiss()))
    page.on(
        "request",
        lambda request: (
            wrong.append(request.url)
            if not request.url.startswith(("file:", "data:", "blob:"))
            else None
        ),
    )
    page.on("requestfailed", lambda request: wrong.append(request.url))
    page.set_default_timeout(PATIENCE)
    page.goto(path.as_uri())
    read_through(page)
    yield page
    context.close()
    assert wrong == []


def pages(folder):
    return sorted(folder.rglob("*.html"))


@pytest.mark.parametrize("scheme", SCHEMES)
def test_every_page_opens_without_a_message_a_dialog_or_a_request(browser, folder, scheme):
    assert len(pages(folder)) == 5
    for path in pages(folder):
        with opened(browser, path, scheme=scheme) as page:
            assert page.title()


def test_every_link_leads_to_a_file_and_to_a_place_in_it(browser, folder):
    places = {}
    links = []
    for path in pages(folder):
        with opened(browser, path) as page:
            places[path.resolve()] = set(
                page.evaluate("[...document.querySelectorAll('[id]')].map(x => x.id)")
            )
            links += [
                (path.name, link)
                for link in page.evaluate(
                    "[...document.querySelectorAll('a[href]')].map(x => x.href)"
                )
            ]
    assert len(links) > 100
    for source, link in links:
        parts = urlsplit(link)
        assert parts.scheme == "file", (source, link)
        target = next(
            (path for path in [*places, *folder.iterdir()] if str(path) == unquote(parts.path)),
            None,
        )
        assert target is not None, (source, link)
        if parts.fragment:
            assert unquote(parts.fragment) in places[target], (source, link)


def test_plots_have_marks_and_choosing_a_quantity_moves_them(browser, folder):
    with opened(browser, folder / "cases/pendulum.html") as page:
        assert page.locator(".plot").count() == 3
        for index in range(3):
            marks = (
                page.locator(".plot")
                .nth(index)
                .locator("svg .mark-symbol path, svg .mark-line path")
            )
            assert marks.count() > 10
        plot = page.locator(".plot").first
        before = plot.locator("svg.marks").evaluate("svg => svg.outerHTML")
        plot.locator("select").select_option("x")
        page.wait_for_function(
            "before => document.querySelector('.plot svg.marks').outerHTML !== before", arg=before
        )


def test_a_chart_tells_its_numbers_when_pointed_at(browser, folder):
    with opened(browser, folder / "cases/pendulum.html") as page:
        page.locator(".plot").first.locator("svg .mark-symbol path").first.hover(force=True)
        tip = page.locator("#vg-tooltip-element.visible")
        tip.wait_for()
        assert "error" in tip.inner_text()
        assert tip.locator("script, img").count() == 0


def test_a_click_in_the_legend_leaves_one_curve_and_another_shows_all(browser, folder):
    faded = """
    () => [...document.querySelector('.plot').querySelectorAll('.role-mark.mark-symbol path')]
      .filter(mark => Number(mark.getAttribute('opacity')) < 0.2).length
    """
    with opened(browser, folder / "cases/pendulum.html") as page:
        assert page.evaluate(faded) == 0
        name = page.locator(".plot").first.locator(".role-legend text", has_text="alpha rk4")
        name.click()
        page.wait_for_function(f"({faded})() > 5")
        name.click()
        page.wait_for_function(f"({faded})() === 0")


def test_a_table_that_goes_on_to_the_right_says_so_until_it_is_scrolled_there(browser, folder):
    with opened(browser, folder / "index.html", width=390) as page:
        frame = page.locator(".scroll").filter(has=page.locator("#digits-rows"))
        page.wait_for_function("document.querySelector('#digits-rows').closest('.more')")
        assert "scroll it sideways" in frame.evaluate("x => x.previousElementSibling.innerText")
        frame.evaluate("x => x.scrollTo(x.scrollWidth, 0)")
        page.wait_for_function("!document.querySelector('#digits-rows').closest('.more')")
    with opened(browser, folder / "engines.html", width=1280) as page:
        assert page.locator(".more, .sideways").count() == 0


@pytest.mark.parametrize("scheme", SCHEMES)
def test_text_stands_out_from_what_is_behind_it(browser, folder, scheme):
    for path in pages(folder):
        with opened(browser, path, scheme=scheme) as page:
            seen = page.evaluate(CONTRAST, SAID)
            assert len(seen) > 20
            assert [(round(contrast, 2), text) for contrast, text in seen if contrast < 4.5] == []


def test_charts_take_the_colours_of_the_page(browser, folder):
    inks = {}
    for scheme in SCHEMES:
        with opened(browser, folder / "index.html", scheme=scheme) as page:
            inks[scheme] = page.locator(".plot svg .role-axis-label text").first.get_attribute(
                "fill"
            )
    assert inks["light"] != inks["dark"]


def test_a_reader_who_changes_to_dark_gets_dark_charts(browser, folder):
    with opened(browser, folder / "index.html") as page:
        ink = page.locator(".plot svg .role-axis-label text").first
        before = ink.get_attribute("fill")
        page.emulate_media(color_scheme="dark")
        page.wait_for_function(
            "before => document.querySelector('.plot svg .role-axis-label"
            " text')?.getAttribute('fill') !== before",
            arg=before,
        )
        assert ink.get_attribute("fill") != before


def test_a_narrow_page_scrolls_its_tables_and_not_itself(browser, folder):
    for path in pages(folder):
        with opened(browser, path, width=390) as page:
            assert page.evaluate("document.documentElement.scrollWidth") <= 390, path.name


def test_every_quantity_is_shown_when_asked_for(browser, folder):
    with opened(browser, folder / "index.html") as page:
        line = page.locator(".tolerance tr.single").first
        assert not line.is_visible()
        page.get_by_label("every quantity").check()
        assert line.is_visible()


def test_a_link_to_a_finding_marks_it(browser, folder):
    with opened(browser, folder / "index.html") as page:
        page.locator("#error + ul .places a").first.click()
        page.wait_for_load_state()
        marked = page.locator("tr:target")
        assert "signal 11" in marked.inner_text()
        assert marked.evaluate("x => getComputedStyle(x).backgroundColor") != "rgba(0, 0, 0, 0)"


def test_without_scripts_the_page_has_its_pictures(browser, folder):
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto((folder / "cases/pendulum.html").as_uri())
    picture = page.locator(".plot img").first
    picture.scroll_into_view_if_needed()
    assert picture.bounding_box()["height"] > 200
    context.close()


def test_the_first_screen_needs_no_part_and_no_chart(browser, folder):
    page = browser.new_page(viewport={"width": 1280, "height": 800})
    page.set_default_timeout(PATIENCE)
    # Nothing of assets/ but the style arrives.
    page.route("**/assets/*.js", lambda route: route.abort())
    page.goto((folder / "index.html").as_uri())
    assert page.locator(".verdict").is_visible()
    assert page.locator("#broken").is_visible()
    assert page.locator(".matrix.small td b").count() > 4
    page.close()


def test_words_leave_the_rows_that_have_them_and_say_how_many(browser, folder):
    with opened(browser, folder / "index.html") as page:
        rows = page.locator("#tolerance-rows tr.joined:visible")
        groups = page.locator("#tolerance-rows tr.group:visible")
        field = page.get_by_label("Show only rows with")
        every = rows.count()
        # A name of an engine, then one of a case, whose rows all stay, then both.
        field.fill("alpha")
        assert {text.split()[0] for text in rows.all_inner_texts()} == {"alpha"}
        assert page.locator("[data-left=tolerance-rows]").inner_text() == f"{rows.count()} rows"
        field.fill("theta0=3")
        assert groups.count() == 1
        assert 1 < rows.count() < every
        field.fill("theta0=3 ADAPTIVE")
        assert rows.count() == 1
        assert page.locator("[data-left=tolerance-rows]").inner_text() == "1 row"
        field.fill("nowhere")
        assert rows.count() == groups.count() == 0
        field.fill("")
        assert rows.count() == every
        page.get_by_label("Show only cases with").fill("theta0")
        assert page.locator("#digits-rows tbody tr:visible").count() == 1


def opened_replay(page):
    """The replay of a page, opened by its reader."""
    replay = page.locator("details.replay")
    replay.locator("summary").click()
    page.wait_for_selector("details.replay[data-loaded]")
    return replay


def legend_row(replay, name):
    """The row of a method in the legend of a replay."""
    return replay.get_by_role("row").filter(has_text=name)


PIXELS = """
(canvas, [red, green, blue]) => {
  const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d");
  copy.drawImage(canvas, 0, 0);
  const data = copy.getImageData(0, 0, canvas.width, canvas.height).data;
  let found = 0;
  for (let k = 0; k < data.length; k += 4)
    found += data[k] === red && data[k + 1] === green && data[k + 2] === blue;
  return found;
}
"""
"""How many pixels of a canvas have exactly this colour."""

HEIGHTS = """
canvas => {
  const copy = new OffscreenCanvas(canvas.width, canvas.height).getContext("2d");
  copy.drawImage(canvas, 0, 0);
  const data = copy.getImageData(0, 0, canvas.width, canvas.height).data;
  const columns = Array(canvas.width).fill(0);
  for (let k = 3; k < data.length; k += 4) columns[((k - 3) / 4) % canvas.width] += data[k] > 0;
  const half = Math.floor(canvas.width / 2);
  return [Math.max(...columns.slice(0, half)), Math.max(...columns.slice(half))];
}
"""
"""The largest heights [pixel] of what is drawn in the left and right halves of a canvas."""


def has_pixels(canvas, colour):
    """True if more than a few pixels of a canvas have this colour #rrggbb."""
    parts = [int(colour[k : k + 2], 16) for k in (1, 3, 5)]
    return canvas.evaluate(PIXELS, parts) > 20


def ink(canvas):
    """The pixels of a canvas, as one text."""
    return canvas.evaluate("canvas => canvas.toDataURL()")


def test_a_replay_comes_when_it_is_opened_and_stands_still_until_play_is_pressed(browser, folder):
    with opened(browser, folder / "cases/pendulum.html") as page:
        loaded = "[...document.scripts].filter(x => x.src.includes('replay')).length"
        assert page.evaluate(loaded) == 0
        replay = opened_replay(page)
        assert page.evaluate(loaded) == 2
        assert "frame 1 of 9" in replay.locator(".now").inner_text()
        canvas = replay.locator("canvas")
        before = ink(canvas)
        # Longer than a frame takes: nothing moves by itself.
        page.wait_for_timeout(300)
        assert ink(canvas) == before
        replay.get_by_role("button", name="Play").click()
        page.wait_for_function(
            "document.querySelector('.replay .now').innerText.includes('frame 9 of 9')"
        )
        assert ink(canvas) != before
        assert replay.get_by_role("button", name="Play").is_visible()


def test_a_replay_is_stepped_and_searched_by_keys_and_tells_what_is_seen(browser, folder):
    with opened(browser, folder / "cases/pendulum.html") as page:
        replay = opened_replay(page)
        now = replay.locator(".now")
        onward = replay.get_by_role("button", name="Step on")
        onward.focus()
        page.keyboard.press("Enter")
        page.keyboard.press("Space")
        assert "t = 1 s, frame 3 of 9." in now.inner_text()
        # Errors grow evenly to 1e-4 m and 1e-3 rad at frame 9.
        of_alpha = legend_row(replay, "alpha rk4").inner_text()
        assert "2.5e-5 m, 2.5e-4 rad" in of_alpha
        assert "1e-4 m, 0.001 rad" in of_alpha
        assert "step 0.1 s" in of_alpha
        assert "Body 1 has just met something" in now.inner_text()
        assert "Body 1 touches the plane" in now.inner_text()
        heard = replay.locator("canvas").get_attribute("aria-label")
        assert "Truth filled. alpha rk4 in lines, 2.5e-5 m, 2.5e-4 rad from truth." in heard
        assert "frame 3 of 9" in heard
        replay.get_by_role("button", name="Step back").click()
        assert "frame 2 of 9" in now.inner_text()
        slider = replay.get_by_label("Time")
        slider.focus()
        page.keyboard.press("End")
        assert "frame 9 of 9" in now.inner_text()
        assert slider.get_attribute("aria-valuetext") == "t = 4 s"
        page.keyboard.press("Home")
        assert "frame 1 of 9" in now.inner_text()


def test_a_replay_says_by_how_much_errors_are_enlarged_and_where_truth_is_from(browser, folder):
    with opened(browser, folder / "cases/pendulum.html") as page:
        replay = opened_replay(page)
        # The tip of the upper spoke is 1e-3 rad * 0.5 m + 1e-4 m too far left. A fifth of 4.3 m,
        # from the left end of the box to the right end of the ball, is 1433 times that.
        assert "enlarged by a factor of 1000 so" in replay.inner_text()
        assert "Certified values of x, alpha are drawn" in replay.inner_text()
        assert "truth is drawn from it" in legend_row(replay, "reference exact").inner_text()
        replay.get_by_role("checkbox", name="alpha rk4").uncheck()
        assert "There is no error to draw." in replay.inner_text()


def test_a_replay_shows_several_methods_at_once_and_its_legend_switches_them(browser, folder):
    with opened(browser, folder / "cases/pendulum.html") as page:
        replay = opened_replay(page)
        canvas = replay.locator("canvas")
        truth, alpha, reference = replay.get_by_role("checkbox").all()
        assert [box.is_checked() for box in (truth, alpha, reference)] == [True, True, False]
        red, grey = "#d55e00", "#767676"
        assert has_pixels(canvas, red)
        assert not has_pixels(canvas, grey)
        # By mouse, on the name. The two runs are the same, and the lines of both are seen.
        replay.get_by_text("reference exact", exact=True).click()
        assert has_pixels(canvas, red)
        assert has_pixels(canvas, grey)
        heard = canvas.get_attribute("aria-label")
        assert "alpha rk4 in lines" in heard
        assert "reference exact in lines" in heard
        # By keys.
        both = ink(canvas)
        truth.focus()
        page.keyboard.press("Space")
        assert ink(canvas) != both
        assert "Truth filled" not in canvas.get_attribute("aria-label")
        page.keyboard.press("Tab")
        page.keyboard.press("Space")
        assert not has_pixels(canvas, red)
        assert has_pixels(canvas, grey)


def test_a_contact_of_some_of_the_methods_is_told_with_their_names(browser, folder):
    with opened(browser, folder / "cases/pendulum.html") as page:
        replay = opened_replay(page)
        replay.get_by_label("Time").fill("2")
        now = replay.locator(".now")
        assert "Body 1 has just met something (alpha rk4)." in now.inner_text()
        assert "Body 1 touches the plane." in now.inner_text()


RIGHT = np.array([0.8, 0.0, -0.6])
TOWARDS = np.array([0.6, 0.0, 0.8])
"""Of a reader who looks at a motion from aside."""


def balls_in_space(*balls, angle=0.0):
    """A replay of balls, each (radius, right, towards the reader) [m], that turn by an angle [rad]
    about an axis of space; without a method, links or planes.
    """
    drawn = []
    for radius, right, towards in balls:
        place = right * RIGHT + towards * TOWARDS
        attitude = (1.0, 0.0, 0.0, 0.0)
        drawn.append(DrawnBody(position=tuple(place.tolist()), attitude=attitude, radius=radius))
    given = synthetic.replay("pendulum", "alpha", "rk4")
    half = np.linspace(0.0, angle / 2, len(given.t))
    zero = np.zeros_like(half)
    turn = np.column_stack([np.cos(half) - 1, zero, zero, np.sin(half)])
    return msgspec.structs.replace(
        given,
        bodies=tuple(drawn),
        links=(),
        planes=(),
        touches=False,
        view=(tuple(RIGHT.tolist()), (0.0, 1.0, 0.0), tuple(TOWARDS.tolist())),
        place=Grid.of(np.zeros((len(given.t), 3 * len(drawn)))),
        turn=Grid.of(np.tile(turn, len(drawn))),
        tracks=(),
    )


@contextmanager
def opened_with(browser, folder, replay):
    """The replay of a page that is given this one in place of its own."""
    script = handed_over("refdemReplay", "pendulum", msgspec.to_builtins(replay))
    page = browser.new_page()
    page.set_default_timeout(PATIENCE)
    page.route(
        "**/assets/replay-pendulum.js",
        lambda route: route.fulfill(body=script, content_type="text/javascript"),
    )
    page.goto((folder / "cases/pendulum.html").as_uri())
    yield opened_replay(page)
    page.close()


def test_of_two_equal_balls_the_nearer_one_is_drawn_larger(browser, folder):
    nearer, farther = (0.5, -1.0, 1.0), (0.5, 1.0, -1.0)
    with opened_with(browser, folder, balls_in_space(nearer, farther)) as replay:
        left, right = replay.locator("canvas").evaluate(HEIGHTS)
        # The eye is 9 m from the middle: 9/8 against 9/10, to some pixels.
        assert 1.2 < left / right < 1.3


def test_what_is_nearer_covers_what_is_farther_whatever_their_order(browser, folder):
    nearer, farther = (0.25, 0.0, 1.0), (0.5, 0.25, -1.0)
    seen = set()
    for balls in ((nearer, farther), (farther, nearer)):
        with opened_with(browser, folder, balls_in_space(*balls)) as replay:
            seen.add(ink(replay.locator("canvas")))
    assert len(seen) == 1


def test_the_spin_of_a_ball_in_space_is_seen(browser, folder):
    with opened_with(browser, folder, balls_in_space((0.5, 0.0, 0.0), angle=1.0)) as replay:
        canvas = replay.locator("canvas")
        before = ink(canvas)
        replay.get_by_role("button", name="Step on").click()
        assert ink(canvas) != before


def test_a_replay_takes_the_colours_of_the_page_and_its_width(browser, folder):
    seen = set()
    for scheme in SCHEMES:
        with opened(browser, folder / "cases/pendulum.html", scheme=scheme, width=390) as page:
            replay = opened_replay(page)
            seen.add(ink(replay.locator("canvas")))
            assert page.evaluate("document.documentElement.scrollWidth") <= 390
    assert len(seen) == 2


def test_a_reader_who_asks_for_less_motion_gets_a_frame_a_second(browser, folder):
    with opened(browser, folder / "cases/pendulum.html") as page:
        page.emulate_media(reduced_motion="reduce")
        page.clock.install()
        replay = opened_replay(page)
        assert "a frame a second" in replay.inner_text()
        replay.get_by_role("button", name="Play").click()
        page.clock.run_for(2500)
        now = replay.locator(".now")
        assert "frame 4 of 9" in now.inner_text()
        replay.get_by_role("button", name="Pause").click()
        page.clock.run_for(5000)
        assert "frame 4 of 9" in now.inner_text()


def test_a_replay_with_names_from_a_stranger_shows_them_as_text(browser, folder):
    (path,) = [p for p in pages(folder) if "script" in p.name]
    with opened(browser, path) as page:
        replay = opened_replay(page)
        assert replay.locator("script, img").count() == 0
        assert "<script>alert(1)</script>" in replay.locator(".tracks").inner_text()


def test_a_replay_that_is_missing_or_broken_is_said_to_be(browser, folder):
    def missing(route):
        route.abort()

    def broken(route):
        route.fulfill(body='refdemReplay("pendulum", {});', content_type="text/javascript")

    for answer, words in ((missing, "could not be loaded"), (broken, "cannot be drawn")):
        page = browser.new_page()
        page.set_default_timeout(PATIENCE)
        page.route("**/assets/replay-pendulum.js", answer)
        page.goto((folder / "cases/pendulum.html").as_uri())
        page.locator("details.replay summary").click()
        said = page.get_by_text(words)
        said.wait_for()
        assert said.is_visible()
        page.close()


def column(page, table, number):
    """The texts of a column in the rows that are seen, without the names of groups."""
    cells = page.locator(f"{table} tbody tr:not(.group):visible > :nth-child({number})")
    return [text.strip() for text in cells.all_inner_texts()]


def test_a_click_on_a_header_sorts_numbers_as_numbers_and_a_third_one_ends_it(browser, folder):
    with opened(browser, folder / "cases/pendulum.html") as page:
        table = "table.tolerance"
        header = page.locator(f"{table} thead th").nth(3)
        button = header.get_by_role("button")
        before = column(page, table, 4)
        button.focus()
        page.keyboard.press("Enter")
        assert header.get_attribute("aria-sort") == "ascending"
        held = column(page, table, 4)
        numbers = [float(text) for text in held if text != "none"]
        assert len(numbers) > 3
        assert numbers == sorted(numbers)
        # As words, "0.8" would come before "2e-8".
        assert held[: len(numbers)] != sorted(held[: len(numbers)])
        assert sorted(held) == sorted(before)
        page.keyboard.press("Space")
        assert header.get_attribute("aria-sort") == "descending"
        falling = column(page, table, 4)
        assert [float(text) for text in falling if text != "none"] == numbers[::-1]
        # What is absent comes last in both directions.
        absent = len(held) - len(numbers)
        assert held[len(numbers) :] == falling[len(numbers) :] == ["none"] * absent
        button.click()
        assert header.get_attribute("aria-sort") is None
        assert column(page, table, 4) == before
        # A header that is clicked later takes the mark from the first one.
        button.click()
        page.locator(f"{table} thead th").first.get_by_role("button").click()
        assert page.locator(f"{table} [aria-sort]").count() == 1
        assert column(page, table, 1) == sorted(column(page, table, 1))


def test_groups_stay_together_and_follow_their_first_row(browser, folder):
    with opened(browser, folder / "index.html") as page:
        groups = page.locator("#tolerance-rows tbody")
        before = groups.all_inner_texts()
        page.get_by_label("Show only rows with").fill("reference")
        page.locator("#tolerance-rows thead button").nth(3).click()
        firsts = [
            group.locator("tr.joined:visible td").nth(3).inner_text()
            for group in groups.all()
            if group.is_visible()
        ]
        assert [float(text) for text in firsts] == sorted(map(float, firsts))
        for group in groups.all():
            assert group.locator("tr").first.get_attribute("class") == "group"
        for _ in range(2):
            page.locator("#tolerance-rows thead button").nth(3).click()
        page.get_by_label("Show only rows with").fill("")
        assert groups.all_inner_texts() == before
        # A header that has a link keeps it, and gets a button beside it.
        engine = page.locator("#digits-rows thead th").nth(1)
        engine.get_by_role("button", name="Sort by").click()
        assert engine.get_attribute("aria-sort") == "ascending"
        assert engine.locator("a").count() == 1


def test_a_part_that_is_missing_is_said_to_be(browser, folder):
    page = browser.new_page()
    page.set_default_timeout(PATIENCE)
    page.route("**/assets/index-digits.js", lambda route: route.abort())
    page.goto((folder / "index.html").as_uri())
    place = page.locator("[data-part=digits]")
    place.scroll_into_view_if_needed()
    page.get_by_text("could not be loaded").wait_for()
    assert "assets/index-digits.js is missing" in place.inner_text()
    page.close()


def test_a_case_with_many_passes_and_values_is_printed_on_four_sheets(browser, tmp_path):
    sheet = synthetic.case_sheet("long", "long", "A long case", r"\ddot x=0")
    scalars = {f"impact_{number}": ("1.25", "1e-16") for number in range(200)}
    sheets = [msgspec.structs.replace(sheet, truth_scalars=scalars)]
    for number in range(20):
        passes = [synthetic.error(f"x{k}", 1e-3, 2) for k in range(12)]
        undecided = synthetic.said("order", "undecided", "Undecided: 2 levels count.")
        sheets.append(synthetic.record("long", "long", "alpha", f"m{number}", *passes, undecided))
    write_report(tmp_path, sheets)
    with opened(browser, tmp_path / "cases/long.html") as page:
        sheets_of_paper = page.pdf(format="A4").count(b"/Type /Page\n")
        assert 1 < sheets_of_paper <= 4
        page.emulate_media(media="print")
        assert not page.locator("tr.pass:visible").count()
        assert page.locator("tr.undecided:visible").count() == 20
        assert page.get_by_text("What passed is counted above").is_visible()
