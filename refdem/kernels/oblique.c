/* Two spheres that rub on each other in a plane, by the linear law with a tangential spring: Taylor
 * series of order 20 from event to event.
 *
 * Coordinates: overlap d, its rate g, the transverse relative velocity q (of j from i), the angle
 * of the line of centres, spins w_i and w_j, spring s. With the distance D = R_i + R_j - d, the
 * turning rate o = q/D of the line, levers l = R - branch d and 1/m = 1/m_i + 1/m_j:
 *   force along the line  F = k d + c g,    force across it, on i:  f by mode
 *   g' = -q o - F/m,   q' = g o - f/m,   w_i' = l_i f/J_i (j alike),
 *   slip u = l_i w_i + l_j w_j - q.
 * STICK: f = -k_t s, s' = u. SLIP: f = -side mu F, the spring as long as that force asks. FREE: f =
 * 0, there is no friction or F pulls. APART: free flight without end, since two spheres that part
 * do not meet again, and a force that has ended does not press again.
 *
 * Coefficients by the recurrences of products and of the quotient (Jorba and Zou 2005, proposition
 * 1). Events are zeros of the series to the last bit; a function that is zero at the start of the
 * segment is first divided by that power of the time. The work lost is the integral of products of
 * these series, which oscillate twice as fast as the motion: its series has all terms of the
 * products, so that it does not require shorter steps.
 *
 * Phases: begin, measure, expand, step_size, locate, record, accept, change_mode.
 */
#include <assert.h>

#include "kernels.h"
#include "series_zeros.h"
#include "simd.h"

enum { STICK, SLIP, FREE, APART, MOST_SEGMENTS = 100000 };
/* Components of the state: d, g, q, angle of the line, spins, angles turned, work lost. */
enum { D, G, Q, TURN, SPIN_I, SPIN_J, ANGLE_I, ANGLE_J, WORK, STATES };

typedef refdem_oblique_pair pair;
typedef double series[ORDER + 1];

/* A segment of the motion in one mode: series of the state but for the work, of F, of f, of the
 * slip, of the spring and of the work that is lost; how long it lasts [s], and the mode after it,
 * -1 if it ends without an event. */
typedef struct {
    series y[WORK], force, across, slip, spring;
    double work[2 * ORDER + 1];
    double end;
    int next;
} segment;

/* The motion now: time [s], state, spring [m], mode, sign of the slip; the orders of the zeros with
 * which the overlap and the guard of sticking, mu F - |f|, begin. */
typedef struct {
    double now, y[STATES], spring;
    int mode, side, overlap_zeros, limit_zeros;
} motion;

/* Products of series: d (w_i + w_j), d f, d o, q o and g o. */
typedef struct {
    running_product d_spins, d_f, d_o, q_o, g_o;
} products;

/* 1 or -1: the sign of a slip or a spring. */
static int sign_of(double value)
{
    if (value > 0.0)
        return 1;
    return -1;
}

/* True if the contact ends where its force does, before the overlap: the law does not pull, and has
 * a dashpot that would. */
static int ends_with_force(const pair *p)
{
    return p->no_pull && p->damping > 0.0;
}

/* The start, touching, or pressed with a slack spring. At a touch F = 0, and a slack spring slides
 * at once if it would grow faster than its limit: k_t |u| > mu F' = mu k g. */
static motion begin(const pair *p, const double *start)
{
    motion m
        = {.overlap_zeros = start[D] <= 0.0, .limit_zeros = start[D] <= 0.0 && p->damping == 0.0};
    memcpy(m.y, start, 6 * sizeof *start);
    m.y[D] = fmax(m.y[D], 0.0);
    double force = p->stiffness * m.y[D] + p->damping * m.y[G];
    double limit = INFINITY; /* pressed: a slack spring sticks */
    if (m.limit_zeros)       /* a touch: the limit grows with the force */
        limit = p->stiffness * m.y[G];
    /* u = l_i w_i + l_j w_j - q, with l = R - branch d. */
    double slip = (p->radius_i - p->branch * m.y[D]) * m.y[SPIN_I]
                  + (p->radius_j - p->branch * m.y[D]) * m.y[SPIN_J] - m.y[Q];
    m.side = sign_of(slip);
    m.mode = STICK;
    if (fabs(slip) * p->tangential_stiffness > p->friction * limit)
        m.mode = SLIP;
    if (p->friction == 0.0 || force < 0.0) /* a force that pulls has no friction */
        m.mode = FREE;
    return m;
}

/* Coefficients n of F, of the slip u and of f, from those of the state. */
static inline void measure(const pair *p, const motion *m, segment *restrict z,
                           products *restrict by, int n)
{
    double d = z->y[D][n];
    double wi = z->y[SPIN_I][n];
    double wj = z->y[SPIN_J][n];
    double spins = wi + wj;
    /* F = k d + c g,   u = R_i w_i + R_j w_j - q - branch d (w_i + w_j). */
    z->force[n] = p->stiffness * d + p->damping * z->y[G][n];
    z->slip[n] = p->radius_i * wi + p->radius_j * wj - z->y[Q][n]
                 - p->branch * coefficient(&by->d_spins, d, spins, n);
    /* f = -k_t s where it sticks, -side mu F where it slips. */
    z->across[n] = 0.0;
    if (m->mode == STICK)
        z->across[n] = -p->tangential_stiffness * z->spring[n];
    else if (m->mode == SLIP)
        z->across[n] = -m->side * p->friction * z->force[n];
    take_in(&by->d_spins, d, spins, n);
}

/* Series of the work lost over s: the integral of the power c g^2 - f u, with all 2 ORDER + 1
 * coefficients of the products, c_(n+k) = sum of c g_n g_k - f_n u_k, row n after row, in vectors.
 * Where the motion is FREE, f = 0. */
static inline void expand_work(const pair *p, const motion *m, segment *restrict z)
{
    double g[PADDED_ORDER], slip[PADDED_ORDER], power[2 * PADDED_ORDER];
    double sign = -1.0;
    if (m->mode == FREE)
        sign = 0.0;
    /* The coefficients, followed by zeros up to a whole vector. */
    memset(power, 0, sizeof power);
    memset(g, 0, sizeof g);
    memset(slip, 0, sizeof slip);
    memcpy(g, z->y[G], sizeof z->y[G]);
    memcpy(slip, z->slip, sizeof z->slip);
    for (int n = 0; n <= ORDER; n++) {
        double damped_g = p->damping * g[n];
        double signed_f = sign * z->across[n];
        for (int k = 0; k <= ORDER; k += LANES)
            for (int i = 0; i < LANES; i++)
                power[n + k + i]
                    = fma(damped_g, g[k + i], fma(signed_f, slip[k + i], power[n + k + i]));
    }
    for (int n = 0; n <= 2 * ORDER; n++)
        z->work[n] = power[n] / (n + 1);
}

/* Coefficients 1 to ORDER of the state. o D = q with D = D_0 - (d - d_0) gives the quotient
 * o_n = (q_n + sum over k >= 1 of d_k o_(n-k))/D_0. */
static void expand(const pair *p, const motion *m, segment *restrict z)
{
    products by;
    double inverse_distance = 1.0 / (p->radius_i + p->radius_j - m->y[D]);
    double o_0 = m->y[Q] * inverse_distance;
    clear(&by.d_spins);
    clear(&by.d_f);
    clear(&by.d_o);
    clear(&by.q_o);
    clear(&by.g_o);
    for (int i = 0; i < WORK; i++)
        z->y[i][0] = m->y[i];
    z->spring[0] = m->spring;
    for (int n = 0; n < ORDER; n++) {
        measure(p, m, z, &by, n);
        double inverse = INVERSE[n + 1];
        double d = z->y[D][n];
        double g = z->y[G][n];
        double q = z->y[Q][n];
        double f = z->across[n];
        double o = o_0;
        if (n > 0)
            o = (q + fma(d, o_0, by.d_o.sum[n])) * inverse_distance;
        double lever_change = p->branch * coefficient(&by.d_f, d, f, n);
        /* d' = g,  g' = -q o - F/m,  q' = g o - f/m,  J w' = (R - branch d) f,  s' = u. */
        z->y[D][n + 1] = g * inverse;
        z->y[G][n + 1] = -(coefficient(&by.q_o, q, o, n) + p->inverse_mass * z->force[n]) * inverse;
        z->y[Q][n + 1] = (coefficient(&by.g_o, g, o, n) - p->inverse_mass * f) * inverse;
        z->y[SPIN_I][n + 1] = p->inverse_inertia_i * (p->radius_i * f - lever_change) * inverse;
        z->y[SPIN_J][n + 1] = p->inverse_inertia_j * (p->radius_j * f - lever_change) * inverse;
        z->y[TURN][n + 1] = o * inverse;
        z->y[ANGLE_I][n + 1] = z->y[SPIN_I][n] * inverse;
        z->y[ANGLE_J][n + 1] = z->y[SPIN_J][n] * inverse;
        z->spring[n + 1] = z->slip[n] * inverse;
        take_in(&by.d_f, d, f, n);
        take_in(&by.d_o, d, o, n);
        take_in(&by.q_o, q, o, n);
        take_in(&by.g_o, g, o, n);
    }
    measure(p, m, z, &by, ORDER);
    expand_work(p, m, z);
}

/* The longest step h for which the last two terms, a_n h^n of the velocities, stay at an ulp,
 * 2^-53, of the motion's speed: h = (2^-53 speed/a_n)^(1/n). As the terms fall by factorials, what
 * is cut off is far below. */
static double step_size(const pair *p, const segment *z)
{
    double speed = fabs(z->y[G][0]) + fabs(z->y[Q][0]) + fabs(p->radius_i * z->y[SPIN_I][0])
                   + fabs(p->radius_j * z->y[SPIN_J][0]);
    /* speed = |g| + |q| + |R_i w_i| + |R_j w_j| + |d| sqrt(k/m), with k the larger stiffness. */
    double frequency = sqrt(fmax(p->stiffness, p->tangential_stiffness) * p->inverse_mass);
    double h = INFINITY;
    speed += fabs(z->y[D][0]) * frequency;
    for (int n = ORDER - 1; n <= ORDER; n++) {
        double largest = fmax(fabs(z->y[G][n]), fabs(z->y[Q][n]));
        largest = fmax(largest, fmax(fabs(p->radius_i * z->y[SPIN_I][n]),
                                     fabs(p->radius_j * z->y[SPIN_J][n])));
        h = fmin(h, exp2((-53.0 - log2(fmax(largest / speed, 1e-300))) / n));
    }
    return fmin(h, p->longest);
}

/* Finds the first zero of the guard `a`, a series with a zero of order `skip` at the start; if it
 * is the first of all guards, the segment ends there, and the mode `next` follows. The segment may
 * also be shortened without an event, to where the absence of a zero is easier to prove. */
static void watch(const double *a, int skip, int next, segment *restrict z)
{
    series guard;
    divide_by_power(a, skip, guard);
    double end = z->end;
    double zero = 0.0; /* a guard that begins below zero has failed already */
    if (!(guard[0] < 0.0))
        zero = first_zero_soon(guard, &end);
    if (zero >= 0.0 && (zero < z->end || z->next < 0)) {
        z->end = zero;
        z->next = next;
    } else if (end < z->end) {
        z->end = end;
        z->next = -1;
    }
}

/* Guards of friction. SLIP ends where the slip no longer outruns the spring's limit, side u = mu
 * F'/k_t; STICK where |s| reaches the limit: mu F/k_t - s or mu F/k_t + s is zero. */
static void watch_friction(const pair *p, const motion *m, segment *restrict z)
{
    series guard;
    double limit_per_force = p->friction / p->tangential_stiffness;
    if (m->mode == SLIP) {
        /* (F')_n = (n + 1) F_(n+1). The coefficient ORDER of the guard is not known, and set to
         * 0. */
        for (int n = 0; n < ORDER; n++)
            guard[n] = m->side * z->slip[n] - limit_per_force * (n + 1) * z->force[n + 1];
        guard[ORDER] = 0.0;
        watch(guard, 0, STICK, z);
    }
    if (m->mode != STICK)
        return;
    for (int side = -1; side <= 1; side += 2) {
        int skip = 0;
        if (m->limit_zeros == 1) /* begins to press: both limits begin at zero */
            skip = 1;
        else if (side == m->side) /* a slip has just ended: at the limit that it came from */
            skip = m->limit_zeros;
        for (int n = 0; n <= ORDER; n++)
            guard[n] = limit_per_force * z->force[n] - side * z->spring[n];
        watch(guard, skip, SLIP, z);
    }
}

/* The end of the segment: the first event within the step, or the step. */
static void locate(const pair *p, const motion *m, segment *restrict z)
{
    z->end = step_size(p, z);
    z->next = -1;
    if (ends_with_force(p))
        watch(z->force, 0, APART, z);
    else
        watch(z->y[D], m->overlap_zeros, APART, z);
    /* A force that pulls has no friction. */
    int may_pull = !ends_with_force(p) && p->damping > 0.0;
    if (p->friction > 0.0 && may_pull && m->mode != FREE)
        watch(z->force, 0, FREE, z);
    if (m->mode != FREE)
        watch_friction(p, m, z);
}

/* The state y after the time t = `since` of free flight. Along and across the line of centres at
 * the release the relative position is (X, Y) = (D - g t, q t), with the velocity (-g, q), so that
 *
 *   D(t) = sqrt(X^2 + Y^2),   g(t) = -(-X g + Y q)/D(t),   q(t) = (X q + Y g)/D(t),
 *
 * the line of centres has turned by atan2(Y, X), and spins are constant. */
static void fly(const pair *p, const motion *m, double since, double *restrict y)
{
    double distance_before = p->radius_i + p->radius_j - m->y[D];
    double along = distance_before - m->y[G] * since;
    double across = m->y[Q] * since;
    double distance_now = hypot(along, across);
    memcpy(y, m->y, STATES * sizeof *y);
    y[D] = p->radius_i + p->radius_j - distance_now;
    y[G] = -(along * -m->y[G] + across * m->y[Q]) / distance_now;
    y[Q] = (along * m->y[Q] + across * m->y[G]) / distance_now;
    y[TURN] += atan2(across, along);
    y[ANGLE_I] += y[SPIN_I] * since;
    y[ANGLE_J] += y[SPIN_J] * since;
}

/* Work lost [J] after `since` [s]. */
static double work_after(const segment *z, double since)
{
    return polynomial(z->work, 2 * ORDER + 1, since) * since;
}

/* The state y after `since` [s] in this segment. */
static void state_at(const pair *p, const motion *m, const segment *z, double since,
                     double *restrict y)
{
    if (m->mode == APART) {
        fly(p, m, since, y);
        return;
    }
    for (int i = 0; i < WORK; i++)
        y[i] = m->y[i] + gained(z->y[i], since);
    y[WORK] = m->y[WORK] + work_after(z, since);
}

/* Energy [J] in springs that the normal force does not return: k_t s^2/2 of the tangential one
 * while the contact presses, k d^2/2 of the normal one once the force has ended before the overlap.
 */
static double stored_energy(const pair *p, const motion *m, const double *restrict y, double spring)
{
    double force = p->stiffness * y[D] + p->damping * y[G];
    double overlap = fmax(y[D], 0.0);
    if (m->mode == APART)
        return 0.5 * p->stiffness * overlap * overlap;
    double stretch = 0.0;
    if (m->mode == STICK)
        stretch = spring;
    else if (m->mode == SLIP)
        stretch = p->friction * force / p->tangential_stiffness;
    return 0.5 * p->tangential_stiffness * stretch * stretch;
}

/* Writes the sample (12) at `since` [s] in this segment. */
static void record(const pair *p, const motion *m, const segment *z, double since,
                   double *restrict out)
{
    double spring = 0.0;
    state_at(p, m, z, since, out);
    /* Contacts, F = k d + c g, and the work lost but for the energy that springs still hold. */
    out[9] = 0.0;
    out[10] = 0.0;
    if (m->mode != APART) { /* they press */
        out[9] = 1.0;
        out[10] = p->stiffness * out[D] + p->damping * out[G];
        spring = z->spring[0] + gained(z->spring, since);
    }
    out[11] = out[WORK] - stored_energy(p, m, out, spring);
}

/* The end of the segment becomes the state; no zero is known to begin there. */
static void accept(const pair *p, motion *m, const segment *z)
{
    double y[STATES];
    state_at(p, m, z, z->end, y);
    double spring = z->spring[0] + gained(z->spring, z->end);
    memcpy(m->y, y, sizeof y);
    m->now += z->end;
    m->spring = spring;
    m->overlap_zeros = 0;
    m->limit_zeros = 0;
}

/* Goes through the event that ended the segment: the new mode, its spring and its zeros. */
static void change_mode(const pair *p, motion *m, const segment *z)
{
    double limit_per_force = 0.0;
    if (p->tangential_stiffness > 0.0)
        limit_per_force = p->friction / p->tangential_stiffness;
    if (z->next < 0) /* a step without an event */
        return;
    if (z->next == SLIP)
        m->side = sign_of(m->spring);
    if (z->next == STICK) { /* the spring that the slip had: s = side mu F/k_t */
        m->spring = m->side * limit_per_force * (p->stiffness * m->y[D] + p->damping * m->y[G]);
        m->limit_zeros = 2; /* mu F - |f| and its rate are zero */
    }
    if (z->next == APART) {
        if (!ends_with_force(p))
            m->y[D] = 0.0; /* exactly */
        /* The energy k d^2/2 left in the normal spring is lost. */
        m->y[WORK] += 0.5 * p->stiffness * m->y[D] * m->y[D];
    }
    m->mode = z->next;
}

REFDEM_EVERY_CPU
int64_t refdem_oblique(const refdem_oblique_pair *p, const double *start, int64_t samples,
                       const double *t, double *release, double *out)
{
    assert(samples >= 1 && release && out);
    assert(p && start && t);
    /* A segment: its series (expand), its end (locate), the samples in it, then the state at its
     * end and the mode after it. */
    segment z;
    motion m = begin(p, start);
    int64_t row = 0;
    *release = INFINITY;
    for (int64_t k = 0; k < MOST_SEGMENTS && row < samples; k++) {
        z.end = INFINITY;
        if (m.mode != APART) {
            expand(p, &m, &z);
            locate(p, &m, &z);
        }
        for (; row < samples && t[row] - m.now <= z.end; row++, out += 12)
            record(p, &m, &z, t[row] - m.now, out);
        if (row == samples)
            break;
        accept(p, &m, &z);
        change_mode(p, &m, &z);
        if (m.mode == APART)
            *release = m.now;
    }
    return row;
}
