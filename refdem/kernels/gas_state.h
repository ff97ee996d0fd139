/* The data of a run of a gas: columns of the bodies in the order of their cells, and every
 * thread's share of pairs and contacts.
 *
 * All of it lies in one block of memory. A thread owns the bodies `from` up to `to`, the listed
 * pairs whose first body is its own, and the contacts that it finds among them.
 */
#ifndef REFDEM_GAS_STATE_H
#define REFDEM_GAS_STATE_H

#include "gas_team.h"
#include "kernels.h"
#include <math.h>
#include <string.h>

/* The box itself and its 26 neighbouring images; the box itself is number 0. */
#define IMAGES 27

/* Failures of a share; 2 is a thread that could not be started (kernels.h). */
enum { NO_ROOM = 1, ASTRAY = 3 };

/* Largest number of whole boxes between a body and the first box, within the range of their count
 * of 32 bits. */
#define FARTHEST 2e9

/* A contact of the bodies a and b, or of a with plane -1 - b. */
typedef struct {
    int32_t a, b;
    double n[3], overlap; /* unit normal from a to b; overlap [m] */
    double spring[3];     /* stretch of the tangential spring, of a against b [m] */
    double impulse[3];    /* half a step's change of the velocity of a, the opposite of b's [m/s] */
    double spin_change[3]; /* half a step's change of the spin of both [rad/s] */
    double power;          /* lost [W] */
} contact;

/* One thread's share of the work. */
typedef struct {
    int64_t from, to;         /* its bodies */
    int64_t pairs, contacts;  /* listed, and found among them */
    int64_t touched;          /* bodies to be kicked, in `marked` */
    int64_t events, crossing; /* contacts begun; contacts with another share's body, in `out` */
    int failed, side;    /* how it has failed; which of the two lists of contacts is the new one */
    double fastest, way; /* largest speed [m/s]; |h| times that of all bodies, summed since the
                            list was made [m] */
    double low[3], high[3]; /* extent of its bodies [m], where there is no box */
    int64_t cells;          /* bodies in its part of the cells */
    int32_t *a, *b;         /* the pairs */
    int32_t *was;           /* number of the contact before of a pair (gas_list.h), 0 for none */
    int32_t *first;         /* first pair of each of its bodies */
    int32_t *count;         /* of its bodies in each cell */
    int32_t *marked, *out;  /* bodies to be kicked; contacts with another share's body */
    uint8_t *image;         /* of the box in which b is near a */
    double *event;          /* (most, 2): time [s], body */
} share;

/* Columns by body in the order of the cells: position, velocity, impulses of the step, spin and its
 * change; whole boxes from the first one, the body's number as given, whether it is to be kicked.
 * There are two sets: a sorted copy is written beside the old one. */
typedef struct {
    double *x, *v, *kick, *w, *turn;
    int32_t *boxes, *label;
    uint8_t *mark;
} columns;

/* A run. */
typedef struct {
    const refdem_gas *p;
    team team;
    int64_t n, threads;            /* bodies, threads */
    int64_t cells[3];              /* along the edges */
    int64_t samples, stride, most; /* steps a sample; room for events of a thread */
    double h, reach, skin;         /* step [s]; diameter + skin, and skin [m] */
    double round;           /* (x + round) - round is x rounded to the grid of velocities (gas.c) */
    double first_work;      /* of the start [J] */
    double side[3], low[3]; /* cells a metre; where they begin [m] */
    double shift[IMAGES][3]; /* of the images of the box [m] */
    columns now, next;
    int32_t *order, *cell;   /* place before of the body now at a place; cell of a body */
    int32_t *gone, *start;   /* place now of the body before at a place; first body of a cell */
    double *lost, *attitude; /* of a body, as given: work lost [J]; attitude at the step `since` */
    double *channel;         /* outputs */
    double *out_x, *out_v, *out_w, *out_q;
    int32_t *since;
    contact *contact[2]; /* the new list and that of the step before, see share.side */
    share *share;
} gas;

/* Largest number of cells, for which memory is laid out. */
static inline int64_t most_cells(const refdem_gas *p)
{
    return 2 * p->bodies + 64;
}

/* Where the share of `rank` in `whole` things begins. */
static inline int64_t share_of(const gas *g, int64_t whole, int64_t rank)
{
    return whole * rank / g->threads;
}

/* `size` bytes from *at, which is advanced by them and at least 64 bytes of padding, so that no two
 * threads write to one cache line. */
static void *take_room(uint8_t **at, int64_t size)
{
    void *found = *at;
    *at += (size + 127) / 64 * 64;
    return found;
}

/* Takes room for a set of columns. */
static void lay_out_columns(const refdem_gas *p, columns *c, uint8_t **at)
{
    int64_t n = p->bodies;
    int64_t three = 3 * n * (int64_t)sizeof(double);
    c->x = take_room(at, three);
    c->v = take_room(at, three);
    c->kick = take_room(at, three);
    int64_t turning = 0; /* bytes of a column that is there only if spheres turn */
    if (p->turning)
        turning = three;
    c->w = take_room(at, turning);
    c->turn = take_room(at, turning);
    c->boxes = take_room(at, 12 * n);
    c->label = take_room(at, 4 * n);
    c->mark = take_room(at, n);
}

/* Takes room for a share's pairs, contacts and counts. */
static void lay_out_share(const gas *g, share *t, uint8_t **at)
{
    const refdem_gas *p = g->p;
    t->a = take_room(at, 4 * p->most_pairs);
    t->b = take_room(at, 4 * p->most_pairs);
    t->was = take_room(at, 4 * p->most_pairs);
    t->image = take_room(at, p->most_pairs);
    t->out = take_room(at, 4 * p->most_contacts);
    t->first = take_room(at, 4 * (t->to - t->from + 1));
    t->marked = take_room(at, 4 * (t->to - t->from));
    t->count = take_room(at, 4 * most_cells(p));
}

/* Takes memory for everything from `memory` on; returns the bytes it takes. With memory NULL it
 * only counts them: nothing is written there. */
static int64_t lay_out(gas *g, const refdem_gas *p, int64_t threads, uint8_t *memory)
{
    uint8_t *at = memory;
    int64_t n = p->bodies;
    g->p = p;
    g->n = n;
    g->threads = threads;
    g->share = take_room(&at, threads * (int64_t)sizeof(share));
    lay_out_columns(p, &g->now, &at);
    lay_out_columns(p, &g->next, &at);
    g->order = take_room(&at, 4 * n);
    g->cell = take_room(&at, 4 * n);
    g->gone = take_room(&at, 4 * n);
    g->since = take_room(&at, 4 * n);
    g->start = take_room(&at, 4 * (most_cells(p) + 1));
    g->lost = take_room(&at, 8 * n);
    int64_t attitudes = 0;
    if (p->turning)
        attitudes = 32 * n;
    g->attitude = take_room(&at, attitudes);
    for (int k = 0; k < 2; k++)
        g->contact[k] = take_room(&at, threads * p->most_contacts * (int64_t)sizeof(contact));
    for (int64_t k = 0; k < threads; k++) {
        share other = {.from = share_of(g, n, k), .to = share_of(g, n, k + 1)};
        share *t = &other;
        lay_out_share(g, t, &at);
        if (memory)
            g->share[k] = other;
    }
    return at - memory;
}

#endif
