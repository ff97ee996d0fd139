/* Head-on contact of two spheres with a linear spring and dashpot, in closed form: the overlap d
 * obeys m d'' + c d' + k d = 0 from d = 0, d' = V at the touch.
 *
 * With the effective mass m = m1 m2/(m1 + m2), b = c/(2m), w0^2 = k/m and w^2 = w0^2 - b^2:
 *
 *   d = V exp(-b t) S(t),   d' = V exp(-b t) (S'(t) - b S(t)),
 *   S = sin(w t)/w for w^2 > 0,   sinh(W t)/W for w^2 = -W^2 < 0,   t for w^2 = 0.
 *
 * The contact ends at d = 0, half a period pi/w after the touch, or, with no_pull, where the force
 * k d + c d' is zero, at twice the time of the largest overlap. Either leaves the speed V exp(-b
 * t_end) (Schwager and Poeschel 2007).
 */
#include <assert.h>

#include "double_double.h"
#include "kernels.h"

typedef struct {
    double decay, rate; /* b [1/s]; w or W [rad/s] */
    double end;         /* how long the contact lasts [s] */
    int kind;           /* sign of w^2 */
} damped;

/* Time [s] of the largest overlap, d' = 0: tan(w t) = w/b, tanh(W t) = W/b, or t = 1/b. */
static double turning_time(const damped *s)
{
    if (s->kind == 0)
        return 1.0 / s->decay;
    if (s->kind > 0)
        return atan2(s->rate, s->decay) / s->rate;
    return atanh(s->rate / s->decay) / s->rate;
}

/* The contact of spheres with the effective mass `mass`. */
static damped prepare(dd mass, double stiffness, double damping, int no_pull)
{
    dd b = dd_div(dd_of(0.5 * damping), mass);
    dd square = dd_sub(dd_div(dd_of(stiffness), mass), dd_square(b));
    damped s = {.decay = dd_round(b), .rate = sqrt(fabs(dd_round(square)))};
    s.kind = (square.hi > 0.0) - (square.hi < 0.0);
    s.end = INFINITY; /* overdamped, and free to pull: it never parts */
    if (no_pull && damping > 0.0)
        s.end = 2.0 * turning_time(&s);
    else if (s.kind > 0) /* half a period */
        s.end = dd_round(dd_div(DD_PI, dd_sqrt(square)));
    return s;
}

/* Overlap and its rate at t [s] after the touch, for V = 1. */
static void state_at(const damped *p, double t, double *restrict overlap, double *restrict rate)
{
    double s_rate = 1.0;
    double s = t;
    double fade = exp(-p->decay * t);
    if (p->kind > 0) {
        s_rate = cos(p->rate * t);
        s = sin(p->rate * t) / p->rate;
    }
    if (p->kind < 0) {
        s_rate = cosh(p->rate * t);
        s = sinh(p->rate * t) / p->rate;
    }
    *overlap = fade * s;
    *rate = fade * (s_rate - p->decay * s);
}

int refdem_head_on(double mass1, double mass2, double stiffness, double damping, int no_pull,
                   double overlap, double closing, int64_t samples, const double *t, double *touch,
                   double *out)
{
    assert(samples >= 1 && t && touch && out); /* (2) and (samples, 5) doubles */
    dd total = two_sum(mass1, mass2);
    dd mass = dd_div(two_product(mass1, mass2), total);
    damped s = prepare(mass, stiffness, damping, no_pull);
    double m = dd_round(mass);
    double begin = INFINITY; /* time of the touch: spheres that do not close never meet */
    if (closing > 0.0)
        begin = fmax(0.0, -overlap / closing);
    double at_end, rate_after;
    double overlap_after
        = 0.0; /* overlap at the end: the force ends before it where there is no pull */
    state_at(&s, fmin(s.end, 1e300), &at_end,
             &rate_after); /* exp(-b 1e300) = 0 where it has no end */
    if (no_pull && damping > 0.0)
        overlap_after = at_end * closing;
    rate_after = -closing * exp(-s.decay * s.end);
    for (int64_t row = 0; row < samples; row++, out += 5) {
        double since = t[row] - begin;
        double *d = out;
        double *rate = out + 1;
        int presses = since >= 0.0 && since < s.end;
        *d = overlap + closing * t[row];
        *rate = closing;
        if (presses) {
            state_at(&s, since, d, rate);
            *d *= closing;
            *rate *= closing;
        } else if (since >= s.end) { /* they fly apart */
            *d = overlap_after + rate_after * (since - s.end);
            *rate = rate_after;
        }
        out[2] = 0.0;
        out[3] = 0.0;
        if (presses) {
            out[2] = 1.0;
            out[3] = stiffness * *d + damping * *rate;
        }
        /* Work lost: m (V^2 - d'^2)/2 - k d^2/2. */
        out[4] = 0.5 * m * (closing - *rate) * (closing + *rate)
                 - 0.5 * stiffness * fmax(*d, 0.0) * fmax(*d, 0.0);
    }
    touch[0] = begin;
    touch[1] = begin + s.end;
    return 0;
}
