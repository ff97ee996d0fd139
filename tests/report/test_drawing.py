"""Pictures from processes of their own are those that this process draws, and nothing is lost if
such a process fails.
"""

import io
import json
import sys
from types import SimpleNamespace

import pytest

from refdem.report import drawing


def spec_of(height: int) -> str:
    """A chart of one point, which differs from others by its height [pixels]."""
    mark = {"data": {"values": [{"x": 1}]}, "mark": "point", "height": height}
    return json.dumps({**mark, "encoding": {"x": {"field": "x", "type": "quantitative"}}})


SPECS = [spec_of(100 + number) for number in range(2 * drawing.MANY + 1)]


@pytest.fixture(scope="module")
def drawn_here() -> list[str]:
    """The pictures as this process draws them."""
    pictures = [drawing.drawn(spec) for spec in SPECS]
    assert len(set(pictures)) == len(SPECS)
    return pictures


def test_processes_draw_what_this_one_draws_in_the_same_order(
    drawn_here: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("refdem.report.drawing.os.cpu_count", lambda: 2)
    monkeypatch.setattr(drawing, "drawn", None)
    assert drawing.all_drawn(SPECS) == drawn_here


@pytest.mark.parametrize("python", ["/bin/false", "/nowhere/python"])
def test_where_a_process_fails_this_one_draws(
    python: str, drawn_here: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("refdem.report.drawing.os.cpu_count", lambda: 2)
    monkeypatch.setattr("refdem.report.drawing.sys.executable", python)
    assert drawing.all_drawn(SPECS) == drawn_here


def test_a_few_are_drawn_here(drawn_here: list[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(drawing, "subprocess", None)
    few = drawing.MANY - 1
    assert drawing.all_drawn(SPECS[:few]) == drawn_here[:few]
    assert drawing.all_drawn([]) == []


def test_a_process_whose_parent_is_gone_draws_no_more(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = io.BytesIO(json.dumps(SPECS).encode())
    answered = io.BytesIO()
    parents = iter([7, 7, 1])
    monkeypatch.setattr(sys, "stdin", SimpleNamespace(buffer=asked))
    monkeypatch.setattr(sys, "stdout", SimpleNamespace(buffer=answered))
    monkeypatch.setattr("refdem.report.drawing.os.getppid", lambda: next(parents))
    with pytest.raises(SystemExit):
        drawing.main()
    assert answered.getvalue() == b""
