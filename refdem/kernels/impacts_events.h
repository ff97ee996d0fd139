/* Many rigid spheres: event-driven, O(log bodies) an impact (impacts.c).
 *
 * Every sphere has one event in a queue: its next impact, as far as it knew when it looked last, or
 * the crossing into the next cell if that comes before. Phases: next_event, then
 *
 *   - cross: the sphere enters a cell, and looks at those that have come near;
 *   - look again: its partner has met another one in the meantime (it has counted more impacts than
 *     when the event was predicted), so that all neighbours are looked at anew;
 *   - collide: both are advanced to the time of their impact and change their velocities;
 *
 * and predict and schedule for those whose event is gone. A pair that is to meet is known to the
 * one of the two that looked last, since it looked when either's flight began: so that a sphere
 * need not be told what others found (Lubachevsky 1991, with cells of Alder and Wainwright 1959).
 */
#ifndef REFDEM_IMPACTS_EVENTS_H
#define REFDEM_IMPACTS_EVENTS_H

#include "impacts_cells.h"
#include "impacts_law.h"
#include "impacts_log.h"
#include "impacts_queue.h"

/* What a body is about to do: meet `partner` at the time `when`, unless that one's `impacts` are no
 * longer `met`; leave its cell at the time `leaves`. */
typedef struct {
    double when, leaves;
    int32_t partner;
    uint32_t met, impacts;
} plan;

/* Someone near, and about when it is met. */
typedef struct {
    double when;
    int32_t body;
} candidate;

typedef struct {
    motion *m;
    grid grid;
    queue queue;
    plan *plan;
    int32_t *near;
    candidate *candidate;
    int64_t crossings;
} crowd;

/* Crossings of each body after which the extent of all is looked at again. */
enum { CROSSINGS_EACH = 64 };

/* Roundings of q below, as a part of w^2 d^2: each of the dozen products and sums has one. */
static const double GRAZING = 0x1p-47;

/* The bodies near i that it may meet, and about when: with d = r_j - r_i and w = v_j - v_i, those
 * with b = d.w <= 0 and q = b^2 - w^2 (d^2 - R^2) >= 0 to rounding, at (d^2 - R^2)/(-b + sqrt(q)).
 * What leaves the range of numbers stays in: until_spheres decides. */
static int64_t list_approaching(crowd *k, int32_t i, double now, int64_t count)
{
    const motion *m = k->m;
    const double radius = m->flight[i].radius;
    double ri[3], vi[3];
    place(m, i, now, ri);
    velocity(m, i, now, vi);
    int64_t found = 0;
    for (int64_t n = 0; n < count; n++) {
        const int32_t j = k->near[n];
        double rj[3], vj[3], d[3], w[3];
        place(m, j, now, rj);
        velocity(m, j, now, vj);
        branch(m, ri, rj, d);
        for (int c = 0; c < 3; c++)
            w[c] = vj[c] - vi[c];
        const double reach = radius + m->flight[j].radius;
        const double b = dot(d, w);
        const double ww = dot(w, w);
        const double dd = dot(d, d);
        const double gap = dd - reach * reach;
        const double q = b * b - ww * gap;
        if (b > 0.0 || q < -GRAZING * ww * dd)
            continue;
        k->candidate[found].body = j;
        k->candidate[found].when = gap / (sqrt(fmax(0.0, q)) - b);
        found++;
    }
    return found;
}

/* The earliest impact of body i among `count` of those near, from the plan's own on. */
static void predict_spheres(const refdem_impacts *p, crowd *k, int32_t i, double now, int64_t count)
{
    plan *own = k->plan + i;
    int64_t left = list_approaching(k, i, now, count);
    while (left > 0) {
        int64_t first = 0;
        for (int64_t n = 1; n < left; n++)
            if (k->candidate[n].when < k->candidate[first].when)
                first = n;
        const int32_t j = k->candidate[first].body;
        const double when = now + until_spheres(p, k->m, i, j, now);
        if (when < own->when) {
            own->when = when;
            own->partner = j;
            own->met = k->plan[j].impacts;
        }
        if (!isinf(when))
            return;
        /* It grazes by, or parts: the next one. */
        k->candidate[first] = k->candidate[--left];
    }
}

/* The earliest impact of body i with a plane, from the plan's own on. */
static void predict_planes(const refdem_impacts *p, crowd *k, int32_t i, double now)
{
    plan *own = k->plan + i;
    for (int64_t n = 0; n < p->planes; n++) {
        const double when = now + until_plane(p, k->m, i, n, now);
        if (when < own->when) {
            own->when = when;
            own->partner = (int32_t)(-1 - n);
        }
    }
}

/* The end of the body's stay in its cell, and its place in the queue. */
static void schedule_plan(crowd *k, int32_t i, double now)
{
    plan *own = k->plan + i;
    own->leaves = now + until_exit(k->m, &k->grid, i, now, &k->grid.slot[i].exit);
    schedule(&k->queue, i, fmin(own->when, own->leaves));
}

/* The events of body i anew. */
static void predict(const refdem_impacts *p, crowd *k, int32_t i, double now)
{
    plan *own = k->plan + i;
    own->when = INFINITY;
    own->leaves = INFINITY;
    own->partner = NOBODY;
    if (is_fixed(p, i))
        return;
    const int64_t count = list_near(&k->grid, i, false, k->near);
    predict_spheres(p, k, i, now, count);
    predict_planes(p, k, i, now);
    schedule_plan(k, i, now);
}

/* A new grid at the time now, and all events anew. */
static void make_grid(const refdem_impacts *p, crowd *k, double now)
{
    if (k->m->period > 0.0)
        fit_periodic_grid(p, k->m, &k->grid);
    else
        fit_open_grid(p, k->m, &k->grid, now);
    fill_grid(k->m, &k->grid, now);
    for (int64_t i = 0; i < k->m->bodies; i++)
        predict(p, k, (int32_t)i, now);
    k->crossings = 0;
}

/* Bodies that fly apart need larger cells: they would cross small ones without end. */
static void check_grid(const refdem_impacts *p, crowd *k, double now)
{
    k->crossings = 0;
    if (k->m->period > 0.0)
        return;
    grid wanted = k->grid;
    fit_open_grid(p, k->m, &wanted, now);
    const double factor = wanted.edge[0] / k->grid.edge[0];
    if (factor > 2.0 || factor < 0.5)
        make_grid(p, k, now);
}

/* Body i enters the next cell, and looks at those that this has brought near. */
static void enter_next(const refdem_impacts *p, crowd *k, int32_t i)
{
    const double now = k->plan[i].leaves;
    cross_side(k->m, &k->grid, i);
    const int64_t count = list_near(&k->grid, i, true, k->near);
    predict_spheres(p, k, i, now, count);
    schedule_plan(k, i, now);
    k->crossings++;
    if (k->crossings > CROSSINGS_EACH * k->m->bodies)
        check_grid(p, k, now);
}

/* True if what body i is about to meet has not met another one since. */
static bool is_valid(const crowd *k, int32_t i)
{
    const plan *own = k->plan + i;
    return own->partner < 0 || k->plan[own->partner].impacts == own->met;
}

/* Advances a body to its impact. Without friction its spin stays, and its attitude can wait. */
static void advance_one(const refdem_impacts *p, crowd *k, int32_t i, double now)
{
    advance(k->m, i, now);
    if (p->friction > 0.0)
        turn(k->m, i, now);
    /* Nothing moves a fixed body: what others know of it stays true. */
    if (!is_fixed(p, i))
        k->plan[i].impacts++;
}

/* The impact of body i with its partner, in the order of their numbers. */
static void meet(const refdem_impacts *p, crowd *k, int32_t i, int32_t j, double now)
{
    double normal[3];
    advance_one(p, k, i, now);
    if (j >= 0)
        advance_one(p, k, j, now);
    normal_of(p, k->m, i, j, normal);
    collide(p, k->m, i, j, normal);
    predict(p, k, i, now);
    if (j >= 0)
        predict(p, k, j, now);
}

/* The first events of all bodies. */
static void begin_cells(const refdem_impacts *p, crowd *k, double now)
{
    empty_queue(&k->queue, k->m->bodies);
    for (int64_t i = 0; i < k->m->bodies; i++)
        k->plan[i].impacts = 0;
    if (k->m->period > 0.0)
        enter_box(k->m);
    make_grid(p, k, now);
}

/* All impacts up to the time `end`; why they end before. */
static int cells_until(const refdem_impacts *p, crowd *k, double end, event_log *log)
{
    for (;;) {
        const int32_t i = next_event(&k->queue);
        if (!(k->queue.when[i] <= end))
            return GOES_ON;
        const plan own = k->plan[i];
        if (own.leaves < own.when) {
            enter_next(p, k, i);
            continue;
        }
        if (!is_valid(k, i)) {
            predict(p, k, i, own.when);
            continue;
        }
        const bool is_second = own.partner >= 0 && own.partner < i;
        const int32_t first = is_second ? own.partner : i;
        const int32_t second = is_second ? i : own.partner;
        const int status = record(log, own.when, first, second);
        if (status != GOES_ON)
            return status;
        meet(p, k, first, second, own.when);
    }
}

#endif
