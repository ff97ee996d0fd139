"""The replays of a report: a script a case, which hands over numbers and names and nothing else."""

import json

from refdem.report import chart_data, write_report
from refdem.report.contents import contents_of, page
from refdem.report.replays import looks_of
from refdem.report.tolerance import rows_of
from tests.report import synthetic


def handed_over(path):
    """The name and the replay of a script: a call with two arguments and nothing else."""
    call = path.read_text()
    assert call.startswith("refdemReplay(")
    assert call.endswith(");\n")
    return json.loads("[" + call[len("refdemReplay(") : -len(");\n")] + "]")


def test_a_script_has_the_frames_and_a_colour_for_each_method(folder):
    name, replay = handed_over(folder / "assets/replay-pendulum.js")
    assert name == "pendulum"
    given = synthetic.replay("pendulum", "alpha", "rk4")
    assert replay["place"] == {
        "scale": given.place.scale,
        "columns": list(given.place.columns),
        "data": given.place.data,
    }
    assert [track["method"] for track in replay["tracks"]] == ["rk4", "exact"]
    assert [track["is_anchor"] for track in replay["tracks"]] == [False, True]
    assert len({track["colour"] for track in replay["tracks"]}) == 2


def test_a_method_has_the_colour_and_the_shape_of_its_charts(sheets):
    contents = contents_of(sheets)
    looks = looks_of(contents, contents.replays["pendulum"])
    chart = chart_data.errors(contents, rows_of(contents, "pendulum"))
    drawn = {series: (colour, shape) for series, colour, shape in chart.styles}
    assert looks["alpha rk4"] == drawn["alpha rk4"]


def test_names_from_strangers_end_no_script(folder):
    label = f"{synthetic.HOSTILE}[x=1]"
    path = folder / f"assets/replay-{page(label)}.js"
    assert "</script" not in path.read_text()
    _, replay = handed_over(path)
    assert replay["tracks"][0]["engine"] == synthetic.HOSTILE


def test_a_page_has_a_replay_if_its_case_has_one(folder):
    assert "data-replay" in (folder / "cases/pendulum.html").read_text()
    other = folder / f"cases/{page('pendulum[theta0=3 mass=2]')}.html"
    assert "data-replay" not in other.read_text()


def test_a_replay_that_is_no_longer_reported_is_removed(tmp_path, store):
    sheets = synthetic.sheets()
    write_report(tmp_path, sheets, store)
    assert (tmp_path / "assets/replay-pendulum.js").is_file()
    without = [sheet for sheet in sheets if type(sheet).__name__ != "Replay"]
    write_report(tmp_path, without, store)
    assert not list(tmp_path.glob("assets/replay-*.js"))
    assert (tmp_path / "assets/replay.js").is_file()


def test_a_report_made_again_from_its_records_has_the_same_replays(folder, tmp_path, store):
    from refdem.report import read_records

    write_report(tmp_path, read_records(folder), store)
    for path in folder.glob("assets/replay-*.js"):
        assert path.read_bytes() == (tmp_path / "assets" / path.name).read_bytes()
