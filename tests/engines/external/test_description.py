"""refdem.toml: what it may say, and that every slip is named with its file."""

import tomllib
from contextlib import suppress
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from refdem.engines.external.features import FEATURES
from refdem.engines.external.sense import read
from refdem.errors import RefdemError, UsageError

PLAIN = """
[engine]
name = "mydem"
command = ["./mydem", "{request}", "{trajectory}"]
[[engine.methods]]
name = "verlet"
order = 2
"""
FOREIGN = sorted((Path(__file__).parents[2] / "foreign").glob("*/refdem.toml"))


def description(folder: Path, text: str) -> object:
    path = folder / "refdem.toml"
    path.write_text(text)
    return read(path)


def test_the_shortest_description_has_defaults(tmp_path: Path) -> None:
    found = read_plain(tmp_path)
    assert (found.engine.timeout, found.engine.budget, found.engine.precision) == (
        60.0,
        600.0,
        "double",
    )
    assert found.gate.baseline == "refdem-baseline.jsonl"


def read_plain(folder: Path):  # type: ignore[no-untyped-def]
    return description(folder, PLAIN)


@pytest.mark.parametrize("path", FOREIGN, ids=lambda path: path.parent.name)
def test_the_examples_are_well_formed(path: Path) -> None:
    assert read(path).engine.methods


def test_claims_become_those_of_the_method(tmp_path: Path) -> None:
    claims = 'order_with = { contact = 1 }\nconserves = ["energy"]\nreversible = true\n'
    text = (
        PLAIN.replace(
            "command =", 'precision = "single"\nvelocity_time = "minus-half-step"\ncommand ='
        )
        + claims
    )
    engine = description(tmp_path, text).engine  # type: ignore[attr-defined]
    method = engine.methods[0].method(engine)
    assert method.order_for(frozenset({"contact"})) == 1
    assert method.round_off == 2.0**-24
    assert method.delay(0.5) == 0.25
    assert not method.complete_state


def test_a_method_for_mass_properties_has_no_step_and_knows_what_supports_names(
    tmp_path: Path,
) -> None:
    text = PLAIN.replace(
        "command =", 'supports = ["spring", "solid:cuboid", "solid:about"]\ncommand ='
    ).replace("order = 2", 'answers = "solid"')
    engine = description(tmp_path, text).engine  # type: ignore[attr-defined]
    method = engine.methods[0].method(engine)
    assert (method.answers, method.control, method.knows) == (
        "solid",
        "exact",
        {"solid:cuboid", "solid:about"},
    )


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (("order = 2", "order = 0"), "order of verlet"),
        (("order = 2", "ordr = 2"), "ordr"),
        (("order = 2", 'order = "2"'), "int"),
        (("order = 2", "order = 2\nconstant = 3.0"), "constant_reason"),
        (("order = 2", "order = 2\norder_with = { frction = 1 }"), "frction"),
        (("order = 2", 'order = 2\nconserves = ["enrgy"]'), "enrgy"),
        (("command", 'supports = ["rotaton"]\ncommand'), "rotaton"),
        (("command", "timeout = 0\ncommand"), "timeout"),
        (("command", "budget = nan\ncommand"), "budget"),
        (("command", 'inputs = ["/etc/*"]\ncommand'), "inputs"),
        (("command", 'velocity_time = "late"\ncommand'), "late"),
        (('"./mydem", "{request}", "{trajectory}"', ""), "engine.command"),
        (("mydem", "my/dem"), "engine.name"),
        (('name = "verlet"', 'name = "a/b"'), "engine.methods"),
        (('[[engine.methods]]\nname = "verlet"\norder = 2', ""), "methods"),
        (("order = 2", 'answers = "solid"'), "solid:polyhedron"),
        (("order = 2", 'answers = "map"'), "map"),
        (("command", 'supports = ["solid:torus"]\ncommand'), "solid:torus"),
        (("order = 2", 'order = 2\n[gate]\nbaseline = "a\\n::error::b"'), "gate.baseline"),
        (("order = 2", 'order = 2\n[gate]\nbaseline = " "'), "gate.baseline"),
        (("[engine]", "[engin]"), "engin"),
        (("[engine]", "[engine"), "line"),
    ],
)
def test_a_slip_is_named(tmp_path: Path, change: tuple[str, str], says: str) -> None:
    with pytest.raises(UsageError, match=says) as raised:
        description(tmp_path, PLAIN.replace(*change, 1))
    assert "refdem.toml" in str(raised.value)


def test_a_method_twice_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="each name once"):
        description(tmp_path, PLAIN + PLAIN[PLAIN.index("[[") :])


def test_a_missing_file_and_a_folder_are_named(tmp_path: Path) -> None:
    for path in (tmp_path / "refdem.toml", tmp_path):
        with pytest.raises(UsageError, match=r"expected a refdem\.toml"):
            read(path)


def test_every_feature_that_a_case_needs_can_be_named() -> None:
    from refdem.core import discovery
    from refdem.core.problem import Motion, Solid
    from refdem.core.selection import Selection

    cases = [discovery.case(name) for name in discovery.names("cases")]
    problems = [case.at().problem for case in cases if not isinstance(case, Selection)]
    family = discovery.case("impact-benchmarks")
    (member,) = (parameter for parameter in family.parameters if parameter.name == "member")
    problems += [family.at(member=name).problem for name in member.choices]
    needed = {
        feature
        for problem in problems
        if isinstance(problem, Motion | Solid)
        for feature in problem.features
    }
    assert {feature for feature in needed if not feature.startswith("dimension:")} <= FEATURES


VALUES = st.recursive(
    st.one_of(st.booleans(), st.integers(-3, 3), st.floats(), st.text(max_size=5)),
    lambda inner: st.lists(inner, max_size=3),
    max_leaves=4,
)
FIELDS = (
    "name",
    "command",
    "inputs",
    "supports",
    "precision",
    "velocity_time",
    "timeout",
    "budget",
    "version_command",
)


@given(st.text(max_size=200) | st.dictionaries(st.sampled_from(FIELDS), VALUES, max_size=4))
@settings(max_examples=300)
def test_no_text_and_no_values_are_worse_than_an_error(
    tmp_path_factory: pytest.TempPathFactory, made: "str | dict[str, object]"
) -> None:
    import json

    text = made
    if isinstance(made, dict):
        own = {line.split(" = ")[0] for line in PLAIN.splitlines()} & set(made)
        kept = [
            line
            for line in PLAIN.splitlines()
            if line.split(" = ")[0] not in own or line.startswith('name = "verlet"')
        ]
        text = "\n".join(kept).replace(
            "[engine]\n",
            "[engine]\n" + "".join(f"{k} = {json.dumps(v)}\n" for k, v in made.items()),
        )
    path = tmp_path_factory.getbasetemp() / "refdem.toml"
    path.write_text(str(text), errors="replace")
    with suppress(RefdemError):
        assert read(path).engine.name == tomllib.loads(path.read_text())["engine"]["name"]
