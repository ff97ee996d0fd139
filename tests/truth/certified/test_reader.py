"""Certified values are read with the standard library alone, and whatever is wrong with a file is seen."""

import json
import shutil
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import pytest

from refdem.truth import load
from refdem.truth.certified import reader, writing

STORE = reader.default_folder()
HEAVY = ("flint", "numpy", "msgspec", "typer", "refdem.core", "refdem.errors")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    shutil.copy(STORE / "pendulum.jsonl", tmp_path)
    return tmp_path


def changed(folder: Path, old: str, new: str, *, hashed: bool = False) -> None:
    """Replaces a text of the file, once; `hashed` makes the checksums anew, as one would who wants it to look right."""
    path = folder / "pendulum.jsonl"
    text = path.read_text()
    assert old in text
    text = text.replace(old, new, 1)
    if hashed:
        blocks = writing.blocks_in(text)
        for block in blocks:
            before, mark, _ = block[0].rpartition('"sha256":"')
            block[0] = f'{before}{mark}{reader.sha256_of(block)}"}}\n'
        text = text.splitlines(keepends=True)[0] + "".join("".join(block) for block in blocks)
    path.write_text(text)


def test_importing_and_loading_brings_in_nothing_but_the_standard_library() -> None:
    code = f"import sys, refdem.truth as t; t.load(); print([n for n in {HEAVY} if n in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd="/")
    assert done.stdout.strip() == "[]"


def test_the_reader_works_as_one_file_on_its_own(folder: Path, tmp_path: Path) -> None:
    alone = tmp_path / "alone.py"
    shutil.copy(reader.__file__, alone)
    done = subprocess.run([sys.executable, "-I", str(alone), str(folder)], capture_output=True, text=True, check=True)
    assert done.stdout.endswith("all hold\n")
    changed(folder, '"9.8125"', '"9.8126"')
    broken = subprocess.run([sys.executable, "-I", str(alone), str(folder)], capture_output=True, text=True, check=False)
    assert broken.returncode == 1
    assert "pendulum.jsonl, line 2" in broken.stdout


def test_a_value_is_what_the_mean_of_gauss_says() -> None:
    """2 pi/w0 over the arithmetic-geometric mean of 1 and cos 1/2, w0^2 = 9.8125: 40 digits by mpmath."""
    (found,) = [one for one in load("pendulum") if one.label == "pendulum"]
    low, high = found.value("period").interval
    period = Fraction("2.1388650815945205866255179436555053906328")
    assert low <= period <= high
    assert high - low < Fraction(1, 10**33)
    assert found.value("period").binary64 == float(period)
    assert found.value("theta", "1/2").t == Fraction(1, 2)


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("2.13886508159452", "2.13886508159453"),
        ('"theta0":"2"', '"theta0":"3"'),
        ("9.37e-36", "9.36e-36"),
        ('["1/2","theta"', '["1/3","theta"'),
        ('"method":"closed form', '"method":"clothed form'),
        ('"sets":7', '"sets":8'),
        ('"format":1', '"format":2'),
    ],
)
def test_no_byte_changes_unseen(folder: Path, old: str, new: str) -> None:
    changed(folder, old, new)
    with pytest.raises(ValueError, match=r"pendulum\.jsonl"):
        load("pendulum", folder=folder)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ('"0x1.11c654bc009e8p+1"', '"0x1.11c654bc009e9p+1"', "both ends round to"),
        ("9.37e-36", "9.37e-16", "radius"),
        ("9.37e-36", "-9.37e-36", "radius"),
    ],
)
def test_what_a_value_claims_is_checked_and_not_only_its_hash(folder: Path, old: str, new: str, told: str) -> None:
    changed(folder, old, new, hashed=True)
    with pytest.raises(ValueError, match=told):
        load("pendulum", folder=folder)


def test_a_lost_line_is_seen(folder: Path) -> None:
    path = folder / "pendulum.jsonl"
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(lines[:5] + lines[6:]))
    with pytest.raises(ValueError, match="sha256"):
        load("pendulum", folder=folder)
    path.write_text("".join(lines[: 2 + json.loads(lines[1])["values"]]))
    with pytest.raises(ValueError, match="1 sets; its first line says 7"):
        load("pendulum", folder=folder)


def test_what_is_not_there_is_said() -> None:
    with pytest.raises(ValueError, match=r"there are .*billiards"):
        load("pendulumm")
    with pytest.raises(KeyError, match="it has period"):
        load("pendulum")[0].value("angle", "1/2")


def test_stores_are_compared_by_overlap() -> None:
    one = reader.Value(None, "x", "1.00", "0.01", None)
    assert one.overlaps(reader.Value(None, "x", "1.015", "0.006", None))
    assert not one.overlaps(reader.Value(None, "x", "1.015", "0.004", None))
