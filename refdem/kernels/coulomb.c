/* The mass on a spring that rubs: m x'' + f Sgn(x') + k x = m g, in exact pieces.
 *
 * About the equilibrium, with s = f/k and w^2 = k/m: from a turning point Y it swings about sgn(Y)
 * s to the next one, whose size is |Y| - 2 s, half a period pi/w later; it stays for ever at the
 * first turning point with |Y| <= s (Sgn(0) = [-1, 1]). Turning points and times are kept as hi +
 * lo, so that neither sums up rounding.
 */
#include "elliptic.h"
#include "kernels.h"

typedef struct {
    dd rate, shift;    /* w, s */
    dd first, opening; /* size of the first turning point, and the time after which it is reached */
    double side, heading;  /* its sign; direction before it, 0 if it is the start */
    dd centre, reach, lag; /* before it: centre, amplitude, phase left */
    int64_t halves;        /* half cycles after it */
    dd half;               /* how long one takes */
} rubbing;

/* Least n >= 0 with |Y| - 2 n s <= s: closed, also where |Y| and s are known only to the rounding
 * of what they came from. */
static int64_t half_cycles(dd first, dd shift)
{
    double n = ceil(0.5 * (first.hi / shift.hi - 1.0)) - 1.0;
    for (n = fmax(n, 0.0);; n += 1.0)
        if (dd_sub(first, dd_scale(shift, 2.0 * n + 1.0)).hi <= 0x1p-51 * first.hi)
            return (int64_t)n;
}

static rubbing prepared(dd mass, dd stiffness, dd friction, dd x, double v)
{
    rubbing b = {.rate = dd_sqrt(dd_div(stiffness, mass)), .shift = dd_div(friction, stiffness)};
    b.heading = (v > 0.0) - (v < 0.0);
    if (b.heading == 0.0) {
        b.first = dd_abs(x);
        b.opening = dd_of(0.0);
        b.side = copysign(1.0, x.hi);
    } else {
        dd swing = dd_abs(dd_div(dd_of(v), b.rate));
        b.centre = dd_scale(b.shift, -b.heading);
        dd away = dd_scale(dd_sub(x, b.centre), b.heading);
        b.reach = dd_sqrt(dd_add(dd_square(away), dd_square(swing)));
        b.lag = angle_of(swing, away);
        b.opening = dd_div(b.lag, b.rate);
        dd turning = dd_add(b.centre, dd_scale(b.reach, b.heading));
        b.first = dd_abs(turning);
        b.side = copysign(1.0, turning.hi);
    }
    b.halves = half_cycles(b.first, b.shift);
    b.half = dd_div(DD_PI, b.rate);
    return b;
}

/* Size of turning point n, negative if it lies on the side it came from. */
static double turning_point(const rubbing *b, int64_t n)
{
    return dd_round(dd_sub(b->first, dd_scale(b->shift, 2.0 * (double)n)));
}

/* Place, velocity and way gone since the start x, at the time `since` the start. */
static void at(const rubbing *b, dd since, dd x, double *restrict place, double *restrict speed,
               double *restrict way)
{
    double c, s;
    double shift = dd_round(b->shift);
    double first = turning_point(b, 0);
    dd late = dd_sub(since, b->opening);
    if (b->heading != 0.0 && late.hi < 0.0) {
        double reach = dd_round(b->reach);
        turned(dd_mul(b->rate, late), &c, &s);
        *place = fma(b->heading * reach, c, dd_round(b->centre));
        *speed = -b->heading * reach * b->rate.hi * s;
        *way = fabs(*place - dd_round(x));
        return;
    }
    dd half = b->half;
    double n = fmax(0.0, floor(late.hi / half.hi));
    if (dd_sub(late, dd_scale(half, n + 1.0)).hi >= 0.0)
        n += 1.0;
    if (n > 0.0 && dd_sub(late, dd_scale(half, n)).hi < 0.0)
        n -= 1.0;
    double opening = 0.0; /* the way to the first turning point */
    if (b->heading != 0.0)
        opening = fabs(b->side * first - dd_round(x));
    if (n >= (double)b->halves) {
        n = (double)b->halves;
        *place = b->side * turning_point(b, b->halves);
        if (b->halves % 2 == 1)
            *place = -*place;
        *speed = 0.0;
        *way = opening + 2.0 * n * (first - shift * n);
        return;
    }
    double side = b->side;
    if (fmod(n, 2.0) != 0.0) /* every other half cycle goes the other way */
        side = -side;
    double size = turning_point(b, (int64_t)n);
    double reach = size - shift;
    turned(dd_mul(b->rate, dd_sub(late, dd_scale(half, n))), &c, &s);
    *place = side * fma(reach, c, shift);
    *speed = -side * reach * b->rate.hi * s;
    *way = opening + 2.0 * n * (first - shift * n) + reach * (1.0 - c);
}

/* A motion, ready to be asked; the state holds at t0. */
typedef struct {
    rubbing b;
    dd middle, x, friction;
    double x0, v0, t0;
    int64_t samples;
    const double *t;
    double *out;
} rubbed;

int64_t refdem_coulomb_size(void)
{
    return (sizeof(rubbed) + sizeof(double) - 1) / sizeof(double);
}

REFDEM_EVERY_CPU
int refdem_coulomb_prepare(double mass, double stiffness, double friction, double normal_force,
                           double gravity, double x0, double v0, double t0, int64_t samples,
                           const double *t, double *stop, double *out, double *motion)
{
    rubbed *r = (rubbed *)motion;
    dd m = dd_of(mass);
    dd k = dd_of(stiffness);
    r->friction = two_product(friction, normal_force);
    r->middle = dd_div(dd_scale(m, gravity), k);
    r->x = dd_sub(dd_of(x0), r->middle);
    r->b = prepared(m, k, r->friction, r->x, v0);
    r->x0 = x0;
    r->v0 = v0;
    r->t0 = t0;
    r->samples = samples;
    r->t = t;
    r->out = out;
    dd last = dd_add(r->b.opening, dd_scale(r->b.half, (double)r->b.halves));
    *stop = dd_round(dd_add(dd_of(t0), last));
    return 0;
}

REFDEM_EVERY_CPU
int refdem_coulomb_run(const double *motion)
{
    const rubbed *r = (const rubbed *)motion;
    const double *t = r->t;
    for (int64_t row = 0; row < r->samples; row++) {
        double place;
        double *to = r->out + 3 * row;
        at(&r->b, two_sum(t[row], -r->t0), r->x, &place, to + 1, to + 2);
        to[0] = dd_round(dd_add(r->middle, dd_of(place)));
        if (t[row] == r->t0) { /* the start as it was given */
            to[0] = r->x0;
            to[1] = r->v0;
        }
        to[2] *= dd_round(r->friction);
    }
    return 0;
}

int refdem_coulomb(double mass, double stiffness, double friction, double normal_force,
                   double gravity, double x0, double v0, double t0, int64_t samples,
                   const double *t, double *stop, double *out)
{
    rubbed r;
    refdem_coulomb_prepare(mass, stiffness, friction, normal_force, gravity, x0, v0, t0, samples, t,
                           stop, out, (double *)&r);
    return refdem_coulomb_run((const double *)&r);
}
