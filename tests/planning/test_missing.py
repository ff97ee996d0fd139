"""A finding that must be there and is not is lost, absent, or told under the error that explains
it; it is never green.
"""

import msgspec
import pytest

from refdem.cli.summary import exit_status
from refdem.core import discovery
from refdem.core.finding import Finding, Record, Sheet
from refdem.errors import UsageError
from refdem.planning import required
from refdem.planning.missing import with_lost, with_missing
from refdem.planning.specification import Entry, Specification, named

MADE = ("error/x", "error/v", "order/state", "energy/joint drift")
IDS = {f"c[k=1,2]/reference/rk4/{name}" for name in MADE}


def finding(name: str, outcome: str = "pass", sentence: str = "It is so.") -> Finding:
    check, quantity = name.split("/")
    return Finding(check=check, quantity=quantity, outcome=outcome, sentence=sentence)  # type: ignore[arg-type]


def record(*findings: Finding, label: str = "c[k=1,2]", method: str = "rk4") -> Record:
    return Record(
        case="c",
        label=label,
        parameters={},
        engine="reference",
        version="1",
        method=method,
        is_reference=True,
        runs=(),
        findings=findings,
    )


def all_but(*left_out: str) -> list[Finding]:
    return [finding(name) for name in MADE if name not in left_out]


def outcomes(records: list[Record]) -> dict[str, str]:
    return {
        f"{f.check}/{f.quantity}": f.outcome
        for found in records
        for f in found.findings
        if f.outcome != "pass"
    }


def test_what_is_all_there_is_left_as_it_is() -> None:
    records = [record(*all_but())]
    assert with_missing(with_lost(records, IDS, "the list"), IDS, "the list") == records


def test_a_finding_that_is_not_made_is_absent() -> None:
    found = with_missing([record(*all_but("order/state"))], IDS, "the list")
    assert outcomes(found) == {"order/state": "absent"}
    sentence = found[0].findings[-1].sentence
    assert "The list contains this finding, and this run did not produce it" in sentence


@pytest.mark.parametrize("outcome", ["undecided", "unsupported"])
def test_a_finding_that_is_no_longer_decided_is_lost(outcome: str) -> None:
    found = with_lost([record(*all_but("error/x"), finding("error/x", outcome))], IDS, "the list")
    assert outcomes(found) == {"error/x": "lost"}


@pytest.mark.parametrize("outcome", ["pass", "fail", "expected", "stale", "worse", "error"])
def test_a_finding_that_is_decided_otherwise_speaks_for_itself(outcome: str) -> None:
    found = with_lost([record(*all_but("error/x"), finding("error/x", outcome))], IDS, "the list")
    assert outcomes(with_missing(found, IDS, "the list")) == (
        {} if outcome == "pass" else {"error/x": outcome}
    )


def test_what_follows_from_an_error_of_the_run_is_told_there_and_alone() -> None:
    found = with_missing(
        [record(finding("run/trajectory", "error", "It crashed."))], IDS, "the baseline"
    )
    (only,) = found[0].findings
    assert only.sentence.startswith(
        "It crashed. Therefore 4 findings of the baseline could not be made: energy/joint drift,"
        " error/v"
    )
    assert exit_status(found) == 3


def test_an_error_of_one_check_explains_the_findings_of_that_check_alone() -> None:
    broken = finding("error/trajectory", "error", "It shows no x.")
    found = with_missing([record(broken, finding("energy/joint drift"))], IDS, "the list")
    assert outcomes(found) == {"error/trajectory": "error", "order/state": "absent"}
    assert "2 findings" in found[0].findings[0].sentence
    assert exit_status(found) == 1


def test_a_scene_that_is_refused_now_and_was_judged_before_is_one_loss() -> None:
    found = with_missing(
        [record(finding("run/scene", "unsupported", "Not supported: no springs."))], IDS, "the list"
    )
    assert outcomes(found) == {"run/scene": "lost"}
    assert "Not supported: no springs. Therefore 4 findings" in found[0].findings[0].sentence
    assert exit_status(found) == 1


def test_a_record_that_is_gone_is_one_absence_that_counts_what_went_with_it() -> None:
    found = with_missing([record(*all_but(), method="leapfrog")], IDS, "the list")
    assert outcomes(found) == {"record/findings": "absent"}
    assert "4 findings" in found[1].findings[0].sentence
    assert (found[1].label, found[1].engine, found[1].method) == ("c[k=1,2]", "reference", "rk4")


def test_a_case_that_comes_twice_stays_twice() -> None:
    twice = [record(*all_but()), record(*all_but())]
    assert with_missing(twice, IDS, "the list") == twice


def test_a_list_that_is_written_is_read_as_it_was(tmp_path) -> None:
    many = {
        f"solids/reference/table/error/solid-{n}.{axis}"
        for n in range(40)
        for axis in ("mass", "xx")
    }
    path = tmp_path / "reference.txt"
    path.write_text(required.text("main", IDS | many))
    assert required.read(path) == IDS | many
    assert max(map(len, path.read_text().splitlines())) <= required.WIDTH
    assert required.text("main", required.read(path)) == path.read_text()


@pytest.mark.parametrize(
    "line", ["  error: x", "c/rk4\n  error", "c/rk4\n      x, v", "c/rk4\n  error: "]
)
def test_a_list_with_a_line_that_says_nothing_is_refused(tmp_path, line) -> None:
    (tmp_path / "reference.txt").write_text(line + "\n")
    with pytest.raises(UsageError, match=r"reference\.txt:\d"):
        required.read(tmp_path / "reference.txt")


def held(
    tmp_path, records: list[Record], engine: str = "reference", labels=(), **more: object
) -> list[Record]:
    """The records under a campaign whose list of the reference holds IDS and those of another
    case.
    """
    other = {"d/reference/rk4/error/x", "d/reference/leapfrog/error/x"}
    (tmp_path / "reference.txt").write_text(required.text("mine", IDS | other))
    specification = Specification(name="mine", case=[Entry("c")], required=str(tmp_path), **more)
    sheets: list[Sheet] = list(records)
    return [
        s
        for s in required.held(sheets, specification, [discovery.engine(engine)], labels)
        if isinstance(s, Record)
    ]


def test_a_whole_campaign_misses_a_case_that_was_taken_out_of_it(tmp_path) -> None:
    found = held(tmp_path, [record(*all_but())])
    assert {(r.label, r.method): outcomes([r]) for r in found[1:]} == {
        ("d", "rk4"): {"record/findings": "absent"},
        ("d", "leapfrog"): {"record/findings": "absent"},
    }


def test_only_the_share_of_what_was_asked_for_is_required(tmp_path) -> None:
    assert len(held(tmp_path, [record(*all_but())], is_part=True, labels=["c[k=1,2]"])) == 1
    assert [r.method for r in held(tmp_path, [record(*all_but())], method="leapfrog")] == [
        "rk4",
        "leapfrog",
    ]
    assert held(tmp_path, [], engine="mujoco") == []
    assert held(tmp_path, [], step=0.1) == []
    assert held(tmp_path, [], checks=["error"]) == []


def test_a_broken_run_is_never_written_down(tmp_path) -> None:
    specification = Specification(name="mine", case=[Entry("c")], required=str(tmp_path / "mine"))
    with pytest.raises(UsageError, match="correct the engine"):
        required.written(
            specification, [record(*all_but("error/x"), finding("run/trajectory", "error"))]
        )
    with pytest.raises(UsageError, match="nothing to write down"):
        required.written(specification, [record(finding("error/x", "undecided"))])
    assert not (tmp_path / "mine").exists()
    assert (
        required.written(specification, [record(*all_but())])[0]
        == "+ c[k=1,2]/reference/rk4/energy/joint drift"
    )
    again = required.written(specification, [record(*all_but("error/x"))])
    assert again[0] == "- c[k=1,2]/reference/rk4/error/x"


def test_a_campaign_knows_the_folder_of_its_lists_and_needs_a_case(tmp_path) -> None:
    (tmp_path / "mine.toml").write_text('[[case]]\nid = "pendulum"\n')
    assert named(str(tmp_path / "mine.toml")).required == str(tmp_path / "mine")
    (tmp_path / "mine.toml").write_text("case = []\n")
    with pytest.raises(UsageError, match="has no case"):
        named(str(tmp_path / "mine.toml"))


def test_a_finding_is_kept_by_name_and_never_by_value() -> None:
    one = record(*(msgspec.structs.replace(f, value=1.0) for f in all_but()))
    other = record(*(msgspec.structs.replace(f, value=2.0) for f in all_but()))
    assert required.decided([one]) == required.decided([other]) == {"reference": IDS}
