/* The modes of a contact: the guards of each mode, and the mode that follows.
 *
 * A guard is a function of the state that is positive as long as the pair stays in its mode; its
 * first zero is the event. Only signs and zeros count; under the linear law guards are
 * dimensionless. With the strain d/R and the force F/(k R), by mode:
 *   APART    GAP: -d/R
 *   PARTED   GAP: d/R, PULL: -F (it presses again)
 *   pressing GAP: d/R, or F/(k R) where the contact ends with its force
 *   FREE     PULL: -F;  SLIP  PULL: F (friction ends and begins with the sign of the force)
 *   STICK    HOLD: mu F - |f|, the margin of the holding force f to its limit
 *   SLIP     HOLD: u.s - D', the slip along the spring less the rate of its stretch limit D
 */
#ifndef REFDEM_CONTACT_MODES_H
#define REFDEM_CONTACT_MODES_H

#include "particle_steps.h"

enum { GAP, PULL, HOLD, GUARDS };

/* The unit of the guard of a slip, in slip floors (particles.h): it makes 1e-11 R times the pair's
 * frequency into R times it, so that the slack of a guard is a rounding of the slip. */
static const double SLIP_UNIT = 1e11;

/* True if the contact ends where its force does, before the overlap: the law does not pull, and has
 * a dashpot that would. */
static inline int ends_with_force(const refdem_particles *p)
{
    return p->no_pull && p->damping > 0.0;
}

/* mu F - |f| of a pair that sticks, over the normal limit mu k R of a strain of 1: f = k_t s, or
 * without a spring the force that stands in the place of its rate. */
static inline double stick_guard(const runner *r, int64_t k, const contact *m,
                                 const double *restrict y, const double *restrict dy)
{
    const refdem_particles *p = r->p;
    double holding_force;
    if (p->tangential_stiffness > 0.0)
        holding_force = tangential_stiffness(p, m) * size(y + history_at(p) + 3 * k);
    else /* no spring: dy has the holding force itself (particles.h, tangential_force) */
        holding_force = size(dy + history_at(p) + 3 * k);
    return (m->limit - holding_force) / (p->friction * p->stiffness * p->radius[m->i]);
}

/* Rate [m/s] of the stretch limit of a tangential spring (particles.h, stretch_limit),
 *
 *   D' = mu (k d' + c d'')/k_t,   d'' = (v_i - v_j).n' + (a_i - a_j).n.
 *
 * It holds for both laws: D = mu (k d + c d')/k_t for the linear one, and D = mu k d/k_t for that
 * of Hertz, which has c = 0. */
static inline double limit_growth(const refdem_particles *p, const contact *m,
                                  const double *restrict dy)
{
    const double *a = dy + 3 * p->bodies;
    double overlap_acceleration = dot(m->velocity, m->normal_rate);
    for (int c = 0; c < 3; c++) {
        double a_j = 0.0;
        if (m->j >= 0)
            a_j = a[3 * m->j + c];
        overlap_acceleration += (a[3 * m->i + c] - a_j) * m->n[c];
    }
    double force_rate = p->stiffness * m->rate + p->damping * overlap_acceleration;
    return p->friction / p->tangential_stiffness * force_rate;
}

/* The slip along the spring less the rate of its stretch limit, u.s - D', in units of SLIP_UNIT
 * slip floors. Where it is no longer positive, the spring sticks. */
static inline double slip_guard(const runner *r, int64_t k, const contact *m,
                                const double *restrict y, const double *restrict dy)
{
    const refdem_particles *p = r->p;
    double slip_along = dot(m->slip, y + history_at(p) + 3 * k);
    double growth = 0.0;
    if (p->tangential_stiffness > 0.0)
        growth = limit_growth(p, m, dy); /* negative while the force decreases to 0 */
    return (slip_along - growth) / (SLIP_UNIT * slip_floor(p, m));
}

/* The guard of that kind of pair k in state y with rates dy (head of this file); INFINITY if the
 * mode has none of that kind. */
static inline double guard(const runner *r, int64_t k, int kind, const double *restrict y,
                           const double *restrict dy)
{
    const refdem_particles *p = r->p;
    int64_t mode = r->mode[k];
    contact m = measure(p, k, y);
    double radius = p->radius[m.i];
    double strain = m.overlap / radius;
    double force = m.force / (p->stiffness * radius);
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
    if (p->friction == 0.0) /* nothing else can change while it presses */
        return INFINITY;
    if (kind == PULL) { /* friction ends, and begins again, with the sign of the force */
        if (p->no_pull || p->damping == 0.0) /* no force ever pulls */
            return INFINITY;
        if (mode == FREE)
            return -force;
        if (mode >= SLIP)
            return force;
        return INFINITY;
    }
    if (mode == FREE) /* no friction to stick or slip by */
        return INFINITY;
    if (mode == STICK)
        return stick_guard(r, k, &m, y, dy);
    return slip_guard(r, k, &m, y, dy);
}

/* The mode of a pair that begins to press; sets its spring in y: slack, or the unit vector of the
 * slip where it slides at once. */
static inline int64_t begin_pressing(const refdem_particles *p, int64_t k, double *restrict y)
{
    if (p->friction == 0.0)
        return FREE;
    contact m = measure(p, k, y);
    double *s = y + history_at(p) + 3 * k;
    double slip_speed = size(m.slip);
    double k_t = p->tangential_stiffness;
    double force_floor = 1e-13 * p->stiffness * p->radius[m.i];
    int slides = slip_speed > slip_floor(p, &m);
    if (k_t > 0.0) {
        /* At zero force the spring force begins as k_t |u| t and its limit as mu k d' t (under
         * Hertz's law both times sqrt(d)): the spring slides at once if k_t |u| > mu k d'. */
        int is_unloaded = fabs(m.force) <= force_floor;
        slides = is_unloaded && slip_speed * k_t > p->friction * p->stiffness * m.rate;
    }
    for (int c = 0; c < 3; c++) {
        if (slides)
            s[c] = m.slip[c] / slip_speed;
        else
            s[c] = 0.0;
    }
    if (m.force < -force_floor) /* a force that pulls has no friction */
        return FREE;
    if (slides)
        return SLIP;
    return STICK;
}

/* Makes the spring s of a slip that begins a unit vector: its own direction, or without a spring
 * that against the force that held, in dy. */
static inline void begin_slip(const refdem_particles *p, int64_t k, double *restrict s,
                              const double *restrict dy)
{
    const double *vector = s;
    double sign = 1.0;
    if (!(p->tangential_stiffness > 0.0)) {
        vector = dy + history_at(p) + 3 * k;
        sign = -1.0;
    }
    double length = size(vector);
    for (int c = 0; c < 3; c++) {
        if (length > 0.0)
            s[c] = sign * vector[c] / length;
        else
            s[c] = 0.0;
    }
}

/* The mode of pair k after it has left its own through the guard of that kind; sets its spring. */
static inline int64_t next_mode(const runner *r, int64_t k, int kind, double *restrict y,
                                const double *restrict dy)
{
    const refdem_particles *p = r->p;
    int64_t mode = r->mode[k];
    if (mode == APART || (mode == PARTED && kind == PULL))
        return begin_pressing(p, k, y);
    if (mode == PARTED)
        return APART;
    if (kind == GAP) {
        if (ends_with_force(p)) /* the spheres still overlap */
            return PARTED;
        return APART;
    }
    if (kind == PULL) {
        if (mode >= SLIP) /* without a force that presses there is no friction */
            return FREE;
        return begin_pressing(p, k, y);
    }
    double *s = y + history_at(p) + 3 * k;
    if (mode >= SLIP) {
        /* s was the unit vector of a spring at its limit: it becomes that spring again. Without a
         * spring nothing is stretched. */
        contact m = measure(p, k, y);
        for (int c = 0; c < 3; c++) {
            if (p->tangential_stiffness > 0.0)
                s[c] *= stretch_limit(p, &m);
            else
                s[c] = 0.0;
        }
        return STICK;
    }
    begin_slip(p, k, s, dy); /* the limit is reached */
    return SLIP;
}

/* The mode of pair k at the start of a run with steps h: it presses if it overlaps, or if it
 * touches and the overlap grows in the direction of time, d' h > 0. */
static inline int64_t first_mode(const refdem_particles *p, int64_t k, double h, double *restrict y)
{
    contact m = measure(p, k, y);
    double touch = 1e-15 * p->radius[m.i];
    if (m.overlap < -touch || (m.overlap <= touch && m.rate * h <= 0.0))
        return APART;
    if (ends_with_force(p) && m.force <= 0.0)
        return PARTED;
    return begin_pressing(p, k, y);
}

#endif
