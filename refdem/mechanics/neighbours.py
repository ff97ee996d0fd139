"""Pairs of points that are near each other, by a cell list (Hockney and Eastwood 1981) at a cost
proportional to the number of points.

Space is divided into cells at least as wide as the reach, so that neighbours of a point are in its
own cell or in one of the 26 around it. Points are sorted by cell, with x running fastest: three
cells in a row along x are one contiguous range of points.
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
"""Number of points up to which all pairs are tested."""
CHUNK = 20_000
"""Points whose neighbours are tested at once, so few that the arrays fit into a cache."""
ROWS = [(y, z) for z, y in product((-1, 0, 1), repeat=2)]
"""Rows of cells around a point's cell, as offsets in (y, z)."""
UPPER = [(y, z) for y, z in ROWS if (z, y) >= (0, 0)]
"""One of every two opposite rows, and the row of the cell itself: every pair is found once."""


def near_pairs(
    position: Array, reach: float, size: float = 0.0, among: Whole | None = None
) -> Pairs:
    """Indices i and j (P,), i != j, of the pairs of points (N, 3) [m] that are less than `reach`
    [m] apart, each pair once.

    With `size` > 0 space is periodic with this period [m] in x, y and z, and distances are to the
    nearest image; reach is at most size/2. With `among` (M,) only pairs whose first index is one of
    these are returned; a pair of two of them comes in both orders.
    """
    firsts = []
    seconds = []
    for i, j in _candidates(position, reach, size, among):
        first, second = _near(position, i, j, reach, size)
        firsts.append(first)
        seconds.append(second)
    return np.concatenate(firsts), np.concatenate(seconds)


def _near(position: Array, i: Whole, j: Whole, reach: float, size: float) -> Pairs:
    """The pairs of candidates with |r_j - r_i| < reach, to the nearest image."""
    branch = position[j] - position[i]
    if size:
        # The nearest image: d - size round(d/size).
        branch -= size * np.rint(branch / size)
    is_near = np.einsum("pk,pk->p", branch, branch) < reach * reach
    return i[is_near], j[is_near]


def _candidates(position: Array, reach: float, size: float, among: Whole | None) -> Iterator[Pairs]:
    """Pairs of points in the same or in neighbouring cells, some at a time."""
    count = len(position)
    if size:
        extent = np.full(3, size)
        inside = np.mod(position, size)
    else:
        low = position.min(axis=0)
        extent = np.maximum(position.max(axis=0) - low, reach)
        inside = position - low
    # At most about two cells per point in all, so that empty cells cost little.
    most_cells = max(1, int(np.ceil((2 * count) ** (1 / 3))))
    cells = np.clip((extent / reach).astype(int), 1, most_cells)
    # With fewer than 3 cells in a period the neighbours on both sides are the same cell, and a pair
    # would be found twice.
    if count <= FEW or (size and cells.min() < 3):
        yield _all_pairs(count, among)
        return
    # The cell (N, 3) of each point, and its index, x running fastest.
    cell = np.clip((inside / extent * cells).astype(np.intp), 0, cells - 1)
    cell_index = (cell[:, 2] * cells[1] + cell[:, 1]) * cells[0] + cell[:, 0]
    # Points sorted by cell are called by their rank; `order` maps ranks to the given indices.
    order = np.argsort(cell_index, kind="stable")
    starts = np.searchsorted(cell_index[order], np.arange(int(np.prod(cells)) + 1))
    grid = Grid(cell[order], cells, starts, periodic=bool(size))
    ranks = np.arange(count)
    if among is not None:
        rank = np.empty(count, np.intp)
        rank[order] = np.arange(count)
        ranks = np.sort(rank[among])
    for chunk in np.array_split(ranks, len(ranks) // CHUNK + 1):
        for first, second in grid.beside(chunk, only_later=among is None):
            yield order[first], order[second]


def _all_pairs(count: int, among: Whole | None) -> Pairs:
    """All pairs of `count` points, or those whose first is among the given indices."""
    i, j = np.triu_indices(count, 1)
    if among is None:
        return i, j
    return _with_first_in(among, np.concatenate([i, j]), np.concatenate([j, i]))


def _with_first_in(among: Whole, i: Whole, j: Whole) -> Pairs:
    """The pairs whose first index is among the given ones."""
    led = np.isin(i, among)
    return i[led], j[led]


@dataclass(frozen=True, eq=False)
class Grid:
    """Points sorted by the cell that they are in.

    `at` (N, 3) is the cell of each point, `cells` (3,) the number of cells along each axis,
    `starts` (cells + 1,) the rank of each cell's first point.
    """

    at: Whole
    cells: Whole
    starts: Whole
    periodic: bool

    def beside(self, points: Whole, *, only_later: bool) -> Iterator[Pairs]:
        """Points paired with those in their own and the neighbouring cells; with `only_later` each
        pair once, by the UPPER rows.
        """
        if only_later:
            rows = UPPER
        else:
            rows = ROWS
        for y, z in rows:
            inside_points = points
            row = self.at[points, 1:] + (y, z)
            if self.periodic:
                row = np.mod(row, self.cells[1:])
            else:
                is_inside = np.all((row >= 0) & (row < self.cells[1:]), axis=1)
                inside_points = points[is_inside]
                row = row[is_inside]
            base = (row[:, 1] * self.cells[1] + row[:, 0]) * self.cells[0]
            yield from self._row(inside_points, base, own=only_later and (y, z) == (0, 0))

    def _row(self, points: Whole, base: Whole, *, own: bool) -> Iterator[Pairs]:
        """Pairs with the three cells around each point's x in the row whose first cell is `base`;
        in the `own` row only with later points.
        """
        x = self.at[points, 0]
        last = self.cells[0] - 1
        first_cell = base + np.maximum(x - 1, 0)
        last_cell = base + np.minimum(x + 1, last)
        if own:
            low = points + 1
        else:
            low = self.starts[first_cell]
        yield _pairs_with_range(points, low, self.starts[last_cell + 1])
        if not self.periodic:
            return
        # At an end of a periodic row one of the three cells is at the other end. In the row of the
        # cell itself only one of the two ends is used, so that every pair is found once.
        for edge, cell in ((last, 0), (0, last)):
            if own and edge == 0:
                continue
            at_edge = np.flatnonzero(x == edge)
            opposite_cell = base[at_edge] + cell
            yield _pairs_with_range(
                points[at_edge], self.starts[opposite_cell], self.starts[opposite_cell + 1]
            )


def _pairs_with_range(points: Whole, low: Whole, high: Whole) -> Pairs:
    """Every point with all points of ranks `low` up to `high`, except itself."""
    counts = high - low
    first = np.repeat(points, counts)
    # For each point the ranks low, low + 1, ..., high - 1.
    first_pair = np.cumsum(counts) - counts
    second = np.arange(len(first)) + np.repeat(low - first_pair, counts)
    is_other = first != second
    return first[is_other], second[is_other]
