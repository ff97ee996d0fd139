/* Points and spheres: springs, gravity, a central field, and the linear contact law with friction,
 * as rates of a state.
 *
 * Contact law (Cundall and Strack 1979): normal force F = k d + c d', tangential spring s with s' =
 * slip, |k_t s| <= mu F. Every pair is in one mode; within a mode the rates are smooth, so that a
 * method keeps its order if a step ends where a mode does. n points from i to j (or into the
 * plane); slip is the velocity of i against j at the ends of the lever arms.
 */
#ifndef REFDEM_PARTICLES_H
#define REFDEM_PARTICLES_H

#include <math.h>
#include <string.h>

#include "kernels.h"
#include "space.h"

/* APART: no overlap. PARTED: overlap, but the force would pull. FREE: normal force only. STICK: the
 * spring holds (without a spring: no slip). SLIP: friction at its limit; s is then the unit vector
 * of the spring, whose length is mu F / k_t. FADE: a SLIP without a spring that may end in this
 * step. Its direction may turn ever faster, so that friction keeps that of the start of the step:
 * the rates are smooth in it, and the end is located to rounding. */
enum { APART, PARTED, FREE, STICK, SLIP, FADE };

typedef struct {
    int64_t i, j;
    double n[3], turn[3], w[3], slip[3]; /* normal and its rate, velocity of i against j, slip */
    double overlap, rate, normal;        /* d, d', F */
    double limit; /* mu F; below zero too: a step may look beyond a release */
    double arm_i, arm_j;
} meeting;

/* Where the blocks of a state (or of its rates) begin: x, v (3 N); w (3 N), q (4 N) if bodies turn;
 * s (3 pairs) if they rub; last the work done against damping and friction. */
static inline int64_t spin_at(const refdem_particles *p)
{
    return 6 * p->bodies;
}

static inline int64_t history_at(const refdem_particles *p)
{
    if (p->turning)
        return 13 * p->bodies;
    return 6 * p->bodies;
}

static inline int64_t work_at(const refdem_particles *p)
{
    if (p->friction > 0.0)
        return history_at(p) + 3 * p->pairs;
    return history_at(p);
}

/* Geometry of pair k: normal, overlap and its rate. */
static inline void approach(const refdem_particles *p, int64_t k, const double *restrict y,
                            meeting *restrict m)
{
    const double *x = y;
    const double *v = y + 3 * p->bodies;
    int64_t i = p->pair[2 * k];
    int64_t j = p->pair[2 * k + 1];
    m->i = i;
    m->j = j;
    double away[3];
    double distance = INFINITY;
    if (j < 0) { /* a plane: its point and its normal */
        const double *plane = p->plane + 6 * (-1 - j);
        for (int c = 0; c < 3; c++) {
            m->n[c] = -plane[3 + c];
            m->w[c] = v[3 * i + c];
            away[c] = x[3 * i + c] - plane[c];
        }
        m->overlap = p->radius[i] + dot(away, m->n);
    } else {
        for (int c = 0; c < 3; c++) {
            away[c] = x[3 * j + c] - x[3 * i + c];
            m->w[c] = v[3 * i + c] - v[3 * j + c];
        }
        distance = sqrt(dot(away, away));
        for (int c = 0; c < 3; c++)
            m->n[c] = away[c] / distance;
        m->overlap = (p->radius[i] + p->radius[j]) - distance;
    }
    m->rate = dot(m->w, m->n);
    for (int c = 0; c < 3; c++)
        m->turn[c] = (m->rate * m->n[c] - m->w[c]) / distance;
}

/* The root of the overlap under Hertz's law, whose stiffnesses grow as it; 1 under the linear law.
 */
static inline double widening(const refdem_particles *p, double overlap)
{
    if (p->hertz)
        return sqrt(fmax(overlap, 0.0));
    return 1.0;
}

/* Everything about pair k that its force needs. */
static inline meeting meet(const refdem_particles *p, int64_t k, const double *restrict y)
{
    meeting m;
    approach(p, k, y, &m);
    /* F = k d (times the root of d under Hertz's law) + c d'. */
    m.normal = p->stiffness * m.overlap * widening(p, m.overlap) + p->damping * m.rate;
    m.limit = p->friction * m.normal;
    if (p->friction > 0.0) {
        const double *w = y + spin_at(p);
        double spin[3], turned[3];
        m.arm_i = p->radius[m.i] - p->branch * m.overlap;
        m.arm_j = 0.0;
        if (m.j >= 0)
            m.arm_j = p->radius[m.j] - p->branch * m.overlap;
        for (int c = 0; c < 3; c++) {
            double other = 0.0; /* a plane does not turn */
            if (m.j >= 0)
                other = m.arm_j * w[3 * m.j + c];
            spin[c] = m.arm_i * w[3 * m.i + c] + other;
        }
        cross(spin, m.n, turned);
        for (int c = 0; c < 3; c++)
            m.slip[c] = m.w[c] - m.rate * m.n[c] + turned[c];
    }
    return m;
}

/* Stiffness of the tangential spring: that of Hertz's contact grows with its circle, as the root of
 * the overlap. */
static inline double grip(const refdem_particles *p, const meeting *m)
{
    return p->tangential_stiffness * widening(p, m->overlap);
}

/* The stretch at which the spring begins to slip. */
static inline double longest(const refdem_particles *p, const meeting *m)
{
    if (p->hertz) /* both stiffnesses grow alike: mu k/k_t d */
        return p->friction * p->stiffness / p->tangential_stiffness * m->overlap;
    return m->limit / p->tangential_stiffness;
}

/* A speed [m/s] below which slip has no direction of its own: 1e-11 of the radius times the pair's
 * own frequency. */
static inline double least_slip(const refdem_particles *p, const meeting *m)
{
    double ease = p->ease[m->i];
    if (m->j >= 0)
        ease += p->ease[m->j];
    return 1e-11 * p->radius[m->i] * sqrt(p->stiffness * ease);
}

/* What a tangential impulse changes the slip by [1/kg]. */
static inline double yields(const refdem_particles *p, const meeting *m)
{
    double ease = p->ease[m->i] + m->arm_i * m->arm_i * p->turn_ease[m->i];
    if (m->j < 0) /* a plane does not yield */
        return ease;
    return ease + p->ease[m->j] + m->arm_j * m->arm_j * p->turn_ease[m->j];
}

/* The force that keeps the slip at zero, from the accelerations without it: -(slip rate) / (1/m +
 * 1/m + l^2/J + l^2/J). */
static inline void holding(const refdem_particles *p, const meeting *m, const double *restrict y,
                           const double *restrict dy, double *restrict force)
{
    const double *w = y + spin_at(p);
    const double *a = dy + 3 * p->bodies;
    const double *b = dy + spin_at(p);
    double spin[3], rate[3], carried[3], turned[3];
    double ease = yields(p, m);
    for (int c = 0; c < 3; c++) {
        spin[c] = m->arm_i * w[3 * m->i + c];
        rate[c] = m->arm_i * b[3 * m->i + c] - p->branch * m->rate * w[3 * m->i + c];
        force[c] = a[3 * m->i + c] - m->rate * m->turn[c];
        if (m->j >= 0) {
            spin[c] += m->arm_j * w[3 * m->j + c];
            rate[c] += m->arm_j * b[3 * m->j + c] - p->branch * m->rate * w[3 * m->j + c];
            force[c] -= a[3 * m->j + c];
        }
    }
    cross(rate, m->n, turned);
    cross(spin, m->turn, carried);
    for (int c = 0; c < 3; c++)
        force[c] += turned[c] + carried[c];
    add_scaled(force, -dot(force, m->n), m->n);
    for (int c = 0; c < 3; c++)
        force[c] /= -ease;
}

/* Angle [rad] within which a spring and the slip lie on a line. */
static const double STRAIGHT = 1e-9;

/* Tangential force on i, and the rate of the spring; where nothing but the lack of slip defines the
 * force, the force itself stands in the place of that rate. */
static inline void rub(const refdem_particles *p, int64_t mode, const meeting *m,
                       const double *restrict y, const double *restrict dy,
                       const double *restrict s, double *restrict force, double *restrict rate)
{
    double k = grip(p, m);
    double along = dot(s, m->slip);
    double carried = dot(s, m->turn);
    double least = 1e-8 * p->friction * p->stiffness * p->radius[m->i];
    double limit = fmax(m->limit, 0.0);
    /* k/limit, but finite where the force vanishes. */
    double lean = k * limit / (limit * limit + least * least);
    double across[3], inside[3];
    double towards[3] = {s[0], s[1], s[2]};
    double fast = size(m->slip);
    double flat = 1.0;
    double out = dot(s, m->n);
    int bends = p->tangential_stiffness > 0.0;
    if (!bends && mode >= SLIP) {
        /* Along the slip; where that has no direction, as it was. */
        if (mode == SLIP && along > least_slip(p, m)) {
            for (int c = 0; c < 3; c++)
                towards[c] = m->slip[c] / fast;
        }
        /* In the plane of contact: a slip that ends is all rounding, and friction may be many times
         * the normal force. */
        add_scaled(towards, -dot(towards, m->n), m->n);
        /* No direction yet, as after sticking without any pull: no friction. */
        flat = fmax(size(towards), 1e-300);
    }
    for (int c = 0; c < 3; c++) {
        inside[c] = s[c] - out * m->n[c];
        towards[c] /= flat;
    }
    for (int c = 0; c < 3; c++)
        across[c] = m->slip[c] - along * inside[c] / fmax(dot(inside, inside), 1e-300);
    /* Motion in a plane: rounding must not turn the spring, nor a trial step that has tilted it out
     * of the plane of contact. */
    if (mode == SLIP && size(across) < STRAIGHT * fast)
        lean = 0.0;
    for (int c = 0; c < 3; c++) {
        force[c] = 0.0;
        if (mode == STICK)
            force[c] = -k * s[c];
        else if (mode >= SLIP)
            force[c] = -m->limit * towards[c];
        rate[c] = 0.0;
        if (bends && mode == STICK)
            rate[c] = m->slip[c] - carried * m->n[c];
        if (bends && mode == SLIP)
            rate[c] = across[c] * lean - carried * m->n[c];
    }
    if (!bends && mode == STICK) {
        holding(p, m, y, dy, force);
        memcpy(rate, force, 3 * sizeof *force);
    }
}

/* Adds the acceleration and the angular accelerations that a tangential force on i (its reaction on
 * j) makes. */
static inline void twist(const refdem_particles *p, const meeting *m, const double *restrict force,
                         double *restrict dy)
{
    double *a = dy + 3 * p->bodies;
    double *b = dy + spin_at(p);
    double torque[3];
    cross(m->n, force, torque);
    add_scaled(a + 3 * m->i, p->ease[m->i], force);
    if (m->j >= 0)
        add_scaled(a + 3 * m->j, -p->ease[m->j], force);
    add_scaled(b + 3 * m->i, m->arm_i * p->turn_ease[m->i], torque);
    if (m->j >= 0)
        add_scaled(b + 3 * m->j, m->arm_j * p->turn_ease[m->j], torque);
}

/* A spring's row: stiffness, length, exponent, anchor (3), factors of the square and the cube. */
enum { STIFFNESS, LENGTH, EXPONENT, ANCHOR, QUADRATIC = 6, CUBIC };

/* Pull [N] over distance of a spring: k s^e + (k2 + k3 s) s^2 with the stretch s. */
static inline double pull_per_length(const double *restrict spring, double distance)
{
    double stretch = distance - spring[LENGTH];
    double size = fabs(stretch);
    if (spring[EXPONENT] != 1.0)
        size = pow(size, spring[EXPONENT]);
    double pull = spring[STIFFNESS] * copysign(size, stretch);
    double more = (spring[QUADRATIC] + spring[CUBIC] * stretch) * stretch * stretch;
    if (distance > 0.0)
        return (pull + more) / distance;
    return 0.0; /* a spring of no length has no direction */
}

/* Adds the forces of the springs. */
static inline void pull_springs(const refdem_particles *p, const double *restrict x,
                                double *restrict force)
{
    for (int64_t k = 0; k < p->springs; k++) {
        const double *spring = p->spring + 8 * k;
        int64_t i = p->spring_end[2 * k];
        int64_t j = p->spring_end[2 * k + 1];
        double to[3];
        double factor = spring[STIFFNESS];
        const double *end = spring + ANCHOR; /* fixed in space, or another body */
        if (j >= 0)
            end = x + 3 * j;
        for (int c = 0; c < 3; c++)
            to[c] = end[c] - x[3 * i + c];
        int has_length = spring[LENGTH] != 0.0;
        int is_linear = spring[EXPONENT] == 1.0 && spring[QUADRATIC] == 0.0 && spring[CUBIC] == 0.0;
        if (has_length || !is_linear)
            factor = pull_per_length(spring, size(to));
        add_scaled(force + 3 * i, factor, to);
        if (j >= 0)
            add_scaled(force + 3 * j, -factor, to);
    }
}

/* Adds the normal forces; returns the power of damping. */
static inline double press(const refdem_particles *p, const int64_t *restrict mode,
                           const double *restrict y, double *restrict force)
{
    double power = 0.0;
    for (int64_t k = 0; k < p->pairs; k++) {
        if (mode[k] < FREE)
            continue;
        meeting m = meet(p, k, y);
        add_scaled(force + 3 * m.i, -m.normal, m.n);
        if (m.j >= 0)
            add_scaled(force + 3 * m.j, m.normal, m.n);
        power += p->damping * m.rate * m.rate;
    }
    return power;
}

/* Adds the tangential forces and the rates of their springs; returns the power of friction.
 * Accelerations must be complete but for these. */
static inline double rub_all(const refdem_particles *p, const int64_t *restrict mode,
                             const double *restrict y, double *restrict dy)
{
    double power = 0.0;
    double force[3];
    for (int64_t k = 0; k < p->pairs; k++) {
        if (mode[k] < STICK)
            continue;
        meeting m = meet(p, k, y);
        rub(p, mode[k], &m, y, dy, y + history_at(p) + 3 * k, force, dy + history_at(p) + 3 * k);
        twist(p, &m, force, dy);
        power -= dot(force, m.slip);
    }
    return power;
}

/* q' = w q / 2 for every body. */
static inline void turn(const refdem_particles *p, const double *restrict w,
                        const double *restrict q, double *restrict dq)
{
    for (int64_t i = 0; i < p->bodies; i++, w += 3, q += 4, dq += 4) {
        double across[3];
        cross(w, q + 1, across);
        dq[0] = -0.5 * dot(w, q + 1);
        for (int c = 0; c < 3; c++)
            dq[1 + c] = 0.5 * (across[c] + q[0] * w[c]);
    }
}

/* Rates of everything: y' = dy. Forces are summed before they are divided by the mass, so that what
 * balances exactly rests. */
static inline void rates(const refdem_particles *p, const int64_t *restrict mode,
                         const double *restrict y, double *restrict dy)
{
    int64_t n = p->bodies;
    double *a = dy + 3 * n;
    memcpy(dy, y + 3 * n, (size_t)(3 * n) * sizeof *dy);
    memset(a, 0, (size_t)(work_at(p) + 1 - 3 * n) * sizeof *dy);
    pull_springs(p, y, a);
    dy[work_at(p)] = press(p, mode, y, a);
    for (int64_t i = 0; i < n; i++) {
        double cube = 0.0;
        if (p->gm > 0.0) {
            double square = dot(y + 3 * i, y + 3 * i);
            cube = p->gm / (square * sqrt(square));
        }
        if (!(p->ease[i] > 0.0)) { /* a fixed body stays */
            memset(a + 3 * i, 0, 3 * sizeof *a);
            continue;
        }
        for (int c = 0; c < 3; c++)
            a[3 * i + c] = (a[3 * i + c] / p->mass[i] + p->gravity[c]) - cube * y[3 * i + c];
    }
    if (p->turning)
        turn(p, y + spin_at(p), y + 9 * n, dy + 9 * n);
    if (p->friction > 0.0)
        dy[work_at(p)] += rub_all(p, mode, y, dy);
}

#endif
