"""The written report: the same for the same records, without times where it is committed, and safe
with any name.
"""

import json
import re
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit
from xml.etree import ElementTree

import pytest
from msgspec.structs import replace

from refdem.core.finding import CampaignSheet, Finding, Record
from refdem.report import write_report
from refdem.report.contents import advice, contents_of
from refdem.report.junit import junit
from refdem.report.mathml import equations
from tests.report import synthetic

COMMITTED = ("validation.md", "figures.md", "figures/*.svg")


class Page(HTMLParser):
    """Links, ids, elements and specifications of a page."""

    def __init__(self, text):
        super().__init__()
        self.links = []
        self.ids = []
        self.tags = []
        self.images = []
        self.handlers = []
        self.specs = {}
        self._inside = None
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        self.tags.append(tag)
        self.ids += [attributes["id"]] if "id" in attributes else []
        self.links += [attributes[name] for name in ("href", "src") if name in attributes]
        self.images += [attributes["src"]] if tag == "img" else []
        self.handlers += [name for name in attributes if name.startswith("on")]
        if attributes.get("type") == "application/json":
            self._inside = attributes["id"]
        else:
            self._inside = None

    def handle_data(self, data):
        if self._inside:
            self.specs[self._inside] = data
            self._inside = None


@pytest.fixture(scope="session")
def pages(folder):
    return {path: Page(path.read_text()) for path in sorted(folder.rglob("*.html"))}


@pytest.fixture(scope="session")
def parts(folder):
    """The parts of the index, as the page has them once they are loaded."""
    return {path.name: Page(html_of(path)) for path in sorted(folder.glob("assets/index-*.js"))}


def html_of(path):
    """What a part hands over: a call with two strings and nothing else."""
    call = path.read_text()
    assert call.startswith("refdemPart(")
    assert call.endswith(");\n")
    name, html = json.loads("[" + call[len("refdemPart(") : -len(");\n")] + "]")
    assert path.name == f"index-{name}.js"
    return html


def test_every_file_of_a_report_is_there(folder):
    names = {str(path.relative_to(folder)) for path in folder.rglob("*") if path.is_file()}
    assert {
        "index.html",
        "engines.html",
        "cases/pendulum.html",
        "assets/vega.js",
        "assets/report.js",
        "assets/report.css",
        "assets/index-tolerance.js",
        "validation.md",
        "figures.md",
        "figures/tolerance.svg",
        "figures/pendulum.svg",
        "junit.xml",
        "records.jsonl",
        "findings.csv",
        "tolerance.csv",
    } <= names


def test_every_link_and_anchor_resolves(folder, pages, parts):
    broken = []
    index = folder / "index.html"
    for path, page in [*pages.items(), *((index, part) for part in parts.values())]:
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme == "data":
                continue
            assert not parts.scheme, link
            if parts.path:
                target = (path.parent / unquote(parts.path)).resolve()
            else:
                target = path
            if not target.is_file() or (
                parts.fragment
                and target.suffix == ".html"
                and parts.fragment not in pages[target].ids
            ):
                broken.append((path.name, link))
    assert broken == []


def test_no_id_is_used_twice_in_a_page(pages):
    assert [path.name for path, page in pages.items() if len(page.ids) != len(set(page.ids))] == []


def test_names_from_strangers_are_text(pages, parts):
    for path, page in pages.items():
        # The one script of a page is report.js.
        assert page.tags.count("script") == len(page.specs) + (path.name != "engines.html")
        assert path.parent.name != "cases" or page.specs
    for part in parts.values():
        assert part.tags.count("script") == len(part.specs)
    for page in [*pages.values(), *parts.values()]:
        assert page.handlers == []
        assert all(source.endswith(".svg") for source in page.images), (
            "an image of a chart, none of a stranger"
        )
        texts = [json.dumps(json.loads(spec)) for spec in page.specs.values()]
        assert not texts or any(synthetic.HOSTILE in text for text in texts), (
            "the name is there, as it is"
        )


def test_a_part_is_one_call_that_nothing_in_it_can_end(folder, parts):
    names = ("digits", "invariants", "overview", "tolerance")
    assert set(parts) == {f"index-{name}.js" for name in names}
    for name in parts:
        text = (folder / "assets" / name).read_text()
        assert text.count("\n") == 1
        for ending in ("</", "<!--", "\u2028", "\u2029"):
            assert ending not in text
    assert synthetic.HOSTILE.replace("&", "&amp;").replace("<", "&lt;").replace(">", "&gt;") in (
        html_of(folder / "assets/index-tolerance.js")
    )


def test_specifications_are_json_that_cannot_end_their_script(pages, parts):
    specs = [spec for page in [*pages.values(), *parts.values()] for spec in page.specs.values()]
    assert len(specs) == 1 + 3 * 3
    for spec in specs:
        assert json.loads(spec)["$schema"].startswith("https://vega.github.io/schema/vega-lite/v6")
        assert "<" not in spec


def test_specifications_satisfy_the_schema_of_vega_lite(pages, parts):
    import altair

    specs = [spec for page in [*pages.values(), *parts.values()] for spec in page.specs.values()]
    charts = [altair.Chart.from_dict(json.loads(spec), validate=True) for spec in specs]
    assert len(charts) == 1 + 3 * 3


def test_the_committed_files_are_the_same_bytes_for_the_same_records_in_any_order(
    folder, sheets, tmp_path
):
    write_report(tmp_path, list(reversed(sheets)))
    for pattern in COMMITTED:
        names = sorted(path.name for path in folder.glob(pattern))
        assert names
        assert names == sorted(path.name for path in tmp_path.glob(pattern))
    for pattern in COMMITTED:
        for path in folder.glob(pattern):
            assert path.read_bytes() == (tmp_path / path.relative_to(folder)).read_bytes()


def test_the_committed_files_do_not_know_how_long_anything_took(folder, sheets, tmp_path):
    def slower(sheet):
        text = json.dumps(sheet)
        return json.loads(
            re.sub(
                r'"seconds": ([0-9.e+-]+)', lambda match: f'"seconds": {float(match[1]) * 7}', text
            )
        )

    lines = [json.loads(line) for line in (folder / "records.jsonl").read_text().splitlines()]
    (tmp_path / "records.jsonl").write_text("\n".join(json.dumps(slower(line)) for line in lines))
    from refdem.report import read_records

    again = read_records(tmp_path)
    assert again != sheets
    write_report(tmp_path, again)
    for pattern in COMMITTED:
        for path in folder.glob(pattern):
            assert path.read_bytes() == (tmp_path / path.relative_to(folder)).read_bytes()


def test_the_pictures_are_well_formed_and_have_marks(folder):
    for path in folder.glob("figures/*.svg"):
        tree = ElementTree.fromstring(path.read_bytes())
        assert len(list(tree.iter("{http://www.w3.org/2000/svg}path"))) > 10
        assert not list(tree.iter("{http://www.w3.org/2000/svg}script"))


def test_the_rows_of_a_table_in_markdown_have_as_many_cells_as_its_head(folder):
    text = (folder / "validation.md").read_text()
    tables = re.findall(r"(?:^\|.*\n)+", text, re.MULTILINE)
    assert len(tables) == 4
    for table in tables:
        assert len({len(re.findall(r"(?<!\\)\|", line)) for line in table.splitlines()}) == 1


def test_markdown_has_no_markup_of_a_stranger(folder):
    text = (folder / "validation.md").read_text() + (folder / "figures.md").read_text()
    assert "<script" not in text
    assert "<img" not in text
    assert not re.search(r"(?<!\\)`", text)


def test_the_pages_in_markdown_show_every_figure_and_no_other(folder):
    def shown_in(page):
        return re.findall(r"\]\((figures/[^)]*)\)", (folder / page).read_text())

    assert shown_in("validation.md") == ["figures/tolerance.svg"]
    shown = ["figures/tolerance.svg", *shown_in("figures.md")]
    drawn = [f"figures/{path.name}" for path in (folder / "figures").iterdir()]
    assert sorted(shown) == sorted(drawn)


def test_junit_counts_failures_and_skips_with_their_reasons(folder, sheets):
    suite = ElementTree.parse(folder / "junit.xml").getroot().find("testsuite")
    assert len(list(suite)) == sum(
        len(sheet.findings) for sheet in sheets if isinstance(sheet, Record)
    )
    assert {key: suite.get(key) for key in ("failures", "errors", "skipped")} == {
        "failures": "7",
        "errors": "2",
        "skipped": "4",
    }
    assert len(suite.findall("testcase/failure")) == 7
    assert suite.find("testcase/error").get("message") == "The engine crashed: signal 11 at step 3."
    assert "gamma has no rod." in {
        skipped.get("message") for skipped in suite.findall("testcase/skipped")
    }


def test_the_findings_of_a_record_share_the_seconds_of_its_runs(sheets):
    records = [sheet for sheet in sheets if isinstance(sheet, Record)]
    timed = [
        replace(record, seconds=float(number)) for number, record in enumerate(records, start=1)
    ]
    document = junit(contents_of([sheet for sheet in sheets if sheet not in records] + timed))
    suite = ElementTree.fromstring(document).find("testsuite")
    seconds = sum(float(item.get("time")) for item in suite.findall("testcase"))
    expected = sum(record.seconds for record in timed if record.findings)
    assert seconds == pytest.approx(expected, abs=1e-6 * len(list(suite)))
    assert float(suite.get("time")) == pytest.approx(sum(record.seconds for record in timed))


def test_junit_is_well_formed_whatever_a_sentence_holds():
    finding = Finding(
        check="error",
        quantity="x\x00",
        outcome="fail",
        sentence="\x1b[31m]]> \ud800 \ufffe <a>&",
        basis="\x08",
    )
    record = Record(
        case="c",
        label="c",
        parameters={},
        engine="e\x07",
        version="1",
        method="m",
        is_reference=False,
        runs=(),
        findings=(finding,),
    )
    suite = ElementTree.fromstring(
        junit(
            contents_of(
                [CampaignSheet(name="\x0c", refdem="", runs_made=0, runs_read=0, seconds=0), record]
            )
        )
    )
    assert suite.find("testsuite/testcase/failure").get("message").endswith("<a>&")


def test_equations_are_mathml_and_nothing_else():
    one, two = equations(r"\ddot x+\frac{k}{m}x=0,\qquad \left(a\quad b\right)")
    assert one.startswith('<math display="block">')
    assert "<mfrac>" in one
    assert "b" in two
    hostile = "".join(
        equations(
            r"\text{<script>alert(1)</script>}\href{javascript:alert(1)}{x}\style{background:url(x)}{y}\class{z}{w}"
        )
    )
    assert "<script" not in hostile
    assert not re.search(r"\b(href|style|class)=", hostile)
    assert "&lt;script&gt;" in hostile


def test_what_is_no_latex_is_shown_as_it_is():
    assert equations(r"\frac{<b>")[0].count("<b>") == 0
    assert equations("") == []


def test_a_stranger_is_told_what_the_worst_outcome_asks_for():
    assert "not passes" in advice({"undecided": 1, "pass": 7})
    assert "above its bound" in advice({"fail": 1, "undecided": 1})
    # An error first: what follows from it is told under it.
    assert "broke the contract" in advice({"fail": 1, "error": 1})
    assert "nothing was judged" in advice({})


def test_a_report_of_nothing_is_a_report(tmp_path):
    write_report(tmp_path, [])
    assert "nothing was judged" in (tmp_path / "index.html").read_text()


def test_a_report_over_another_leaves_nothing_of_it_and_nothing_else_is_touched(
    tmp_path, sheets, store
):
    write_report(tmp_path, sheets, store)
    (tmp_path / "figures/mine.svg").write_text("mine")
    write_report(
        tmp_path,
        [synthetic.record("a", "a", "alpha", "rk4", synthetic.error("x", 1e-3, 4))],
        store,
    )
    assert [path.name for path in (tmp_path / "cases").iterdir()] == ["a.html"]
    assert sorted(path.name for path in (tmp_path / "figures").iterdir()) == [
        "a.svg",
        "mine.svg",
        "tolerance.svg",
    ]


def test_a_record_without_sheets_of_its_case_and_engine_is_reported(tmp_path):
    write_report(
        tmp_path,
        [synthetic.record("pendulum", "pendulum", "alpha", "rk4", synthetic.error("x", 1e-3, 4))],
    )
    assert "alpha" in (tmp_path / "cases/pendulum.html").read_text()


def test_a_report_whose_charts_are_in_the_store_imports_no_tables_and_no_charts(
    folder, store, tmp_path
):
    code = (
        "import sys; from pathlib import Path; from refdem.core.store import Store; from"
        f" refdem.report import read_records, write_report; write_report(Path({str(tmp_path)!r}),"
        f" read_records(Path({str(folder)!r})), Store(Path({str(store.path)!r}))); print([name for"
        " name in ('altair', 'pandas', 'vl_convert') if name in sys.modules])"
    )
    assert (
        subprocess.run(
            [sys.executable, "-c", code], capture_output=True, text=True, check=True
        ).stdout.strip()
        == "[]"
    )
    assert (tmp_path / "index.html").read_bytes() == (folder / "index.html").read_bytes()


def test_colours_of_engines_stand_out_from_both_backgrounds():
    from refdem.report.palette import ENGINES, REFERENCE

    style = (Path(__file__).parents[2] / "refdem/report/assets/report.css").read_text()
    backgrounds = re.findall(r"--page: (#[0-9a-f]{6})", style)
    assert len(backgrounds) == 2
    for colour in (*ENGINES, REFERENCE):
        assert all(contrast(colour, background) >= 3.0 for background in backgrounds), colour


def contrast(one, other):
    """Contrast of two colours after WCAG 2.2."""

    def luminance(colour):
        parts = [int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)]
        linear = [
            part / 12.92 if part <= 0.04045 else ((part + 0.055) / 1.055) ** 2.4 for part in parts
        ]
        return sum(
            weight * part for weight, part in zip((0.2126, 0.7152, 0.0722), linear, strict=True)
        )

    low, high = sorted((luminance(one), luminance(other)))
    return (high + 0.05) / (low + 0.05)


def test_a_report_links_to_the_site_if_there_is_one(tmp_path):
    from refdem.report import write_report

    write_report(tmp_path, [])
    assert "site/index.html" not in (tmp_path / "index.html").read_text()
    (tmp_path / "site").mkdir()
    (tmp_path / "site" / "index.html").write_text("")
    write_report(tmp_path, [])
    assert '<a href="site/index.html">' in (tmp_path / "index.html").read_text()
