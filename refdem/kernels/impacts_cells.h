/* Cells for the neighbour search of many rigid spheres (impacts.c).
 *
 * Cells are cubes with edges of at least the largest diameter, so that a sphere can touch only
 * spheres of its own and of the neighbouring cells. There are `count` of them along each axis, and
 * they repeat periodically: the cell after the last is the first. In a periodic box the repeated
 * cells are its images. In open space distant cells with the same number share a list; the pairs
 * that this adds are examined needlessly, without any other effect. Along an axis with one cell
 * spheres do not leave it.
 */
#ifndef REFDEM_IMPACTS_CELLS_H
#define REFDEM_IMPACTS_CELLS_H

#include "impacts_state.h"

/* Edges are longer than a diameter by this fraction, since positions and the times at which spheres
 * leave their cells are rounded. */
static const double MARGIN = 0x1p-20;

/* FEWEST_PERIODIC: least number of cells along an edge of a periodic box. Two spheres of
 * neighbouring cells are then less than half a period apart, and the nearest image is the one in
 * the neighbouring cell. FEWEST_OPEN: in open space fewer cells along an axis are replaced by one,
 * since a sphere would have all of them as neighbours. */
enum { FEWEST_PERIODIC = 5, FEWEST_OPEN = 4, SPARE_CELLS = 128 };

/* The cell of a sphere: `at` counts cells from the corner of the grid, without bounds, and `cell`
 * is `at` modulo the number of cells. The sphere leaves through the side `exit` = 2 axis + (1 if
 * upwards). */
typedef struct {
    int64_t at[3];
    int32_t cell[3];
    int32_t exit;
} slot;

/* The grid, and the spheres of every cell as a list: from `first` (cells) on by `next`, and back by
 * `previous` (bodies + 1 each), up to `nobody`, whose next is nobody. */
typedef struct {
    int32_t nobody;
    double low[3], edge[3];
    int32_t count[3];
    slot *slot;
    int32_t *first, *next, *previous;
} grid;

/* Cells of a grid for so many bodies, at most. */
static inline int64_t most_cells(int64_t bodies)
{
    return 2 * bodies + SPARE_CELLS;
}

/* The least edge of a cell, 2 max(R_i) (1 + MARGIN). */
static inline double least_edge(const refdem_impacts *p)
{
    double radius = 0.0;
    for (int64_t i = 0; i < p->bodies; i++)
        radius = fmax(radius, p->radius[i]);
    return 2.0 * radius * (1.0 + MARGIN);
}

/* Numbers of cells of this edge that cover the extent, for open space; returns their product. */
static inline double cells_of_edge(const double *restrict extent, double edge,
                                   double *restrict count)
{
    double all = 1.0;
    for (int c = 0; c < 3; c++) {
        count[c] = floor(extent[c] / edge) + 1.0;
        if (count[c] < FEWEST_OPEN)
            count[c] = 1.0;
        all *= count[c];
    }
    return all;
}

/* The extent of all bodies at the time now: its corner, and its edges. */
static inline void extent_of(const motion *m, double now, double *restrict low,
                             double *restrict extent)
{
    double high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (int c = 0; c < 3; c++)
        low[c] = INFINITY;
    for (int64_t i = 0; i < m->bodies; i++) {
        double r[3];
        place(m, i, now, r);
        for (int c = 0; c < 3; c++) {
            low[c] = fmin(low[c], r[c]);
            high[c] = fmax(high[c], r[c]);
        }
    }
    for (int c = 0; c < 3; c++)
        extent[c] = high[c] - low[c];
}

/* The grid over the extent of the bodies. Its edge is the least with at most `most_cells` cells, up
 * to a factor GROWTH. */
static inline void fit_open_grid(const refdem_impacts *p, const motion *m, grid *g, double now)
{
    static const double GROWTH = 1.0625;
    double extent[3], count[3];
    extent_of(m, now, g->low, extent);
    const double most = (double)most_cells(m->bodies);
    const double least = least_edge(p);
    const double longest = fmax(extent[0], fmax(extent[1], extent[2]));
    /* Along one axis alone more cells than `most` are too many. */
    double edge = fmax(least, longest / most);
    while (cells_of_edge(extent, edge, count) > most)
        edge *= GROWTH;
    for (int c = 0; c < 3; c++) {
        g->edge[c] = edge;
        g->count[c] = (int32_t)count[c];
    }
}

/* The grid of a periodic box. */
static inline void fit_periodic_grid(const refdem_impacts *p, const motion *m, grid *g)
{
    const double along = floor(cbrt((double)most_cells(m->bodies)));
    const double fitting = floor(m->period / least_edge(p));
    const double count = fmin(along, fitting);
    assert(count >= FEWEST_PERIODIC);
    for (int c = 0; c < 3; c++) {
        g->low[c] = 0.0;
        g->edge[c] = m->period / count;
        g->count[c] = (int32_t)count;
    }
}

/* The number of a cell in the grid. */
static inline int64_t cell_number(const grid *g, const int32_t *restrict cell)
{
    const int64_t row = (int64_t)cell[2] * g->count[1] + cell[1];
    return row * g->count[0] + cell[0];
}

/* Puts a body into the list of its cell. */
static inline void enter_cell(grid *g, int32_t i)
{
    const int64_t cell = cell_number(g, g->slot[i].cell);
    const int32_t other = g->first[cell];
    g->previous[i] = g->nobody;
    g->next[i] = other;
    g->previous[other] = i;
    g->first[cell] = i;
}

/* Takes a body out of the list of its cell. */
static inline void leave_cell(grid *g, int32_t i)
{
    const int32_t before = g->previous[i];
    const int32_t after = g->next[i];
    if (before == g->nobody)
        g->first[cell_number(g, g->slot[i].cell)] = after;
    else
        g->next[before] = after;
    g->previous[after] = before;
}

/* Puts every body of a periodic box into the box that the grid covers. */
static inline void enter_box(motion *m)
{
    for (int64_t i = 0; i < m->bodies; i++)
        for (int c = 0; c < 3; c++) {
            /* x = place + boxes period, 0 <= place < period */
            const double boxes = floor(m->flight[i].place[c] / m->period);
            m->flight[i].place[c] -= boxes * m->period;
            m->boxes[3 * i + c] = (int64_t)boxes;
        }
}

/* Puts every body into its cell: at = floor((r - low)/edge), cell = at modulo count. */
static inline void fill_grid(const motion *m, grid *g, double now)
{
    const int64_t all = (int64_t)g->count[0] * g->count[1] * g->count[2];
    g->nobody = (int32_t)m->bodies;
    g->next[g->nobody] = g->nobody;
    for (int64_t k = 0; k < all; k++)
        g->first[k] = g->nobody;
    for (int64_t i = 0; i < m->bodies; i++) {
        slot *s = g->slot + i;
        double r[3];
        place(m, i, now, r);
        for (int c = 0; c < 3; c++) {
            s->at[c] = (int64_t)floor((r[c] - g->low[c]) / g->edge[c]);
            const int64_t within = s->at[c] % g->count[c];
            s->cell[c] = (int32_t)((within + g->count[c]) % g->count[c]);
        }
        enter_cell(g, (int32_t)i);
    }
}

/* Keeps the earlier of two times, and the side through which the body leaves at it. */
static inline void first_of(double when, int32_t side, double *restrict first,
                            int32_t *restrict exit)
{
    const int is_first = when < *first;
    *exit = is_first ? side : *exit;
    *first = is_first ? when : *first;
}

/* The time s from now until a body leaves its cell, and through which side; infinity along an axis
 * with one cell, or for a body that does not reach a side. With the distance D to the side in the
 * direction of motion, D = |v| s, and under gravity D = v s + g s^2/2 for either side. */
static inline double until_exit(const motion *m, const grid *g, int64_t i, double now,
                                int32_t *exit)
{
    const slot *s = g->slot + i;
    double r[3], v[3];
    double first = INFINITY;
    place(m, i, now, r);
    velocity(m, i, now, v);
    for (int c = 0; c < 3; c++) {
        if (g->count[c] == 1)
            continue;
        const double below = r[c] - (g->low[c] + (double)s->at[c] * g->edge[c]);
        const double above = g->edge[c] - below;
        if (m->falls) {
            const double up = until_passed(above, v[c], m->gravity[c]);
            const double down = until_passed(below, -v[c], -m->gravity[c]);
            first_of(up, 2 * c + 1, &first, exit);
            first_of(down, 2 * c, &first, exit);
            continue;
        }
        const int upwards = v[c] > 0.0;
        const double way = upwards ? above : below;
        /* At rest on the side itself 0/0 is NaN, which first_of does not keep. */
        first_of((way > 0.0 ? way : 0.0) / fabs(v[c]), 2 * c + upwards, &first, exit);
    }
    return first;
}

/* Moves a body to the cell beyond the side by which it leaves. */
static inline void cross_side(motion *m, grid *g, int32_t i)
{
    slot *s = g->slot + i;
    const int axis = s->exit / 2;
    const int32_t step = s->exit % 2 ? 1 : -1;
    const int32_t count = g->count[axis];
    leave_cell(g, i);
    s->at[axis] += step;
    s->cell[axis] += step;
    double wrapped = 0.0;
    if (s->cell[axis] == count) {
        s->cell[axis] = 0;
        wrapped = -1.0;
    } else if (s->cell[axis] < 0) {
        s->cell[axis] = count - 1;
        wrapped = 1.0;
    }
    /* In a periodic box it enters again through the opposite side, and the box is counted. */
    if (wrapped != 0.0 && m->period > 0.0) {
        m->flight[i].place[axis] += wrapped * m->period;
        m->boxes[3 * i + axis] -= (int64_t)wrapped;
        s->at[axis] = s->cell[axis];
    }
    enter_cell(g, i);
}

/* The indices `out` of the cells along an axis that a search covers, and their number: the body's
 * own cell and its two neighbours. With `only_new`, along the axis of the last crossing, it is only
 * the cell that has become a neighbour by that crossing. */
static inline int columns(const grid *g, const slot *s, int axis, bool only_new,
                          int32_t *restrict out)
{
    const int32_t count = g->count[axis];
    const int32_t cell = s->cell[axis];
    if (count == 1) {
        out[0] = 0;
        return 1;
    }
    const int32_t below = cell == 0 ? count - 1 : cell - 1;
    const int32_t above = cell == count - 1 ? 0 : cell + 1;
    if (only_new && s->exit / 2 == axis) {
        out[0] = s->exit % 2 ? above : below;
        return 1;
    }
    out[0] = below;
    out[1] = cell;
    out[2] = above;
    return 3;
}

/* Appends the bodies of a cell to the `found` ones of other cells; returns the new number. Cells
 * seldom have more than two: these are written without a branch, and the marker `nobody` is
 * overwritten by the next entry. */
static inline int64_t list_cell(const grid *g, int64_t cell, int64_t found, int32_t *restrict near)
{
    const int32_t first = g->first[cell];
    const int32_t second = g->next[first];
    near[found] = first;
    found += first != g->nobody;
    near[found] = second;
    found += second != g->nobody;
    for (int32_t j = g->next[second]; j != g->nobody; j = g->next[j])
        near[found++] = j;
    return found;
}

/* Lists the bodies of the cells around body i, including i itself; returns their number. */
static inline int64_t list_near(const grid *g, int32_t i, bool only_new, int32_t *restrict near)
{
    const slot *s = g->slot + i;
    int32_t x[3], y[3], z[3];
    const int along_x = columns(g, s, 0, only_new, x);
    const int along_y = columns(g, s, 1, only_new, y);
    const int along_z = columns(g, s, 2, only_new, z);
    int64_t found = 0;
    for (int c = 0; c < along_z; c++)
        for (int b = 0; b < along_y; b++) {
            const int64_t row = ((int64_t)z[c] * g->count[1] + y[b]) * g->count[0];
            for (int a = 0; a < along_x; a++)
                found = list_cell(g, row + x[a], found, near);
        }
    return found;
}

#endif
