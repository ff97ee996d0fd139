"""Pairs of points that are near each other, from cells: cost proportional to the number of points (Hockney and Eastwood 1981)."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Whole = NDArray[np.intp]
Pairs = tuple[Whole, Whole]

FEW = 32
"""Points up to which all pairs are looked at."""
HALF = [(0, 0, 0), *((x, y, z) for x in (-1, 0, 1) for y in (-1, 0, 1) for z in (-1, 0, 1) if (z, y, x) > (0, 0, 0))]
"""A cell itself, and one of every two opposite neighbours."""


def near_pairs(position: Array, reach: float, size: float = 0.0) -> Pairs:
    """Numbers i and j (P,), i != j, of the pairs of points (N, 3) [m] that are less than `reach` [m] apart, each pair once.

    With `size` > 0 space repeats itself after `size` [m] along x, y and z, and the nearest images count; reach is at most size/2.
    """
    i, j = _candidates(position, reach, size)
    apart = position[j] - position[i]
    if size:
        apart -= size * np.round(apart / size)
    near = np.einsum("pk,pk->p", apart, apart) < reach * reach
    return i[near], j[near]


def _candidates(position: Array, reach: float, size: float) -> Pairs:
    """Pairs in the same or in neighbouring cells."""
    count = len(position)
    low = np.zeros(3) if size else position.min(axis=0)
    extent = np.full(3, size) if size else np.maximum(position.max(axis=0) - low, reach)
    most = max(1, int(np.ceil((2 * count) ** (1 / 3))))
    cells = np.clip((extent / reach).astype(int), 1, most)
    if count <= FEW or (size and cells.min() < 3):
        i, j = np.triu_indices(count, 1)
        return i, j
    place = (np.mod(position, size) if size else position - low) / extent
    at = np.clip((place * cells).astype(int), 0, cells - 1)
    number = (at[:, 2] * cells[1] + at[:, 1]) * cells[0] + at[:, 0]
    order = np.argsort(number, kind="stable")
    starts = np.searchsorted(number[order], np.arange(int(np.prod(cells)) + 1))
    found = [_beside(np.array(step), at, cells, order, starts, bool(size)) for step in HALF]
    return np.concatenate([i for i, _ in found]), np.concatenate([j for _, j in found])


def _beside(step: Whole, at: Whole, cells: Whole, order: Whole, starts: Whole, periodic: bool) -> Pairs:
    """Every point with those of the cell that is `step` away from its own; within the own cell with the later ones."""
    there = at + step
    inside = np.all((there >= 0) & (there < cells), axis=1)
    points = np.arange(len(at)) if periodic else np.flatnonzero(inside)
    there = np.mod(there[points], cells)
    number = (there[:, 2] * cells[1] + there[:, 1]) * cells[0] + there[:, 0]
    held = starts[number + 1] - starts[number]
    first = np.repeat(points, held)
    within = np.arange(held.sum()) - np.repeat(np.cumsum(held) - held, held)
    second = order[np.repeat(starts[number], held) + within]
    if not step.any():
        later = second > first
        return first[later], second[later]
    return first, second
