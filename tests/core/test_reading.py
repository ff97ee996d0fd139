"""Files from outside: whatever is in them is read, or is one sentence of a UsageError."""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from refdem.core.reading import MOST_BYTES, content, json_as, toml_as
from refdem.engines.external.description import Description
from refdem.engines.external.sense import read
from refdem.errors import UsageError
from refdem.gate import baseline
from refdem.planning.exchange import Manifest
from refdem.planning.exchange import read as manifest_in
from refdem.planning.specification import Specification, named

TOML = b"""
[engine]
name = "mydem"
command = ["./mydem", "{request}", "{trajectory}"]
inputs = ["src/*.cpp"]
supports = ["rotation", "spring"]
timeout = 60
[[engine.methods]]
name = "verlet"
order = 2
order_with = { contact = 1 }
conserves = ["momentum"]
[gate]
cases = ["two-spheres"]
[[expected]]
case = "two-spheres"
method = "verlet"
check = "error"
quantity = "x"
versions = "*"
low = 0.1
high = 0.2
reason = "known"
"""
CAMPAIGN = (
    b'levels = 4\ntimeout = 60\n[[case]]\nid = "pendulum"\nset = { theta0 = "2" }\n[[case]]\nid ='
    b' "duffing"\n'
)
MANIFEST = (
    b'{"refdem": "1", "case": [{"id": "pendulum", "set": {}}], "versions": {"a": "1"}, "levels": 4}'
)
ACCEPTED = b'{"id": "pendulum/a/b/error/x", "outcome": "pass", "value": 1.0, "constant": 2.0}'
BASELINE = (
    b'{"format": 2, "engine": "a", "version": "1", "why": "first", "findings": 1, "sha256": "%s"}\n'
    b"%s\n" % (baseline.digest([ACCEPTED]).encode(), ACCEPTED)
)
PIECES = [
    b"[",
    b"{",
    b"]",
    b"}",
    b'"',
    b"\0",
    b"\xff",
    b"\n",
    b"=",
    b"nan",
    b"1e999",
    b"-1",
    b"1_0",
    b"**a",
    b"'",
    b",",
    b"\xc3\xa9",
    b"::",
]


def of_manifest(path: Path) -> object:
    folder = path.parent / "exported"
    folder.mkdir(exist_ok=True)
    (folder / "manifest.json").write_bytes(path.read_bytes())
    return manifest_in(folder)


READERS: dict[str, tuple[bytes, Callable[[Path], object]]] = {
    "refdem.toml": (TOML, read),
    "campaign.toml": (CAMPAIGN, lambda path: named(str(path))),
    "manifest.json": (MANIFEST, of_manifest),
    "baseline.jsonl": (BASELINE, baseline.read),
}


@st.composite
def broken(draw: st.DrawFn, whole: bytes) -> bytes:
    """The bytes of a file with a few of them cut out, repeated or replaced."""
    data = whole
    for _ in range(draw(st.integers(1, 4))):
        begin = draw(st.integers(0, len(data)))
        end = draw(st.integers(begin, min(len(data), begin + 12)))
        piece = draw(st.sampled_from(PIECES)) * draw(st.sampled_from([0, 1, 1, 2, 40]))
        data = data[:begin] + piece + data[end:]
    return data


@pytest.mark.parametrize("name", READERS)
@given(data=st.data())
def test_a_broken_file_is_read_or_refused_in_one_sentence(
    name: str, data: Any, tmp_path_factory: pytest.TempPathFactory
) -> None:
    whole, reader = READERS[name]
    path = tmp_path_factory.getbasetemp() / name
    path.write_bytes(data.draw(broken(whole)))
    said = ""
    try:
        reader(path)
    except UsageError as error:
        said = str(error)
    assert said.isprintable()


@pytest.mark.parametrize("name", READERS)
@pytest.mark.parametrize(
    "content",
    [b"", b"[" * 5000, b"a = " + b"[" * 5000, b"\xff\xfe", b"\0" * 10, b"[]", b"{}", b"null", b"1"],
)
def test_what_is_no_such_file_at_all_is_refused_in_one_sentence(
    name: str, content: bytes, tmp_path: Path
) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(UsageError) as raised:
        READERS[name][1](path)
    assert str(raised.value).isprintable()


@pytest.mark.parametrize("name", ["nowhere", "x" * 300, "nul\0nul", "."])
def test_a_name_without_a_file_is_refused_in_one_sentence(name: str, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"expected a refdem\.toml") as raised:
        read(tmp_path / name)
    assert str(raised.value).isprintable()


def test_a_loop_of_links_is_refused_in_one_sentence(tmp_path: Path) -> None:
    (tmp_path / "a.toml").symlink_to(tmp_path / "b.toml")
    (tmp_path / "b.toml").symlink_to(tmp_path / "a.toml")
    with pytest.raises(UsageError, match="symbolic links"):
        read(tmp_path / "a.toml")


@pytest.mark.parametrize(
    ("before", "after", "says"),
    [
        (b"supports =", b"suports =", "did you mean 'supports'"),
        (b"[[expected]]", b"[[expectd]]", "did you mean 'expected'"),
        (b"low = 0.1", b"low = -inf", "low = -inf"),
        (b"high = 0.2", b"high = nan", "high = nan"),
        (b"high = 0.2", b"high = 0.01", "0 <= low <= high"),
        (b'reason = "known"', b'reason = " "', "reason is empty"),
        (b"timeout = 60", b"timeout = -1", "engine.timeout"),
        (b"timeout = 60", b"timeout = 1e300", "engine.timeout"),
        (b"timeout = 60", b"timeout = nan", "engine.timeout"),
        (b"timeout = 60", b"memory = 0", "engine.memory"),
        (b'{trajectory}"', b'{traj}"', "{traj}"),
        (b'cases = ["two-spheres"]', b'cases = ["two-spheres", "two-spheres"]', "twice"),
        (b'inputs = ["src/*.cpp"]', b'inputs = ["**a"]', "**a"),
        (b"[gate]", b"[gate]\nmemory = 1", "'memory' is a field of another table"),
    ],
)
def test_a_slip_in_a_description_is_said_with_what_was_expected(
    before: bytes, after: bytes, says: str, tmp_path: Path
) -> None:
    assert TOML.count(before) == 1
    path = tmp_path / "refdem.toml"
    path.write_bytes(TOML.replace(before, after))
    with pytest.raises(UsageError) as raised:
        read(path)
    assert says in str(raised.value)


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ("levels = 0", "levels is 0"),
        ("levels = 99", "levels is 99"),
        ("timeout = -1", "timeout is -1"),
        ("timeout = 1e300", "timeout is 1e+300"),
        ("most_steps = nan", "most_steps is nan"),
        ("most_steps = -5", "most_steps is -5"),
        ("step = 0", "step is 0"),
        ("step = -inf", "step is -inf"),
        ("steps_per_tau = 0", "steps_per_tau is 0"),
        ("step = 1\nsteps_per_tau = 4", "at most one"),
        ("perturbed_ulps = 2_000_000_000_000", "perturbed_ulps is 2e+12"),
        ("levls = 3", "did you mean 'levels'"),
        ('[[case]]\nid = "pendulum"\n[[case]]\nid = "pendulum"', "listed twice"),
    ],
)
def test_every_number_of_a_campaign_has_a_range(more: str, says: str, tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(f'{more}\n[[case]]\nid = "duffing"\n')
    with pytest.raises(UsageError) as raised:
        named(str(path))
    assert says in str(raised.value)


def test_whole_files_are_read(tmp_path: Path) -> None:
    path = tmp_path / "whole"
    path.write_bytes(TOML)
    assert toml_as(Description, path, "x").engine.name == "mydem"
    path.write_bytes(CAMPAIGN)
    assert len(toml_as(Specification, path, "x", {"name": "c"}).case) == 2
    assert json_as(Manifest, MANIFEST, "m").levels == 4
    path.write_bytes(BASELINE)
    assert len(baseline.read(path)[1]) == 1


def test_a_pipe_in_place_of_a_file_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(UsageError, match="a pipe or a device, not a file; expected a list"):
        content(tmp_path / "pipe", "a list")


def test_a_path_that_no_system_has_says_why(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"null byte; expected a list"):
        content(tmp_path / "a\0b", "a list")
    with pytest.raises(UsageError, match=r"No such file or directory; expected a list"):
        content(tmp_path / "absent", "a list")


def test_a_file_may_have_so_many_bytes_and_no_more(tmp_path: Path) -> None:
    path = tmp_path / "long"
    with path.open("wb") as file:
        file.truncate(MOST_BYTES)
    assert len(content(path, "a list")) == MOST_BYTES
    with path.open("wb") as file:
        file.truncate(MOST_BYTES + 1)
    with pytest.raises(UsageError, match=f"more than {MOST_BYTES} bytes; expected a list"):
        content(path, "a list")


@pytest.mark.parametrize(
    ("right", "wrong", "nearest"),
    [
        ('["momentum"]', '["angular_momentum"]', "'angular-momentum'"),
        ('["momentum"]', '["momentum", "energie"]', "'energy'"),
        ("order = 2", 'order = 2\ncontrol = "steps"', "'step'"),
        ("timeout = 60", 'precision = "duoble"', "'double'"),
        ("timeout = 60", 'velocity_time = "minus_half_step"', "'minus-half-step'"),
        ("timeout = 60", 'may_refuse = ["rotate"]', "'rotated'"),
        ('"spring"]', '"sping"]', "'spring'"),
        ("{ contact = 1 }", "{ contacts = 1 }", "'contact'"),
        ("order = 2", "ordr = 2", "'order'"),
    ],
)
def test_a_word_that_is_none_of_a_field_s_is_answered_with_the_nearest(
    right: str, wrong: str, nearest: str, tmp_path: Path
) -> None:
    text = TOML.decode()
    assert text.count(right) == 1
    path = tmp_path / "refdem.toml"
    path.write_text(text.replace(right, wrong))
    with pytest.raises(UsageError, match=f"did you mean {nearest}"):
        read(path)


def test_a_word_like_none_of_a_field_s_is_answered_with_all(tmp_path: Path) -> None:
    path = tmp_path / "refdem.toml"
    path.write_bytes(TOML.replace(b'["momentum"]', b'["q7"]'))
    with pytest.raises(UsageError, match="known: angular-momentum, constraint, energy, momentum"):
        read(path)
