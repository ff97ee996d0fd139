/* Few rigid spheres: every pair is examined (impacts.c).
 *
 * Each body has its next impact: the earliest with any other body and plane. After an impact only
 * the two bodies, and those whose next impact was with one of them, are predicted again: O(bodies)
 * an impact, without a sorted queue.
 */
#ifndef REFDEM_IMPACTS_PAIRS_H
#define REFDEM_IMPACTS_PAIRS_H

#include "impacts_law.h"
#include "impacts_log.h"

/* Sets the next impact of body i if this one is earlier. */
static inline void offer(motion *m, int64_t i, double when, double partner)
{
    if (when < m->next[i]) {
        m->next[i] = when;
        m->partner[i] = partner;
    }
}

/* Predicts the next impact of body i, and updates that of the others where one with i is earlier.
 */
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

/* Applies the impact of body i with its partner, and predicts those that follow. */
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

/* Processes all impacts up to the time `end`; returns GOES_ON, or the reason for stopping earlier.
 */
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
