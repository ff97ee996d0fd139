/* Many rigid spheres: event-driven, O(log bodies) an impact (impacts.c).
 *
 * Every sphere has one event in a queue: its next impact, as predicted at its last search, or the
 * crossing into the next cell if that comes before. Phases: next_event, then one of
 *
 *   - cross: the sphere enters a cell, and examines the spheres that have become neighbours;
 *   - search again: its partner has had another impact since (its count of impacts exceeds that at
 *     the prediction), so that all neighbours are examined again;
 *   - collide: both are advanced to the time of their impact and change their velocities;
 *
 * and predict and schedule for the spheres that have no valid event. The next impact of a pair is
 * the event of the sphere that was predicted last: a sphere is predicted again when its own flight
 * begins, with the current flights of the others, so that predictions need not be passed on to the
 * partner (Lubachevsky 1991, with cells of Alder and Wainwright 1959).
 */
#ifndef REFDEM_IMPACTS_EVENTS_H
#define REFDEM_IMPACTS_EVENTS_H

#include "impacts_cells.h"
#include "impacts_law.h"
#include "impacts_log.h"
#include "impacts_queue.h"

/* Number of neighbours in one vectorised block. */
enum { NEAR_AT_ONCE = 64 };

/* The next events of a body: an impact with `partner` at the time `when`, valid while the partner's
 * count `impacts` equals `met`; and leaving its cell at the time `leaves`. */
typedef struct {
    double when, leaves;
    int32_t partner;
    uint32_t met, impacts;
} plan;

/* Neighbours of a sphere at one time, in columns that the compiler can vectorise. */
typedef struct {
    double place[3][NEAR_AT_ONCE], velocity[3][NEAR_AT_ONCE], radius[NEAR_AT_ONCE];
} neighbours;

/* The data of a run. For the body whose events are predicted, `near` lists its neighbours, and
 * `due` the estimated times until it meets them, in units that keep squares of lengths and speeds
 * in the range of binary64. */
typedef struct {
    motion *m;
    grid grid;
    queue queue;
    plan *plan;
    int32_t *near;
    double *due;
    double per_length, per_speed;
    int64_t crossings;
} crowd;

/* Average number of crossings of a body after which the grid is checked against the extent. */
enum { CROSSINGS_EACH = 64 };

/* Bound on the rounding error of q in `estimate`, relative to w^2 d^2: about a dozen products and
 * sums with one rounding each. */
static const double GRAZING = 0x1p-47;

/* Positions r + v s + g s^2/2 and velocities v + g s of the listed bodies at the time now. */
static inline void gather(const motion *m, const int32_t *restrict near, int64_t count, double now,
                          neighbours *restrict out)
{
    for (int64_t n = 0; n < count; n++) {
        const flight *f = m->flight + near[n];
        const double elapsed = now - f->since;
        for (int c = 0; c < 3; c++) {
            out->place[c][n] = fma(f->velocity[c], elapsed, f->place[c]);
            out->velocity[c][n] = f->velocity[c];
        }
        out->radius[n] = f->radius;
    }
    for (int64_t n = 0; n < count && m->falls; n++) {
        const double elapsed = now - m->flight[near[n]].since;
        for (int c = 0; c < 3; c++) {
            out->place[c][n] += 0.5 * elapsed * elapsed * m->gravity[c];
            out->velocity[c][n] += elapsed * m->gravity[c];
        }
    }
}

/* Estimated times from now until a body at r with velocity v meets each of its neighbours; infinity
 * if it does not. With d = r_j - r, w = v_j - v and the sum R of the radii, they can meet if b =
 * d.w < 0 and, up to rounding, q = b^2 - w^2 (d^2 - R^2) >= 0, at s = (d^2 - R^2)/(-b + sqrt(q)).
 */
static inline void estimate(const crowd *k, const neighbours *restrict near, int64_t count,
                            const double *restrict r, const double *restrict v, double radius,
                            double *restrict due)
{
    const double period = k->m->period;
    const double half = period > 0.0 ? 0.5 * period : INFINITY;
    for (int64_t n = 0; n < count; n++) {
        double b = 0.0;
        double dd = 0.0;
        double ww = 0.0;
        for (int c = 0; c < 3; c++) {
            double d = near->place[c][n] - r[c];
            d = d > half ? d - period : d;
            d = d < -half ? d + period : d;
            d *= k->per_length;
            const double w = (near->velocity[c][n] - v[c]) * k->per_speed;
            b = fma(d, w, b);
            dd = fma(d, d, dd);
            ww = fma(w, w, ww);
        }
        /* gap = d^2 - R^2, q = b^2 - w^2 gap, s = gap/(-b + sqrt(q)). */
        const double reach = (radius + near->radius[n]) * k->per_length;
        const double gap = fma(-reach, reach, dd);
        const double q = fma(b, b, -ww * gap);
        const double root = sqrt(q > 0.0 ? q : 0.0);
        const double when = gap / (root - b);
        due[n] = (b < 0.0) & (q >= -GRAZING * ww * dd) ? when : INFINITY;
    }
}

/* Fills `due` with the estimated times until body i meets each of its neighbours. */
static inline void estimate_all(crowd *k, int32_t i, double now, int64_t count)
{
    neighbours some;
    double r[3], v[3];
    place(k->m, i, now, r);
    velocity(k->m, i, now, v);
    for (int64_t n = 0; n < count; n += NEAR_AT_ONCE) {
        const int64_t left = count - n;
        const int64_t part = left < NEAR_AT_ONCE ? left : NEAR_AT_ONCE;
        gather(k->m, k->near + n, part, now, &some);
        estimate(k, &some, part, r, v, k->m->flight[i].radius, k->due + n);
    }
}

/* The index of the smallest of `count` times, the first one of equals; -1 if all are infinite.
 * Nonnegative doubles are ordered like their bits read as integers, whose minimum the compiler may
 * vectorise, unlike that of doubles. */
static inline int64_t smallest(const double *restrict due, int64_t count)
{
    double soonest = INFINITY;
    int64_t least = INT64_MAX;
    int64_t first = -1;
    for (int64_t n = 0; n < count; n++) {
        int64_t bits;
        memcpy(&bits, due + n, sizeof bits);
        least = bits < least ? bits : least;
    }
    memcpy(&soonest, &least, sizeof soonest);
    if (least >= 0 && !(soonest < INFINITY))
        return -1;
    if (least >= 0) {
        for (first = 0; due[first] != soonest; first++) {
        }
        return first;
    }
    /* A negative time, of spheres that overlap by a rounding, or an empty list: a plain search. */
    soonest = INFINITY;
    for (int64_t n = 0; n < count; n++)
        if (due[n] < soonest) {
            soonest = due[n];
            first = n;
        }
    return first;
}

/* The earliest impact of body i with one of its `count` neighbours, if it is earlier than that of
 * the plan. Estimates give the order in which until_spheres, which decides, is evaluated. */
static inline void predict_spheres(const refdem_impacts *p, crowd *k, int32_t i, double now,
                                   int64_t count)
{
    plan *own = k->plan + i;
    estimate_all(k, i, now, count);
    for (;;) {
        const int64_t first = smallest(k->due, count);
        if (first < 0)
            return;
        const int32_t j = k->near[first];
        const double when = now + until_spheres(p, k->m, i, j, now);
        if (when < own->when) {
            own->when = when;
            own->partner = j;
            own->met = k->plan[j].impacts;
        }
        if (when < INFINITY)
            return;
        /* They miss each other or separate: try the next one. */
        k->due[first] = INFINITY;
    }
}

/* The earliest impact of body i with a plane, if it is earlier than that of the plan. */
static void predict_planes(const refdem_impacts *p, crowd *k, int32_t i, double now)
{
    plan *own = k->plan + i;
    double r[3], v[3];
    place(k->m, i, now, r);
    velocity(k->m, i, now, v);
    double soonest = own->when;
    for (int64_t n = 0; n < p->planes; n++) {
        const double when = now + until_plane(k->m, p->plane + 6 * n, r, v, p->radius[i]);
        if (when < soonest) {
            soonest = when;
            own->partner = (int32_t)(-1 - n);
        }
    }
    own->when = soonest;
}

/* The time at which body i leaves its cell, and its entry in the queue: the earlier event. */
static void schedule_plan(crowd *k, int32_t i, double now)
{
    plan *own = k->plan + i;
    own->leaves = now + until_exit(k->m, &k->grid, i, now, &k->grid.slot[i].exit);
    schedule(&k->queue, i, own->when < own->leaves ? own->when : own->leaves);
}

/* Predicts the events of body i, from all its neighbours and the planes. */
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

/* Makes a new grid at the time now, and predicts the events of all bodies. */
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

/* Bodies that fly apart need larger cells, since they would cross more and more small ones. */
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

/* Body i enters the next cell, and examines the bodies that have become neighbours. */
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

/* True if the partner of body i has had no impact since the prediction, or is a plane. */
static bool is_valid(const crowd *k, int32_t i)
{
    const plan *own = k->plan + i;
    return own->partner < 0 || k->plan[own->partner].impacts == own->met;
}

/* Counts an impact of body i, which makes predictions of other bodies with it invalid; not of a
 * fixed body, whose motion does not change. */
static inline void count_impact(const refdem_impacts *p, crowd *k, int32_t i)
{
    if (!is_fixed(p, i))
        k->plan[i].impacts++;
}

/* The impact of body i with body j > i, or with a plane (j < 0), at the time now; predicts the next
 * events of the bodies. Returns RESTS if they come to rest against each other. */
static int meet(const refdem_impacts *p, crowd *k, int32_t i, int32_t j, double now)
{
    if (!strike(p, k->m, i, j, now))
        return RESTS;
    count_impact(p, k, i);
    if (j >= 0)
        count_impact(p, k, j);
    predict(p, k, i, now);
    if (j >= 0)
        predict(p, k, j, now);
    return GOES_ON;
}

/* Units in which the products of `estimate`, of degree 4 in length and speed, do not overflow: the
 * diameter D of the largest sphere, and the larger of sqrt(g D) and the largest speed. Both are
 * rounded to powers of two, so that the change of units is exact. */
static void choose_units(const refdem_impacts *p, crowd *k)
{
    const double length = least_edge(p);
    double speed = sqrt(size(k->m->gravity) * length);
    for (int64_t i = 0; i < k->m->bodies; i++)
        speed = fmax(speed, size(k->m->flight[i].velocity));
    k->per_length = ldexp(1.0, -ilogb(length));
    k->per_speed = speed > 0.0 ? ldexp(1.0, -ilogb(speed)) : 1.0;
}

/* The first events of all bodies. */
static void begin_cells(const refdem_impacts *p, crowd *k, double now)
{
    choose_units(p, k);
    empty_queue(&k->queue, k->m->bodies);
    for (int64_t i = 0; i < k->m->bodies; i++)
        k->plan[i].impacts = 0;
    if (k->m->period > 0.0)
        enter_box(k->m);
    make_grid(p, k, now);
}

/* Processes all events up to the time `end`; returns GOES_ON, or the reason for stopping earlier.
 * The next event of a body is that it leaves its cell or meets its partner. If the partner has had
 * another impact since the prediction, the events of the body are predicted again. */
static int cells_until(const refdem_impacts *p, crowd *k, double end, event_log *log)
{
    for (;;) {
        const entry next = next_event(&k->queue);
        if (!(next.when <= end))
            return GOES_ON;
        const int32_t i = (int32_t)next.body;
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
        int status = record(log, own.when, first, second);
        if (status == GOES_ON)
            status = meet(p, k, first, second, own.when);
        if (status != GOES_ON)
            return status;
    }
}

#endif
