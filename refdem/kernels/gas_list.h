/* The bodies of a gas in the order of their cells, and Verlet's list of the pairs that may meet before it is rebuilt (gas.c).
 *
 * Positions are kept in the box, with whole boxes counted apart. The list has each pair once, with the body that comes first in memory
 * first, and planes as -1 - k. Contacts that last are found again in a new list.
 */
#ifndef REFDEM_GAS_LIST_H
#define REFDEM_GAS_LIST_H

#include "kernels.h"
#include <math.h>
#include <string.h>

#define SKIN 0.5      /* diameters; measured: the flat minimum of cost at packing fractions of 1 to 5 % */
#define LONGEST 1024  /* cells along an edge, at most */

typedef struct {
    const refdem_gas *p;
    int64_t n, pairs, near_planes, contacts, touched, cells[3];
    double h, reach, skin, way, fastest, round, side[3], low[3], work, power;
    double *x, *v, *kick, *spare, *contact;
    int32_t *image, *label, *order, *cell, *start, *first, *a, *b, *ca, *cb, *marked, *spare_int;
    uint8_t *touching, *mark;
} gas;

static int64_t most_cells(const refdem_gas *p) { return 2 * p->bodies + 64; }

static void laid_out(gas *g, const refdem_gas *p, double *w, int32_t *k, uint8_t *byte)
{
    int64_t n = p->bodies, most = refdem_gas_contacts(p);
    g->p = p, g->n = n;
    g->x = w, g->v = w + 3 * n, g->kick = w + 6 * n, g->spare = w + 9 * n, g->contact = w + 12 * n;
    g->image = k, g->label = k + 3 * n, g->order = k + 4 * n, g->cell = k + 5 * n, g->marked = k + 6 * n, g->spare_int = k + 7 * n;
    g->first = k + 12 * n, g->start = g->first + n + 1, g->a = g->start + most_cells(p) + 1;
    g->b = g->a + p->most_pairs, g->ca = g->b + p->most_pairs, g->cb = g->ca + most;
    g->touching = byte, g->mark = byte + p->most_pairs;
}

/* d of the nearest image of a body, for bodies less than one box and a half apart. */
static inline double nearest(double d, double size)
{
    double half = 0.5 * size;
    return d > half ? d - size : d < -half ? d + size : d;
}

static double fastest(const gas *g)
{
    double most = 0.0;
    for (int64_t i = 0; i < g->n; i++) {
        const double *v = g->v + 3 * i;
        most = fmax(most, v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    }
    return sqrt(most);
}

/* Moves whole boxes from positions to their count. */
static void wrapped(gas *g)
{
    double size = g->p->size;
    for (int64_t i = 0; size > 0.0 && i < 3 * g->n; i++) {
        double boxes = floor(g->x[i] / size);
        g->x[i] -= boxes * size, g->image[i] += (int32_t)boxes;
    }
}

/* Cells at least `reach` wide, not many more of them than bodies; 1 where the nearest images would meet a cell twice. */
static void measured(gas *g)
{
    double high[3];
    int64_t most = 1;
    while ((most + 1) * (most + 1) * (most + 1) <= most_cells(g->p) && most < LONGEST)
        most++;
    for (int c = 0; c < 3; c++) {
        g->low[c] = 0.0, high[c] = g->p->size;
        if (!(g->p->size > 0.0)) {
            g->low[c] = high[c] = g->x[c];
            for (int64_t i = 0; i < g->n; i++)
                g->low[c] = fmin(g->low[c], g->x[3 * i + c]), high[c] = fmax(high[c], g->x[3 * i + c]);
        }
        double fit = floor((high[c] - g->low[c]) / g->reach);
        g->cells[c] = fit > (double)most ? most : fit < 1.0 ? 1 : (int64_t)fit;
        g->side[c] = (double)g->cells[c] / fmax(high[c] - g->low[c], g->reach);
    }
    for (int c = 0; c < 3 && g->p->size > 0.0; c++)
        if (g->cells[c] < 3)
            g->cells[0] = g->cells[1] = g->cells[2] = 1;
}

static int64_t cell_of(const gas *g, const double *x)
{
    int64_t at[3];
    for (int c = 0; c < 3; c++) {
        at[c] = g->cells[c] == 1 ? 0 : (int64_t)((x[c] - g->low[c]) * g->side[c]);
        at[c] = at[c] < 0 ? 0 : at[c] >= g->cells[c] ? g->cells[c] - 1 : at[c];
    }
    return (at[2] * g->cells[1] + at[1]) * g->cells[0] + at[0];
}

static void permuted(const gas *g, double *column)
{
    memcpy(g->spare, column, (size_t)(3 * g->n) * sizeof(double));
    for (int64_t i = 0; i < g->n; i++)
        memcpy(column + 3 * i, g->spare + 3 * g->order[i], 3 * sizeof(double));
}

/* Counting sort: the bodies in the order of their cells, and of their labels before within a cell. */
static void sorted(gas *g)
{
    int64_t n = g->n, count = g->cells[0] * g->cells[1] * g->cells[2];
    int32_t *where = g->spare_int, *held = g->spare_int + n;
    memset(g->start, 0, (size_t)(count + 1) * sizeof(int32_t));
    for (int64_t i = 0; i < n; i++)
        g->start[1 + (where[i] = (int32_t)cell_of(g, g->x + 3 * i))]++;
    for (int64_t c = 0; c < count; c++)
        g->start[c + 1] += g->start[c];
    for (int64_t i = 0; i < n; i++)
        g->order[g->start[where[i]]++] = (int32_t)i;
    for (int64_t c = count; c > 0; c--)
        g->start[c] = g->start[c - 1];
    g->start[0] = 0;
    for (int64_t i = 0; i < n; i++)
        g->cell[i] = where[g->order[i]];
    permuted(g, g->x), permuted(g, g->v), permuted(g, g->kick);
    memcpy(held, g->image, (size_t)(3 * n) * sizeof(int32_t));
    memcpy(where, g->label, (size_t)n * sizeof(int32_t));
    for (int64_t i = 0; i < n; i++) {
        memcpy(g->image + 3 * i, held + 3 * g->order[i], 3 * sizeof(int32_t));
        g->label[i] = where[g->order[i]];
    }
    for (int64_t i = 0; i < n; i++)
        where[g->order[i]] = (int32_t)i; /* where each has gone */
    for (int64_t k = 0; k < g->contacts; k++) {
        g->ca[k] = where[g->ca[k]];
        if (g->cb[k] >= 0)
            g->cb[k] = where[g->cb[k]];
    }
    for (int64_t k = 0; k < g->touched; k++)
        g->mark[g->marked[k]] = 0;
    for (int64_t k = 0; k < g->touched; k++)
        g->mark[g->marked[k] = where[g->marked[k]]] = 1;
}

/* Pairs of body i with those from `from` up to `to`, as far as they are within reach. */
static int listed(gas *g, int64_t i, int64_t from, int64_t to)
{
    const double *x = g->x + 3 * i, size = g->p->size, reach2 = g->reach * g->reach;
    for (int64_t j = from; j < to; j++) {
        double d2 = 0.0;
        for (int c = 0; c < 3; c++) {
            double d = g->x[3 * j + c] - x[c];
            d = size > 0.0 ? nearest(d, size) : d;
            d2 += d * d;
        }
        if (d2 < reach2) {
            if (g->pairs == g->p->most_pairs)
                return 1;
            g->a[g->pairs] = (int32_t)i, g->b[g->pairs] = (int32_t)j, g->touching[g->pairs++] = 0;
        }
    }
    return 0;
}

/* One row of three cells along x, those after i in the order of cells only. */
static int row_listed(gas *g, int64_t i, int64_t x, int64_t y, int64_t z)
{
    int64_t *n = g->cells, base = (z * n[1] + y) * n[0];
    int periodic = g->p->size > 0.0;
    for (int64_t dx = -1; dx <= 1; dx++) {
        int64_t at = x + dx;
        if (at < 0 || at >= n[0]) {
            if (!periodic)
                continue;
            at += at < 0 ? n[0] : -n[0];
        }
        int64_t from = g->start[base + at], to = g->start[base + at + 1];
        if (listed(g, i, from > i ? from : i + 1, to))
            return 1;
    }
    return 0;
}

static int planes_listed(gas *g, int64_t i)
{
    for (int64_t k = 0; k < g->p->planes; k++) {
        const double *q = g->p->plane + 6 * k, *x = g->x + 3 * i;
        double away = (x[0] - q[0]) * q[3] + (x[1] - q[1]) * q[4] + (x[2] - q[2]) * q[5];
        if (away < g->reach - 0.5 * g->p->diameter) {
            if (g->pairs == g->p->most_pairs)
                return 1;
            g->a[g->pairs] = (int32_t)i, g->b[g->pairs] = (int32_t)(-1 - k), g->touching[g->pairs++] = 0;
        }
    }
    return 0;
}

static int neighbours_listed(gas *g, int64_t i)
{
    int64_t *n = g->cells, at = g->cell[i], x = at % n[0], y = at / n[0] % n[1], z = at / n[0] / n[1];
    int periodic = g->p->size > 0.0;
    if (n[0] * n[1] * n[2] == 1)
        return listed(g, i, i + 1, g->n);
    for (int64_t k = 0; k < 9; k++) {
        int64_t to[2] = {y + k % 3 - 1, z + k / 3 - 1};
        int outside = 0;
        for (int c = 0; c < 2; c++)
            if (to[c] < 0 || to[c] >= n[c + 1])
                outside = 1, to[c] += to[c] < 0 ? n[c + 1] : -n[c + 1];
        if (!(outside && !periodic) && row_listed(g, i, x, to[0], to[1]))
            return 1;
    }
    return 0;
}

/* The list anew; contacts that last are found in it again. Returns 0, or 1 if there are more pairs than room for them. */
static int rebuilt(gas *g)
{
    wrapped(g), measured(g), sorted(g);
    g->pairs = 0, g->way = 0.0, g->fastest = fastest(g);
    for (int64_t i = 0; i < g->n; i++) {
        g->first[i] = (int32_t)g->pairs;
        if (neighbours_listed(g, i) || planes_listed(g, i))
            return 1;
    }
    g->first[g->n] = (int32_t)g->pairs;
    for (int64_t k = 0; k < g->contacts; k++) {
        int32_t i = g->ca[k], j = g->cb[k];
        if (j >= 0 && j < i)
            i = g->cb[k], j = g->ca[k];
        for (int64_t m = g->first[i]; m < g->first[i + 1]; m++)
            if (g->b[m] == j)
                g->touching[m] = 1;
    }
    return 0;
}

#endif
