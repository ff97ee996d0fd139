/* The modes of a contact: what holds a pair in its mode, and what it changes to. */
#ifndef REFDEM_CONTACT_MODES_H
#define REFDEM_CONTACT_MODES_H

#include "particle_steps.h"

enum { GAP, PULL, HOLD, GUARDS };

/* What must stay above zero for pair k to stay in its mode, in units of its own size; INFINITY if
 * the mode does not ask. */
static inline double guard(const runner *r, int64_t k, int kind, const double *restrict y,
                           const double *restrict dy)
{
    const refdem_particles *p = r->p;
    int64_t mode = r->mode[k];
    meeting m = meet(p, k, y);
    double radius = p->radius[m.i];
    double strain = m.overlap / radius;
    double force = m.normal / (p->stiffness * radius);
    if (mode == APART)
        return kind == GAP ? -strain : INFINITY;
    if (mode == PARTED)
        return kind == GAP ? strain : kind == PULL ? -force : INFINITY;
    if (kind == GAP)
        return p->no_pull && p->damping > 0.0 ? force : strain;
    if (p->friction == 0.0 || (kind == PULL && (p->no_pull || p->damping == 0.0)))
        return INFINITY;
    if (kind == PULL)
        return mode == FREE ? -force : mode >= SLIP ? force : INFINITY;
    if (mode == FREE)
        return INFINITY;
    const double *s = y + history_at(p) + 3 * k;
    const double *a = dy + 3 * p->bodies;
    double stiffness = p->tangential_stiffness;
    double growth = 0.0;
    double along = dot(m.slip, s);
    if (mode == STICK) {
        double held = stiffness > 0.0 ? grip(p, &m) * size(s) : size(dy + history_at(p) + 3 * k);
        return (m.limit - held) / (p->friction * p->stiffness * radius);
    }
    if (stiffness > 0.0) {
        double bend = dot(m.w, m.turn);
        for (int c = 0; c < 3; c++)
            bend += (a[3 * m.i + c] - (m.j < 0 ? 0.0 : a[3 * m.j + c])) * m.n[c];
        growth = p->friction / stiffness
                 * (p->stiffness * m.rate
                    + p->damping * bend); /* no jump where the force ends: no stick there */
    }
    return (along - growth) / (1e11 * least_slip(p, &m));
}

/* The mode of a pair that begins to press, and its spring. */
static inline int64_t pressing(const refdem_particles *p, int64_t k, double *restrict y)
{
    if (p->friction == 0.0)
        return FREE;
    meeting m = meet(p, k, y);
    double *s = y + history_at(p) + 3 * k;
    double fast = size(m.slip);
    double stiffness = p->tangential_stiffness;
    double least = 1e-13 * p->stiffness * p->radius[m.i];
    int slides = fast > least_slip(p, &m);
    if (stiffness > 0.0)
        slides = fabs(m.normal) <= least && fast * stiffness > p->friction * p->stiffness * m.rate;
    for (int c = 0; c < 3; c++)
        s[c] = slides ? m.slip[c] / fast : 0.0;
    return m.normal < -least ? FREE : slides ? SLIP : STICK;
}

/* The mode of pair k after it has left its own through one of the guards. */
static inline int64_t next_mode(const runner *r, int64_t k, int kind, double *restrict y,
                                const double *restrict dy)
{
    const refdem_particles *p = r->p;
    int64_t mode = r->mode[k];
    if (mode == APART || (mode == PARTED && kind == PULL))
        return pressing(p, k, y);
    if (mode == PARTED)
        return APART;
    if (kind == GAP)
        return p->no_pull && p->damping > 0.0 ? PARTED : APART;
    double *s = y + history_at(p) + 3 * k;
    double stiffness = p->tangential_stiffness;
    if (kind == PULL)
        return mode >= SLIP ? FREE : pressing(p, k, y);
    meeting m = meet(p, k, y);
    if (mode >= SLIP) {
        for (int c = 0; c < 3; c++)
            s[c] = stiffness > 0.0 ? s[c] * longest(p, &m) : 0.0;
        return STICK;
    }
    const double *pull = stiffness > 0.0 ? s : dy + history_at(p) + 3 * k;
    double length = size(pull);
    double sense = stiffness > 0.0 ? 1.0 : -1.0;
    for (int c = 0; c < 3; c++)
        s[c] = length > 0.0 ? sense * pull[c] / length : 0.0;
    return SLIP;
}

/* The mode of pair k at the start: overlapping or touching and not about to part. */
static inline int64_t first_mode(const refdem_particles *p, int64_t k, double h, double *restrict y)
{
    meeting m = meet(p, k, y);
    double touch = 1e-15 * p->radius[m.i];
    if (m.overlap < -touch || (m.overlap <= touch && m.rate * h <= 0.0))
        return APART;
    return p->no_pull && p->damping > 0.0 && m.normal <= 0.0 ? PARTED : pressing(p, k, y);
}

#endif
