/* A point on a spring that rubs on a moving belt and is driven:
 *   m x'' in P(t, x) - N mu(|u|) Sgn(u),   P = F cos(w t + phase) + weight - k x,   u = x' - belt,
 *   mu(s) = (mu0 - mu1) q(s) + mu1 + lambda1 s^2 (or lambda1 s),   q(s) = 1/(1 + lambda0 s).
 *
 * While it slips: Taylor series of order 20 in x and s = |u|, by the recurrences of products and of
 * the quotient (Jorba and Zou 2005, proposition 1), the step such that they end at round-off. It
 * stops at the first zero of the series of |u|, to the last bit (series_zeros.h). While it sticks,
 * |P| <= N mu0; the release is found between turning points of P, which are known in closed form
 * and between which P is monotone. A slip begins with u = 0 and, after sticking, u' = 0, exactly.
 *
 * Phases: begin, expand, step_size, locate, accept, change_mode; samples are read in stick_slip.c.
 */
#ifndef REFDEM_BELT_H
#define REFDEM_BELT_H

#include "double_double.h"
#include "kernels.h"
#include "series_zeros.h"

/* Events: the point sticks, or is released. Largest number of turning points of the pull examined.
 */
enum { STOPS = 1, LEAVES = 2, MOST_PIECES = 1 << 30 };

typedef refdem_belt belt;

/* A segment of the motion: series of x, of |u|, of the work done against friction and drive and of
 * the rate N mu'(|u|) of the friction with the slip speed; the duration [s]; and the event at its
 * end, 0 for none. */
typedef struct {
    double x[ORDER + 1], w[ORDER + 1], work[ORDER + 1], rate[ORDER + 1], end;
    int event;
} segment;

/* The motion now: time [s], x [m] and work [J] in double-double, w = |u| [m/s]; side is the sign of
 * u, 0 while it sticks; zero_order is the order of the zero of u with which a slip began.
 * has_tangent: a tangent (dx, du) is integrated too. drive_terms: the coefficients F w^n/n! of the
 * drive. */
typedef struct {
    dd now, x, work;
    double w, tangent[2], drive_terms[ORDER];
    int side, zero_order, has_tangent;
} motion;

/* from + by in double-double, |by| small against from. */
static inline dd add_small(dd from, double by)
{
    dd sum = two_sum(from.hi, by);
    return quick_two_sum(sum.hi, sum.lo + from.lo);
}

/* 1 or -1: the sign of a pull, and of the slip that it starts. */
static inline int sign_of(double pull)
{
    if (pull > 0.0)
        return 1;
    return -1;
}

/* The drive F cos(w t + phase) [N] and its slope [N/s] at `since` after now. */
static inline double drive_at(const belt *p, dd now, double since, double *restrict slope)
{
    double cosine, sine;
    /* F cos(w (now + since) + phase), with the rate -F w sin(w (now + since) + phase). */
    turned(dd_add(dd_scale(dd_add(now, dd_of(since)), p->frequency), dd_of(p->phase)), &cosine,
           &sine);
    *slope = -p->amplitude * p->frequency * sine;
    return p->amplitude * cosine;
}

/* The pull P(t, x) [N] and its slope while x moves with the belt, at `since` after now. */
static inline double pull_at(const belt *p, const motion *m, double since, double *restrict slope)
{
    double force = drive_at(p, m->now, since, slope);
    /* P = F cos(w t + phase) + weight - k x with x = x_now + belt since, so that
     * P' = -F w sin(w t + phase) - k belt. */
    *slope -= p->stiffness * p->belt;
    return force + p->weight - p->stiffness * (m->x.hi + (m->x.lo + p->belt * since));
}

/* The motion at the start, from x0 [m] and v0 [m/s] at t0 [s]; at rest on the belt it sticks unless
 * |P| > N mu0. */
static inline motion begin(const belt *p, double x0, double v0, double t0)
{
    motion m = {.now = dd_of(t0),
                .x = dd_of(x0),
                .work = dd_of(0.0),
                .w = fabs(v0 - p->belt),
                .tangent = {1.0, 0.0}};
    /* F w^n/n!: the n-th Taylor coefficient of the drive but for the derivative of the cosine. */
    m.drive_terms[0] = p->amplitude;
    for (int n = 1; n < ORDER; n++)
        m.drive_terms[n] = m.drive_terms[n - 1] * p->frequency * INVERSE[n];
    m.side = 0;
    if (v0 > p->belt)
        m.side = 1;
    else if (v0 < p->belt)
        m.side = -1;
    double slope;
    double pull = pull_at(p, &m, 0.0, &slope);
    if (m.side == 0 && fabs(pull) > p->normal_force * p->mu0) {
        m.side = sign_of(pull);
        m.zero_order = 1;
    }
    return m;
}

/* Taylor coefficients of the drive about now: `drive_terms` times the n-th derivative of cos, which
 * is cos, -sin, -cos, sin, cos, ... at the angle of the drive. */
static inline void expand_drive(const belt *p, const motion *m, double *restrict force)
{
    double c, s;
    turned(dd_add(dd_scale(m->now, p->frequency), dd_of(p->phase)), &c, &s);
    double turn[LANES] = {c, -s, -c, s};
    for (int n = 0; n < ORDER; n += LANES)
        for (int i = 0; i < LANES; i++)
            force[n + i] = m->drive_terms[n + i] * turn[i];
}

/* The series of a slip to m->side. With s = |u| = side u:
 *   x' = side s + belt,   m s' = side P - N (mu0 - mu1) q - N mu1 - N lambda1 s^2,
 *   q (1 + lambda0 s) = 1,  so that  q_n = -q_0 lambda0 (sum over k >= 1 of s_k q_(n-k)),
 * and the power lost is (side N mu - F cos) x'. Each coefficient of s depends on the one before:
 * the latency of this chain is the cost of an expansion. The products are arranged so that few
 * operations follow each other in it. */
static inline void expand_slip(const belt *p, const motion *m, int with_work, segment *restrict y)
{
    double force[ORDER], q[ORDER];
    double side = m->side;
    double n_falling = p->normal_force * (p->mu0 - p->mu1);
    double n_lambda1 = p->normal_force * p->lambda1;
    running_product w_q, w_w, power_v;
    clear(&w_q);
    clear(&w_w);
    if (with_work)
        clear(&power_v);
    expand_drive(p, m, force);
    y->x[0] = m->x.hi;
    y->w[0] = m->w;
    y->work[0] = 0.0;
    double q_0 = 1.0 / (1.0 + p->lambda0 * m->w);
    double minus_q0_lambda0 = -q_0 * p->lambda0;
    double inverse_mass = 1.0 / p->mass;
#pragma GCC unroll 32
    for (int n = 0; n < ORDER; n++) {
        double w = y->w[n];
        double inverse = INVERSE[n + 1];
        /* What is constant in time has a coefficient of order 0 only. */
        double belt_speed = 0.0;
        double weight = 0.0;
        double n_mu1 = 0.0;
        if (n == 0) {
            belt_speed = p->belt;
            weight = p->weight;
            n_mu1 = p->normal_force * p->mu1;
        }
        double v = side * w + belt_speed;
        double w2 = w;
        if (!p->linear)
            w2 = coefficient(&w_w, w, w, n);
        double pull = force[n] + weight - p->stiffness * y->x[n];
        /* q_n = -q_0 lambda0 (s_n q_0 + sum of s_k q_(n-k) over 0 < k < n). */
        q[n] = q_0;
        if (n > 0)
            q[n] = fma(w, minus_q0_lambda0 * q_0, minus_q0_lambda0 * w_q.sum[n]);
        /* (n + 1) x_(n+1) = v_n,
         * (n + 1) m s_(n+1) = side P_n - N mu1 [n = 0] - N lambda1 (s^2)_n - N (mu0 - mu1) q_n. */
        y->x[n + 1] = v * inverse;
        y->w[n + 1] = fma(-n_falling * inverse_mass * inverse, q[n],
                          inverse_mass * inverse * (side * pull - n_mu1 - n_lambda1 * w2));
        if (n == 0 && m->zero_order == 2) /* released from sticking: u' begins at 0, exactly */
            y->w[1] = 0.0;
        take_in(&w_q, w, q[n], n);
        if (!p->linear)
            take_in(&w_w, w, w, n);
        if (with_work) {
            double power_lost = side * (fma(n_falling, q[n], n_lambda1 * w2) + n_mu1) - force[n];
            y->work[n + 1] = coefficient(&power_v, power_lost, v, n) * inverse;
            take_in(&power_v, power_lost, v, n);
        }
    }
    if (!m->has_tangent) /* only a tangent needs the slope of the friction */
        return;
    /* N mu'(s) = N (2 lambda1 s - (mu0 - mu1) lambda0 q^2) as q' = -lambda0 q^2; of the linear law
     * the first term is lambda1. */
    for (int n = 0; n < ORDER; n++) {
        double growing_slope = 2.0 * y->w[n];
        if (p->linear)
            growing_slope = n == 0;
        double falling_slope = (p->mu0 - p->mu1) * p->lambda0 * square(q, n);
        y->rate[n] = p->normal_force * (p->lambda1 * growing_slope - falling_slope);
    }
}

/* The series of a stick: x moves with the belt, x = x0 + belt s, and the work against the holding
 * force, less that of the drive, has the rate belt (weight - k x). */
static inline void expand_stick(const belt *p, const motion *m, segment *restrict y)
{
    memset(y->x, 0, sizeof y->x);
    memset(y->w, 0, sizeof y->w);
    memset(y->work, 0, sizeof y->work);
    memset(y->rate, 0, sizeof y->rate);
    y->x[0] = m->x.hi;
    y->x[1] = p->belt;
    y->work[1] = p->belt * (p->weight - p->stiffness * m->x.hi);
    y->work[2] = -0.5 * p->stiffness * p->belt * p->belt;
}

/* The longest step h for which the last two terms of the series do not exceed 2^-54, a quarter of
 * an ulp, relative to the length L of the motion:
 *
 *   h = min over n = ORDER - 1, ORDER of (2^-54 L/|a_n|)^(1/n),   at most 2/w0,
 *   L = N mu0/k + |x| + |u|/w0,   a_n = max(|x_n|, |s_n|/w0),   w0 = sqrt(k/m).
 *
 * The truncation error is much smaller. */
static inline double step_size(const belt *p, const segment *y)
{
    double frequency = sqrt(p->stiffness / p->mass);
    double length = p->normal_force * p->mu0 / p->stiffness + fabs(y->x[0]) + y->w[0] / frequency;
    double last = fmax(fabs(y->x[ORDER]), fabs(y->w[ORDER]) / frequency) / length;
    double last_but_one = fmax(fabs(y->x[ORDER - 1]), fabs(y->w[ORDER - 1]) / frequency) / length;
    double step_last = exp2((-54.0 - log2(fmax(last, 1e-300))) / ORDER);
    double step_last_but_one = exp2((-54.0 - log2(fmax(last_but_one, 1e-300))) / (ORDER - 1));
    return fmin(fmin(step_last, step_last_but_one), 2.0 / frequency);
}

/* The time [s] at which the slip stops: the first zero of |u| after the one with which it began, or
 * -1 if there is none within h. The step h is shortened where the bounds on the series decide this
 * on a part of it only. */
static inline double stop_time(const motion *m, const segment *y, double *restrict h)
{
    double a[ORDER + 1];
    divide_by_power(y->w, m->zero_order, a);
    return first_zero_soon(a, h);
}

/* The time since now [s] at which |P| exceeds the limit N mu0: the zero of limit - side P, with the
 * sign `side` of P at `high`. P is monotone between `low` and `high`. */
static inline double limit_time(const belt *p, const motion *m, double limit, double low,
                                double high)
{
    double slope;
    double side = sign_of(pull_at(p, m, high, &slope));
    bracket b = bracketed(low, high);
    for (int i = 0; i < 1200 && is_open(&b); i++) {
        double left = limit - side * pull_at(p, m, b.at, &slope);
        double left_rate = -side * slope;
        if (i % 8 == 7) /* every eighth step is a bisection, in case Newton's steps creep */
            left_rate = 0.0;
        narrow(&b, left, left_rate);
    }
    return b.high;
}

/* The time from now until the release [s], or infinity if the point sticks for ever. The pull has
 * the rate P' = -F w sin(w t + phase) - k belt. */
static inline double release_time(const belt *p, const motion *m)
{
    double limit = p->normal_force * p->mu0;
    double slope;
    double belt_rate = p->stiffness * p->belt;
    double swing = fabs(p->amplitude * p->frequency);
    double pull_now = pull_at(p, m, 0.0, &slope);
    double low = 0.0;
    if (fabs(pull_now) >= limit && pull_now * slope > 0.0) /* at the limit, and growing */
        return 0.0;
    if (swing <= fabs(belt_rate)) { /* the pull is monotone */
        if (belt_rate == 0.0)       /* and does not change at all */
            return INFINITY;
        /* k |belt| t > 2 (limit + F), of which the drive compensates at most 2 F: by then P has
         * changed by more than 2 limit, and |P| has passed the limit. */
        double ramp = 2.0 * (limit + fabs(p->amplitude)) / fabs(belt_rate);
        double longest = ramp + 1.0 / fmax(p->frequency, 1.0);
        return limit_time(p, m, limit, 0.0, longest);
    }
    /* P' = 0 where sin(w t + phase) = -k belt/(F w): at two phases of every period. */
    double c, s;
    double arcsine = asin(-belt_rate / (p->amplitude * p->frequency));
    double period = 2.0 * DD_PI.hi;
    turned(dd_add(dd_scale(m->now, p->frequency), dd_of(p->phase)), &c, &s);
    double phase_now = atan2(s, c);
    double turning_phase[2] = {arcsine - phase_now, DD_PI.hi - arcsine - phase_now};
    for (int i = 0; i < 2; i++)
        turning_phase[i] -= period * floor(turning_phase[i] / period);
    for (int64_t k = 0; k < MOST_PIECES; k++) {
        /* There are two turning points of P in a period of the drive. */
        double within = fmin(turning_phase[0], turning_phase[1]);
        if (k % 2 == 1)
            within = fmax(turning_phase[0], turning_phase[1]);
        double phase_there = within + period * (double)(k / 2);
        double high = phase_there / p->frequency;
        if (fabs(pull_at(p, m, high, &slope)) > limit)
            return limit_time(p, m, limit, low, high);
        if (belt_rate == 0.0 && k > 2) /* the belt stands still: every period is the same */
            return INFINITY;
        low = high;
    }
    return INFINITY;
}

/* The series of the next segment. */
static inline void expand(const belt *p, const motion *m, int with_work, segment *restrict y)
{
    if (m->side == 0)
        expand_stick(p, m, y);
    else
        expand_slip(p, m, with_work, y);
}

/* The end of the segment: the first event, or the step. */
static inline void locate(const belt *p, const motion *m, segment *restrict y)
{
    if (m->side == 0) { /* it sticks until it is released */
        y->end = release_time(p, m);
        y->event = LEAVES;
        return;
    }
    double h = step_size(p, y);
    double stop = stop_time(m, y, &h);
    y->event = 0;
    y->end = h;
    if (stop > 0.0) {
        y->event = STOPS;
        y->end = stop;
    }
}

/* Carries the tangent (dx, du) through a slip: dx' = du, m du' = -k dx - N mu'(|u|) du. */
static inline void carry_tangent(const belt *p, motion *m, const segment *y)
{
    double dx[ORDER + 1], du[ORDER + 1];
    dx[0] = m->tangent[0];
    du[0] = m->tangent[1];
    for (int n = 0; n < ORDER; n++) {
        dx[n + 1] = du[n] * INVERSE[n + 1];
        du[n + 1] = -(p->stiffness * dx[n] + product(y->rate, du, n)) * INVERSE[n + 1] / p->mass;
    }
    m->tangent[0] = value(dx, y->end);
    m->tangent[1] = value(du, y->end);
}

/* Makes the end of the segment the state: x += x(end) - x(0), and the same for the work. */
static inline void accept(const belt *p, motion *m, const segment *y)
{
    if (m->has_tangent && m->side)
        carry_tangent(p, m, y);
    m->x = add_small(m->x, gained(y->x, y->end));
    m->work = add_small(m->work, gained(y->work, y->end));
    m->w = 0.0; /* exactly, at an event */
    if (!y->event)
        m->w = value(y->w, y->end);
    m->now = dd_add(m->now, dd_of(y->end));
    m->zero_order = 0;
}

/* Goes through the event that ended the segment. Returns STOPS if the point comes to stick, LEAVES
 * if it is released, 0 if there was none or the slip goes on to the other side. */
static inline int change_mode(const belt *p, motion *m, const segment *y)
{
    if (!y->event) /* a step without an event */
        return 0;
    double slope;
    double limit = p->normal_force * p->mu0;
    double pull = pull_at(p, m, 0.0, &slope);
    int before = m->side;
    if (y->event == LEAVES) {
        m->side = sign_of(pull);
        m->zero_order = 2;
        return LEAVES;
    }
    if (fabs(pull) <= limit) { /* the limit of static friction holds it: it moves with the belt */
        m->side = 0;
        m->tangent[1] = 0.0;
        return STOPS;
    }
    /* It continues to slip with the other sign, and m u' = P - side N mu0 jumps. A tangent shifts
     * the time of the event by dt* = -du/u'_before, so that
     *   du_after = du + (u'_before - u'_after) dt* = du u'_after/u'_before,
     * while dx is continuous, since x' is. */
    m->side = sign_of(pull);
    m->zero_order = 1;
    m->tangent[1] *= (pull - m->side * limit) / (pull - before * limit);
    return 0;
}

#endif
