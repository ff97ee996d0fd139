"""Questions without time: which operations are refused, what their results are, and what rounding
may move.
"""

import msgspec
import numpy as np
import pytest

from refdem.core.algebra import SIZES
from refdem.core.static_problems import (
    Cuboid,
    Ellipsoid,
    Identity,
    IdentityDocument,
    Operation,
    Piece,
    Solid,
    SolidDocument,
    body,
    properties,
    results,
)
from refdem.errors import UsageError

EPS = 2.0**-52


def identity(*steps):
    """Operations of (name, operation, operands)."""
    operations = [Operation(name=n, operation=o, operands=list(x)) for n, o, x in steps]
    return Identity(IdentityDocument(operations=operations))


TURN = ("turn", "plane-turn", ([0.5], [1.0, 2.0]))


@pytest.mark.parametrize("operation", SIZES)
def test_every_operation_takes_operands_of_its_sizes_and_no_others(operation):
    expected, size = SIZES[operation]
    operands = [[0.0] * (needed or 6) for needed in expected]
    assert size >= 1
    identity(("it", operation, operands))
    for wrong in ([*operands, [1.0]], operands[:-1], [[0.0] * 99, *operands[1:]]):
        if expected[0] == 0:
            continue
        with pytest.raises(UsageError, match=r"expected \(.*\), each name once"):
            identity(("it", operation, wrong))


@pytest.mark.parametrize(
    ("steps", "words"),
    [
        ((("it", "twist", ([1.0],)),), "expected one of sum, dot"),
        ((TURN, TURN), r"expected \(1, 2\), each name once"),
        ((("it", "plane-turn", ([0.5], "turn")),), r"sizes \(1, -1\) \(-1: unknown\)"),
        ((TURN, ("it", "dot", ("turn", "turn"))), r"sizes \(2, 2\)"),
    ],
)
def test_what_no_engine_can_compute_is_refused_with_what_came(steps, words):
    with pytest.raises(UsageError, match=words):
        identity(*steps)


def test_an_operation_takes_the_result_of_an_earlier_one():
    asked = identity(TURN, ("again", "plane-turn", ([0.25], "turn")))
    assert asked.features == {"identity:plane-turn"}
    found = results(asked, {"plane-turn": lambda angle, vector: vector + angle})
    assert {name: value.tolist() for name, value in found.items()} == {
        "turn": [[1.5, 2.5]],
        "again": [[1.75, 2.75]],
    }


def test_an_operation_is_left_out_with_all_that_need_it():
    asked = identity(
        TURN, ("size", "absolute", ([1.0, 0, 0, 0],)), ("on", "plane-turn", ([1.0], "turn"))
    )
    found = results(asked, {"absolute": lambda q: np.linalg.norm(q)})
    assert {name: value.tolist() for name, value in found.items()} == {"size": [[1.0]]}


def test_numbers_that_measure_are_perturbed_and_those_that_count_are_not():
    moved = identity(
        TURN,
        ("free", "first-order-freedom", ([2.0], [0.5, 1.0, 1.5, 3.0], [0.0, 1.0])),
        ("rigid", "rigid-freedom", ([3.0], [0.25, 1.0])),
        ("on", "plane-turn", ([1.0], "turn")),
    ).perturbed(3)
    turn, free, rigid, on = moved.content.operations
    f = 1 + 3 * EPS
    assert turn.operands == [[0.5 * f], [f, 2 * f]]
    assert free.operands == [[2.0], [0.5 * f, f, 1.5 * f, 3 * f], [0.0, 1.0]]
    assert rigid.operands == [[3.0], [0.25 * f, f]]
    assert on.operands == [[f], "turn"]
    piece = Piece(name="box", shape=Cuboid(sides=(1.0, 2.0, 3.0)), density=5.0)
    denser = Solid(SolidDocument(solids=[piece])).perturbed(4).content.solids[0]
    assert denser.density == 5.0 * (1 + 4 * EPS)


def test_mass_properties_are_told_by_name_and_what_is_not_said_is_left_out():
    tensor = np.array([[1.0, 4.0, 5.0], [4.0, 2.0, 6.0], [5.0, 6.0, 3.0]])
    told = body(7.0, np.array([8.0, 9.0, 10.0]), tensor)
    assert told == {
        "mass": 7.0,
        "centre.x": 8.0,
        "centre.y": 9.0,
        "centre.z": 10.0,
        "inertia.xx": 1.0,
        "inertia.yy": 2.0,
        "inertia.zz": 3.0,
        "inertia.xy": 4.0,
        "inertia.xz": 5.0,
        "inertia.yz": 6.0,
    }
    pieces = [Piece(name=name, shape=Cuboid(sides=(1.0, 1.0, 1.0))) for name in ("a", "b")]
    asked = Solid(SolidDocument(solids=pieces))
    found = properties(asked, lambda piece: {"mass": 2.5} if piece.name == "b" else None)
    assert {name: value.tolist() for name, value in found.items()} == {"b.mass": [2.5]}


@pytest.mark.parametrize(
    ("more", "features"),
    [
        ({}, {"solid:cuboid"}),
        ({"hollow": Cuboid(sides=(0.5, 0.5, 0.5))}, {"solid:cuboid", "solid:hollow"}),
        ({"attitude": (-1.0, 0.0, 0.0, 0.0)}, {"solid:cuboid"}),
        ({"attitude": (0.8, 0.0, 0.0, 0.6)}, {"solid:cuboid", "solid:turned"}),
        ({"attitude": (0.8, 0.6, 0.0, 0.0)}, {"solid:cuboid", "solid:turned"}),
        ({"about": (0.0, 0.0, 0.0)}, {"solid:cuboid", "solid:about"}),
    ],
)
def test_a_solid_needs_its_shape_and_what_is_done_with_it(more, features):
    piece = Piece(name="it", shape=Cuboid(sides=(1.0, 1.0, 1.0)), **more)
    asked = Solid(SolidDocument(solids=[piece]))
    assert asked.features == features
    assert (asked.times.tolist(), asked.interval, asked.when(0.0)) == ([0.0], 1.0, "once")


@pytest.mark.parametrize("length", [1e-9, 0.5, 1.0, 2.0])
def test_a_half_axis_is_any_length_above_zero(length):
    given = {"kind": "ellipsoid", "half_axes": [length, 1.0, 1.0]}
    assert msgspec.convert(given, Ellipsoid).half_axes == (length, 1.0, 1.0)


@pytest.mark.parametrize("length", [0.0, -1.0])
def test_a_half_axis_of_no_length_is_refused(length):
    with pytest.raises(msgspec.ValidationError, match="`float` > 0"):
        msgspec.convert({"kind": "ellipsoid", "half_axes": [length, 1.0, 1.0]}, Ellipsoid)
