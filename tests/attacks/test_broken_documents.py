"""What fuzzing found in documents, a class a test: each is refused by a sentence, none is read in
part.
"""

import json
from pathlib import Path

import pytest

from refdem.core import discovery
from refdem.core.problem import Request
from refdem.core.store import Store
from refdem.errors import RefdemError, SceneError, UsageError
from refdem.gate import baseline
from refdem.planning import exchange, required, specification
from refdem.scene import Scene

DEEP = b'{"a":' * 100_000
NO_TEXT = b'{"bodies": [], "\xff\xfe": 1}'
HEADER = {"format": 2, "engine": "small", "version": "1.0", "why": "first"}
ENTRY = {"id": "pendulum/small/rk4/error/x", "outcome": "pass", "value": 1e-9, "constant": None}
MANIFEST = {"refdem": "0.1.0", "case": [{"id": "pendulum"}], "levels": 4}


def asked() -> dict:  # type: ignore[type-arg]
    """A request as a document."""
    problem = discovery.case("harmonic-oscillator").at(samples="4").problem
    request = Request(problem=problem, method="m", step=problem.interval / 4)
    found: dict = json.loads(request.to_json())  # type: ignore[type-arg]
    return found


@pytest.mark.parametrize("data", [DEEP, NO_TEXT, b"", b"\xef\xbb\xbf{}"])
def test_what_is_no_json_is_no_scene_and_no_request(data: bytes) -> None:
    with pytest.raises(SceneError, match=r"^scene: "):
        Scene.from_json(data)
    with pytest.raises(UsageError, match=r"^request: "):
        Request.from_json(data)


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"format": 64}, "format is 64; expected 1"),
        ({"stridd": 4}, "unknown field `stridd`; did you mean 'stride'"),
        ({"step": 1e-310, "stride": 4}, "step is"),
        ({"times": [0.0, 1e308]}, "times"),
        ({"times": [-1e308, 1e308], "step": None}, "times"),
    ],
)
def test_a_request_of_another_kind_is_refused(change: "dict[str, object]", says: str) -> None:
    with pytest.raises(RefdemError, match=says):
        Request.from_json(json.dumps(asked() | {"stride": None} | change).encode())


def test_a_question_that_says_more_than_its_kind_has_is_refused() -> None:
    problem = discovery.case("logistic").at().problem
    document = json.loads(Request(problem=problem, method="m").to_json())
    document["problem"]["more"] = 1
    with pytest.raises(UsageError, match="unknown field `more`"):
        Request.from_json(json.dumps(document).encode())


def test_numbers_beyond_binary64_are_refused_and_not_a_traceback() -> None:
    document = asked()["scene"]
    document["elements"][0]["a"] = 10**300
    with pytest.raises(SceneError, match="joins bodies"):
        Scene.from_json(json.dumps(document).encode())
    document = asked()["scene"]
    document["bodies"][0]["attitude"] = [1e308, 1e308, 0.0, 0.0]
    with pytest.raises(SceneError, match="attitude has norm inf"):
        Scene.from_json(json.dumps(document).encode())


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        ([HEADER, ENTRY | {"valu": 1}], "line 2: .*unknown field `valu`; did you mean 'value'"),
        ([HEADER | {"wy": ""}, ENTRY], "line 1: .*unknown field `wy`"),
        ([HEADER, ENTRY, ENTRY | {"outcome": "fail"}], "line 3: .* is listed twice"),
    ],
)
def test_a_baseline_is_read_as_a_whole_or_not_at_all(
    tmp_path: Path, lines: "list[object]", says: str
) -> None:
    path = tmp_path / "baseline.jsonl"
    path.write_text("".join(json.dumps(line) + "\n" for line in lines))
    with pytest.raises(UsageError, match=says):
        baseline.read(path)


def sealed(*entries: object, **more: object) -> bytes:
    """A baseline whose first line fits the others, but for `more`."""
    lines = [json.dumps(entry).encode() for entry in entries]
    header = HEADER | {"findings": len(lines), "sha256": baseline.digest(lines)} | more
    return b"".join(line + b"\n" for line in [json.dumps(header).encode(), *lines])


OTHER = ENTRY | {"id": "pendulum/small/rk4/error/y"}


@pytest.mark.parametrize(
    "cut",
    [
        lambda lines: lines[:1],
        lambda lines: lines[:2],
        lambda lines: [*lines, lines[1].replace(b"error/x", b"error/z")],
        lambda lines: [lines[0], lines[1].replace(b"1e-09", b"1e-03"), lines[2]],
        lambda lines: [lines[0].replace(b'"findings": 2', b'"findings": 1'), *lines[1:2]],
    ],
    ids=["header alone", "one less", "one more", "another value", "another number"],
)
def test_a_baseline_that_was_cut_down_or_changed_opens_no_gate(tmp_path: Path, cut) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "baseline.jsonl"
    path.write_bytes(sealed(ENTRY, OTHER))
    assert len(baseline.read(path, "small")[1]) == 2
    path.write_bytes(b"".join(cut(path.read_bytes().splitlines(keepends=True))))
    with pytest.raises(UsageError, match="its first line was written for"):
        baseline.read(path)


def test_a_baseline_of_another_program_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "baseline.jsonl"
    path.write_bytes(sealed(ENTRY))
    with pytest.raises(UsageError, match="is that of 'small'; expected one of 'large'"):
        baseline.read(path, "large")


def test_a_baseline_of_an_older_format_says_what_to_do(tmp_path: Path) -> None:
    path = tmp_path / "baseline.jsonl"
    path.write_bytes(sealed(ENTRY, format=1))
    with pytest.raises(UsageError, match="has format 1; expected 2: delete it and bless anew"):
        baseline.read(path)


@pytest.mark.parametrize("field", ["levels", "perturbed_ulps"])
def test_a_whole_number_beyond_binary64_is_out_of_range(tmp_path: Path, field: str) -> None:
    path = tmp_path / "own.toml"
    path.write_text(f'{field} = {"9" * 400}\n[[case]]\nid = "pendulum"\n')
    with pytest.raises(UsageError, match=f"{field} is 999"):
        specification.named(str(path))


@pytest.mark.parametrize("name", ["/", "../other", "", "a\x1b[31m", "a b"])
def test_a_manifest_names_programs_of_its_own_folder(tmp_path: Path, name: str) -> None:
    (tmp_path / exchange.MANIFEST).write_text(json.dumps(MANIFEST | {"versions": {name: "1"}}))
    with pytest.raises(UsageError, match="is not a valid name of a program"):
        exchange.read(tmp_path)


def test_a_list_of_findings_holds_what_prints(tmp_path: Path) -> None:
    path = tmp_path / "small.txt"
    path.write_text("pendulum/rk4\n  error: x\u2028\n")
    with pytest.raises(UsageError, match="expected characters that print"):
        required.read(path)


def test_a_store_whose_own_words_are_no_text_is_made_anew(
    tmp_path: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """SQLite quotes its damaged schema in its message, which Python then cannot decode."""
    path = tmp_path / "s.sqlite"
    store = Store(path)
    store.put("run", "k", b"data")
    store.close()
    data = path.read_bytes()
    schema = b"PRIMARY KEY"
    assert data.count(schema) == 1
    path.write_bytes(data.replace(schema, b"PRIMARY \xffEY"))
    store = Store(path)
    assert store.get("run", "k") is None
    store.put("run", "k", b"other")
    assert store.get("run", "k") == b"other"
    store.close()
    assert "was damaged" in capfd.readouterr().err
