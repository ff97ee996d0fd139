/* The bodies of a gas in the order of their cells, and Verlet's list of the pairs that may come
 * into contact before it is rebuilt (gas.c).
 *
 * Positions are kept in the box, and whole boxes are counted separately. The list has each pair
 * once, from half of the cells around each body, with the nearest image of the second body; plane k
 * is -1 - k. Lasting contacts are transferred to a new list. Every thread builds its own share, and
 * the list is the same for any number of threads.
 */
#ifndef REFDEM_GAS_LIST_H
#define REFDEM_GAS_LIST_H

#include "gas_state.h"

/* Thickness of the skin in diameters. Measured: the minimum of run time, which is flat, at packing
 * fractions of 1 to 5 %. */
#define SKIN 0.5
#define LONGEST 1024 /* cells along an edge, at most */

/* The difference d of coordinates to the nearest image, d - size round(d/size), for |d| < 3/2 size.
 */
static inline double nearest(double d, double size)
{
    double half = 0.5 * size;
    if (d > half)
        return d - size;
    if (d < -half)
        return d + size;
    return d;
}

/* Number of the image of the box that is x, y, z = -1, 0 or 1 boxes away. */
static inline int image_of(int x, int y, int z)
{
    return ((x + 3) % 3) + 3 * ((y + 3) % 3) + 9 * ((z + 3) % 3);
}

/* The shift [m] of every image, by its number. */
static void place_images(gas *g)
{
    static const int boxes[3] = {0, 1, -1};
    for (int k = 0; k < IMAGES; k++) {
        g->shift[k][0] = g->p->size * boxes[k % 3];
        g->shift[k][1] = g->p->size * boxes[k / 3 % 3];
        g->shift[k][2] = g->p->size * boxes[k / 9];
    }
}

/* Moves whole boxes from the share's positions to their count, x -= size floor(x/size), and finds
 * the extent of the share. In a motion that diverges the count of boxes may overflow, or a position
 * be NaN: the share is then marked as failed, and the coordinate is set to 0, so that the search
 * for neighbours has a valid position. */
static void wrap(gas *g, share *t)
{
    double size = g->p->size;
    double *x = g->now.x;
    if (size > 0.0) { /* the box is the extent */
        for (int64_t i = 3 * t->from; i < 3 * t->to; i++) {
            if (x[i] >= 0.0 && x[i] < size)
                continue;
            /* x -= size floor(x/size), and the count of boxes gains floor(x/size). */
            double boxes = floor(x[i] / size);
            if (!(fabs(boxes + g->now.boxes[i]) <= FARTHEST)) {
                t->failed = ASTRAY;
                x[i] = 0.0;
                continue;
            }
            x[i] -= boxes * size;
            g->now.boxes[i] += (int32_t)boxes;
        }
        return;
    }
    for (int c = 0; c < 3; c++) {
        t->low[c] = INFINITY;
        t->high[c] = -INFINITY;
        for (int64_t i = t->from; i < t->to; i++) {
            if (!isfinite(x[3 * i + c])) {
                t->failed = ASTRAY;
                x[3 * i + c] = 0.0;
            }
            t->low[c] = fmin(t->low[c], x[3 * i + c]);
            t->high[c] = fmax(t->high[c], x[3 * i + c]);
        }
    }
}

/* Numbers and sizes of the cells: at least `reach` wide, floor(width/reach) along an edge, and at
 * most `most_cells` in all. A periodic box with fewer than 3 along an edge has a single cell, since
 * a neighbouring cell would be visited twice. */
static void set_cells(gas *g)
{
    int64_t most_along = 1;
    while ((most_along + 1) * (most_along + 1) * (most_along + 1) <= most_cells(g->p)
           && most_along < LONGEST)
        most_along++;
    for (int c = 0; c < 3; c++) {
        /* cells = min(floor(width/reach), most_along), at least 1; `side` is cells a metre. */
        double low = 0.0;
        double width = g->p->size;
        if (!(g->p->size > 0.0)) { /* no box: the extent of all shares */
            low = g->share[0].low[c];
            double high = g->share[0].high[c];
            for (int64_t k = 1; k < g->threads; k++) {
                low = fmin(low, g->share[k].low[c]);
                high = fmax(high, g->share[k].high[c]);
            }
            width = high - low;
        }
        double fitting = floor(width / g->reach);
        g->low[c] = low;
        g->cells[c] = (int64_t)fmax(1.0, fmin(fitting, (double)most_along));
        g->side[c] = (double)g->cells[c] / fmax(width, g->reach);
    }
    if (!(g->p->size > 0.0))
        return;
    if (g->cells[0] < 3) { /* the box is a cube: as many along each edge */
        for (int c = 0; c < 3; c++)
            g->cells[c] = 1;
    }
}

/* The index of a cell along an edge, limited to 0 .. cells - 1. */
static inline int64_t clamped(int64_t at, int64_t cells)
{
    if (at < 0)
        return 0;
    if (at >= cells)
        return cells - 1;
    return at;
}

/* The cell of a position, (z n_y + y) n_x + x with the indices x, y, z along the edges. */
static inline int64_t cell_of(const gas *g, const double *x)
{
    int64_t at[3];
    for (int c = 0; c < 3; c++) {
        at[c] = 0;
        if (g->cells[c] > 1)
            at[c] = clamped((int64_t)((x[c] - g->low[c]) * g->side[c]), g->cells[c]);
    }
    return (at[2] * g->cells[1] + at[1]) * g->cells[0] + at[0];
}

/* Replaces the counts of bodies by their prefix sums: `start` is the index of the first body of
 * each cell, `count` of a thread that of the thread's first body in each cell. Bodies are sorted by
 * cells, and within a cell by threads; every thread sums its own share of the cells. */
static void count_cells(gas *g, share *t, int rank)
{
    int64_t all = g->cells[0] * g->cells[1] * g->cells[2];
    int64_t from = share_of(g, all, rank);
    int64_t to = share_of(g, all, rank + 1);
    int64_t sum = 0;
    for (int64_t k = 0; k < g->threads; k++)
        for (int64_t c = from; c < to; c++)
            sum += g->share[k].count[c];
    t->cells = sum;
    wait_for_all(&g->team);
    sum = 0; /* bodies in the shares of the threads before */
    for (int k = 0; k < rank; k++)
        sum += g->share[k].cells;
    for (int64_t c = from; c < to; c++) {
        g->start[c] = (int32_t)sum;
        for (int64_t k = 0; k < g->threads; k++) {
            int32_t bodies = g->share[k].count[c];
            g->share[k].count[c] = (int32_t)sum;
            sum += bodies;
        }
    }
    if (rank == 0)
        g->start[all] = (int32_t)g->n;
    wait_for_all(&g->team);
}

/* Copies a vector. */
static inline void copy3(double *to, const double *from)
{
    memcpy(to, from, 3 * sizeof(double));
}

/* Copies the share's part of the sorted columns; finds its largest speed and its bodies with an
 * impulse to be applied (`marked`). */
static void permute(gas *g, share *t)
{
    const columns *old = &g->now;
    columns *new = &g->next;
    double fastest = 0.0;
    t->touched = 0;
    for (int64_t i = t->from; i < t->to; i++) {
        int64_t j = g->order[i];
        copy3(new->x + 3 * i, old->x + 3 * j);
        copy3(new->v + 3 * i, old->v + 3 * j);
        copy3(new->kick + 3 * i, old->kick + 3 * j);
        if (g->p->turning) {
            copy3(new->w + 3 * i, old->w + 3 * j);
            copy3(new->turn + 3 * i, old->turn + 3 * j);
        }
        memcpy(new->boxes + 3 * i, old->boxes + 3 * j, 3 * sizeof(int32_t));
        new->label[i] = old->label[j];
        new->mark[i] = old->mark[j];
        g->gone[j] = (int32_t)i;
        if (new->mark[i])
            t->marked[t->touched++] = (int32_t)i;
        const double *v = new->v + 3 * i;
        fastest = fmax(fastest, v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    }
    t->fastest = sqrt(fastest);
}

/* Counting sort: the bodies in the order of their cells, and within a cell in their former order.
 */
static void sort(gas *g, share *t, int rank)
{
    int64_t all = g->cells[0] * g->cells[1] * g->cells[2];
    memset(t->count, 0, (size_t)all * sizeof(int32_t));
    for (int64_t i = t->from; i < t->to; i++) {
        g->cell[i] = (int32_t)cell_of(g, g->now.x + 3 * i);
        t->count[g->cell[i]]++;
    }
    wait_for_all(&g->team);
    count_cells(g, t, rank);
    for (int64_t i = t->from; i < t->to; i++)
        g->order[t->count[g->cell[i]]++] = (int32_t)i;
    wait_for_all(&g->team);
    permute(g, t);
    wait_for_all(&g->team);
    if (rank == 0) {
        columns swap = g->now;
        g->now = g->next;
        g->next = swap;
    }
    contact *own = g->contact[t->side] + rank * g->p->most_contacts;
    for (int64_t k = 0; k < t->contacts; k++) {
        own[k].a = g->gone[own[k].a];
        if (own[k].b >= 0) /* planes keep their numbers */
            own[k].b = g->gone[own[k].b];
    }
    wait_for_all(&g->team);
}

/* Lists the pairs of body i with the bodies `from` up to `to` in an image for which
 * |x_j + shift - x_i| < reach. */
static inline void list_pairs(gas *g, share *t, int64_t i, int64_t from, int64_t to, int image)
{
    const double *x = g->now.x + 3 * i;
    const double *s = g->shift[image];
    const double reach2 = g->reach * g->reach;
    /* |x_j - (x_i - shift)|^2 < reach^2. */
    double at[3] = {x[0] - s[0], x[1] - s[1], x[2] - s[2]};
    for (int64_t j = from; j < to; j++) {
        const double *y = g->now.x + 3 * j;
        double d[3] = {y[0] - at[0], y[1] - at[1], y[2] - at[2]};
        if (!(d[0] * d[0] + d[1] * d[1] + d[2] * d[2] < reach2))
            continue;
        if (t->pairs == g->p->most_pairs) {
            t->failed = NO_ROOM;
            return;
        }
        t->a[t->pairs] = (int32_t)i;
        t->b[t->pairs] = (int32_t)j;
        t->image[t->pairs] = (uint8_t)image;
        t->was[t->pairs++] = 0;
    }
}

/* Lists the pairs of body i with every later one, by their nearest images: for boxes of one cell.
 */
static void list_all(gas *g, share *t, int64_t i)
{
    double size = g->p->size;
    for (int64_t j = i + 1; j < g->n; j++) {
        int boxes[3] = {0, 0, 0};
        for (int c = 0; c < 3 && size > 0.0; c++) {
            double d = g->now.x[3 * j + c] - g->now.x[3 * i + c];
            if (nearest(d, size) < d)
                boxes[c] = -1;
            else if (nearest(d, size) > d)
                boxes[c] = 1;
        }
        list_pairs(g, t, i, j, j + 1, image_of(boxes[0], boxes[1], boxes[2]));
    }
}

/* Lists pairs of body i with the cells x - 1, x, x + 1 of the row that begins at cell `base`, in
 * the image (y, z) of it; of its own row those bodies that come after i, so that a pair is listed
 * once. */
static void list_row(gas *g, share *t, int64_t i, int64_t x, int64_t base, int is_own, int y, int z)
{
    int64_t n = g->cells[0];
    int64_t high = clamped(x + 1, n);
    int64_t begin = g->start[base + clamped(x - 1, n)];
    if (is_own) /* bodies lie in the order of their cells */
        begin = i + 1;
    list_pairs(g, t, i, begin, g->start[base + high + 1], image_of(0, y, z));
    if (!(g->p->size > 0.0)) /* no box: no images beyond the edge */
        return;
    if (x == 0 && !is_own)
        list_pairs(g, t, i, g->start[base + n - 1], g->start[base + n], image_of(-1, y, z));
    if (x == n - 1)
        list_pairs(g, t, i, g->start[base], g->start[base + 1], image_of(1, y, z));
}

/* Lists pairs of body i with its own row of cells and the four of eight around it on the upper
 * side: the other four list them from their side. */
static void list_neighbours(gas *g, share *t, int64_t i)
{
    static const int rows[5][2] = {{0, 0}, {1, 0}, {-1, 1}, {0, 1}, {1, 1}};
    int64_t *n = g->cells;
    int64_t cell = cell_of(g, g->now.x + 3 * i);
    int64_t x = cell % n[0];
    int64_t y = cell / n[0] % n[1];
    int64_t z = cell / n[0] / n[1];
    for (int k = 0; k < 5; k++) {
        int64_t row[2] = {y + rows[k][0], z + rows[k][1]};
        int beyond[2] = {0, 0};
        for (int c = 0; c < 2; c++) {
            if (row[c] < 0)
                beyond[c] = -1;
            else if (row[c] >= n[c + 1])
                beyond[c] = 1;
            row[c] -= beyond[c] * n[c + 1];
        }
        if (g->p->size > 0.0 || (!beyond[0] && !beyond[1]))
            list_row(g, t, i, x, (row[1] * n[1] + row[0]) * n[0], k == 0, beyond[0], beyond[1]);
    }
}

/* Lists the planes within reach of body i: (x_i - p).n < reach - diameter/2. */
static void list_planes(gas *g, share *t, int64_t i)
{
    const double *x = g->now.x + 3 * i;
    for (int64_t k = 0; k < g->p->planes; k++) {
        const double *plane = g->p->plane + 6 * k;
        double distance = (x[0] - plane[0]) * plane[3] + (x[1] - plane[1]) * plane[4]
                          + (x[2] - plane[2]) * plane[5];
        if (!(distance < g->reach - 0.5 * g->p->diameter))
            continue;
        if (t->pairs == g->p->most_pairs) {
            t->failed = NO_ROOM;
            return;
        }
        t->a[t->pairs] = (int32_t)i;
        t->b[t->pairs] = (int32_t)(-1 - k);
        t->image[t->pairs] = 0;
        t->was[t->pairs++] = 0;
    }
}

/* The number of the listed pair (a, b) of this share; -1 if it is not listed here. */
static int64_t pair_number(const share *t, int64_t a, int64_t b)
{
    if (a < t->from || a >= t->to)
        return -1;
    for (int64_t m = t->first[a - t->from]; m < t->first[a - t->from + 1]; m++)
        if (t->b[m] == b)
            return m;
    return -1;
}

/* Assigns to the pairs of a new list their contacts of the step before, in `was`: contact k as
 * k + 1, or as -(k + 1) where the bodies have changed their order. */
static void find_contacts_again(gas *g, share *t)
{
    for (int64_t s = 0; s < g->threads; s++) {
        /* The contacts of each thread have room of their own. */
        int64_t first = s * g->p->most_contacts;
        int64_t end = first + g->share[s].contacts;
        for (int64_t k = first; k < end; k++) {
            const contact *c = g->contact[t->side] + k;
            int is_with_plane = c->b < 0;
            int64_t pair = pair_number(t, c->a, c->b);
            int64_t pair_turned = -1;
            if (pair < 0 && !is_with_plane)
                pair_turned = pair_number(t, c->b, c->a);
            if (pair >= 0)
                t->was[pair] = (int32_t)(k + 1);
            if (pair_turned >= 0)
                t->was[pair_turned] = -(int32_t)(k + 1);
        }
    }
}

/* Makes the list anew: wrap, cells, sort, pairs, contacts. A share without room for its pairs is
 * marked as failed. */
static void rebuild(gas *g, share *t, int rank)
{
    wrap(g, t);
    wait_for_all(&g->team);
    if (rank == 0)
        set_cells(g);
    wait_for_all(&g->team);
    sort(g, t, rank);
    t->pairs = 0;
    t->way = 0.0;
    for (int64_t i = t->from; i < t->to && !t->failed; i++) {
        t->first[i - t->from] = (int32_t)t->pairs;
        if (g->cells[0] * g->cells[1] * g->cells[2] == 1)
            list_all(g, t, i);
        else
            list_neighbours(g, t, i);
        list_planes(g, t, i);
    }
    t->first[t->to - t->from] = (int32_t)t->pairs;
    if (!t->failed)
        find_contacts_again(g, t);
    wait_for_all(&g->team);
}

#endif
