"""Parts of the transparent engine for forces that place and orientation choose."""

from typing import Any

from refdem.faults.parts import Parts, PositionalParts
from refdem.faults.state import Loads, State
from refdem.faults.world import World
from refdem.mechanics import vectors as vec
from refdem.mechanics.vectors import Number, Quaternion, Vector
from refdem.scene.elements.piecewise_field import PiecewiseField
from refdem.scene.elements.wedge import Wedge

EDGE = (0.0, 1.0, 0.0)
TINY = 5e-324
"""What stands for a margin that is used up at 0."""
HALF_TURN: Quaternion = (0.0, 0.0, 0.0, 1.0)


def field_force(field: PiecewiseField, s: Number) -> Number:
    """F [N] along the axis at s [m]."""
    if s <= 0:
        return field.k1 * max(s - field.x1, 0.0)
    return field.k2 * min(s - field.x2, 0.0)


def wedge_force(wall: Wedge, depth: Number, edge_first: bool, rate: Number) -> Number:
    """Force [N] along the normal on a body that presses; its rate says nothing."""
    if edge_first:
        return wall.quadratic * depth * depth
    return wall.stiffness * depth


def wedge_energy(wall: Wedge, depth: Number, edge_first: bool) -> Number:
    """The potential energy [J] stored in the wall."""
    if edge_first:
        return wall.quadratic * depth * depth * depth / 3
    return wall.stiffness * depth * depth / 2


CORRECT_POSITIONAL = PositionalParts(field_force=field_force, wedge_force=wedge_force)


def force_of_fields(
    world: World, state: State, parts: Parts, i: int, total: Loads | None = None
) -> Vector:
    """The force (3) [N] of all fields on body i; the power of those that have no potential leaves
    the motion in `total`.
    """
    sum_of_forces = vec.ZERO
    for field in world.fields:
        tell = parts.forces[type(field)]
        force = tell(field, state.t, world.mass[i], state.r[i], state.v[i])
        if field.reads_clock:
            force = rounded(force, world)
        sum_of_forces = vec.plus(sum_of_forces, force)
        if total is not None and not field.conservative:
            total.power -= vec.dot(force, state.v[i])
    return sum_of_forces


def rounded(force: Vector, world: World) -> Vector:
    """The force in the precision of the world."""
    x, y, z = force
    return world.number(x), world.number(y), world.number(z)


def pushed_by_fields(world: World, state: State, parts: Parts, total: Loads, *_: Any) -> None:
    """Adds the forces of the fields to those found."""
    for i, fixed in enumerate(world.fixed):
        if fixed:
            continue
        for field in world.tents:
            s = vec.dot(vec.minus(state.r[i], field.point), field.axis)
            push = parts.positional.field_force(field, s)
            total.force[i] = vec.moved(total.force[i], push, field.axis)


def pushed_by_walls(world: World, state: State, parts: Parts, total: Loads, *_: Any) -> None:
    """Adds the forces of walls for wedges."""
    for wall, i in pairs(world):
        depth, rate, edge = approach(wall, state, parts, i)
        if depth > 0:
            push = parts.positional.wedge_force(wall, depth, edge, rate)
            total.force[i] = vec.moved(total.force[i], push, wall.normal)


def approach(wall: Wedge, state: State, parts: Parts, i: int) -> tuple[Number, Number, bool]:
    """Overlap, its rate, and whether the edge looks at the wall."""
    depth = vec.dot(vec.minus(wall.point, state.r[i]), wall.normal)
    rate = -vec.dot(state.v[i], wall.normal)
    return depth, rate, bool(vec.dot(parts.to_space(state.q[i], EDGE), wall.normal) < 0)


def _edge_margin(was: Number, now: Number) -> Number:
    """How far a step that begins on one side of an edge stays from it: below 0 beyond it.

    A step that ends on the edge has crossed it if it began above.
    """
    if was > 0:
        return now or -TINY
    return -now or 0.0


def margins(
    world: World, before: State, after: State, parts: Parts, h: Number
) -> list[tuple[Number, tuple[str, int]]]:
    """How far a step stays from the next edge of a field or of a wall, and bodies that press on a
    wall from coming to a stop in it.
    """
    sides = zip(edges(world, before, parts), edges(world, after, parts), strict=True)
    distances = [(_edge_margin(was, now), ("edge", 0)) for was, now in sides]
    for number, (wall, i) in enumerate(pairs(world)):
        _, rate, _ = approach(wall, before, parts, i)
        depth, now, _ = approach(wall, after, parts, i)
        if depth > 0 and rate * h > 0:
            distances.append((now * h, ("turn", number)))
    return distances


def edges(world: World, state: State, parts: Parts) -> list[Number]:
    """How far beyond every edge every body is: a force has a corner there."""
    places = [
        (vec.dot(vec.minus(r, field.point), field.axis), field)
        for field in world.tents
        for r in state.r
    ]
    beyond = [s - edge for s, field in places for edge in (field.x1, 0.0, field.x2)]
    return beyond + [approach(wall, state, parts, i)[0] for wall, i in pairs(world)]


def turned(world: World, state: State, parts: Parts, number: int) -> None:
    """Turns a wedge by pi about its z axis; what the wall holds less by that is lost."""
    wall, i = pairs(world)[number]
    depth, _, edge = approach(wall, state, parts, i)
    state.q[i] = vec.product(state.q[i], HALF_TURN)
    state.work += wedge_energy(wall, depth, edge) - wedge_energy(wall, depth, not edge)


def pairs(world: World) -> list[tuple[Wedge, int]]:
    """Every wall for wedges with every body that it can press."""
    return [(wall, i) for wall in world.walls for i, fixed in enumerate(world.fixed) if not fixed]
