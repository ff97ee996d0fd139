"""The command line of certified truth: what is there, what it says, and what it does when it does
not hold.
"""

import json
import os
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path

import pytest

from refdem.planning.kept_truth import truth_folder

Run = Callable[..., "subprocess.CompletedProcess[str]"]
WITHOUT_COLOUR = os.environ | {"NO_COLOR": "1", "COLUMNS": "400"}


@pytest.fixture
def refdem(command_line: Run) -> Run:
    def called(*arguments: str, store: Path | None = None) -> "subprocess.CompletedProcess[str]":
        return command_line(
            *arguments, env=WITHOUT_COLOUR | ({"REFDEM_STORE": str(store)} if store else {})
        )

    return called


def test_the_list_has_every_case_with_sets_values_methods_and_witnesses(refdem: Run) -> None:
    document = json.loads(refdem("truth", "--list", "--json").stdout)
    cases = {one["case"]: one for one in document["cases"]}
    assert sum(one["sets"] for one in cases.values()) >= 100
    assert sum(one["values"] for one in cases.values()) >= 3000
    assert cases["pendulum"]["digits"] == 34
    assert cases["pendulum"]["witnessed"] == cases["pendulum"]["values"]
    assert "Taylor" in cases["pendulum"]["witness"]


def test_the_list_of_one_case_has_its_sets_and_times(refdem: Run) -> None:
    done = refdem("truth", "--list", "pendulum")
    assert done.returncode == 0
    assert "pendulum[theta0=2]: 21 values at t = 1/2, 2, 7, 20" in done.stdout
    assert "two-body-orbit" not in done.stdout


def test_no_case_and_no_list_is_bad_usage(refdem: Run) -> None:
    done = refdem("truth")
    assert done.returncode == 2
    assert "`refdem truth --list`" in done.stderr


def test_a_check_of_a_store_proves_a_sample_again(refdem: Run, tmp_path: Path) -> None:
    home = tmp_path / "truth"
    (home / "certified").mkdir(parents=True)
    (home / "samples").mkdir()
    lines = (truth_folder() / "certified" / "logistic.jsonl").read_text()
    (home / "certified" / "logistic.jsonl").write_text(lines)
    from refdem.truth.certified.listing import listing

    (home / "certified" / "sha256sums.txt").write_text(listing({"logistic.jsonl": lines}))
    shutil.copy(truth_folder() / "sets.toml", home)
    done = refdem(
        "certify", "--check", "--folder", str(home), "--each", "1", store=tmp_path / "store.sqlite"
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "2 sets proved again" in done.stdout
    (home / "certified" / "logistic.jsonl").write_text(lines.replace('"64"', '"63"', 1))
    broken = refdem("certify", "--check", "--folder", str(home), store=tmp_path / "store.sqlite")
    assert broken.returncode == 1
    assert "PROBLEM: logistic.jsonl" in broken.stdout


@pytest.mark.parametrize("arguments", [("certify", "nobody"), ("truth", "nobody", "--list")])
def test_a_case_that_is_not_there_is_named(refdem: Run, arguments: tuple[str, ...]) -> None:
    done = refdem(*arguments)
    assert done.returncode == 2
    assert "nobody" in done.stderr
