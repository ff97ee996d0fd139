/* A convex body whose corners press on a plane, from event to event: Taylor series of order 20 in
 * body axes.
 *
 * q' = q w/2, J w' = (J w) x w + sum c x F, V' = V x w + R^T g + sum F/m, r' = R V with V = R^T v.
 * A corner c of depth d = -n.(r + R c) and velocity u presses with N = k d + c d', rubs with
 * friction N against its slip along the plane, and stops where N would pull (cutoff zero_force); it
 * then idles until it leaves or presses again. The last coordinate is the work that is lost.
 */
#include <assert.h>

#include "kernels.h"
#include "double_double.h"
#include "series_zeros.h"

enum { STATES = 14, MOST_CORNERS = 32, OFF = 0, PRESSES = 1, IDLES = 2 };
typedef double line[ORDER + 1];

/* exp(-2) of the radius of convergence: what is cut off is exp(-40), Jorba and Zou 2005. */
static const double STEP_PART = 0.1353352832366127;
/* Part of the interval of the samples: where steps are shorter a slip has come to an end. */
static const double SHORTEST = 1e-10;

typedef struct {
    line gap, push, closing, square, inverse, rub, slip[3], speed[3], force[3];
    int mode, fresh;
} corner;

typedef struct {
    const refdem_tumbling_body *given;
    line y[STATES], turned[3][3], normal[3];
    double low[STATES];
    corner at[MOST_CORNERS];
} motion;

static double triple(line *a, line *b, int k)
{
    return product(a[0], b[0], k) + product(a[1], b[1], k) + product(a[2], b[2], k);
}

/* Coefficient k of R, and of the normal in body axes. */
static void turn(motion *m, int k)
{
    double w[4][4];
    for (int i = 0; i < 4; i++)
        for (int j = i; j < 4; j++)
            w[i][j] = product(m->y[i], m->y[j], k);
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3;
        int l = (i + 2) % 3;
        int low = j + 1; /* w has its upper half only */
        int high = l + 1;
        if (j > l) {
            low = l + 1;
            high = j + 1;
        }
        double across = 2.0 * w[low][high];
        double side = 2.0 * w[0][i + 1];
        m->turned[i][i][k] = w[0][0] + w[i + 1][i + 1] - w[j + 1][j + 1] - w[l + 1][l + 1];
        m->turned[j][l][k] = across - side;
        m->turned[l][j][k] = across + side;
    }
    const double *n = m->given->plane + 3;
    for (int j = 0; j < 3; j++)
        m->normal[j][k]
            = n[0] * m->turned[0][j][k] + n[1] * m->turned[1][j][k] + n[2] * m->turned[2][j][k];
}

/* Coefficient k of a series to the power -1/2. */
static double inverse_root(const double *a, const double *power, int k)
{
    double sum = 0.0;
    if (k == 0)
        return 1.0 / sqrt(a[0]);
    for (int i = 1; i <= k; i++)
        sum += (0.5 * i - k) * a[i] * power[k - i];
    return sum * PART[k] / a[0];
}

static double height(const motion *m, const double *c, int k)
{
    const double *point = m->given->plane;
    const double *n = point + 3;
    double sum = 0.0;
    if (k == 0) /* the plane stays where it is */
        sum = -(n[0] * point[0] + n[1] * point[1] + n[2] * point[2]);
    for (int i = 0; i < 3; i++)
        sum += n[i] * m->y[10 + i][k] + m->normal[i][k] * c[i];
    return sum;
}

/* Coefficient k of friction on a corner that presses, added to its force. */
static void rub(motion *m, corner *at, int k)
{
    for (int i = 0; i < 3; i++)
        at->slip[i][k] = at->speed[i][k] + product(m->normal[i], at->closing, k);
    at->square[k] = triple(at->slip, at->slip, k);
    at->inverse[k] = inverse_root(at->square, at->inverse, k);
    at->rub[k] = m->given->friction * product(at->push, at->inverse, k);
    for (int i = 0; i < 3; i++)
        at->force[i][k] -= product(at->rub, at->slip[i], k);
}

/* Coefficient k of gap, push and force of a corner; returns that of the power that is lost. */
static double touch(motion *m, int number, int k)
{
    const refdem_tumbling_body *p = m->given;
    const double *c = p->corner + 3 * number;
    corner *at = &m->at[number];
    line *omega = m->y + 4;
    line *velocity = m->y + 7;
    at->gap[k] = height(m, c, k);
    if (at->mode == OFF)
        return 0.0;
    for (int i = 0; i < 3; i++) {
        int j = (i + 1) % 3;
        int l = (i + 2) % 3;
        at->speed[i][k] = velocity[i][k] + omega[j][k] * c[l] - omega[l][k] * c[j];
    }
    at->closing[k] = -triple(m->normal, at->speed, k);
    at->push[k] = -p->stiffness * at->gap[k] + p->damping * at->closing[k];
    if (at->mode == IDLES)
        return p->stiffness * product(at->gap, at->closing, k);
    for (int i = 0; i < 3; i++)
        at->force[i][k] = product(at->push, m->normal[i], k);
    double lost = p->damping * product(at->closing, at->closing, k);
    if (p->friction > 0.0) {
        rub(m, at, k);
        lost += product(at->rub, at->square, k);
    }
    return lost;
}

/* Coefficients of the whole state. */
static void expand(motion *m)
{
    const refdem_tumbling_body *p = m->given;
    line *q = m->y;
    line *w = m->y + 4;
    line *v = m->y + 7;
    line *r = m->y + 10;
    for (int k = 0; k < ORDER; k++) {
        double force[3] = {0.0};
        double torque[3] = {0.0};
        double lost = 0.0;
        double part = PART[k + 1];
        turn(m, k);
        for (int number = 0; number < p->corners; number++) {
            corner *at = &m->at[number];
            const double *c = p->corner + 3 * number;
            lost += touch(m, number, k);
            if (at->mode != PRESSES)
                continue;
            for (int i = 0; i < 3; i++) {
                int j = (i + 1) % 3;
                int l = (i + 2) % 3;
                force[i] += at->force[i][k];
                torque[i] += c[j] * at->force[l][k] - c[l] * at->force[j][k];
            }
        }
        q[0][k + 1] = -0.5 * part * triple(q + 1, w, k);
        for (int i = 0; i < 3; i++) {
            int j = (i + 1) % 3;
            int l = (i + 2) % 3;
            double fall = 0.0;
            double turning = (p->inertia[j] - p->inertia[l]) * product(w[j], w[l], k) + torque[i];
            for (int a = 0; a < 3; a++)
                fall += p->gravity[a] * m->turned[a][i][k];
            q[i + 1][k + 1] = 0.5 * part
                              * (product(q[0], w[i], k) + product(q[j + 1], w[l], k)
                                 - product(q[l + 1], w[j], k));
            w[i][k + 1] = part * turning / p->inertia[i];
            v[i][k + 1]
                = part
                  * (product(v[j], w[l], k) - product(v[l], w[j], k) + fall + force[i] / p->mass);
            r[i][k + 1] = part * triple(m->turned[i], v, k);
        }
        m->y[13][k + 1] = part * lost;
    }
    turn(m, ORDER);
    for (int number = 0; number < p->corners; number++)
        touch(m, number, ORDER);
}

/* The step for the radius of convergence that the last terms of attitude, omega and velocity show.
 */
static double step(const motion *m)
{
    static const int begins[4] = {0, 4, 7, 10};
    double radius = INFINITY;
    for (int k = ORDER - 1; k <= ORDER; k++) {
        double worst = 0.0;
        for (int block = 0; block < 3; block++) {
            double size = 0.0;
            double term = 0.0;
            for (int i = begins[block]; i < begins[block + 1]; i++) {
                size = fmax(size, fabs(m->y[i][0]));
                term = fmax(term, fabs(m->y[i][k]));
            }
            if (size > 0.0) /* what is at rest has no scale */
                worst = fmax(worst, term / size);
        }
        if (worst > 0.0)
            radius = fmin(radius, pow(worst, -1.0 / k));
    }
    return radius * STEP_PART;
}

/* When a guard, a series or its negative, first falls through zero in (0, h]; -1 if it does not.
 * One that is fresh starts at zero. */
static double falls(const double *a, double sign, int fresh, double h)
{
    line b;
    for (int k = 0; k <= ORDER; k++)
        b[k] = sign * a[k];
    if (fresh)
        b[0] = 0.0;
    else if (b[0] <= 0.0 && b[1] < 0.0)
        return 0.0;
    return first_zero(b, h);
}

enum { NONE = 0, GAP = 1, PUSH = 2 };

/* The first event in (0, h]: its time, which corner and which guard. */
static double first_event(motion *m, double h, int *which, int *guard)
{
    *guard = NONE;
    for (int number = 0; number < m->given->corners; number++) {
        corner *at = &m->at[number];
        for (int kind = GAP; kind <= PUSH; kind++) {
            if ((kind == GAP && at->mode == PRESSES) || (kind == PUSH && at->mode == OFF))
                continue;
            const double *series = at->push;
            if (kind == GAP)
                series = at->gap;
            double sign = 1.0;
            if (at->mode == IDLES) /* both are below zero: it leaves, or presses, as they rise */
                sign = -1.0;
            double when = falls(series, sign, at->fresh == kind, h);
            if (when >= 0.0 && (when < h || *guard == NONE)) {
                h = when;
                *which = number;
                *guard = kind;
            }
        }
    }
    return h;
}

/* Touch, release, leave, press: the new mode and the guard that is zero in it. */
static void switched(motion *m, corner *at, int guard)
{
    int damped = m->given->damping > 0.0;
    int before = at->mode;
    if (before == OFF || (before == IDLES && guard == PUSH)) {
        at->mode = PRESSES;
        at->fresh = PUSH;
        if (before == OFF && damped) /* a dashpot pushes from the first touch */
            at->fresh = NONE;
        return;
    }
    if (before == PRESSES && damped) { /* it overlaps still */
        at->mode = IDLES;
        at->fresh = PUSH;
        return;
    }
    at->mode = OFF;
    at->fresh = GAP;
}

static void advance(motion *m, double h)
{
    for (int i = 0; i < STATES; i++) {
        dd sum = two_sum(m->y[i][0], m->low[i] + gained(m->y[i], h));
        m->y[i][0] = sum.hi;
        m->low[i] = sum.lo;
    }
    if (!(h > 0.0)) /* two events at one time: what began at zero is there still */
        return;
    for (int number = 0; number < m->given->corners; number++)
        m->at[number].fresh = NONE;
}

/* The state, how many corners touch, the largest depth and the largest push, `since` after the
 * begin of the step. */
static void record(const motion *m, double since, double *out, double *channel)
{
    memset(channel, 0, 3 * sizeof *channel);
    for (int i = 0; i < STATES; i++)
        out[i] = m->y[i][0] + (m->low[i] + gained(m->y[i], since));
    for (int number = 0; number < m->given->corners; number++) {
        const corner *at = &m->at[number];
        if (at->mode == OFF)
            continue;
        channel[0] += 1.0;
        channel[1] = fmax(channel[1], -value(at->gap, since));
        if (at->mode == PRESSES)
            channel[2] = fmax(channel[2], value(at->push, since));
    }
}

/* Modes of the start: what is in the plane presses if it would push. */
static void begin(motion *m, const double *start)
{
    for (int i = 0; i < STATES; i++) {
        m->y[i][0] = start[i];
        m->low[i] = 0.0;
    }
    turn(m, 0);
    for (int number = 0; number < m->given->corners; number++) {
        corner *at = &m->at[number];
        at->mode = IDLES;
        at->fresh = NONE;
        touch(m, number, 0);
        if (at->gap[0] > 0.0)
            at->mode = OFF;
        else if (at->push[0] > 0.0)
            at->mode = PRESSES;
    }
}

int64_t refdem_tumbling_body_run(const refdem_tumbling_body *given, int64_t samples,
                                 const double *t, int64_t most, double *event, double *channel,
                                 double *out)
{
    assert(given->corners >= 1 && given->corners <= MOST_CORNERS);
    assert(samples >= 1 && event && channel && out);
    assert(t[samples - 1] >= t[0]); /* events are looked for forward only */
    motion m = {.given = given};
    int64_t k = 1;
    int64_t events = 0;
    dd now = dd_of(t[0]);
    begin(&m, out);
    expand(&m);
    record(&m, 0.0, out, channel);
    while (k < samples) {
        int which = 0;
        int guard = NONE;
        double h = step(&m);
        if (!(h > SHORTEST * (t[1] - t[0])))
            return -k;
        h = first_event(&m, fmin(h, t[samples - 1] - t[0]), &which, &guard);
        for (; k < samples && dd_round(dd_sub(dd_of(t[k]), now)) <= h; k++)
            record(&m, dd_round(dd_sub(dd_of(t[k]), now)), out + k * STATES, channel + 3 * k);
        advance(&m, h);
        now = dd_add(now, dd_of(h));
        if (guard != NONE) {
            if (events < most) {
                double *row = event + 3 * events;
                row[0] = dd_round(now);
                row[1] = m.at[which].mode;
                row[2] = which;
            }
            events++;
            switched(&m, &m.at[which], guard);
        }
        expand(&m);
    }
    if (events > most) /* those that were told */
        return most;
    return events;
}
