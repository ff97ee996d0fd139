"""Parts of the transparent engine for forces that depend on position and orientation piecewise."""

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
"""A guard of -TINY stands for one that is exactly 0 and counts as negative."""
HALF_TURN: Quaternion = (0.0, 0.0, 0.0, 1.0)


def field_force(field: PiecewiseField, s: Number) -> Number:
    """F(s) [N] along the axis (1.139): k1 (s - x1) for x1 < s <= 0, k2 (s - x2) for 0 < s < x2,
    else 0.
    """
    if s <= 0:
        return field.k1 * max(s - field.x1, 0.0)
    return field.k2 * min(s - field.x2, 0.0)


def wedge_force(wall: Wedge, depth: Number, edge_first: bool, rate: Number) -> Number:
    """Force [N] along the normal on a body that presses: k2 d^2 edge first, else k1 d, for any
    rate.
    """
    if edge_first:
        return wall.quadratic * depth * depth
    return wall.stiffness * depth


def wedge_energy(wall: Wedge, depth: Number, edge_first: bool) -> Number:
    """The potential energy [J] stored in the wall: k2 d^3/3 edge first, else k1 d^2/2."""
    if edge_first:
        return wall.quadratic * depth * depth * depth / 3
    return wall.stiffness * depth * depth / 2


CORRECT_POSITIONAL = PositionalParts(field_force=field_force, wedge_force=wedge_force)


def force_of_fields(
    world: World, state: State, parts: Parts, i: int, total: Loads | None = None
) -> Vector:
    """The force (3) [N] of all fields on body i. The power of those without a potential is
    subtracted from the lost power in `total`.
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
    """The force rounded to the precision of the world."""
    x, y, z = force
    return world.number(x), world.number(y), world.number(z)


def pushed_by_fields(world: World, state: State, parts: Parts, total: Loads, *_: Any) -> None:
    """Adds the forces of piecewise linear fields on all bodies that are not fixed."""
    for i, fixed in enumerate(world.fixed):
        if fixed:
            continue
        for field in world.tents:
            # F(s) along the axis, at s = (r - p) . axis.
            s = vec.dot(vec.minus(state.r[i], field.point), field.axis)
            push = parts.positional.field_force(field, s)
            total.force[i] = vec.moved(total.force[i], push, field.axis)


def pushed_by_walls(world: World, state: State, parts: Parts, total: Loads, *_: Any) -> None:
    """Adds the forces of walls on wedges."""
    for wall, i in pairs(world):
        depth, rate, edge = approach(wall, state, parts, i)
        if depth > 0:
            push = parts.positional.wedge_force(wall, depth, edge, rate)
            total.force[i] = vec.moved(total.force[i], push, wall.normal)


def approach(wall: Wedge, state: State, parts: Parts, i: int) -> tuple[Number, Number, bool]:
    """Overlap [m], its rate [m/s], and True if the edge points at the wall."""
    # d = (p - r) . n and d' = -v . n, with a point p of the wall and its normal n to the body.
    depth = vec.dot(vec.minus(wall.point, state.r[i]), wall.normal)
    rate = -vec.dot(state.v[i], wall.normal)
    return depth, rate, bool(vec.dot(parts.to_space(state.q[i], EDGE), wall.normal) < 0)


def _edge_margin(was: Number, now: Number) -> Number:
    """The guard of an edge of a force: positive as long as a step stays on the side of its start.

    A step that ends exactly on the edge has crossed it if it began above.
    """
    if was > 0:
        return now or -TINY
    return -now or 0.0


def margins(
    world: World, before: State, after: State, parts: Parts, h: Number
) -> list[tuple[Number, tuple[str, int]]]:
    """Guards of the edges of fields and walls, and of the closing velocity of bodies that press on
    a wall, which vanishes at their greatest overlap.
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
    """The signed distance [m] of every body from every edge, at which a force has a kink."""
    places = [
        (vec.dot(vec.minus(r, field.point), field.axis), field)
        for field in world.tents
        for r in state.r
    ]
    beyond = [s - edge for s, field in places for edge in (field.x1, 0.0, field.x2)]
    return beyond + [approach(wall, state, parts, i)[0] for wall, i in pairs(world)]


def turned(world: World, state: State, parts: Parts, number: int) -> None:
    """Rotates a wedge by pi about its z axis; the decrease of the energy stored in the wall is
    lost.
    """
    wall, i = pairs(world)[number]
    depth, _, edge = approach(wall, state, parts, i)
    state.q[i] = vec.product(state.q[i], HALF_TURN)
    state.work += wedge_energy(wall, depth, edge) - wedge_energy(wall, depth, not edge)


def pairs(world: World) -> list[tuple[Wedge, int]]:
    """Pairs of every wall for wedges and every body that is not fixed."""
    return [(wall, i) for wall in world.walls for i, fixed in enumerate(world.fixed) if not fixed]
