/* What a run of a gas works on: columns of the bodies in the order of their cells, and every
 * thread's share of pairs and contacts.
 *
 * All of it lies in one piece of memory. A thread owns the bodies `from` up to `to`, the listed
 * pairs whose first body is its own, and the contacts that it finds among them.
 */
#ifndef REFDEM_GAS_STATE_H
#define REFDEM_GAS_STATE_H

#include "gas_team.h"
#include "kernels.h"
#include <math.h>
#include <string.h>

/* A body's own place and its neighbours in a periodic box; the first is the own. */
#define IMAGES 27

/* How a share may have failed; 2 is a thread that could not be had (kernels.h). */
enum { NO_ROOM = 1, ASTRAY = 3 };

/* Whole boxes from the first one that a body may be away: as many as their count of 32 bits holds.
 */
#define FARTHEST 2e9

/* Bodies a and b, or plane -1 - b; normal from a to b, overlap, tangential spring (of a against b),
 * and half a step's change of the velocity of a (-b), and of the spin of both. */
typedef struct {
    int32_t a, b;
    double n[3], deep, bend[3], push[3], twist[3], power;
} contact;

typedef struct {
    int64_t from, to, pairs, contacts, touched, events, crossing;
    int failed, side;
    double fastest, way, low[3], high[3];
    int64_t cells;
    int32_t *a, *b, *was, *first, *count, *marked, *out;
    uint8_t *image;
    double *event;
} share;

/* Columns, two of each: a sorted copy is written beside the old one. */
typedef struct {
    double *x, *v, *kick, *w, *turn;
    int32_t *boxes, *label;
    uint8_t *mark;
} columns;

typedef struct {
    const refdem_gas *p;
    team team;
    int64_t n, threads, cells[3], samples, stride, most;
    double h, reach, skin, round, first_work, side[3], low[3], shift[IMAGES][3];
    columns now, next;
    int32_t *order, *cell, *gone, *start;
    double *lost, *attitude, *channel, *out_x, *out_v, *out_w, *out_q;
    int32_t *since;
    contact *contact[2];
    share *share;
} gas;

static inline int64_t most_cells(const refdem_gas *p)
{
    return 2 * p->bodies + 64;
}

static inline int64_t share_of(const gas *g, int64_t whole, int64_t rank)
{
    return whole * rank / g->threads;
}

/* `size` bytes at the next cache line. */
static void *placed(uint8_t **at, int64_t size)
{
    void *found = *at;
    *at += (size + 127) / 64 * 64;
    return found;
}

static void columns_placed(const refdem_gas *p, columns *c, uint8_t **at)
{
    int64_t n = p->bodies;
    int64_t three = 3 * n * (int64_t)sizeof(double);
    c->x = placed(at, three);
    c->v = placed(at, three);
    c->kick = placed(at, three);
    int64_t turning = 0; /* bytes of a column that is there only if spheres turn */
    if (p->turning)
        turning = three;
    c->w = placed(at, turning);
    c->turn = placed(at, turning);
    c->boxes = placed(at, 12 * n);
    c->label = placed(at, 4 * n);
    c->mark = placed(at, n);
}

static void share_placed(const gas *g, share *t, uint8_t **at)
{
    const refdem_gas *p = g->p;
    t->a = placed(at, 4 * p->most_pairs);
    t->b = placed(at, 4 * p->most_pairs);
    t->was = placed(at, 4 * p->most_pairs);
    t->image = placed(at, p->most_pairs);
    t->out = placed(at, 4 * p->most_contacts);
    t->first = placed(at, 4 * (t->to - t->from + 1));
    t->marked = placed(at, 4 * (t->to - t->from));
    t->count = placed(at, 4 * most_cells(p));
}

/* Lays everything out from `room` on; returns the bytes it takes. */
static int64_t laid_out(gas *g, const refdem_gas *p, int64_t threads, uint8_t *room)
{
    uint8_t *at = room;
    int64_t n = p->bodies;
    g->p = p;
    g->n = n;
    g->threads = threads;
    g->share = placed(&at, threads * (int64_t)sizeof(share));
    columns_placed(p, &g->now, &at);
    columns_placed(p, &g->next, &at);
    g->order = placed(&at, 4 * n);
    g->cell = placed(&at, 4 * n);
    g->gone = placed(&at, 4 * n);
    g->since = placed(&at, 4 * n);
    g->start = placed(&at, 4 * (most_cells(p) + 1));
    g->lost = placed(&at, 8 * n);
    int64_t attitudes = 0;
    if (p->turning)
        attitudes = 32 * n;
    g->attitude = placed(&at, attitudes);
    for (int k = 0; k < 2; k++)
        g->contact[k] = placed(&at, threads * p->most_contacts * (int64_t)sizeof(contact));
    for (int64_t k = 0; k < threads; k++) {
        share other = {.from = share_of(g, n, k), .to = share_of(g, n, k + 1)};
        share *t = &other;
        share_placed(g, t, &at);
        if (room)
            g->share[k] = other;
    }
    return at - room;
}

#endif
