/* A point on a spring that rubs on a moving belt and is driven: m x'' in F cos(w t + phase) +
 * weight - k x - N mu(|u|) Sgn(u), u = x' - belt.
 *
 * mu(s) = (mu0 - mu1)/(1 + lambda0 s) + mu1 + lambda1 s^2, or lambda1 s in its last term. While it
 * slips: Taylor series of order 20 by the recurrences of products and of the quotient (Jorba and
 * Zou 2005, proposition 1), the step such that they end at round-off. Events are zeros of these
 * series to the last bit: a stretch without one is told by bounds of the series, never by its ends
 * alone. While it sticks the pull P = F cos + weight - k x is monotone between turning points known
 * in closed form. A slip begins with u = 0 and, after sticking, u' = 0, exactly.
 */
#ifndef REFDEM_BELT_H
#define REFDEM_BELT_H

#include "double_double.h"
#include "kernels.h"
#include "series_zeros.h"

enum { STICKS = 0, STOPS = 1, LEAVES = 2, MOST_PIECES = 1 << 30 };

typedef refdem_belt belt;

/* A stretch: series of x, of |u|, of the work done against friction and drive; where it ends, and
 * by which event. */
typedef struct {
    double x[ORDER + 1], w[ORDER + 1], work[ORDER + 1], rate[ORDER + 1], end;
    int event, leads;
} piece;

/* Now: side is the sign of u, 0 while it sticks; fresh is the order of the zero of u with which a
 * slip began. tangent: x, u. swing: amplitude w^n/n! of the drive. */
typedef struct {
    dd now, x, work;
    double w, tangent[2], swing[ORDER];
    int side, fresh, follows;
} motion;

/* A sum in double-double and a small change of it. */
static inline dd grown(dd from, double by)
{
    dd sum = two_sum(from.hi, by);
    return quick_two_sum(sum.hi, sum.lo + from.lo);
}

/* The drive [N] and its phase's cosine and sine at `since` after now. */
static inline double drive(const belt *p, dd now, double since, double *restrict slope)
{
    double c, s;
    turned(dd_add(dd_scale(dd_add(now, dd_of(since)), p->frequency), dd_of(p->phase)), &c, &s);
    *slope = -p->amplitude * p->frequency * s;
    return p->amplitude * c;
}

/* Taylor coefficients of the drive about now. */
static inline void driven(const belt *p, const motion *m, double *restrict force)
{
    double c, s;
    turned(dd_add(dd_scale(m->now, p->frequency), dd_of(p->phase)), &c, &s);
    double turn[LANES] = {c, -s, -c, s};
    for (int n = 0; n < ORDER; n += LANES)
        for (int i = 0; i < LANES; i++)
            force[n + i] = m->swing[n + i] * turn[i];
}

/* The series of a slip to the given side; the rate of the friction by |u| too, for tangents. What a
 * coefficient waits for is kept short. */
static inline void expand(const belt *p, const motion *m, int with_work, piece *restrict y)
{
    double force[ORDER], q[ORDER];
    double side = m->side;
    double drop = p->normal_force * (p->mu0 - p->mu1);
    double curve = p->normal_force * p->lambda1;
    growing share, bent, power;
    cleared(&share);
    cleared(&bent);
    if (with_work)
        cleared(&power);
    driven(p, m, force);
    y->x[0] = m->x.hi;
    y->w[0] = m->w;
    y->work[0] = 0.0;
    double first = 1.0 / (1.0 + p->lambda0 * m->w);
    double fall = -first * p->lambda0;
    double ease = 1.0 / p->mass;
#pragma GCC unroll 32
    for (int n = 0; n < ORDER; n++) {
        double w = y->w[n];
        double part = PART[n + 1];
        /* What is constant in time has a coefficient of order 0 only. */
        double belt = 0.0;
        double weight = 0.0;
        double even = 0.0;
        if (n == 0) {
            belt = p->belt;
            weight = p->weight;
            even = p->normal_force * p->mu1;
        }
        double v = side * w + belt;
        double bend = w;
        if (!p->linear)
            bend = coefficient(&bent, w, w, n);
        double pull = force[n] + weight - p->stiffness * y->x[n];
        q[n] = first;
        if (n > 0)
            q[n] = fma(w, fall * first, fall * share.sum[n]);
        y->x[n + 1] = v * part;
        y->w[n + 1]
            = fma(-drop * ease * part, q[n], ease * part * (side * pull - even - curve * bend));
        if (n == 0 && m->fresh == 2) /* after sticking u' begins at 0, exactly */
            y->w[1] = 0.0;
        grow(&share, w, q[n], n);
        if (!p->linear)
            grow(&bent, w, w, n);
        if (with_work) {
            double lost = side * (fma(drop, q[n], curve * bend) + even) - force[n];
            y->work[n + 1] = coefficient(&power, lost, v, n) * part;
            grow(&power, lost, v, n);
        }
    }
    if (!m->follows)
        return;
    /* N mu'(s) = N (lambda1 2 s - (mu0 - mu1) lambda0 q^2), or lambda1 in its first term. */
    for (int n = 0; n < ORDER; n++) {
        double slope = 2.0 * y->w[n];
        if (p->linear)
            slope = n == 0;
        double falling = (p->mu0 - p->mu1) * p->lambda0 * square(q, n);
        y->rate[n] = p->normal_force * (p->lambda1 * slope - falling);
    }
}

/* The longest step for which the last terms stay at a quarter of an ulp of the motion's own sizes:
 * what is cut off is far below. */
static inline double step_of(const belt *p, const piece *y)
{
    double rate = sqrt(p->stiffness / p->mass);
    double reach = p->normal_force * p->mu0 / p->stiffness + fabs(y->x[0]) + y->w[0] / rate;
    double a = fmax(fabs(y->x[ORDER]), fabs(y->w[ORDER]) / rate) / reach;
    double b = fmax(fabs(y->x[ORDER - 1]), fabs(y->w[ORDER - 1]) / rate) / reach;
    double h = exp2((-54.0 - log2(fmax(a, 1e-300))) / ORDER);
    double k = exp2((-54.0 - log2(fmax(b, 1e-300))) / (ORDER - 1));
    return fmin(fmin(h, k), 2.0 / rate);
}

/* The first zero of |u| in a slip: of the series without the zero with which it began. The step
 * ends early where that tells sooner. */
static inline double stop_of(const motion *m, const piece *y, double *restrict h)
{
    double a[ORDER + 1];
    without_zeros(y->w, m->fresh, a);
    return first_zero_soon(a, h);
}

/* 1 or -1: the sign of a pull, and so the side to which it lets go. */
static inline int side_of(double pull)
{
    if (pull > 0.0)
        return 1;
    return -1;
}

static inline double pull_at(const belt *p, const motion *m, double since, double *restrict slope)
{
    double force = drive(p, m->now, since, slope);
    *slope -= p->stiffness * p->belt;
    return force + p->weight - p->stiffness * (m->x.hi + (m->x.lo + p->belt * since));
}

/* When |P| passes the limit between two times between which P is monotone. */
static inline double passing(const belt *p, const motion *m, double limit, double low, double high)
{
    double slope;
    double side = side_of(pull_at(p, m, high, &slope));
    bracket b = bracketed(low, high);
    for (int i = 0; i < 1200 && open_still(&b); i++) {
        double f = limit - side * pull_at(p, m, b.at, &slope);
        double rate = -side * slope;
        if (i % 8 == 7) /* a half now and then, where Newton's steps creep */
            rate = 0.0;
        narrowed(&b, f, rate);
    }
    return b.high;
}

/* When it is released, since now; infinity if it sticks for ever. */
static inline double release_of(const belt *p, const motion *m)
{
    double limit = p->normal_force * p->mu0;
    double slope;
    double lead = p->stiffness * p->belt;
    double swing = fabs(p->amplitude * p->frequency);
    double first = pull_at(p, m, 0.0, &slope);
    double low = 0.0;
    if (fabs(first) >= limit && first * slope > 0.0)
        return 0.0;
    if (swing <= fabs(lead)) { /* the pull is monotone */
        if (lead == 0.0)       /* and does not change at all */
            return INFINITY;
        double ramp = 2.0 * (limit + fabs(p->amplitude)) / fabs(lead);
        double longest = ramp + 1.0 / fmax(p->frequency, 1.0);
        return passing(p, m, limit, 0.0, longest);
    }
    /* P' = 0 where sin(phase) = -k belt/(F w). */
    double c, s;
    double angle = asin(-lead / (p->amplitude * p->frequency));
    double turn = 2.0 * DD_PI.hi;
    turned(dd_add(dd_scale(m->now, p->frequency), dd_of(p->phase)), &c, &s);
    double begin = atan2(s, c);
    double next[2] = {angle - begin, DD_PI.hi - angle - begin};
    for (int i = 0; i < 2; i++)
        next[i] -= turn * floor(next[i] / turn);
    for (int64_t k = 0; k < MOST_PIECES; k++) {
        /* Two turning points a turn of the drive. */
        double within = fmin(next[0], next[1]);
        if (k % 2 == 1)
            within = fmax(next[0], next[1]);
        double phase = within + turn * (double)(k / 2);
        double high = phase / p->frequency;
        if (fabs(pull_at(p, m, high, &slope)) > limit)
            return passing(p, m, limit, low, high);
        if (lead == 0.0 && k > 2)
            return INFINITY;
        low = high;
    }
    return INFINITY;
}

/* The next stretch of the motion. */
static inline void next_piece(const belt *p, const motion *m, int with_work, piece *restrict y)
{
    if (m->side == 0) {
        memset(y->x, 0, sizeof y->x);
        memset(y->w, 0, sizeof y->w);
        memset(y->work, 0, sizeof y->work);
        memset(y->rate, 0, sizeof y->rate);
        y->x[0] = m->x.hi;
        y->x[1] = p->belt;
        y->work[1] = p->belt * (p->weight - p->stiffness * m->x.hi);
        y->work[2] = -0.5 * p->stiffness * p->belt * p->belt;
        y->end = release_of(p, m);
        y->event = LEAVES;
        return;
    }
    expand(p, m, with_work, y);
    double h = step_of(p, y);
    double stop = stop_of(m, y, &h);
    y->event = 0;
    y->end = h;
    if (stop > 0.0) {
        y->event = STOPS;
        y->end = stop;
    }
}

/* The tangent carried along a slip: dx' = du, m du' = -k dx - N mu'(|u|) du. */
static inline void carried(const belt *p, motion *m, const piece *y)
{
    double a[ORDER + 1], b[ORDER + 1];
    a[0] = m->tangent[0];
    b[0] = m->tangent[1];
    for (int n = 0; n < ORDER; n++) {
        a[n + 1] = b[n] * PART[n + 1];
        b[n + 1] = -(p->stiffness * a[n] + product(y->rate, b, n)) * PART[n + 1] / p->mass;
    }
    m->tangent[0] = value(a, y->end);
    m->tangent[1] = value(b, y->end);
}

/* Moves to the end of a stretch and through its event; returns STICKS + 1 if it comes to stick,
 * LEAVES if it leaves, else 0. */
static inline int pass(const belt *p, motion *m, const piece *y)
{
    if (m->follows && m->side)
        carried(p, m, y);
    m->x = grown(m->x, gained(y->x, y->end));
    m->work = grown(m->work, gained(y->work, y->end));
    m->w = 0.0; /* exactly, at an event */
    if (!y->event)
        m->w = value(y->w, y->end);
    m->now = dd_add(m->now, dd_of(y->end));
    m->fresh = 0;
    if (!y->event)
        return 0;
    double slope;
    double limit = p->normal_force * p->mu0;
    double pull = pull_at(p, m, 0.0, &slope);
    int before = m->side;
    if (y->event == LEAVES) {
        m->side = side_of(pull);
        m->fresh = 2;
        return LEAVES;
    }
    if (fabs(pull) <= limit) {
        m->side = 0;
        m->tangent[1] = 0.0;
        return STOPS;
    }
    m->side = side_of(pull);
    m->fresh = 1;
    m->tangent[1] *= (pull - m->side * limit) / (pull - before * limit);
    return 0;
}

static inline motion begun(const belt *p, double x0, double v0, double t0)
{
    motion m = {.now = dd_of(t0),
                .x = dd_of(x0),
                .work = dd_of(0.0),
                .w = fabs(v0 - p->belt),
                .tangent = {1.0, 0.0}};
    m.swing[0] = p->amplitude;
    for (int n = 1; n < ORDER; n++)
        m.swing[n] = m.swing[n - 1] * p->frequency * PART[n];
    m.side = 0;
    if (v0 > p->belt)
        m.side = 1;
    else if (v0 < p->belt)
        m.side = -1;
    double slope;
    double pull = pull_at(p, &m, 0.0, &slope);
    if (m.side == 0 && fabs(pull) > p->normal_force * p->mu0) {
        m.side = side_of(pull);
        m.fresh = 1;
    }
    return m;
}

#endif
