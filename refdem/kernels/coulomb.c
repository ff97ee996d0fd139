/* The mass on a spring with dry friction: m x'' + f Sgn(x') + k x = m g, in exact half cycles.
 *
 * About the equilibrium m g/k, with s = f/k and w^2 = k/m:
 *   from a turning point Y    x = sgn(Y) (s + (|Y| - s) cos w t),   half a period pi/w long,
 *   the next turning point    -sgn(Y) (|Y| - 2 s),
 *   it stops at the first one with |Y| <= s (Sgn(0) = [-1, 1]).
 * A start with v != 0 swings first about -sgn(v) s, with the amplitude R = sqrt((x + sgn(v) s)^2 +
 * (v/w)^2), to its first turning point. Turning points and times are kept in double-double, so that
 * their rounding errors do not accumulate.
 */
#include <assert.h>

#include "elliptic.h"
#include "kernels.h"

/* The motion about the equilibrium. */
typedef struct {
    dd rate, shift;        /* w [rad/s], s [m] */
    dd first, opening;     /* size |Y| of the first turning point [m], and its time [s] */
    double side, heading;  /* its sign; sign of v before it, 0 if it is the start */
    dd centre, reach, lag; /* before it: centre -sgn(v) s, amplitude R, and phase left [rad] */
    int64_t halves;        /* half cycles after it */
    dd half;               /* pi/w [s] */
} pieces;

/* Half cycles until it stops: the least n >= 0 with |Y| - 2 n s <= s. Equality counts, up to 2^-51
 * |Y|, since |Y| and s are known only to rounding. */
static int64_t half_cycles(dd first, dd shift)
{
    /* n >= (|Y|/s - 1)/2, less 1 for the rounding of the quotient. */
    double n = ceil(0.5 * (first.hi / shift.hi - 1.0)) - 1.0;
    for (n = fmax(n, 0.0);; n += 1.0)
        if (dd_sub(first, dd_scale(shift, 2.0 * n + 1.0)).hi <= 0x1p-51 * first.hi)
            return (int64_t)n;
}

/* The sign -1, 0 or 1. */
static double sign_of(double x)
{
    return (x > 0.0) - (x < 0.0);
}

/* The motion from x [m], off the equilibrium, and v [m/s]. */
static pieces prepare(dd mass, dd stiffness, dd friction, dd x, double v)
{
    pieces b = {.rate = dd_sqrt(dd_div(stiffness, mass)), .shift = dd_div(friction, stiffness)};
    b.heading = sign_of(v);
    if (b.heading == 0.0) { /* at rest: the start is the first turning point */
        b.first = dd_abs(x);
        b.opening = dd_of(0.0);
        b.side = copysign(1.0, x.hi);
    } else {
        /* About the centre -sgn(v) s: R cos lag = sgn(v) (x + sgn(v) s), R sin lag = |v|/w. The
         * first turning point is -sgn(v) s + sgn(v) R, at the time lag/w. */
        dd v_over_w = dd_abs(dd_div(dd_of(v), b.rate));
        b.centre = dd_scale(b.shift, -b.heading);
        dd along_v = dd_scale(dd_sub(x, b.centre), b.heading);
        b.reach = dd_sqrt(dd_add(dd_square(along_v), dd_square(v_over_w)));
        b.lag = angle_of(v_over_w, along_v);
        b.opening = dd_div(b.lag, b.rate);
        dd turning = dd_add(b.centre, dd_scale(b.reach, b.heading));
        b.first = dd_abs(turning);
        b.side = copysign(1.0, turning.hi);
    }
    b.halves = half_cycles(b.first, b.shift);
    b.half = dd_div(DD_PI, b.rate);
    return b;
}

/* Size |Y| - 2 n s [m] of turning point n; negative if it lies on the side that the half cycle came
 * from. */
static double turning_point(const pieces *b, int64_t n)
{
    return dd_round(dd_sub(b->first, dd_scale(b->shift, 2.0 * (double)n)));
}

/* Place [m] off the equilibrium, velocity [m/s], and length of the path [m] from the start x, at
 * the time `since` the start. The path consists of that to the first turning point; of n complete
 * half cycles, the sum over i < n of 2 (|Y| - (2 i + 1) s) = 2 n (|Y| - n s); and of (|Y| - (2 n +
 * 1) s) (1 - cos w t) in the current half cycle. */
static void state_at(const pieces *b, dd since, dd x, double *restrict place,
                     double *restrict speed, double *restrict path)
{
    double cosine, sine;
    double shift = dd_round(b->shift);
    double first = turning_point(b, 0);
    dd since_first = dd_sub(since, b->opening);
    if (b->heading != 0.0 && since_first.hi < 0.0) { /* before the first turning point */
        /* x = centre + sgn(v) R cos w t, t < 0 before the first turning point */
        double amplitude = dd_round(b->reach);
        turned(dd_mul(b->rate, since_first), &cosine, &sine);
        *place = fma(b->heading * amplitude, cosine, dd_round(b->centre));
        *speed = -b->heading * amplitude * b->rate.hi * sine;
        *path = fabs(*place - dd_round(x));
        return;
    }
    dd half = b->half;
    /* Half cycles that are over; the quotient may be off by one. */
    double n = fmax(0.0, floor(since_first.hi / half.hi));
    if (dd_sub(since_first, dd_scale(half, n + 1.0)).hi >= 0.0)
        n += 1.0;
    if (n > 0.0 && dd_sub(since_first, dd_scale(half, n)).hi < 0.0)
        n -= 1.0;
    double path_before = 0.0; /* path to the first turning point */
    if (b->heading != 0.0)
        path_before = fabs(b->side * first - dd_round(x));
    if (n >= (double)b->halves) { /* it has stopped */
        n = (double)b->halves;
        /* x = (-1)^n sgn(Y) (|Y| - 2 n s) with the number n of half cycles, at rest. */
        *place = b->side * turning_point(b, b->halves);
        if (b->halves % 2 == 1)
            *place = -*place;
        *speed = 0.0;
        *path = path_before + 2.0 * n * (first - shift * n);
        return;
    }
    /* x = sgn(Y_n) (s + (|Y_n| - s) cos w t) off the equilibrium, t since turning point n */
    double sign = b->side;
    if (fmod(n, 2.0) != 0.0) /* every other half cycle goes the other way */
        sign = -sign;
    double turning = turning_point(b, (int64_t)n);
    double amplitude = turning - shift;
    turned(dd_mul(b->rate, dd_sub(since_first, dd_scale(half, n))), &cosine, &sine);
    *place = sign * fma(amplitude, cosine, shift);
    *speed = -sign * amplitude * b->rate.hi * sine;
    *path = path_before + 2.0 * n * (first - shift * n) + amplitude * (1.0 - cosine);
}

/* A prepared run: motion, equilibrium and start off it [m], friction force f [N], and the arguments
 * of refdem_coulomb_prepare. */
typedef struct {
    pieces b;
    dd middle, x, friction;
    double x0, v0, t0;
    int64_t samples;
    const double *t;
    double *out;
} run;

/* Doubles that a prepared run takes. */
int64_t refdem_coulomb_size(void)
{
    return (sizeof(run) + sizeof(double) - 1) / sizeof(double);
}

REFDEM_EVERY_CPU
int refdem_coulomb_prepare(double mass, double stiffness, double friction, double normal_force,
                           double gravity, double x0, double v0, double t0, int64_t samples,
                           const double *t, double *stop, double *out, double *motion)
{
    assert(samples >= 0 && t && stop && out && motion);
    run *r = (run *)motion;
    dd m = dd_of(mass);
    dd k = dd_of(stiffness);
    /* f = mu N; the equilibrium is m g/k from the anchor, and x = x0 - m g/k. */
    r->friction = two_product(friction, normal_force);
    r->middle = dd_div(dd_scale(m, gravity), k);
    r->x = dd_sub(dd_of(x0), r->middle);
    r->b = prepare(m, k, r->friction, r->x, v0);
    r->x0 = x0;
    r->v0 = v0;
    r->t0 = t0;
    r->samples = samples;
    r->t = t;
    r->out = out;
    /* It stops at t0 + (time of the first turning point) + halves pi/w. */
    dd last = dd_add(r->b.opening, dd_scale(r->b.half, (double)r->b.halves));
    *stop = dd_round(dd_add(dd_of(t0), last));
    return 0;
}

REFDEM_EVERY_CPU
int refdem_coulomb_run(const double *motion)
{
    assert(motion);
    const run *r = (const run *)motion;
    const double *t = r->t;
    for (int64_t row = 0; row < r->samples; row++) {
        double place;
        double *to = r->out + 3 * row;
        state_at(&r->b, two_sum(t[row], -r->t0), r->x, &place, to + 1, to + 2);
        /* Position m g/k + place, from the anchor of the spring. */
        to[0] = dd_round(dd_add(r->middle, dd_of(place)));
        if (t[row] == r->t0) { /* the start as it was given */
            to[0] = r->x0;
            to[1] = r->v0;
        }
        /* Work against friction: f times the length of the path. */
        to[2] *= dd_round(r->friction);
    }
    return 0;
}

int refdem_coulomb(double mass, double stiffness, double friction, double normal_force,
                   double gravity, double x0, double v0, double t0, int64_t samples,
                   const double *t, double *stop, double *out)
{
    run r;
    double *prepared = (double *)&r; /* callers know a prepared run as doubles */
    refdem_coulomb_prepare(mass, stiffness, friction, normal_force, gravity, x0, v0, t0, samples, t,
                           stop, out, prepared);
    return refdem_coulomb_run(prepared);
}
