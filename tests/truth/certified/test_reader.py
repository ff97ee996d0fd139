"""Certified values are read with the standard library alone, and whatever is wrong with a file is
seen.
"""

import json
import shutil
import subprocess
import sys
from contextlib import suppress
from fractions import Fraction
from pathlib import Path
from random import Random

import pytest

from refdem.truth import load
from refdem.truth.certified import reader, writing
from refdem.truth.certified.listing import listing

STORE = reader.default_folder()
HEAVY = ("flint", "numpy", "msgspec", "typer", "refdem.core", "refdem.errors")


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    shutil.copy(STORE / "pendulum.jsonl", tmp_path)
    listed(tmp_path)
    return tmp_path


def listed(folder: Path) -> None:
    """Writes the list of the folder's files as they are."""
    texts = {path.name: path.read_text() for path in folder.glob("*.jsonl")}
    (folder / reader.LIST).write_text(listing(texts))


def changed(folder: Path, old: str, new: str, *, hashed: bool = False) -> None:
    """Replaces a text of the file, once;

    `hashed` makes the checksums anew, as one would who wants it to look right.
    """
    path = folder / "pendulum.jsonl"
    text = path.read_text()
    assert old in text
    text = text.replace(old, new, 1)
    if hashed:
        text = writing.file_text(
            "pendulum", [writing.sealed(block) for block in writing.blocks_in(text)]
        )
    path.write_text(text)
    if hashed:
        listed(folder)


def test_importing_and_loading_brings_in_nothing_but_the_standard_library() -> None:
    code = (
        f"import sys, refdem.truth as t; t.load(); print([n for n in {HEAVY} if n in sys.modules])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, cwd="/"
    )
    assert done.stdout.strip() == "[]"


def test_the_reader_works_as_one_file_on_its_own(folder: Path, tmp_path: Path) -> None:
    alone = tmp_path / "alone.py"
    shutil.copy(reader.__file__, alone)
    done = subprocess.run(
        [sys.executable, "-I", str(alone), str(folder)], capture_output=True, text=True, check=True
    )
    assert done.stdout.endswith("all hold\n")
    changed(folder, '"9.8125"', '"9.8126"')
    broken = subprocess.run(
        [sys.executable, "-I", str(alone), str(folder)], capture_output=True, text=True, check=False
    )
    assert broken.returncode == 1
    assert "pendulum.jsonl, line 2" in broken.stdout


def test_a_value_is_what_the_mean_of_gauss_says() -> None:
    """2 pi/w0 over the arithmetic-geometric mean of 1 and cos 1/2, w0^2 = 9.8125: 40 digits by
    mpmath.
    """
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
        ('"format":2', '"format":3'),
        ('"case":"pendulum"', '"case":"pendulums"'),
        ('"columns":["t","quantity"', '"columns":["quantity","t"'),
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
def test_what_a_value_claims_is_checked_and_not_only_its_hash(
    folder: Path, old: str, new: str, told: str
) -> None:
    changed(folder, old, new, hashed=True)
    with pytest.raises(ValueError, match=told):
        load("pendulum", folder=folder)


def test_a_lost_line_is_seen(folder: Path) -> None:
    path = folder / "pendulum.jsonl"
    lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join(lines[:5] + lines[6:]))
    with pytest.raises(ValueError, match=r"pendulum\.jsonl, line \d+: expected \[t, quantity"):
        load("pendulum", folder=folder)
    path.write_text("".join(lines[: 2 + json.loads(lines[1])["values"]]))
    with pytest.raises(ValueError, match="1 sets; its first line says 7"):
        load("pendulum", folder=folder)


@pytest.mark.parametrize("name", ["pendulum", "new"])
def test_a_directory_in_place_of_a_file_is_seen(folder: Path, name: str) -> None:
    (folder / f"{name}.jsonl").unlink(missing_ok=True)
    (folder / f"{name}.jsonl").mkdir()
    with pytest.raises(ValueError, match=rf"{name}\.jsonl: not a file"):
        load(folder=folder)


def test_a_file_that_is_gone_or_new_is_seen(folder: Path) -> None:
    shutil.copy(STORE / "duffing.jsonl", folder)
    with pytest.raises(
        ValueError, match=r"duffing\.jsonl: there, though sha256sums\.txt does not have it"
    ):
        load(folder=folder)
    listed(folder)
    assert {one.case for one in load(folder=folder)} == {"pendulum", "duffing"}
    (folder / "duffing.jsonl").unlink()
    with pytest.raises(ValueError, match=r"duffing\.jsonl: missing, though sha256sums\.txt has it"):
        load(folder=folder)
    (folder / reader.LIST).unlink()
    with pytest.raises(ValueError, match=r"sha256sums\.txt: missing"):
        load(folder=folder)


def test_a_file_under_another_name_is_seen(folder: Path) -> None:
    (folder / "pendulum.jsonl").rename(folder / "duffing.jsonl")
    listed(folder)
    with pytest.raises(ValueError, match="has the values of pendulum"):
        load(folder=folder)


JUNK = [
    "",
    "junk",
    "[]",
    "{}",
    "null",
    '["1","x","1"]',
    '[1,"x","1.0","0",null]',
    '["1","x","1e99999999","0",null]',
    "[" * 9999,
]


@pytest.mark.parametrize(
    "junk",
    [*JUNK, '["1","x","1.0","0","0x1.0p+99999"]', '["1/0","x","1.0","0",null]', '{"values":3}'],
)
def test_a_junk_line_is_one_sentence_with_file_and_line(folder: Path, junk: str) -> None:
    path = folder / "pendulum.jsonl"
    lines = path.read_text().splitlines(keepends=True)
    for number in (1, 2, 5):
        path.write_text("".join([*lines[: number - 1], junk + "\n", *lines[number:]]))
        with pytest.raises(ValueError, match=rf"pendulum\.jsonl, line {number}"):
            load("pendulum", folder=folder)


def test_the_reader_on_its_own_says_what_is_wrong_and_no_traceback(folder: Path) -> None:
    for content in (b"", b"\xff\xfe", b"junk", b"junk\n", b"{}\n"):
        (folder / "pendulum.jsonl").write_bytes(content)
        done = subprocess.run(
            [sys.executable, "-I", reader.__file__, str(folder)],
            capture_output=True,
            text=True,
            check=False,
        )
        assert (done.returncode, done.stderr) == (1, "")
        assert done.stdout.startswith("PROBLEM: pendulum.jsonl, line 1")


def spoiled(content: bytes, random: Random) -> bytes:
    """The content with a byte flipped, dropped or put in, or a line dropped, doubled or moved, at a
    random place.
    """
    at = random.randrange(len(content))
    lines = content.splitlines(keepends=True)
    one = random.randrange(len(lines))
    other = random.randrange(len(lines))
    swapped = list(lines)
    swapped[one], swapped[other] = lines[other], lines[one]
    before, after = content[:at], content[at + 1 :]
    flipped = before + bytes([content[at] ^ 1 << random.randrange(8)]) + after
    put_in = before + bytes([random.randrange(256)]) + content[at:]
    line_dropped = b"".join(lines[:one] + lines[one + 1 :])
    line_doubled = b"".join([*lines[:one], lines[one], *lines[one:]])
    line_moved = b"".join(swapped)
    ways = [flipped, before + after, put_in, before, line_dropped, line_doubled, line_moved]
    return random.choice(ways)


@pytest.mark.parametrize("name", ["pendulum.jsonl", reader.LIST])
def test_whatever_is_done_to_a_file_is_a_value_error_or_changes_nothing(
    folder: Path, name: str
) -> None:
    """Seeded: 300 spoiled files."""
    random = Random(f"spoiled {name}")
    path = folder / name
    whole = path.read_bytes()
    as_it_was = load(folder=folder)
    told = []
    for _ in range(300):
        path.write_bytes(spoiled(whole, random))
        try:
            assert load(folder=folder) == as_it_was
        except ValueError as error:
            told.append(str(error))
    assert len(told) > 200
    assert all(".jsonl" in one or reader.LIST in one for one in told)


def test_what_is_wrong_inside_is_seen_also_where_every_hash_was_made_anew(folder: Path) -> None:
    """Spoiled and sealed again: no traceback, and no radius or double that does not hold."""
    random = Random("sealed again")
    path = folder / "pendulum.jsonl"
    whole = path.read_bytes()
    for _ in range(150):
        with suppress(ValueError, KeyError, IndexError, TypeError):
            text = spoiled(whole, random).decode()
            path.write_text(
                writing.file_text(
                    "pendulum", [writing.sealed(block) for block in writing.blocks_in(text)]
                )
            )
            listed(folder)
        try:
            found = load(folder=folder)
        except ValueError:
            continue
        assert all(not value.problem() for one in found for value in one.values)


def test_what_is_not_there_is_said() -> None:
    with pytest.raises(ValueError, match=r"there are .*billiards"):
        load("pendulumm")
    with pytest.raises(KeyError, match="it has period"):
        load("pendulum")[0].value("angle", "1/2")


def test_stores_are_compared_by_overlap() -> None:
    one = reader.Value(None, "x", "1.00", "0.01", None)
    assert one.overlaps(reader.Value(None, "x", "1.015", "0.006", None))
    assert not one.overlaps(reader.Value(None, "x", "1.015", "0.004", None))
