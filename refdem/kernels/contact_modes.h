/* The modes of a contact: what holds a pair in its mode, and what it changes to. */
#ifndef REFDEM_CONTACT_MODES_H
#define REFDEM_CONTACT_MODES_H

#include "particle_steps.h"

enum { GAP, PULL, HOLD, GUARDS };

/* A slip is at an end where it is below this part of the least one. */
static const double HARDLY = 1e11;

/* The contact ends where its force does, before the overlap: the law has no pull, and a dashpot
 * that would pull. */
static inline int ends_with_force(const refdem_particles *p)
{
    return p->no_pull && p->damping > 0.0;
}

/* What the spring of a pair that sticks may still be stretched by, as a force over that of a strain
 * of 1. */
static inline double hold_left(const runner *r, int64_t k, const meeting *m,
                               const double *restrict y, const double *restrict dy)
{
    const refdem_particles *p = r->p;
    double held;
    if (p->tangential_stiffness > 0.0)
        held = grip(p, m) * size(y + history_at(p) + 3 * k);
    else /* the force that holds stands in the place of the spring's rate */
        held = size(dy + history_at(p) + 3 * k);
    return (m->limit - held) / (p->friction * p->stiffness * p->radius[m->i]);
}

/* How fast the longest stretch of a pair that slips grows [m/s]: mu F'/k_t. */
static inline double limit_growth(const refdem_particles *p, const meeting *m,
                                  const double *restrict dy)
{
    const double *a = dy + 3 * p->bodies;
    double bend = dot(m->w, m->turn);
    for (int c = 0; c < 3; c++) {
        double other = 0.0;
        if (m->j >= 0)
            other = a[3 * m->j + c];
        bend += (a[3 * m->i + c] - other) * m->n[c];
    }
    double force_rate = p->stiffness * m->rate + p->damping * bend;
    return p->friction / p->tangential_stiffness * force_rate;
}

/* What is left of a slip along its direction before the spring would hold, in least slips. */
static inline double slip_left(const runner *r, int64_t k, const meeting *m,
                               const double *restrict y, const double *restrict dy)
{
    const refdem_particles *p = r->p;
    double along = dot(m->slip, y + history_at(p) + 3 * k);
    double growth = 0.0;
    if (p->tangential_stiffness > 0.0)
        growth = limit_growth(p, m, dy); /* no jump where the force ends: no stick there */
    return (along - growth) / (HARDLY * least_slip(p, m));
}

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
    if (mode == APART) { /* until they touch */
        if (kind == GAP)
            return -strain;
        return INFINITY;
    }
    if (mode == PARTED) { /* until they are apart, or press again */
        if (kind == GAP)
            return strain;
        if (kind == PULL)
            return -force;
        return INFINITY;
    }
    if (kind == GAP) { /* until the contact ends */
        if (ends_with_force(p))
            return force;
        return strain;
    }
    if (p->friction == 0.0)
        return INFINITY;
    if (kind == PULL) { /* friction ends, and begins again, with the sign of the force */
        if (p->no_pull || p->damping == 0.0)
            return INFINITY;
        if (mode == FREE)
            return -force;
        if (mode >= SLIP)
            return force;
        return INFINITY;
    }
    if (mode == FREE)
        return INFINITY;
    if (mode == STICK)
        return hold_left(r, k, &m, y, dy);
    return slip_left(r, k, &m, y, dy);
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
    if (stiffness > 0.0) {
        /* A spring slides at once only if it would grow faster than its limit does. */
        int is_unloaded = fabs(m.normal) <= least;
        slides = is_unloaded && fast * stiffness > p->friction * p->stiffness * m.rate;
    }
    for (int c = 0; c < 3; c++) {
        if (slides)
            s[c] = m.slip[c] / fast;
        else
            s[c] = 0.0;
    }
    if (m.normal < -least) /* a force that pulls does not rub */
        return FREE;
    if (slides)
        return SLIP;
    return STICK;
}

/* The direction of a slip that begins: that of the spring, or against the force that held. */
static inline void let_go(const refdem_particles *p, int64_t k, double *restrict s,
                          const double *restrict dy)
{
    const double *pull = s;
    double sense = 1.0;
    if (!(p->tangential_stiffness > 0.0)) {
        pull = dy + history_at(p) + 3 * k;
        sense = -1.0;
    }
    double length = size(pull);
    for (int c = 0; c < 3; c++) {
        if (length > 0.0)
            s[c] = sense * pull[c] / length;
        else
            s[c] = 0.0;
    }
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
    if (kind == GAP) {
        if (ends_with_force(p)) /* they overlap still */
            return PARTED;
        return APART;
    }
    if (kind == PULL) {
        if (mode >= SLIP) /* what pulls does not rub */
            return FREE;
        return pressing(p, k, y);
    }
    double *s = y + history_at(p) + 3 * k;
    if (mode >= SLIP) {
        /* The spring is as long as its limit; without one nothing is stretched. */
        meeting m = meet(p, k, y);
        for (int c = 0; c < 3; c++) {
            if (p->tangential_stiffness > 0.0)
                s[c] *= longest(p, &m);
            else
                s[c] = 0.0;
        }
        return STICK;
    }
    let_go(p, k, s, dy);
    return SLIP;
}

/* The mode of pair k at the start: overlapping or touching and not about to part. */
static inline int64_t first_mode(const refdem_particles *p, int64_t k, double h, double *restrict y)
{
    meeting m = meet(p, k, y);
    double touch = 1e-15 * p->radius[m.i];
    if (m.overlap < -touch || (m.overlap <= touch && m.rate * h <= 0.0))
        return APART;
    if (ends_with_force(p) && m.normal <= 0.0)
        return PARTED;
    return pressing(p, k, y);
}

#endif
