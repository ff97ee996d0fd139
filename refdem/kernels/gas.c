/* A gas of equal spheres under a linear contact law with friction, in a periodic box, between
 * planes or in the open.
 *
 * Velocity Verlet (Swope et al. 1982), synchronous; what depends on velocities sees those of the
 * end of the step, predicted with the last acceleration. Verlet's list (1967) of pairs closer than
 * a diameter and a skin is rebuilt, from a counting sort of the bodies into cells, before the two
 * fastest bodies could have crossed the skin. Bodies lie in memory in the order of their cells.
 * Work is done on a velocity only while a contact lasts, and on an attitude only when its spin
 * changes. Impulses are rounded to a grid on which velocities lie, and given to both bodies of a
 * pair with opposite signs: sums are then exact, and so is total momentum. Positions are kept in
 * the box, with whole boxes counted apart, so that a body's velocity knows nothing of the walls of
 * the box.
 *
 * Threads own bodies that are neighbours in memory. Each finds the contacts of its own, and gathers
 * for its own, from all contacts in the order of the list: the result has the same bits for any
 * number of threads.
 */
#include <assert.h>

#include "gas_contact.h"
#include "gas_list.h"

/* Times the fastest body at the start: faster ones are still right, but no longer on the grid. */
#define GRID 8.0

int64_t refdem_gas_room(const refdem_gas *p, int64_t threads)
{
    gas g;
    return laid_out(&g, p, threads, NULL);
}

/* Contacts of the share's listed pairs, with what they do to velocities. */
static void touch(gas *g, share *t, int rank, double time)
{
    int64_t base = rank * g->p->most_contacts;
    const contact *before = g->contact[t->side];
    t->side ^= 1;
    contact *now = g->contact[t->side] + base;
    t->contacts = 0;
    t->crossing = 0;
    for (int64_t m = 0; m < t->pairs; m++) {
        double n[3];
        double deep = overlap(g, t->a[m], t->b[m], t->image[m], n);
        int32_t was = t->was[m];
        if (!(deep > 0.0)) {
            if (was)
                t->was[m] = 0;
            continue;
        }
        if (t->contacts == g->p->most_contacts) {
            t->failed = NO_ROOM;
            return;
        }
        contact *c = now + t->contacts;
        c->a = t->a[m];
        c->b = t->b[m];
        c->deep = deep;
        moved(c->n, n);
        if (!was && t->events < g->most) {
            t->event[2 * t->events] = time;
            t->event[2 * t->events + 1] = (double)g->now.label[c->a];
        }
        t->events += !was;
        if (g->p->friction > 0.0) {
            /* Below 0: a pair that has changed its order since. */
            const contact *same = NULL;
            double sense = 1.0;
            if (was > 0)
                same = before + was - 1;
            if (was < 0) {
                same = before - was - 1;
                sense = -1.0;
            }
            stretch(g, c, same, sense, time != 0.0);
        }
        press(g, c);
        if (c->b >= 0 && (c->b < t->from || c->b >= t->to))
            t->out[t->crossing++] = (int32_t)t->contacts;
        t->contacts++;
        t->was[m] = (int32_t)(base + t->contacts);
    }
}

static inline void given(gas *g, share *t, int64_t i, double sign, const contact *c)
{
    double *kick = g->now.kick + 3 * i;
    double *turn = g->now.turn + 3 * i;
    int rubs = g->p->friction > 0.0;
    if (!g->now.mark[i]) {
        g->now.mark[i] = 1;
        t->marked[t->touched++] = (int32_t)i;
        memset(kick, 0, 3 * sizeof *kick);
        if (g->p->turning)
            memset(turn, 0, 3 * sizeof *turn);
    }
    for (int k = 0; k < 3; k++)
        kick[k] += sign * c->push[k];
    if (!rubs)
        return;
    for (int k = 0; k < 3; k++)
        turn[k] += c->twist[k];
}

/* The kicks of the share's own bodies, from all contacts in the order of the list, and the work of
 * its own contacts. */
static void gathered(gas *g, share *t, int rank)
{
    for (int64_t k = 0; k < t->touched; k++) {
        int64_t i = t->marked[k];
        g->now.mark[i] = 0;
        memset(g->now.kick + 3 * i, 0, 3 * sizeof(double));
        if (g->p->turning)
            memset(g->now.turn + 3 * i, 0, 3 * sizeof(double));
    }
    t->touched = 0;
    for (int s = 0; s < g->threads; s++) {
        const share *other = g->share + s;
        const contact *found = g->contact[t->side] + s * g->p->most_contacts;
        for (int64_t k = 0; s == rank && k < t->contacts; k++) {
            const contact *c = found + k;
            given(g, t, c->a, 1.0, c);
            if (c->b >= t->from && c->b < t->to)
                given(g, t, c->b, -1.0, c);
            g->lost[g->now.label[c->a]] += g->h * c->power;
        }
        for (int64_t k = 0; s != rank && k < other->crossing; k++) {
            const contact *c = found + other->out[k];
            if (c->b >= t->from && c->b < t->to)
                given(g, t, c->b, -1.0, c);
        }
    }
}

/* q (4) turned by the rotation vector w time, exactly, and put back to unit length by one step of
 * Newton's. */
static void turned(const double *w, double time, const double *q, double *out)
{
    double angle = 0.5 * time * sqrt(dot(w, w));
    double part = 0.5 * time; /* sin(angle)/angle tends to 1 */
    if (angle != 0.0)
        part = 0.5 * time * sin(angle) / angle;
    double c = cos(angle);
    double v[3] = {part * w[0], part * w[1], part * w[2]};
    double across[3], found[4];
    cross(v, q + 1, across);
    found[0] = c * q[0] - dot(v, q + 1);
    for (int k = 0; k < 3; k++)
        found[1 + k] = c * q[1 + k] + q[0] * v[k] + across[k];
    double unit = 1.0; /* what does not turn keeps its bits */
    if (angle != 0.0)
        unit = 1.5 - 0.5 * (found[0] * found[0] + dot(found + 1, found + 1));
    for (int k = 0; k < 4; k++)
        out[k] = found[k] * unit;
}

static void kick(gas *g, share *t, int64_t taken)
{
    double most = t->fastest * t->fastest;
    for (int64_t m = 0; m < t->touched; m++) {
        int64_t i = t->marked[m];
        int64_t label = g->now.label[i];
        double *v = g->now.v + 3 * i;
        add_scaled(v, 1.0, g->now.kick + 3 * i);
        most = fmax(most, dot(v, v));
        if (!(g->p->friction > 0.0))
            continue;
        double *w = g->now.w + 3 * i;
        if (g->since[label] != taken)
            turned(w, (double)(taken - g->since[label]) * g->h, g->attitude + 4 * label,
                   g->attitude + 4 * label);
        g->since[label] = (int32_t)taken;
        add_scaled(w, 1.0, g->now.turn + 3 * i);
    }
    t->fastest = sqrt(most);
}

static void drift(const gas *g, const share *t)
{
    double h = g->h;
    double *restrict x = g->now.x;
    const double *restrict v = g->now.v;
    for (int64_t i = 3 * t->from; i < 3 * t->to; i++)
        x[i] += h * v[i];
}

/* The share's bodies at sample s; once for all, contacts and work: lost, less half a step of power
 * and what tangential springs hold. */
static void recorded(gas *g, share *t, int rank, int64_t s, int64_t taken)
{
    for (int64_t i = t->from; i < t->to; i++) {
        int64_t label = g->now.label[i];
        int64_t row = s * g->n + label;
        for (int c = 0; c < 3; c++)
            g->out_x[3 * row + c] = g->now.x[3 * i + c] + g->p->size * g->now.boxes[3 * i + c];
        moved(g->out_v + 3 * row, g->now.v + 3 * i);
        if (!g->p->turning)
            continue;
        moved(g->out_w + 3 * row, g->now.w + 3 * i);
        turned(g->now.w + 3 * i, (double)(taken - g->since[label]) * g->h, g->attitude + 4 * label,
               g->out_q + 4 * row);
    }
    together(&g->team);
    if (rank > 0)
        return;
    double *channel = g->channel + 2 * s;
    double work = 0.0;
    channel[0] = 0.0;
    for (int64_t i = 0; i < g->n; i++)
        work += g->lost[i];
    for (int64_t k = 0; k < g->threads; k++) {
        const contact *c = g->contact[t->side] + k * g->p->most_contacts;
        const contact *end = c + g->share[k].contacts;
        channel[0] += (double)g->share[k].contacts;
        for (; c < end; c++)
            work -= 0.5 * g->h * c->power + stored(g, c);
    }
    if (s == 0)
        g->first_work = work;
    channel[1] = work - g->first_work;
}

/* How some share has failed, the worst of all; 0 if none has. */
static int has_failed(const gas *g)
{
    int failed = 0;
    for (int64_t k = 0; k < g->threads; k++) {
        if (g->share[k].failed > failed)
            failed = g->share[k].failed;
    }
    return failed;
}

static double fastest(const gas *g)
{
    double most = 0.0;
    for (int64_t k = 0; k < g->threads; k++)
        most = fmax(most, g->share[k].fastest);
    return most;
}

/* Contacts at time `taken` steps, and the kicks that they give. Returns 1 if some share has
 * failed. */
static int met(gas *g, share *t, int rank, int64_t taken)
{
    touch(g, t, rank, (double)taken * g->h);
    together(&g->team);
    if (has_failed(g))
        return 1;
    gathered(g, t, rank);
    return 0;
}

/* One thread's part of the whole run. */
static void gone_through(void *shared, int rank)
{
    gas *g = shared;
    share *t = g->share + rank;
    rebuilt(g, t, rank);
    if (met(g, t, rank, 0))
        return;
    t->events = 0; /* what touches at the start does not begin to */
    recorded(g, t, rank, 0, 0);
    for (int64_t taken = 1, s = 1; s < g->samples; s++) {
        for (int64_t last = s * g->stride; taken <= last; taken++) {
            kick(g, t, taken - 1);
            drift(g, t);
            together(&g->team);
            t->way += fabs(g->h) * fastest(g);
            if (2.0 * t->way > g->skin)
                rebuilt(g, t, rank);
            if (met(g, t, rank, taken))
                return;
            kick(g, t, taken);
        }
        recorded(g, t, rank, s, taken - 1);
    }
}

/* Columns in the order given; the start is row 0 of what comes out. */
static void begun(gas *g, double step)
{
    const refdem_gas *p = g->p;
    int64_t n = g->n;
    double room = SKIN * p->diameter;
    if (p->size > 0.0) /* a body meets one image of another at a time */
        room = 0.5 * p->size - p->diameter;
    double most = 0.0;
    size_t three = (size_t)(3 * n) * sizeof(double);
    memcpy(g->now.x, g->out_x, three);
    memcpy(g->now.v, g->out_v, three);
    memset(g->now.kick, 0, three);
    if (p->turning) {
        memcpy(g->now.w, g->out_w, three);
        memset(g->now.turn, 0, three);
        memcpy(g->attitude, g->out_q, (size_t)(4 * n) * sizeof(double));
    }
    memset(g->now.boxes, 0, (size_t)(3 * n) * sizeof(int32_t));
    memset(g->now.mark, 0, (size_t)n);
    memset(g->since, 0, (size_t)n * sizeof(int32_t));
    memset(g->lost, 0, (size_t)n * sizeof(double));
    for (int64_t i = 0; i < n; i++) {
        g->now.label[i] = (int32_t)i;
        most = fmax(most, dot(g->now.v + 3 * i, g->now.v + 3 * i));
    }
    most = sqrt(most);
    g->skin = fmin(SKIN * p->diameter, 0.9 * room);
    g->reach = p->diameter + g->skin;
    g->h = step;
    /* 1.5 2^52 times a grid of 2^-53 of the next power of two. */
    g->round = 0.0;
    if (most > 0.0)
        g->round = ldexp(0.75, ilogb(GRID * most) + 1);
    images_placed(g);
}

int64_t refdem_gas_run(const refdem_gas *p, int64_t threads, double step, int64_t samples,
                       int64_t stride, int64_t most, uint8_t *room, int64_t *events, double *event,
                       double *channel, double *position, double *velocity, double *omega,
                       double *attitude)
{
    assert(threads >= 1 && threads <= MOST_THREADS && samples >= 1 && stride >= 1);
    assert(room && events && event && channel); /* `room` has refdem_gas_room bytes */
    assert(position && velocity);
    assert(!p->turning || (omega && attitude));
    gas g = {.samples = samples, .stride = stride, .most = most, .channel = channel};
    g.out_x = position;
    g.out_v = velocity;
    g.out_w = omega;
    g.out_q = attitude;
    laid_out(&g, p, threads, room);
    begun(&g, step);
    for (int64_t k = 0; k < threads; k++)
        g.share[k].event = event + 2 * most * k;
    if (at_work(&g.team, (int)threads, gone_through, &g))
        return 2;
    for (int64_t k = 0; k < threads; k++)
        events[k] = g.share[k].events;
    return has_failed(&g);
}
