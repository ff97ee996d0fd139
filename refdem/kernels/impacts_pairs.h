/* Few rigid spheres: every pair is looked at (impacts.c).
 *
 * A body knows its next impact: the earliest of those with every other body and plane. Only the
 * bodies that met, and those that were to meet one of them, look for their next ones anew:
 * O(bodies) an impact, without anything to keep in order.
 */
#ifndef REFDEM_IMPACTS_PAIRS_H
#define REFDEM_IMPACTS_PAIRS_H

#include "impacts_law.h"
#include "impacts_log.h"

/* Takes an impact of body i if it is its earliest. */
static inline void offer(motion *m, int64_t i, double when, double partner)
{
    if (when < m->next[i]) {
        m->next[i] = when;
        m->partner[i] = partner;
    }
}

/* The next impact of body i anew; the others hear of theirs with it. */
static void predict_among_all(const refdem_impacts *p, motion *m, int64_t i, double now)
{
    m->next[i] = INFINITY;
    m->partner[i] = NOBODY;
    for (int64_t j = 0; j < m->bodies; j++) {
        if (j == i || (is_fixed(p, i) && is_fixed(p, j)))
            continue;
        const double when = now + until_spheres(p, m, i, j, now);
        offer(m, i, when, (double)j);
        offer(m, j, when, (double)i);
    }
    if (is_fixed(p, i))
        return;
    double r[3], v[3];
    place(m, i, now, r);
    velocity(m, i, now, v);
    for (int64_t k = 0; k < p->planes; k++) {
        const double wait = until_plane(m, p->plane + 6 * k, r, v, p->radius[i]);
        offer(m, i, now + wait, -1.0 - (double)k);
    }
}

/* The first impacts of all bodies. */
static void begin_pairs(const refdem_impacts *p, motion *m, double now)
{
    for (int64_t i = 0; i < m->bodies; i++) {
        m->next[i] = INFINITY;
        m->partner[i] = NOBODY;
    }
    for (int64_t i = 0; i < m->bodies; i++)
        predict_among_all(p, m, i, now);
}

/* The body with the earliest impact. */
static int64_t earliest(const motion *m)
{
    int64_t first = 0;
    for (int64_t i = 1; i < m->bodies; i++)
        if (m->next[i] < m->next[first])
            first = i;
    return first;
}

/* Makes the impact of body i with its partner, and looks for those that follow. */
static int happen(const refdem_impacts *p, motion *m, int64_t i)
{
    const double now = m->next[i];
    const int64_t j = (int64_t)m->partner[i];
    if (!strike(p, m, i, j, now))
        return RESTS;
    for (int64_t k = 0; k < m->bodies; k++) {
        const int64_t other = (int64_t)m->partner[k];
        if (k == i || k == j || other == i || (j >= 0 && other == j))
            predict_among_all(p, m, k, now);
    }
    return GOES_ON;
}

/* All impacts up to the time `end`; why they end before. */
static int pairs_until(const refdem_impacts *p, motion *m, double end, event_log *log)
{
    for (;;) {
        const int64_t i = earliest(m);
        if (!(m->next[i] <= end))
            return GOES_ON;
        int status = record(log, m->next[i], i, (int64_t)m->partner[i]);
        if (status == GOES_ON)
            status = happen(p, m, i);
        if (status != GOES_ON)
            return status;
    }
}

#endif
