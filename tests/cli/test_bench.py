"""The command from end to end, in this process."""

from pathlib import Path

import msgspec
import pytest
import typer

from refdem.bench.record import read
from refdem.cli.bench import command, grown
from refdem.errors import UsageError

SMALL = {
    "method": "rk4",
    "most_steps": 2e3,
    "rounds": 4,
    "peers": False,
    "memory": False,
    "stability": False,
    "longest": 0.3,
}
REST = {"set": ["duration=4"], "grow": None, "engine": ["reference"]}


def ended(out: Path, against: Path | None = None) -> int:
    """The exit status of a small bench."""
    with pytest.raises(typer.Exit) as end:
        command(["harmonic-oscillator"], against=against, out=out, **SMALL, **REST)
    return end.value.exit_code


def test_a_bench_writes_its_record_and_its_pages(tmp_path: Path) -> None:
    assert ended(tmp_path) == 0
    record = read(tmp_path / "bench.json")
    assert [curve.method for curve in record.curves] == ["rk4"]
    assert "to 1e-3" in (tmp_path / "bench.md").read_text()
    assert "assets/report.js" in (tmp_path / "bench.html").read_text()
    assert "vegaEmbed" in (tmp_path / "assets" / "vega.js").read_text()
    assert (tmp_path / "bench-1.svg").read_text().startswith("<svg")


def test_a_code_that_was_a_thousand_times_faster_is_told_from_this_one(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        "refdem.report.bench.write", lambda *pages: None
    )  # drawn in the test before
    ended(tmp_path)
    then = read(tmp_path / "bench.json")
    (curve,) = then.curves
    fast = [
        msgspec.structs.replace(point, rounds=[seconds / 1000 for seconds in point.rounds])
        for point in curve.points
    ]
    before = msgspec.structs.replace(then, curves=[msgspec.structs.replace(curve, points=fast)])
    (tmp_path / "then.json").write_bytes(msgspec.json.encode(before))
    assert ended(tmp_path, tmp_path / "then.json") == 1
    assert "slower" in capsys.readouterr().out


def test_values_of_a_parameter_come_as_a_list() -> None:
    assert grown(["samples=64,128"]) == {"samples": ["64", "128"]}
    with pytest.raises(UsageError, match="expected name=value"):
        grown(["samples"])
