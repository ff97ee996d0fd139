"""Pairs of points that are near each other, from cells: cost proportional to the number of points
(Hockney and Eastwood 1981).
"""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Whole = NDArray[np.intp]
Pairs = tuple[Whole, Whole]

FEW = 32
"""Points up to which all pairs are looked at."""
CHUNK = 20_000
"""Points whose neighbours are looked at in one go: what that takes stays in a cache."""
ROWS = [(y, z) for z, y in product((-1, 0, 1), repeat=2)]
UPPER = [(y, z) for y, z in ROWS if (z, y) >= (0, 0)]
"""Rows of cells along x around a point's own, by steps in y and z: all, and one of every two
opposite ones with the own.
"""


def near_pairs(
    position: Array, reach: float, size: float = 0.0, among: Whole | None = None
) -> Pairs:
    """Numbers i and j (P,), i != j, of the pairs of points (N, 3) [m] that are less than `reach`
    [m] apart, each pair once.

    With `size` > 0 space repeats itself after `size` [m] along x, y and z, and the nearest images
    count; reach is at most size/2. With `among` (M,) only those pairs whose first is one of these
    numbers; a pair of two of them comes in both orders.
    """
    firsts = []
    seconds = []
    for i, j in _candidates(position, reach, size, among):
        first, second = _near(position, i, j, reach, size)
        firsts.append(first)
        seconds.append(second)
    return np.concatenate(firsts), np.concatenate(seconds)


def _near(position: Array, i: Whole, j: Whole, reach: float, size: float) -> Pairs:
    """The pairs that are within reach of each other."""
    apart = position[j] - position[i]
    if size:
        apart -= size * np.rint(apart / size)
    near = np.einsum("pk,pk->p", apart, apart) < reach * reach
    return i[near], j[near]


def _candidates(position: Array, reach: float, size: float, among: Whole | None) -> Iterator[Pairs]:
    """Pairs in the same or in neighbouring cells, some at a time."""
    count = len(position)
    if size:
        extent = np.full(3, size)
    else:
        low = position.min(axis=0)
        extent = np.maximum(position.max(axis=0) - low, reach)
    # No more than about two cells a point.
    most = max(1, int(np.ceil((2 * count) ** (1 / 3))))
    cells = np.clip((extent / reach).astype(int), 1, most)
    if count <= FEW or (size and cells.min() < 3):
        i, j = np.triu_indices(count, 1)
        if among is not None:
            both_ways = np.concatenate([i, j]), np.concatenate([j, i])
            i, j = _led_by(among, *both_ways)
        yield i, j
        return
    # The cell (N, 3) of each point, and the number of that cell, x running fastest.
    if size:
        inside = np.mod(position, size)
    else:
        inside = position - low
    place = inside / extent
    at = np.clip((place * cells).astype(np.intp), 0, cells - 1)
    number = (at[:, 2] * cells[1] + at[:, 1]) * cells[0] + at[:, 0]
    order = np.argsort(number, kind="stable")
    starts = np.searchsorted(number[order], np.arange(int(np.prod(cells)) + 1))
    rank = np.empty(count, np.intp)
    rank[order] = np.arange(count)
    grid = Grid(at[order], cells, starts, periodic=bool(size))
    if among is None:
        ranks = np.arange(count)
    else:
        ranks = np.sort(rank[among])
    for chunk in np.array_split(ranks, len(ranks) // CHUNK + 1):
        for first, second in grid.beside(chunk, only_later=among is None):
            yield order[first], order[second]


def _led_by(among: Whole, i: Whole, j: Whole) -> Pairs:
    """The pairs whose first body is among the given numbers."""
    led = np.isin(i, among)
    return i[led], j[led]


@dataclass(frozen=True, eq=False)
class Grid:
    """Points sorted by cells: cell (N, 3) of each, number of cells (3,), and where each cell's
    points start (cells + 1,).
    """

    at: Whole
    cells: Whole
    starts: Whole
    periodic: bool

    def beside(self, points: Whole, *, only_later: bool) -> Iterator[Pairs]:
        """Points and those in their own and the neighbouring cells; each pair once if only those
        count that come later.
        """
        if only_later:
            rows = UPPER
        else:
            rows = ROWS
        for y, z in rows:
            led = points
            there = self.at[points, 1:] + (y, z)
            if self.periodic:
                there = np.mod(there, self.cells[1:])
            else:
                inside = np.all((there >= 0) & (there < self.cells[1:]), axis=1)
                led = points[inside]
                there = there[inside]
            base = (there[:, 1] * self.cells[1] + there[:, 0]) * self.cells[0]
            yield from self._row(led, base, own=only_later and (y, z) == (0, 0))

    def _row(self, points: Whole, base: Whole, *, own: bool) -> Iterator[Pairs]:
        """The three cells around each point's x in the row that begins at `base`; of the own row,
        those that come later.
        """
        x = self.at[points, 0]
        last = self.cells[0] - 1
        first_cell = base + np.maximum(x - 1, 0)
        last_cell = base + np.minimum(x + 1, last)
        if own:
            low = points + 1
        else:
            low = self.starts[first_cell]
        yield _within(points, low, self.starts[last_cell + 1])
        if not self.periodic:
            return
        # Across the border: the cell at the other end of the row.
        for edge, cell in ((last, 0), (0, last)):
            if own and edge == 0:
                continue
            on = np.flatnonzero(x == edge)
            beyond = base[on] + cell
            yield _within(points[on], self.starts[beyond], self.starts[beyond + 1])


def _within(points: Whole, low: Whole, high: Whole) -> Pairs:
    """Every point with all others from `low` up to `high`."""
    held = high - low
    first = np.repeat(points, held)
    # Of each point the numbers low, low + 1, ..., high - 1.
    begin = np.cumsum(held) - held
    second = np.arange(len(first)) + np.repeat(low - begin, held)
    other = first != second
    return first[other], second[other]
