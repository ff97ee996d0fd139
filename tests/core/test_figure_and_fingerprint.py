"""Ends of the axes of a picture, and digests of all that can change a result."""

import hashlib

import numpy as np
import pytest

from refdem.core import fingerprint
from refdem.core.figure import GREY, Axis, Figure, Panel, Series, file_name
from refdem.errors import UsageError


def curve(*y, **more):
    """A series with these values of y over 0, 1, 2, ..."""
    return Series(x=np.arange(float(len(y))), y=np.array(y, float), **more)


def ends(axis, *series):
    """The ends of y."""
    return Panel(series=series, x=Axis(), y=axis).ends("y")


def test_an_axis_ends_a_twenty_fifth_beyond_all_finite_data():
    assert ends(Axis(), curve(1.0, 3.0), curve(np.nan, 6.0)) == pytest.approx((0.8, 6.2))
    assert ends(Axis(ends=(2.0, 9.0)), curve(1.0, 3.0)) == (2.0, 9.0)
    assert ends(Axis(is_log=True), curve(1.2, 30.0)) == pytest.approx((1.0, 36.0))
    assert ends(Axis(), curve(5.0, 5.0)) == (4.0, 6.0)


def test_a_series_has_as_many_y_as_x_and_a_word_a_place():
    with pytest.raises(UsageError, match=r"have shapes \(2,\) and \(3,\)"):
        Series(x=np.zeros(2), y=np.zeros(3))
    with pytest.raises(UsageError, match="expected"):
        Series(x=np.zeros((2, 2)), y=np.zeros((2, 2)))
    with pytest.raises(UsageError, match="N >= 1"):
        Series(x=np.zeros(0), y=np.zeros(0))
    with pytest.raises(UsageError, match="1 words for 2 places"):
        curve(1.0, 2.0, mark="text", words=("a",))
    told = curve(1.0, 2.0, mark="text", words=("a", "b"))
    assert (told.ink, told.width, told.dashed, GREY) == (0, 1.5, False, -1)


def test_a_figure_is_named_for_its_number():
    panel = Panel(series=(curve(1.0),), x=Axis(), y=Axis())
    assert panel.size == (460, 280)
    figure = Figure(id="1.15", title="", caption="", panels=(panel,))
    assert (figure.name, figure.columns, file_name("co-4")) == ("fig-1-15", 1, "fig-co-4")


def test_a_digest_of_files_is_of_their_names_and_contents_in_order(tmp_path):
    first = tmp_path / "a.txt"
    second = tmp_path / "b.txt"
    first.write_bytes(b"one")
    second.write_bytes(b"two")
    whole = hashlib.sha256()
    for name, data in ((b"a.txt", b"one"), (b"b.txt", b"two")):
        whole.update(name + b"\0" + hashlib.sha256(data).digest())
    assert fingerprint.of_files([second, first]) == whole.hexdigest()


def test_a_digest_of_a_folder_sees_places_and_leaves_out_what_is_made_of_it(tmp_path):
    (tmp_path / "sub").mkdir()
    (tmp_path / "sub/a.py").write_bytes(b"one")
    plain = fingerprint.of_tree(tmp_path)
    (tmp_path / ".hidden").write_bytes(b"x")
    (tmp_path / "a.pyc").write_bytes(b"x")
    assert fingerprint.of_tree(tmp_path) == plain
    (tmp_path / "sub/a.py").rename(tmp_path / "a.py")
    assert fingerprint.of_tree(tmp_path) != plain


def test_digests_of_refdem_see_its_own_files():
    one = fingerprint.of_source("core/figure.py")
    folder = fingerprint.of_source("core")
    assert len({one, folder, fingerprint.of_source("core/figure.py", "core/run.py")}) == 3
    assert fingerprint.of_source("core/figure.py") == one
    assert fingerprint.of_package("no-such-package-is-installed") == "missing"
    assert fingerprint.of_package("numpy") != "missing"
    assert len(fingerprint.of_machine()) == len(fingerprint.of_refdem()) == 64


def test_a_module_is_known_by_its_own_files(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "alone_in_a_folder.py").write_text("x = 1\n")
    import alone_in_a_folder  # noqa: F401

    before = fingerprint.of_module("alone_in_a_folder")
    (tmp_path / "alone_in_a_folder.py").write_text("x = 2\n")
    assert fingerprint.of_module("alone_in_a_folder") != before
    (tmp_path / "beside.py").write_text("x = 3\n")
    after = fingerprint.of_module("alone_in_a_folder")
    (tmp_path / "beside.py").write_text("x = 4\n")
    assert fingerprint.of_module("alone_in_a_folder") == after
