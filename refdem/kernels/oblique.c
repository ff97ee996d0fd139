/* Two spheres that rub on each other in a plane, by the linear law with a tangential spring: Taylor
 * series of order 20 from event to event.
 *
 * Coordinates: overlap d, its rate g, the transverse relative velocity q (of j from i), the angle
 * of the line of centres, spins, spring s. With D = R - d, o = q/D and the force F = k d + c g
 * along the line, f across it (on i): g' = -q o - F/m, q' = g o - f/m, spin_i' = l_i f/J_i (j
 * alike), slip = l_i spin_i + l_j spin_j - q, l = R - branch d. HOLDS: f = -k_t s, s' = slip.
 * SLIPS: f = -side mu F, the spring as long as that force asks. FREE: f = 0, there is no friction
 * or F pulls. APART: straight on, for ever: nothing brings two spheres back, nor can a force that
 * has ended press again. Coefficients by the recurrences of products and of the quotient (Jorba and
 * Zou 2005, proposition 1). Events are zeros of the series to the last bit; a function that begins
 * at a zero of its own is asked without it. The work lost is the integral of products of these
 * series, which turn twice as fast as the motion: its series has all terms of the products, so that
 * it does not ask for shorter steps.
 */
#include <assert.h>

#include "kernels.h"
#include "series_zeros.h"
#include "simd.h"

enum { HOLDS, SLIPS, FREE, APART, MOST_STRETCHES = 100000 };
enum { D, G, Q, TURN, SPIN_I, SPIN_J, ANGLE_I, ANGLE_J, WORK, STATES };

typedef refdem_oblique_pair pair;
typedef double series[ORDER + 1];

/* A stretch: series of the state but for the work, of the forces along and across, of the slip, of
 * the spring and of the work that is lost; where it ends and the mode after it. */
typedef struct {
    series y[WORK], force, across, slip, spring;
    double work[2 * ORDER + 1];
    double end;
    int next;
} stretch;

/* Now: time, state, spring; side of the slip; how many zeros of the overlap and of the limit it
 * begins with. */
typedef struct {
    double now, y[STATES], spring;
    int mode, side, touch, fresh;
} motion;

/* Products of series of the state: overlap with spins, with the force across and with the turning
 * of the line o; o with q and g. */
typedef struct {
    growing spun, levered, turned, swept, thrown;
} products;

/* Coefficients n of the force, of the slip and of the force across, from those of the state. */
static inline void pressed(const pair *p, const motion *m, stretch *restrict z,
                           products *restrict by, int n)
{
    double d = z->y[D][n];
    double wi = z->y[SPIN_I][n];
    double wj = z->y[SPIN_J][n];
    double spins = wi + wj;
    z->force[n] = p->stiffness * d + p->damping * z->y[G][n];
    z->slip[n] = p->radius_i * wi + p->radius_j * wj - z->y[Q][n]
                 - p->branch * coefficient(&by->spun, d, spins, n);
    z->across[n] = 0.0;
    if (m->mode == HOLDS)
        z->across[n] = -p->tangential_stiffness * z->spring[n];
    else if (m->mode == SLIPS)
        z->across[n] = -m->side * p->friction * z->force[n];
    grow(&by->spun, d, spins, n);
}

/* The integral of the power c g^2 - f slip to the last product of what is known: row by row of the
 * triangle of products, in vectors. */
static inline void spent(const pair *p, const motion *m, stretch *restrict z)
{
    double g[ROOM], slip[ROOM], sum[2 * ROOM];
    double friction = -1.0;
    if (m->mode == FREE)
        friction = 0.0;
    /* Known coefficients, and zeros up to a whole vector. */
    memset(sum, 0, sizeof sum);
    memset(g, 0, sizeof g);
    memset(slip, 0, sizeof slip);
    memcpy(g, z->y[G], sizeof z->y[G]);
    memcpy(slip, z->slip, sizeof z->slip);
    for (int n = 0; n <= ORDER; n++) {
        double a = p->damping * g[n];
        double b = friction * z->across[n];
        for (int k = 0; k <= ORDER; k += LANES)
            for (int i = 0; i < LANES; i++)
                sum[n + k + i] = fma(a, g[k + i], fma(b, slip[k + i], sum[n + k + i]));
    }
    for (int n = 0; n <= 2 * ORDER; n++)
        z->work[n] = sum[n] / (n + 1);
}

static double lost(const stretch *z, double since)
{
    return polynomial(z->work, 2 * ORDER + 1, since) * since;
}

static void expand(const pair *p, const motion *m, stretch *restrict z)
{
    products by;
    double reach = 1.0 / (p->radius_i + p->radius_j - m->y[D]);
    double first = m->y[Q] * reach;
    cleared(&by.spun);
    cleared(&by.levered);
    cleared(&by.turned);
    cleared(&by.swept);
    cleared(&by.thrown);
    for (int i = 0; i < WORK; i++)
        z->y[i][0] = m->y[i];
    z->spring[0] = m->spring;
    for (int n = 0; n < ORDER; n++) {
        pressed(p, m, z, &by, n);
        double part = PART[n + 1];
        double d = z->y[D][n];
        double g = z->y[G][n];
        double q = z->y[Q][n];
        double f = z->across[n];
        double o = first;
        if (n > 0)
            o = (q + fma(d, first, by.turned.sum[n])) * reach;
        double lever = p->branch * coefficient(&by.levered, d, f, n);
        z->y[D][n + 1] = g * part;
        z->y[G][n + 1] = -(coefficient(&by.swept, q, o, n) + p->ease * z->force[n]) * part;
        z->y[Q][n + 1] = (coefficient(&by.thrown, g, o, n) - p->ease * f) * part;
        z->y[SPIN_I][n + 1] = p->turn_ease_i * (p->radius_i * f - lever) * part;
        z->y[SPIN_J][n + 1] = p->turn_ease_j * (p->radius_j * f - lever) * part;
        z->y[TURN][n + 1] = o * part;
        z->y[ANGLE_I][n + 1] = z->y[SPIN_I][n] * part;
        z->y[ANGLE_J][n + 1] = z->y[SPIN_J][n] * part;
        z->spring[n + 1] = z->slip[n] * part;
        grow(&by.levered, d, f, n);
        grow(&by.turned, d, o, n);
        grow(&by.swept, q, o, n);
        grow(&by.thrown, g, o, n);
    }
    pressed(p, m, z, &by, ORDER);
    spent(p, m, z);
}

/* The longest step for which the last terms stay at an ulp of the motion's own sizes: as the terms
 * fall by factorials, what is cut off is far below. */
static double step_of(const pair *p, const stretch *z)
{
    double speed = fabs(z->y[G][0]) + fabs(z->y[Q][0]) + fabs(p->radius_i * z->y[SPIN_I][0])
                   + fabs(p->radius_j * z->y[SPIN_J][0]);
    double rate = sqrt(fmax(p->stiffness, p->tangential_stiffness) * p->ease);
    double h = INFINITY;
    speed += fabs(z->y[D][0]) * rate;
    for (int n = ORDER - 1; n <= ORDER; n++) {
        double last = fmax(fabs(z->y[G][n]), fabs(z->y[Q][n]));
        last = fmax(last,
                    fmax(fabs(p->radius_i * z->y[SPIN_I][n]), fabs(p->radius_j * z->y[SPIN_J][n])));
        h = fmin(h, exp2((-53.0 - log2(fmax(last / speed, 1e-300))) / n));
    }
    return fmin(h, p->longest);
}

/* The first zero of a series that begins with `skip` zeros; the event with the mode that follows is
 * kept if it is the first. The stretch ends early where that tells sooner. */
static void watched(const double *a, int skip, int next, stretch *restrict z)
{
    series b;
    without_zeros(a, skip, b);
    double end = z->end;
    double at = 0.0; /* what begins below zero has passed it */
    if (!(b[0] < 0.0))
        at = first_zero_soon(b, &end);
    if (at >= 0.0 && (at < z->end || z->next < 0)) {
        z->end = at;
        z->next = next;
    } else if (end < z->end) {
        z->end = end;
        z->next = -1;
    }
}

/* The contact ends where its force does, before the overlap: the law has no pull, and a dashpot
 * that would pull. */
static int ends_with_force(const pair *p)
{
    return p->no_pull && p->damping > 0.0;
}

/* Watches what ends a slip, the rate at which the spring would have to grow, or a hold, the
 * spring's longest. */
static void rubbing(const pair *p, const motion *m, stretch *restrict z)
{
    series a;
    double share = p->friction / p->tangential_stiffness;
    if (m->mode == SLIPS) {
        for (int n = 0; n < ORDER; n++)
            a[n] = m->side * z->slip[n] - share * (n + 1) * z->force[n + 1];
        a[ORDER] = 0.0;
        watched(a, 0, HOLDS, z);
    }
    if (m->mode != HOLDS)
        return;
    for (int side = -1; side <= 1; side += 2) {
        int skip = 0;
        if (m->fresh == 1) /* pressed just now: both limits begin at zero */
            skip = 1;
        else if (side == m->side) /* held just now: the limit that it came from */
            skip = m->fresh;
        for (int n = 0; n <= ORDER; n++)
            a[n] = share * z->force[n] - side * z->spring[n];
        watched(a, skip, SLIPS, z);
    }
}

static void next_stretch(const pair *p, const motion *m, stretch *restrict z)
{
    expand(p, m, z);
    z->end = step_of(p, z);
    z->next = -1;
    if (ends_with_force(p))
        watched(z->force, 0, APART, z);
    else
        watched(z->y[D], m->touch, APART, z);
    /* A force that pulls does not rub. */
    int may_pull = !ends_with_force(p) && p->damping > 0.0;
    if (p->friction > 0.0 && may_pull && m->mode != FREE)
        watched(z->force, 0, FREE, z);
    if (m->mode != FREE)
        rubbing(p, m, z);
}

/* Straight on: the line of centres turns, spins stay. */
static void apart(const pair *p, const motion *m, double since, double *restrict y)
{
    double reach = p->radius_i + p->radius_j - m->y[D];
    double along = reach - m->y[G] * since;
    double across = m->y[Q] * since;
    double distance = hypot(along, across);
    memcpy(y, m->y, STATES * sizeof *y);
    y[D] = p->radius_i + p->radius_j - distance;
    y[G] = -(along * -m->y[G] + across * m->y[Q]) / distance;
    y[Q] = (along * m->y[Q] + across * m->y[G]) / distance;
    y[TURN] += atan2(across, along);
    y[ANGLE_I] += y[SPIN_I] * since;
    y[ANGLE_J] += y[SPIN_J] * since;
}

static void at(const pair *p, const motion *m, const stretch *z, double since, double *restrict y)
{
    if (m->mode == APART) {
        apart(p, m, since, y);
        return;
    }
    for (int i = 0; i < WORK; i++)
        y[i] = m->y[i] + gained(z->y[i], since);
    y[WORK] = m->y[WORK] + lost(z, since);
}

static int side_of(double value)
{
    if (value > 0.0)
        return 1;
    return -1;
}

/* What springs hold and do not give back: the tangential one, and the normal one once the force has
 * ended. */
static double held(const pair *p, const motion *m, const double *restrict y, double spring)
{
    double force = p->stiffness * y[D] + p->damping * y[G];
    double left = fmax(y[D], 0.0);
    if (m->mode == APART)
        return 0.5 * p->stiffness * left * left;
    double bent = 0.0;
    if (m->mode == HOLDS)
        bent = spring;
    else if (m->mode == SLIPS)
        bent = p->friction * force / p->tangential_stiffness;
    return 0.5 * p->tangential_stiffness * bent * bent;
}

/* Moves to the end of a stretch and through its event. */
static void pass(const pair *p, motion *m, const stretch *z)
{
    double y[STATES];
    double share = 0.0;
    if (p->tangential_stiffness > 0.0)
        share = p->friction / p->tangential_stiffness;
    at(p, m, z, z->end, y);
    double spring = z->spring[0] + gained(z->spring, z->end);
    memcpy(m->y, y, sizeof y);
    m->now += z->end;
    m->spring = spring;
    m->touch = 0;
    m->fresh = 0;
    if (z->next < 0)
        return;
    if (z->next == SLIPS)
        m->side = side_of(spring);
    if (z->next == HOLDS) {
        m->spring = m->side * share * (p->stiffness * y[D] + p->damping * y[G]);
        m->fresh = 2;
    }
    if (z->next == APART && !ends_with_force(p))
        m->y[D] = 0.0;
    m->mode = z->next;
}

/* Touching, or pressed with the spring at rest. */
static motion begun(const pair *p, const double *start)
{
    motion m = {.touch = start[D] <= 0.0, .fresh = start[D] <= 0.0 && p->damping == 0.0};
    memcpy(m.y, start, 6 * sizeof *start);
    m.y[D] = fmax(m.y[D], 0.0);
    double force = p->stiffness * m.y[D] + p->damping * m.y[G];
    double limit = INFINITY; /* a spring that is pressed holds what it has */
    if (m.fresh)             /* a touch: the limit grows with the force */
        limit = p->stiffness * m.y[G];
    double slip = (p->radius_i - p->branch * m.y[D]) * m.y[SPIN_I]
                  + (p->radius_j - p->branch * m.y[D]) * m.y[SPIN_J] - m.y[Q];
    m.side = side_of(slip);
    m.mode = HOLDS;
    if (fabs(slip) * p->tangential_stiffness > p->friction * limit)
        m.mode = SLIPS;
    if (p->friction == 0.0 || force < 0.0) /* what pulls does not rub */
        m.mode = FREE;
    return m;
}

REFDEM_EVERY_CPU
int64_t refdem_oblique(const refdem_oblique_pair *p, const double *start, int64_t samples,
                       const double *t, double *release, double *out)
{
    assert(samples >= 1 && release && out);
    stretch z;
    motion m = begun(p, start);
    int64_t row = 0;
    *release = INFINITY;
    for (int64_t k = 0; k < MOST_STRETCHES && row < samples; k++) {
        z.end = INFINITY;
        if (m.mode != APART)
            next_stretch(p, &m, &z);
        for (; row < samples && t[row] - m.now <= z.end; row++, out += 12) {
            double since = t[row] - m.now;
            double spring = 0.0;
            at(p, &m, &z, since, out);
            out[9] = 0.0;
            out[10] = 0.0;
            if (m.mode != APART) { /* they press */
                out[9] = 1.0;
                out[10] = p->stiffness * out[D] + p->damping * out[G];
                spring = z.spring[0] + gained(z.spring, since);
            }
            out[11] = out[WORK] - held(p, &m, out, spring);
        }
        if (row == samples)
            break;
        pass(p, &m, &z);
        if (m.mode == APART) {
            *release = m.now;
            m.y[WORK] += 0.5 * p->stiffness * m.y[D] * m.y[D];
        }
    }
    return row;
}
