"""What a refdem.toml may say, at the edge of every limit: the last value that is taken, and the
first that is refused.
"""

import math
from typing import Any

import msgspec
import pytest

from refdem.engines.external.description import EngineTable, GateTable, MethodTable
from refdem.engines.external.sense import is_pattern_below, is_slip, nonsense

YEAR = 366 * 24 * 3600.0
METHOD = MethodTable(name="verlet", order=2)
ENGINE = EngineTable(name="small", command=["./program"], methods=[METHOD])
GATE = GateTable()
NAME = 64
"""Most characters of a name."""

TAKEN: dict[str, list[Any]] = {
    "name": ["a", "9", "a-b.c_d+e", "a" * NAME],
    "command": [["a"], ["a", ""], ["a", "{request}", "{mine}"]],
    "inputs": [[], ["*.c"], ["**/*.c", "src/**"], ["a/b"]],
    "timeout": [1e-9, YEAR],
    "budget": [1e-9, YEAR],
    "memory": [None, 0.001, 1e6],
    "levels": [1, 10],
    "baseline": ["a", "\u00e4 b"],
    "cases": [[], ["pendulum"], ["pendulum", "pendulum[mass=3]"]],
    "order": [1, 20],
    "order_with": [{"friction": 1}, {"friction": 20}],
    "constant": [1.0],
    "supports": [["spring"], []],
}
REFUSED: dict[str, list[Any]] = {
    "name": ["", "-a", ".a", "a b", "a/b", "a" * (NAME + 1), "a\n"],
    "command": [[], [""], ["a\0b"], ["a", "b\0"], ["a", "{requst}"], ["a", "{trajectry}"]],
    "inputs": [[""], [" "], ["/etc/*"], ["a\0"], ["a**"], ["src/a**/b"]],
    "timeout": [0.0, -1.0, math.nan, math.inf, YEAR * 1.001],
    "budget": [0.0, -1.0, math.nan, math.inf, YEAR * 1.001],
    "memory": [0.0, 0.0009, 1.001e6, math.nan, math.inf, -1.0],
    "levels": [0, 11, -1],
    "baseline": ["", " ", "a\nb", "a\tb"],
    "cases": [["pendulum", "pendulum"], ["a", "b", "a"]],
    "order": [0, 21],
    "order_with": [{"friction": 0}, {"friction": 21}, {"frction": 1}],
    "constant": [0.0, -1.0, math.nan, math.inf, 2.0],
    "supports": [["sprng"]],
}


def faults(field: str, value: object) -> list[str]:
    """Names of the fields at which a description is refused, with one field set."""
    engine = ENGINE
    gate = GATE
    if field in GateTable.__struct_fields__:
        gate = msgspec.structs.replace(GATE, **{field: value})
    elif field in EngineTable.__struct_fields__:
        engine = msgspec.structs.replace(ENGINE, **{field: value})
    else:
        method = msgspec.structs.replace(METHOD, **{field: value})
        engine = msgspec.structs.replace(ENGINE, methods=[method])
    return [name for name, _, _ in nonsense(engine, gate)]


@pytest.mark.parametrize(("field", "value"), [(f, v) for f in TAKEN for v in TAKEN[f]])
def test_what_makes_sense_is_taken(field: str, value: object) -> None:
    assert faults(field, value) == []


@pytest.mark.parametrize(("field", "value"), [(f, v) for f in REFUSED for v in REFUSED[f]])
def test_what_makes_none_is_refused_by_its_name(field: str, value: object) -> None:
    found = faults(field, value)
    assert found
    assert all(field.partition("_")[0] in name for name in found)


def test_a_constant_that_is_not_1_has_a_reason() -> None:
    for reason, count in (("because", 0), (" ", 1)):
        method = msgspec.structs.replace(METHOD, constant=2.0, constant_reason=reason)
        engine = msgspec.structs.replace(ENGINE, methods=[method])
        assert len(list(nonsense(engine, GATE))) == count


def test_methods_are_there_and_each_has_a_name_of_its_own() -> None:
    other = msgspec.structs.replace(METHOD, name="other")
    for methods, count in (([METHOD, other], 0), ([METHOD, METHOD], 1), ([], 1)):
        engine = msgspec.structs.replace(ENGINE, methods=methods)
        assert len(list(nonsense(engine, GATE))) == count
    strange = msgspec.structs.replace(METHOD, name="a/b")
    engine = msgspec.structs.replace(ENGINE, methods=[METHOD, strange])
    assert [name for name, _, _ in nonsense(engine, GATE)] == ["engine.methods"]


@pytest.mark.parametrize(
    ("control", "answers", "is_free"),
    [
        ("step", "motion", False),
        ("tolerance", "motion", True),
        ("exact", "motion", True),
        ("step", "solid", True),
    ],
)
def test_only_a_method_with_steps_has_an_order(control: str, answers: str, is_free: bool) -> None:
    method = msgspec.structs.replace(METHOD, order=0, control=control, answers=answers)
    engine = msgspec.structs.replace(ENGINE, methods=[method], supports=["solid:cuboid"])
    assert (list(nonsense(engine, GATE)) == []) is is_free


def test_a_method_for_solids_needs_some() -> None:
    solid = msgspec.structs.replace(METHOD, answers="solid")
    other = msgspec.structs.replace(METHOD, name="other")
    for supports, count in ((["solid:cuboid"], 0), (["spring"], 1), ([], 1)):
        engine = msgspec.structs.replace(ENGINE, methods=[solid, other], supports=supports)
        assert len(list(nonsense(engine, GATE))) == count


def test_words_in_braces_are_slips_where_they_look_like_a_file() -> None:
    assert [word for word in ("request", "requests", "reqest", "mine", "T") if is_slip(word)] == [
        "requests",
        "reqest",
    ]


def test_a_pattern_lies_below_its_folder() -> None:
    assert is_pattern_below("a/**/b*")
    assert not is_pattern_below("/a")
