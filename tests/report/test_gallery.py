"""The gallery's files: nothing that a name could smuggle in, curves thinned to what is seen, clouds
as pictures.
"""

import base64
import struct
import zlib
from dataclasses import replace

import numpy as np
import pytest

from refdem.core.figure import Axis, Figure, Panel, Series
from refdem.errors import UsageError
from refdem.report import write_gallery
from refdem.report.panels import density, kept, pixels

NASTY = '<script>alert("x")</script> | *a* </script>'
X = np.linspace(0.0, 1.0, 5001)


def panel(*series):
    return Panel(
        series=series,
        x=Axis(title=NASTY, ends=(0.0, 1.0)),
        y=Axis(title="y", ends=(-1.0, 1.0)),
        title=NASTY,
        size=(200, 100),
    )


LINE = Series(x=X, y=np.sin(20 * X), label=NASTY)
CLOUD = Series(x=X, y=X**2, mark="cloud", ink=1)
WORD = Series(x=X[:1], y=X[:1], mark="text", words=(NASTY,))
FIGURE = Figure(
    id="9.9",
    title=NASTY,
    caption=NASTY,
    panels=(panel(LINE, WORD), panel(CLOUD)),
    numbers={NASTY: 1.5},
    commands=(NASTY,),
)


def test_names_are_written_as_text(tmp_path):
    write_gallery(tmp_path, [FIGURE], version="1")
    page = (tmp_path / "gallery.html").read_text()
    text = (tmp_path / "gallery.md").read_text()
    assert "<script>alert" not in page
    assert "<script>alert" not in text.split("```")[0]
    assert "<script>alert" not in (tmp_path / "fig-9-9.svg").read_text()
    assert (tmp_path / "assets" / "vega.js").stat().st_size > 100_000


def test_pictures_of_figures_that_are_gone_are_removed(tmp_path):
    write_gallery(tmp_path, [FIGURE], version="1")
    write_gallery(tmp_path, [], version="1")
    assert list(tmp_path.glob("*.svg")) == []


def test_figures_that_are_not_made_again_stay_in_pictures_page_and_text(tmp_path):
    other = replace(FIGURE, id="co-4", commands=("refdem gallery co-4",))
    every = ["9.9", "co-4"]
    write_gallery(tmp_path / "whole", [FIGURE, other], version="1", every=every)
    write_gallery(tmp_path / "parts", [other], version="1", every=[*every, "9.10"])
    write_gallery(
        tmp_path / "parts", [replace(FIGURE, id="9.10")], version="1", every=[*every, "9.10"]
    )
    assert (tmp_path / "parts" / "fig-9-10.svg").exists()
    write_gallery(tmp_path / "parts", [FIGURE], version="1", every=every)
    files = ["fig-9-9.svg", "fig-co-4.svg", "gallery.html", "gallery.md"]
    assert sorted(path.name for path in (tmp_path / "parts").iterdir() if path.is_file()) == files
    for name in files:
        assert (tmp_path / "parts" / name).read_bytes() == (
            tmp_path / "whole" / name
        ).read_bytes(), name


def test_a_curve_is_thinned_but_nowhere_off_by_a_third_of_a_pixel():
    own = panel(LINE)
    pick = kept(LINE, own)
    place = pixels(LINE, own)
    drawn = np.interp(place[:, 0], place[pick, 0], place[pick, 1])
    assert len(pick) < 300
    assert np.abs(drawn - place[:, 1]).max() < 0.35 * np.hypot(1, 20 * 50 / 200)


def test_a_break_in_a_curve_stays():
    y = np.where((X > 0.4) & (X < 0.6), np.nan, X)
    broken = Series(x=X, y=y)
    pick = kept(broken, panel(broken))
    assert np.isnan(y[pick]).sum() == 1


def test_a_cloud_has_its_points_where_they_are():
    spot = Series(x=np.array([0.25]), y=np.array([0.5]), mark="cloud", width=0.5)
    data = base64.b64decode(density(spot, panel(spot)).partition(",")[2])
    width, height = struct.unpack(">II", data[16:24])
    begin = data.index(b"IDAT") + 4
    lines = np.frombuffer(zlib.decompressobj().decompress(data[begin:]), np.uint8)
    rows = lines.reshape(height, -1)[:, 1:]
    dots = np.stack((rows >> 4, rows & 15), axis=2).reshape(height, width)
    assert [tuple(map(int, place)) for place in np.argwhere(dots)] == [(49, 100)]


def test_series_that_do_not_fit_are_refused():
    with pytest.raises(UsageError, match="shapes"):
        Series(x=X, y=X[1:])
    with pytest.raises(UsageError, match="words"):
        Series(x=X, y=X, mark="text")


def test_a_report_links_to_the_gallery_if_there_is_one(tmp_path):
    from refdem.report import write_report

    write_report(tmp_path, [])
    assert "gallery/gallery.html" not in (tmp_path / "index.html").read_text()
    write_gallery(tmp_path / "gallery", [], version="1")
    write_report(tmp_path, [])
    assert "gallery/gallery.html" in (tmp_path / "index.html").read_text()
