"""Whoever asks for a judgement and gets none is told so, with the reason and an exit status that is
not 0.
"""

import json
import os
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from refdem.cli.summary import VOID, exit_status, lines
from refdem.core.finding import Finding, Record
from refdem.planning.exchange import FORMAT, MANIFEST

Run = Callable[..., "subprocess.CompletedProcess[str]"]

NOTHING = """
[engine]
name = "nothing"
command = ["sh", "-c", "exit 77"]
supports = []
[[engine.methods]]
name = "none"
order = 1
"""


@pytest.fixture
def refdem(tmp_path: Path, command_line: Run) -> Run:
    """The command in a folder of its own."""
    environment = os.environ | {"REFDEM_STORE": str(tmp_path / "store.sqlite")}
    (tmp_path / "nothing.toml").write_text(NOTHING)
    return lambda *arguments: command_line(*arguments, cwd=tmp_path, env=environment)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["run", "two-spheres[damping=1]", "--engine", "mujoco"], "an attractive contact force"),
        (["run", "logistic", "billiards", "--engine", "rebound"], "Cannot run an iteration"),
        (
            ["run", "harmonic-oscillator", "--engine", "reference", "--method", "rattle"],
            "No elements of kind rod",
        ),
        (["run", "pendulum", "--engine", "nothing.toml"], "not in `supports`"),
        (["run", "--campaign", "empty.toml"], "has no case"),
        (["run", "--campaign", "main", "pendulun"], "did you mean 'pendulum'"),
        (
            ["run", "--campaign", "main", "--method", "rk4", "--bless"],
            "--bless is for a whole campaign",
        ),
        (["run", "pendulum", "--bless"], "--bless is for a whole campaign"),
        (["gate", "nothing.toml"], "engine.supports allows no case"),
        (["judge", "empty"], "nothing to judge"),
        (["judge", "nobody"], "nothing to judge"),
        (
            ["stress", "pendulum", "--engine", "nothing.toml", "--battery", "frame"],
            "nothing was judged",
        ),
        (["smoke", "nothing.toml"], "nothing was judged"),
        (["bench", "pendulum", "--engine", "nothing.toml", "--no-peers"], "nothing could be run"),
        (["certify", "no-such-case"], "no-such-case"),
        (["certify", "--check", "no-such-case"], "no set of case 'no-such-case'"),
        (["gallery", "9.99"], "9.99"),
        (["faults", "--fault", "no-such-fault"], "no-such-fault"),
        (["report", "blank"], "nothing to report"),
    ],
)
def test_nothing_judged_is_exit_2_with_the_reason(
    refdem: Run, tmp_path: Path, arguments: list[str], says: str
) -> None:
    import refdem as package

    (tmp_path / "empty.toml").write_text("case = []\n")
    (tmp_path / "blank").mkdir()
    (tmp_path / "blank" / "records.jsonl").write_text("\n")
    manifest = {
        "format": FORMAT,
        "refdem": package.__version__,
        "case": [],
        "levels": 3,
        "versions": {"far": "1"},
    }
    for folder, more in (("empty", {}), ("nobody", {"case": [{"id": "pendulum"}], "versions": {}})):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / MANIFEST).write_text(json.dumps(manifest | more))
    done = refdem(*arguments)
    assert done.returncode == VOID, done.stdout + done.stderr
    assert says in done.stdout + done.stderr
    assert "Traceback" not in done.stderr


def record(*outcomes: str, engine: str = "e") -> Record:
    findings = tuple(
        Finding(check="run", quantity="scene", outcome=outcome, sentence="No springs.")
        for outcome in outcomes
    )  # type: ignore[arg-type]
    return Record(
        case="c",
        label="c",
        parameters={},
        engine=engine,
        version="1",
        method="m",
        is_reference=False,
        runs=(),
        findings=findings,
    )


@pytest.mark.parametrize(
    ("outcomes", "status"),
    [
        ([], VOID),
        (["unsupported"], VOID),
        (["undecided", "unsupported"], VOID),
        (["undecided", "pass"], 0),
        (["expected"], 0),
        (["error", "pass"], 3),
        (["error", "fail"], 1),
        (["absent"], 1),
        (["lost", "pass"], 1),
        (["stale"], 1),
    ],
)
def test_the_exit_status_follows_from_the_outcomes(outcomes: list[str], status: int) -> None:
    assert exit_status([record(*outcomes)] if outcomes else []) == status


def test_an_engine_that_judged_nothing_is_named_beside_those_that_did() -> None:
    shown = lines([record("pass"), record("unsupported", engine="other")])
    assert "c/other (m): No springs." in shown
    assert not any(line.startswith("c/e ") for line in shown)
